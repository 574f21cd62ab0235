//! Environment variables that look like settings and are none.

use super::Cli;
use clap::{Command, CommandFactory};
use strahl::scene::problem::nearest;
use tracing::warn;

/// What the names of all of them begin with.
const PREFIX: &str = "STRAHL_";
/// The one that is no flag.
const LOG: &str = "LOG";

/// Logs which variables are likely misspelt, since the service does not see them. Others are left alone: Kubernetes sets
/// `STRAHL_PORT` and more for a service of that name.
pub(super) fn warn_of_misspelt() {
    for name in std::env::vars_os().filter_map(|(name, _)| name.into_string().ok()) {
        if let Some(meant) = misspelt(&name) {
            warn!("{name} is no setting; did you mean {meant}?");
        }
    }
}

/// What a variable should be called, if it is no setting and nearly one.
fn misspelt(name: &str) -> Option<String> {
    let upper = name.to_ascii_uppercase();
    let given = upper.strip_prefix(PREFIX)?;
    let program = Cli::command();
    let mut known = vec![LOG];
    add(&program, &mut known);
    if upper == name && known.contains(&given) {
        return None;
    }
    nearest(given, known).map(|meant| format!("{PREFIX}{meant}"))
}

/// Adds the variables of a command and of those below it, without the prefix.
fn add<'a>(command: &'a Command, known: &mut Vec<&'a str>) {
    let variables = command.get_arguments().filter_map(|argument| argument.get_env()?.to_str());
    known.extend(variables.filter_map(|variable| variable.strip_prefix(PREFIX)));
    for below in command.get_subcommands() {
        add(below, known);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_told_from_what_others_set() {
        for (name, meant) in [
            ("STRAHL_MEMORY_BYTE", "STRAHL_MEMORY_BYTES"),
            ("STRAHL_LISTN", "STRAHL_LISTEN"),
            ("strahl_listen", "STRAHL_LISTEN"),
            ("STRAHL_LOGS", "STRAHL_LOG"),
        ] {
            assert_eq!(misspelt(name).as_deref(), Some(meant), "{name}");
        }
        for name in
            ["STRAHL_LISTEN", "STRAHL_LOG", "STRAHL_PORT", "STRAHL_PORT_8080_TCP_ADDR", "STRAHL_SERVICE_HOST", "PATH"]
        {
            assert_eq!(misspelt(name), None, "{name}");
        }
    }
}
