//! The documents against the program: every command and request in them is run, and what they name is looked for.

mod commands;
mod deploy;
mod pages;
mod references;
mod shell;
