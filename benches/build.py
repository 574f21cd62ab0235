#!/usr/bin/env python3
"""What building strahl takes: time, processor time and memory, each beside its target.

    python3 benches/build.py                  # every row; half an hour on two free cores
    python3 benches/build.py fresh api        # single rows; --list names them
    python3 benches/build.py --commit HEAD~3  # another commit than HEAD; changes that are not committed never count

It clones the repository into a temporary folder and builds there, in folders of its own, so nothing of yours is touched or
reused but the packages that cargo has downloaded. It needs nothing but Python's own library, git and cargo, on Linux.
Times count only on a machine that does nothing else: it says what the load was before each row.
"""

import argparse
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.append(str(HERE))
from machine import machine  # noqa: E402

# In the target folder.
PROGRAM = "release/strahl"

# Edits that change machine code, as a day's work does: in the one file below a folder that has a line, it becomes another.
EDITS = {
    "api": ("api", "const PAGE: [u32; 2] = [50, 200];", "const PAGE: [u32; 2] = [51, 201];"),
    "library": ("src", "const CLEARLY: f64 = 0.1;", "const CLEARLY: f64 = 0.11;"),
    # The same pictures by another comparison, since tests are run after it.
    "kernel": ("src", "if exponent <= MAX_SQUARED && exponent", "if exponent < MAX_SQUARED + 0.5 && exponent"),
}


@dataclass
class Took:
    """What a command took: seconds, processor seconds of it and all it started, and the most memory of all together."""

    wall: float
    cpu: float
    memory: int


class Memory(threading.Thread):
    """Watches the memory that a group of processes has at one time, in bytes."""

    def __init__(self, group):
        super().__init__(daemon=True)
        self.group, self.most, self.over = group, 0, threading.Event()

    def run(self):
        while not self.over.wait(0.25):
            self.most = max(self.most, sum(map(self.of, filter(str.isdigit, os.listdir("/proc")))))

    def of(self, pid):
        """A process's own memory and its share of what it shares, as compilers share theirs."""
        try:
            # After the name in parentheses: state, parent, group.
            if int(Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[2]) != self.group:
                return 0
            lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
            return next(int(line.split()[1]) << 10 for line in lines if line.startswith("Pss:"))
        except (OSError, StopIteration):
            return 0


class Place:
    """A clone and its target folder."""

    def __init__(self, folder, commit):
        self.clone, self.target, self.log = folder / "strahl", folder / "target", folder / "log"
        subprocess.run(["git", "clone", "--quiet", "--no-local", ROOT, self.clone], check=True)
        subprocess.run(["git", "checkout", "--quiet", "--detach", commit], cwd=self.clone, check=True)
        # What the network gives is not measured.
        subprocess.run(["cargo", "fetch", "--quiet", "--locked"], cwd=self.clone, check=True)

    def run(self, *command, serve=False, daily=False):
        """Runs a command, and the service until it listens; what both took. Daily work is incremental."""
        env = {**os.environ, "CARGO_TARGET_DIR": str(self.target), "CARGO_INCREMENTAL": "1" if daily else "0"}
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        with open(self.log, "w") as log:
            process = subprocess.Popen(command, cwd=self.clone, env=env, stdin=subprocess.DEVNULL, stdout=log,
                                       stderr=subprocess.STDOUT, start_new_session=True)
        memory = Memory(process.pid)
        memory.start()
        try:
            status = process.wait()
        except BaseException:
            os.killpg(process.pid, signal.SIGTERM)
            raise
        memory.over.set()
        memory.join()
        if status != 0:
            tail = "\n".join(self.log.read_text().splitlines()[-30:])
            sys.exit(f"{' '.join(map(str, command))} failed:\n{tail}")
        if serve:
            listen(self.target / PROGRAM)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Took(time.monotonic() - start, cpu, memory.most)

    def edit(self, what):
        """Makes a small change to the clone."""
        folder, old, new = EDITS[what]
        files = [path for path in (self.clone / folder).rglob("*.rs") if old in path.read_text()]
        if len(files) != 1:
            sys.exit(f"{old!r} is in {len(files)} files of {folder}: adapt EDITS in benches/build.py")
        files[0].write_text(files[0].read_text().replace(old, new))

    def forget(self):
        """Empties the target folder."""
        shutil.rmtree(self.target, ignore_errors=True)


def listen(program):
    """Starts the service and waits until it listens."""
    command = [program, "serve", "--listen", "127.0.0.1:0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        if not any("listening on http://" in line for line in process.stderr):
            sys.exit("the service has not started")
    finally:
        process.kill()
        process.wait()


def fresh(place):
    place.forget()
    return place.run("cargo", "build", "--release", "--locked", serve=True)


def after_edit(what):
    def row(place):
        build = ["cargo", "build", "--release", "--locked"]
        place.run(*build, daily=True)
        place.edit(what)
        return place.run(*build, serve=True, daily=True)

    return row


def tests_cold(place):
    place.forget()
    return place.run("cargo", "test", "--release", "--locked")


def tests_after_edit(place):
    test = ["cargo", "test", "--release", "--locked"]
    place.run(*test, "--no-run", daily=True)
    place.edit("kernel")
    return place.run(*test, daily=True)


def ci(place):
    place.forget()
    shutil.rmtree(place.clone / "target", ignore_errors=True)
    # Its last steps look for the program in the clone's own target folder.
    (place.clone / "target").symlink_to(place.target)
    place.target.mkdir(exist_ok=True)
    return place.run(".ci/run")


GIB = 1 << 30
# What is measured, how, and the most that it may take on two free cores: seconds and bytes.
ROWS = {
    "fresh": ("fresh clone to a serving service", fresh, 180, 2 * GIB),
    "api": ("changed api file to a running service", after_edit("api"), 10, None),
    "library": ("changed library file to a running service", after_edit("library"), 25, None),
    "kernel": ("changed kernel file to a running service", after_edit("kernel"), 25, None),
    "tests": ("cargo test --release, cold", tests_cold, 480, None),
    "tests-edit": ("cargo test --release after a changed kernel file", tests_after_edit, 240, None),
    "ci": (".ci/run in a fresh clone", ci, 900, None),
}


def table(rows):
    print("\n| what | wall | target | CPU seconds | peak memory | load before |\n|---|---|---|---|---|---|")
    for name, load, took in rows:
        what, _, seconds, memory = ROWS[name]
        size = f"{took.memory / GIB:.1f} GiB" + (f" of {memory / GIB:.0f}" if memory else "")
        print(f"| {what} | {minutes(took.wall)} | {minutes(seconds)} | {took.cpu:.0f} | {size} | {load:.1f} |")


def minutes(seconds):
    return f"{seconds:.1f} s" if seconds < 60 else f"{int(seconds // 60)} min {int(seconds % 60):02} s"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="what to measure; everything unless named")
    parser.add_argument("--list", action="store_true", help="name the rows")
    parser.add_argument("--commit", default="HEAD", help="what to build")
    parser.add_argument("--folder", help="where to clone and build; needs some gigabytes (default: the temporary folder)")
    asked = parser.parse_args()
    if asked.list:
        for name, (what, *_) in ROWS.items():
            print(f"{name:<12}{what}")
        return
    if unknown := [name for name in asked.rows if name not in ROWS]:
        sys.exit(f"no such row: {', '.join(unknown)}; there are {', '.join(ROWS)}")
    commit = subprocess.run(["git", "rev-parse", asked.commit], cwd=ROOT, check=True, capture_output=True, text=True)
    commit = commit.stdout.strip()
    print(f"{machine()}; commit {commit[:12]}", flush=True)
    done = []
    # However it is stopped, it stops what it has started and leaves no folder.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))
    with tempfile.TemporaryDirectory(prefix="strahl-build-", dir=asked.folder) as folder:
        place = Place(Path(folder), commit)
        for name in asked.rows or ROWS:
            load = os.getloadavg()[0]
            subprocess.run(["git", "checkout", "--quiet", "--", "."], cwd=place.clone, check=True)
            took = ROWS[name][1](place)
            done.append((name, load, took))
            print(f"{name}: {minutes(took.wall)}, {took.cpu:.0f} CPU seconds, {took.memory / GIB:.1f} GiB", flush=True)
    table(done)


if __name__ == "__main__":
    main()
