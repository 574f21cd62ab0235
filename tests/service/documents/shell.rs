//! A shell that runs the commands of one page, one after the other, as a reader would: in the repository's folder, with
//! `strahl` on the path and a service where the page has started one.

use super::pages::root;
use crate::common::service::{Service, address_in};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Addresses in the documents, for which the service takes free ports.
const CLIENTS: &str = "127.0.0.1:8080";
const OPERATORS: &str = "127.0.0.1:9090";

/// The shell of one page.
pub(super) struct Shell {
    folder: PathBuf,
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    service: Option<Service>,
}

/// What came of a command.
pub(super) struct Outcome {
    pub(super) exit_code: i32,
    /// Standard output, then standard error.
    pub(super) shown: Vec<String>,
    /// The statuses of all requests that curl sent.
    pub(super) statuses: Vec<u16>,
}

impl Shell {
    /// A shell in a folder of its own, which shows the repository's files without being able to change the folders they are in.
    pub(super) fn start(page: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("documents").join(page.replace(['/', '.'], "-"));
        // What an earlier run has left would hide that a command makes nothing.
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("bin")).unwrap();
        let link = |from: PathBuf, to: &str| std::os::unix::fs::symlink(from, folder.join(to)).unwrap();
        for shared in ["api", "scenes", "tests"] {
            link(root().join(shared), shared);
        }
        link(env!("CARGO_BIN_EXE_strahl").into(), "bin/strahl");
        // curl's own configuration: each request reports its status, and none waits for ever.
        std::fs::write(folder.join(".curlrc"), "write-out = \"%{stderr}\\nstatus %{http_code}\\n\"\nmax-time = 60\n")
            .unwrap();
        let path = format!("{}:{}", folder.join("bin").display(), std::env::var("PATH").unwrap());
        let mut child = Command::new("sh")
            .current_dir(&folder)
            .env("PATH", path)
            .env("CURL_HOME", &folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("sh runs");
        let (input, output) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        Self { folder, child, input, output, service: None }
    }

    /// Starts the service of a command line, in place of the one before.
    pub(super) fn serve(&mut self, command: &str) {
        let command = command.split(" #").next().unwrap();
        let flags =
            command.strip_prefix("cargo run --release -- serve").or_else(|| command.strip_prefix("strahl serve"));
        let flags =
            flags.unwrap_or_else(|| panic!("{command}: a block marked `serve` starts the service, and nothing else"));
        let flags = flags.replace(":8080", ":0").replace(":9090", ":0");
        self.service = None;
        self.service = Some(Service::start_in(&self.folder, &flags.split_whitespace().collect::<Vec<_>>()));
    }

    /// Pairs of an address in the documents and the one that the service really has.
    fn addresses(&self) -> Vec<(&'static str, String)> {
        let Some(service) = &self.service else { return Vec::new() };
        let clients = (CLIENTS, format!("127.0.0.1:{}", service.address.port()));
        let operators = address_in(service.said_first()).filter(|own| *own != service.address);
        std::iter::once(clients).chain(operators.map(|own| (OPERATORS, own.to_string()))).collect()
    }

    /// Writes a file that the page shows.
    pub(super) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).unwrap();
    }

    /// Runs a command, which may span several lines.
    pub(super) fn run(&mut self, command: &str) -> Outcome {
        let addresses = self.addresses();
        let real = addresses.iter().fold(command.to_owned(), |text, (shown, real)| text.replace(shown, real));
        let script = format!("{{ {real}\n}} </dev/null 2>errors.txt; printf '\\nend of output %s\\n' $?\n");
        self.input.write_all(script.as_bytes()).expect("the shell lives");
        let mut lines = Vec::new();
        let exit_code = loop {
            let mut line = Vec::new();
            assert!(self.output.read_until(b'\n', &mut line).unwrap() > 0, "{command}: the shell has ended");
            let line = String::from_utf8_lossy(&line).trim_end().to_owned();
            match line.strip_prefix("end of output ") {
                Some(code) => break code.parse().unwrap(),
                None => lines.push(line),
            }
        };
        // The line break before the mark, if the output did not end with one.
        if lines.last().is_some_and(String::is_empty) {
            lines.pop();
        }
        let errors = std::fs::read_to_string(self.folder.join("errors.txt")).unwrap();
        let mut statuses = Vec::new();
        for line in errors.lines().filter(|line| !line.is_empty()) {
            match line.strip_prefix("status ") {
                Some(status) => statuses.push(status.parse().unwrap()),
                None => lines.push(line.to_owned()),
            }
        }
        let as_shown = |line: String| addresses.iter().fold(line, |text, (shown, real)| text.replace(real, shown));
        Outcome { exit_code, shown: lines.into_iter().map(as_shown).collect(), statuses }
    }
}

impl Drop for Shell {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
