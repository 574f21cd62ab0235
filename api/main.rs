//! The `strahl` command.

fn main() {}
