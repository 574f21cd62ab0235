"""What the external suites share: the built service on a free port, and a place to install what they need."""

import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "target" / "external"


PROGRAM = ROOT / "target" / "release" / "strahl"


class Service:
    """The program on a free port; `address` is host:port. Its log goes to a file if one is named."""

    def __init__(self, *flags, program=PROGRAM, log=os.devnull):
        if not pathlib.Path(program).exists():
            sys.exit(f"there is no {program}: cargo build --release")
        self.process = subprocess.Popen([program, "serve", "--listen", "127.0.0.1:0", *flags], stderr=subprocess.PIPE, text=True)
        said = ""
        for line in self.process.stderr:
            said += line
            if (found := re.search(r"listening on http://(\S+)", line)) and "admin" not in line:
                break
        else:
            sys.exit(f"the service has not started:\n{said}")
        self.address = found.group(1)
        # Its log must go somewhere, or it would wait for a reader.
        with open(log, "a") as sink:
            sink.write(said)
            sink.flush()
            self.drain = subprocess.Popen(["cat"], stdin=self.process.stderr, stdout=sink)

    def stop(self, signal=signal.SIGTERM):
        """Ends it; its exit code."""
        self.process.send_signal(signal)
        code = self.process.wait(timeout=60)
        self.drain.wait(timeout=60)
        self.process.stderr.close()
        return code

    def processor_seconds(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory(self, of="VmHWM"):
        """Its memory at most (or now: VmRSS) in MB."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(rf"{of}:\s+(\d+) kB", status)[1]) / 1024


@contextlib.contextmanager
def running(*flags):
    """The service while something is done with it; its address as host:port."""
    service = Service(*flags)
    try:
        yield service.address
    finally:
        service.stop()


def key(file, tenant, scopes="render,jobs,read", program=PROGRAM):
    """A new key in a key file, as an `Authorization` header."""
    command = [program, "key", "new", "--tenant", tenant, "--scopes", scopes, "--file", file]
    made = subprocess.run(command, capture_output=True, text=True, check=True)
    return {"Authorization": f"Bearer {made.stdout.strip()}"}


def add(address, scene, query=""):
    """Makes a scene of the repository known; what the service says of it."""
    request = urllib.request.Request(
        f"http://{address}/v1/scenes{query}",
        data=(ROOT / scene).read_bytes(),
        headers={"Content-Type": "application/json"},
    )
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def python(*packages):
    """The folder of programs of an environment with some packages of PyPI."""
    folder = TOOLS / re.sub(r"[^a-z0-9.]+", "-", "-".join(packages).lower())
    if not (folder / "complete").exists():
        subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)
        subprocess.run([folder / "bin" / "pip", "install", "--quiet", *packages], check=True)
        (folder / "complete").touch()
    return folder / "bin"


def node(name, *packages):
    """The folder of modules with some packages of npm."""
    folder = TOOLS / name
    if not (folder / "complete").exists():
        folder.mkdir(parents=True, exist_ok=True)
        options = ["--prefix", folder, "--no-fund", "--no-audit", "--ignore-scripts", "--silent"]
        subprocess.run(["npm", "install", *options, *packages], check=True)
        (folder / "complete").touch()
    return folder / "node_modules"
