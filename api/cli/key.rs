//! `strahl key`: makes keys and secrets for the key file of `strahl serve --keys`.

use super::failure::Failure;
use super::output;
use super::values::word;
use crate::http::auth::tenant::Scope;
use crate::http::auth::{new_key, new_signer, new_webhook_secret};
use clap::{Args, Subcommand};
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// `strahl key`.
#[derive(Debug, Subcommand)]
pub(super) enum KeyCommand {
    /// Make an API key, which is shown only once, and its lines for the key file.
    New(NewKeyArgs),
    /// Make a secret that signs capability URLs, for the key file. The first one in the file signs, all are accepted.
    Signer {
        /// Add it to this key file instead of printing it.
        #[arg(long, value_name = "FILE")]
        file: Option<PathBuf>,
    },
    /// Make a secret that signs messages about a tenant's jobs, for webhook_secret of [tenants.NAME] in the key file. The
    /// receiver has the same.
    Webhook,
}

/// `strahl key new`.
#[derive(Debug, Args)]
pub(super) struct NewKeyArgs {
    /// Name of the tenant: letters, digits and -.
    #[arg(long, value_name = "NAME")]
    tenant: String,
    /// What the key allows.
    #[arg(long, value_name = "SCOPES", value_delimiter = ',', value_parser = word::<Scope>(), default_value = "render,jobs,read")]
    scopes: Vec<Scope>,
    /// Add the lines to this key file instead of printing them.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
}

/// Makes one.
pub(super) fn run(command: &KeyCommand) -> Result<(), Failure> {
    match command {
        KeyCommand::New(NewKeyArgs { tenant, scopes, file }) => {
            let (key, lines) = new_key(tenant, scopes).map_err(|error| Failure::Usage(error.to_string()))?;
            match file {
                Some(file) => {
                    append(file, &lines)?;
                    output::print(format!("{key}\n").as_bytes())
                }
                None => {
                    let about = "# The key, which is shown only now, is:";
                    output::print(format!("{about}\n# {key}\n# For the key file:\n\n{lines}").as_bytes())
                }
            }
        }
        KeyCommand::Signer { file } => {
            let lines = new_signer().map_err(|error| Failure::Input(error.to_string()))?;
            match file {
                Some(file) => append(file, &lines),
                None => output::print(lines.as_bytes()),
            }
        }
        KeyCommand::Webhook => {
            let secret = new_webhook_secret().map_err(|error| Failure::Input(error.to_string()))?;
            output::print(format!("{}\n", secret.text()).as_bytes())
        }
    }
}

/// Appends lines to a key file, which is created readable by its owner only.
fn append(file: &Path, lines: &str) -> Result<(), Failure> {
    let mut options = OpenOptions::new();
    options.append(true).create(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let written = options.open(file).and_then(|mut file| {
        let gap = if file.metadata()?.len() > 0 { "\n" } else { "" };
        file.write_all(format!("{gap}{lines}").as_bytes())
    });
    written.map_err(|error: io::Error| Failure::writing(&file.display().to_string(), &error))
}
