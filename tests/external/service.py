"""What the external suites share: the built service on a free port, and a place to install what they need."""

import contextlib
import json
import pathlib
import re
import subprocess
import sys
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "target" / "external"


@contextlib.contextmanager
def running(*flags):
    """The service while something is done with it; its address as host:port."""
    program = ROOT / "target" / "release" / "strahl"
    if not program.exists():
        sys.exit("there is no target/release/strahl: cargo build --release")
    command = [program, "serve", "--listen", "127.0.0.1:0", *flags]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        for line in process.stderr:
            if found := re.search(r"listening on http://(\S+)", line):
                break
        else:
            sys.exit("the service has not started")
        # Its log must go somewhere, or it would wait for a reader.
        drain = subprocess.Popen(["cat"], stdin=process.stderr, stdout=subprocess.DEVNULL)
        yield found.group(1)
    finally:
        process.terminate()
        process.wait(timeout=60)
        drain.wait(timeout=60)


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
