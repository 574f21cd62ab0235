//! The configuration file of `strahl serve`: TOML, with the names of the flags. Flags override the environment, which overrides
//! the file, which overrides defaults.
//!
//! Its entries are put in front of the flags on the command line, unless a flag or the environment sets the same. So all values
//! are checked in one place by the same rules.

use super::Cli;
use super::failure::Failure;
use clap::parser::ValueSource;
use clap::{ArgMatches, Command, CommandFactory};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use strahl::scene::problem::did_you_mean;
use toml::{Table, Value};

/// The arguments, with the entries of the configuration file added if they name one.
pub(super) fn with_file(given: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    // Mistakes in the arguments are reported when they are parsed again.
    let Ok(matches) = Cli::command().try_get_matches_from(&given) else { return Ok(given) };
    let Some((at, serve)) = matches_of(&matches) else { return Ok(given) };
    let only_listens = matches.subcommand_name() == Some("healthcheck");
    let has = |id: &str| !only_listens || matches!(id, "listen" | "admin_listen");
    let Some(path) = serve.get_one::<PathBuf>("config") else { return Ok(given) };
    let entries = flags_of(path, |id| {
        !has(id) || matches!(serve.value_source(id), Some(ValueSource::CommandLine | ValueSource::EnvVariable))
    })?;
    let mut all = given;
    all.splice(at..at, entries);
    Ok(all)
}

/// Index of the first flag of the service in the arguments, or of what asks for it, and the matches of its flags.
fn matches_of(matches: &ArgMatches) -> Option<(usize, &ArgMatches)> {
    match matches.subcommand()? {
        ("serve" | "healthcheck", flags) => Some((2, flags)),
        ("config", config) => config.subcommand_matches("print").map(|print| (3, print)),
        _ => None,
    }
}

/// The entries of a file as flags, without those that are set elsewhere.
pub(super) fn flags_of(path: &Path, decided: impl Fn(&str) -> bool) -> Result<Vec<OsString>, Failure> {
    let name = path.display();
    let text =
        std::fs::read_to_string(path).map_err(|error| Failure::Input(format!("{name} cannot be read: {error}")))?;
    let entries: Table = toml::from_str(&text).map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
    let serve = serve_command();
    let known: Vec<&str> = serve.get_arguments().map(|arg| arg.get_id().as_str()).filter(|id| is_entry(id)).collect();
    let mut flags = Vec::new();
    for (key, value) in entries {
        if !known.contains(&key.as_str()) {
            let suggestion = did_you_mean(&key, known.iter().copied());
            return Err(Failure::Usage(format!("{name}: there is no setting \"{key}\"{suggestion}")));
        }
        if decided(&key) {
            continue;
        }
        let flag = format!("--{}", key.replace('_', "-"));
        match value {
            Value::Boolean(true) if is_switch(&serve, &key) => flags.push(flag.into()),
            Value::Boolean(false) if is_switch(&serve, &key) => {}
            value => flags.push(format!("{flag}={}", text_of(&name.to_string(), &key, &value)?).into()),
        }
    }
    Ok(flags)
}

/// `strahl serve` as clap knows it.
pub(super) fn serve_command() -> Command {
    Cli::command().find_subcommand("serve").cloned().unwrap_or_default()
}

/// Whether a file may set an argument.
pub(super) fn is_entry(id: &str) -> bool {
    !matches!(id, "config" | "help" | "version")
}

fn is_switch(serve: &Command, key: &str) -> bool {
    serve.get_arguments().any(|arg| arg.get_id() == key && !arg.get_action().takes_values())
}

fn text_of(name: &str, key: &str, value: &Value) -> Result<String, Failure> {
    match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        Value::Boolean(flag) => Ok(flag.to_string()),
        Value::Array(values) => {
            let texts: Result<Vec<_>, _> = values.iter().map(|value| text_of(name, key, value)).collect();
            Ok(texts?.join(","))
        }
        Value::Datetime(_) | Value::Table(_) => {
            Err(Failure::Usage(format!("{name}: {key} must be a number, a text, true or false")))
        }
    }
}
