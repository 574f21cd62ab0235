#!/usr/bin/env python3
"""The client libraries of `clients/` against the real service: their types, their generated files, their tests.

    cargo build --release && python3 tests/external/clients.py [python | js]

It needs Python 3.11 or newer, and node 20 with npm for JavaScript. It installs what it needs (PyPI, npm) into target/external.
"""

import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import time

import service

CLIENTS = service.ROOT / "clients"
PROGRAM = os.environ.get("STRAHL_BINARY") or service.PROGRAM


def run(*command, cwd):
    """Runs a command; what it says is shown once it has ended, since several run beside each other."""
    started = time.monotonic()
    environment = {**os.environ, "STRAHL_BINARY": str(PROGRAM)}
    done = subprocess.run(command, cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    name = " ".join([pathlib.Path(command[0]).name, *map(str, command[1:])])
    tail = "\n".join(done.stdout.splitlines()[-60:] if done.returncode else done.stdout.splitlines()[-1:])
    print(f"== {name} ({cwd.relative_to(service.ROOT)}): {time.monotonic() - started:.0f} s\n{tail}", flush=True)
    return done.returncode == 0


def python():
    """mypy and pytest, on the package as users get it."""
    programs = service.python("httpx", "hatchling", "numpy", "pillow", "pytest", "mypy")
    folder = CLIENTS / "python"
    install = [programs / "pip", "install", "--quiet", "--no-build-isolation", "--no-deps", "--force-reinstall", folder]
    return run(*install, cwd=folder) and all([run(programs / "mypy", cwd=folder), run(programs / "pytest", cwd=folder)])


def js():
    """tsc, whether the generated files are up to date, and node --test. Modules stay where tsc looks for them."""
    folder = CLIENTS / "js"
    if not (folder / "node_modules").exists() and not run("npm", "ci", "--ignore-scripts", cwd=folder):
        return False
    before = {path.name: path.read_text() for path in (folder / "types").iterdir()}
    if not all([run("npm", "run", "contract", cwd=folder), run("npm", "run", "check", cwd=folder)]):
        return False
    stale = [path.name for path in (folder / "types").iterdir() if before.get(path.name) != path.read_text()]
    if stale:
        print(f"clients/js/types were not up to date and have been written again: {', '.join(stale)}")
    return run("npm", "test", cwd=folder) and not stale


def main():
    if not pathlib.Path(PROGRAM).exists():
        sys.exit(f"there is no {PROGRAM}: cargo build --release")
    parts = {"python": python, "js": js}
    chosen = [parts[name] for name in sys.argv[1:] or parts]
    if js in chosen and not shutil.which("npm"):
        sys.exit("this test needs node and npm, which are not installed")
    with concurrent.futures.ThreadPoolExecutor() as both:
        sys.exit(not all([*both.map(lambda part: part(), chosen)]))


if __name__ == "__main__":
    main()
