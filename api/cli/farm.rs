//! `strahl farm`: what the operator of a farm needs besides fronts and nodes.

use super::failure::Failure;
use super::output;
use crate::service::farm::accounts::{Role, User, configuration};
use clap::{Args, Subcommand};
use nkeys::KeyPair;
use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// `strahl farm`.
#[derive(Debug, Subcommand)]
pub(super) enum FarmCommand {
    /// Make users of the broker for fronts and nodes, who may do no more than they need, and the broker's configuration of
    /// them. Secrets that are there stay: run it again after an upgrade, or to add a group of nodes.
    Accounts(AccountsArgs),
}

/// `strahl farm accounts`.
#[derive(Debug, Args)]
pub(super) struct AccountsArgs {
    /// File that the broker's configuration includes. It holds public keys only.
    #[arg(value_name = "BROKER.conf", default_value = "accounts.conf")]
    broker: PathBuf,
    /// File of the secret of fronts, readable by its owner only.
    #[arg(long, value_name = "FILE", default_value = "front.nk")]
    front: PathBuf,
    /// File of the secret of nodes. Groups of nodes that trust each other less get a file each; its name is the group's.
    #[arg(long, value_name = "FILE", default_value = "node.nk")]
    node: Vec<PathBuf>,
}

/// Writes them, and says with which flags they are used.
pub(super) fn run(command: &FarmCommand) -> Result<(), Failure> {
    let FarmCommand::Accounts(AccountsArgs { broker, front, node }) = command;
    let files = std::iter::once((front, Role::Front)).chain(node.iter().map(|file| (file, Role::Node)));
    let (mut users, mut told, mut inboxes) = (Vec::new(), String::new(), BTreeSet::new());
    for (file, role) in files {
        let inbox = format!("_INBOX.{}", name_of(file)?);
        if !inboxes.insert(inbox.clone()) {
            return Err(Failure::Usage(format!(
                "{}: another file has this name; groups need names of their own",
                file.display()
            )));
        }
        let public_key = secret(file)?.public_key();
        told += &format!("--farm-credentials {} --farm-inbox {inbox}\n", file.display());
        users.push(User { public_key, inbox, role });
    }
    fs::write(broker, configuration(&users))
        .map_err(|error| Failure::writing(&broker.display().to_string(), &error))?;
    output::print(told.as_bytes())
}

/// The group's name: that of the file, without its ending.
fn name_of(file: &Path) -> Result<&str, Failure> {
    let name = file.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
    let is_word = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b));
    let wrong = || {
        Failure::Usage(format!("{}: the file's name may have letters, digits, _ and -, then an ending", file.display()))
    };
    is_word.then_some(name).ok_or_else(wrong)
}

/// The secret of a file. A new one if there is no such file.
fn secret(file: &Path) -> Result<KeyPair, Failure> {
    let name = file.display().to_string();
    match fs::read_to_string(file) {
        Ok(text) => KeyPair::from_seed(text.trim()).map_err(|error| {
            Failure::Input(format!("{name} holds no secret of a user: {error}; delete it for a new one"))
        }),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let new = KeyPair::new_user();
            let seed = new.seed().map_err(|error| Failure::Input(error.to_string()))?;
            write_secret(file, &seed).map_err(|error| Failure::writing(&name, &error))?;
            Ok(new)
        }
        Err(error) => Err(Failure::Input(format!("{name} cannot be read: {error}"))),
    }
}

fn write_secret(file: &Path, seed: &str) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    writeln!(options.open(file)?, "{seed}")
}
