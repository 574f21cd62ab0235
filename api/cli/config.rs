//! `strahl config`: checks a configuration file, or shows the settings that the service would use.

use super::config_file::{flags_of, is_entry, serve_command};
use super::failure::Failure;
use super::output;
use super::serve::{self, ServeArgs};
use super::{Cli, Command};
use crate::service::error::StartError;
use clap::parser::ValueSource;
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `strahl config`.
#[derive(Debug, Subcommand)]
pub(super) enum ConfigCommand {
    /// Check a configuration file.
    Check {
        /// The file.
        file: PathBuf,
    },
    /// Print the settings that the service would use with these flags, and where each comes from.
    Print(Box<ServeArgs>),
}

/// Runs the command.
pub(super) fn run(command: &ConfigCommand) -> Result<(), Failure> {
    match command {
        ConfigCommand::Check { file } => check(file),
        ConfigCommand::Print(_) => print(),
    }
}

/// Reads the file as `strahl serve` would. What it names, such as keys and folders, may be on another machine.
fn check(file: &Path) -> Result<(), Failure> {
    let flags = flags_of(file, |_| false)?;
    let all = ["strahl", "serve"].into_iter().map(OsString::from).chain(flags);
    let read = Cli::try_parse_from(all).map_err(|error| {
        let text = error.render().to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        // What is missing, or which values there are, comes in the next lines.
        let said: Vec<_> =
            text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more")).collect();
        Failure::Usage(format!("{}: {}", file.display(), said.join("\n").trim_end()))
    })?;
    if let Command::Serve(args) = read.command {
        serve::check(&args).map_err(|error| {
            let (StartError::Settings(why) | StartError::Machine(why)) = error;
            Failure::Usage(format!("{}: {why}", file.display()))
        })?;
    }
    output::print(format!("{}: ok\n", file.display()).as_bytes())
}

/// Prints every setting as TOML, with its source. Entries of the file have been added to the arguments before.
fn print() -> Result<(), Failure> {
    let given: Vec<_> = std::env::args_os().collect();
    let of = |args: Vec<OsString>| Cli::command().get_matches_from(args);
    let (plain, all) = (of(given.clone()), of(super::config_file::with_file(given)?));
    let inner = |matches: &clap::ArgMatches| {
        matches.subcommand_matches("config").and_then(|config| config.subcommand_matches("print")).cloned()
    };
    let (Some(plain), Some(all)) = (inner(&plain), inner(&all)) else { return Ok(()) };
    let mut text = String::new();
    for arg in serve_command().get_arguments().filter(|arg| is_entry(arg.get_id().as_str())) {
        let id = arg.get_id().as_str();
        let from = match (plain.value_source(id), all.value_source(id)) {
            (Some(ValueSource::CommandLine), _) => "flag",
            (Some(ValueSource::EnvVariable), _) => "environment",
            (_, Some(ValueSource::CommandLine)) => "file",
            (_, Some(_)) => "default",
            // Writing to a String cannot fail, here and below.
            (_, None) => {
                let _ = writeln!(text, "# {id} is not set");
                continue;
            }
        };
        let value = if arg.get_action().takes_values() {
            let raw = all.get_raw(id).into_iter().flatten().map(|raw| raw.to_string_lossy().into_owned());
            let value = raw.collect::<Vec<_>>().join(",");
            literal(&if arg.is_hide_env_values_set() { without_logins(&value) } else { value })
        } else {
            all.get_flag(id).to_string()
        };
        let _ = writeln!(text, "{id} = {value}  # {from}");
    }
    output::print(text.as_bytes())
}

/// Addresses whose users and passwords are not shown.
fn without_logins(addresses: &str) -> String {
    let shown = |address: &str| match (address.split_once("://"), address.rsplit_once('@')) {
        (Some((scheme, _)), Some((_, host))) => format!("{scheme}://***@{host}"),
        (Some(_), None) => address.to_owned(),
        (None, _) => "***".to_owned(),
    };
    addresses.split(',').map(shown).collect::<Vec<_>>().join(",")
}

/// A value as TOML, which has fewer ways to write numbers than flags. A JSON string is one of TOML, too.
fn literal(text: &str) -> String {
    let is_number = |value: &toml::Value| value.is_integer() || value.is_float();
    let read = format!("value = {text}").parse::<toml::Table>().ok();
    let is_plain = text.parse::<f64>().is_ok_and(f64::is_finite);
    if is_plain && read.is_some_and(|table| table.len() == 1 && table.get("value").is_some_and(is_number)) {
        text.to_owned()
    } else {
        serde_json::Value::from(text).to_string()
    }
}
