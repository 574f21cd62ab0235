#!/usr/bin/env python3
"""The studio in headless Chromium: flows, figures of speed, deep zoom, accessibility, bad connections, a killed service. Each line is a figure.

    cargo build --release && python3 tests/external/studio.py             # everything
    python3 tests/external/studio.py flows speed deep access trouble keys restart farm   # some of it

It needs node, npm and Chromium (Debian: nodejs, npm, chromium; or CHROMIUM=path), and installs puppeteer-core and axe-core
(npm) into target/external. STUDIO_FILES=web serves the files of a folder instead of those in the program.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import service
from broker import Broker

PACKAGES = ["puppeteer-core@25.16.0", "axe-core@4.14.1"]
SUITES = ["flows", "pixel", "plan", "accuracy", "compare", "maps", "jobs", "speed", "deep", "access", "trouble", "keys", "restart", "farm"]


def node(modules, browser, suite, address, *more):
    program = service.ROOT / "tests" / "external" / "studio" / f"{suite}.mjs"
    return subprocess.run(["node", program, modules, browser, f"http://{address}", *map(str, more)]).returncode


def restart(modules, browser, flags):
    """The service is killed in the middle of a job and starts again at the same address, with the same data."""
    with tempfile.TemporaryDirectory() as data:
        first = service.Service("--data", data, *flags)
        program = service.ROOT / "tests" / "external" / "studio" / "restart.mjs"
        page = subprocess.Popen(["node", program, modules, browser, f"http://{first.address}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        second = None
        try:
            for line in page.stdout:
                if line.startswith("kill"):
                    first.stop(signal.SIGKILL)
                    page.stdin.write("killed\n")
                    page.stdin.flush()
                elif line.startswith("start"):
                    second = service.Service("--data", data, "--listen", first.address, *flags)
                    page.stdin.write("started\n")
                    page.stdin.flush()
                else:
                    print(line, end="", flush=True)
            return page.wait(timeout=120)
        finally:
            if second:
                second.stop()


def keys(modules, browser, flags):
    """A service that wants a key."""
    with tempfile.TemporaryDirectory() as folder:
        file = f"{folder}/keys.toml"
        key = service.key(file, "studio")["Authorization"].removeprefix("Bearer ")
        with service.running("--keys", file, *flags) as address:
            return node(modules, browser, "keys", address, key)


def farm(modules, browser, flags):
    """A service with a farm, whose first node comes when there is work."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        broker = Broker(folder).until_healthy()
        shared = ["--farm", f"nats://127.0.0.1:{broker.port}", "--store", folder / "store"]
        front, worker = service.Service(*shared, *flags), None
        program = service.ROOT / "tests" / "external" / "studio" / "farm.mjs"
        page = subprocess.Popen(["node", program, modules, browser, f"http://{front.address}"], stdout=subprocess.PIPE, text=True)
        try:
            for line in page.stdout:
                if line.startswith("node"):
                    worker = subprocess.Popen([service.PROGRAM, "node", *shared, "--slots", "1", "--name", "flow-node"], stderr=subprocess.DEVNULL)
                else:
                    print(line, end="", flush=True)
            return page.wait(timeout=120)
        finally:
            if worker:
                worker.terminate()
                worker.wait(timeout=60)
            front.stop()
            broker.stop()


def main():
    suites = sys.argv[1:] or SUITES
    if unknown := set(suites) - set(SUITES):
        sys.exit(f"there is no {', '.join(unknown)}; there are {', '.join(SUITES)}")
    browser = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    for program, found in (("node", shutil.which("node")), ("npm", shutil.which("npm")), ("chromium", browser)):
        if not found:
            sys.exit(f"this test needs {program}, which is not installed")
    modules = service.node("studio", *PACKAGES)
    flags = ["--studio-files", os.environ["STUDIO_FILES"]] if "STUDIO_FILES" in os.environ else []
    failed = []
    for suite in suites:
        print(f"== {suite}", flush=True)
        started = time.monotonic()
        if suite in ("restart", "keys", "farm"):
            code = {"restart": restart, "keys": keys, "farm": farm}[suite](modules, browser, flags)
        else:
            with service.running("--admin-listen", "127.0.0.1:0", *flags) as address:
                code = node(modules, browser, suite, address)
        print(f"== {suite} took {time.monotonic() - started:.0f} s", flush=True)
        if code != 0:
            failed.append(suite)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
