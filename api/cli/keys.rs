//! Flags of `strahl key`.

use crate::http::auth::tenant::Scope;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `strahl key`.
#[derive(Debug, Subcommand)]
pub(crate) enum KeyCommand {
    /// Make an API key, which is shown once, and the lines about it for the key file.
    New(NewKeyArgs),
    /// Make a secret that signs capability URLs, for the key file. The first one signs, all of them are accepted.
    Signer {
        /// Add it to this key file instead of printing it.
        #[arg(long, value_name = "FILE")]
        file: Option<PathBuf>,
    },
}

/// `strahl key new`.
#[derive(Debug, Args)]
pub(crate) struct NewKeyArgs {
    /// Whose key it is: letters, digits and -.
    #[arg(long, value_name = "NAME")]
    pub(crate) tenant: String,
    /// What it allows.
    #[arg(long, value_name = "SCOPES", value_delimiter = ',', default_value = "render,jobs,read")]
    pub(crate) scopes: Vec<Scope>,
    /// Add the lines to this key file instead of printing them.
    #[arg(long, value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}
