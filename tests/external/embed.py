#!/usr/bin/env python3
"""`<strahl-picture>` in a browser: jobs, images and scenes in pages of others, with cut connections and a strict policy.

    cargo build --release && python3 tests/external/embed.py [FLOW...]

It needs node, npm and Chromium (Debian: nodejs, npm, chromium; or CHROMIUM=path), and installs puppeteer-core and axe-core
(npm) into target/external.
"""

import gzip
import os
import shutil
import subprocess
import sys
import tempfile

import service

PACKAGES = ["puppeteer-core@25.16.0", "axe-core@4.14.1"]
BUDGET = 8_192


def main():
    browser = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    for program, found in (("node", shutil.which("node")), ("npm", shutil.which("npm")), ("chromium", browser)):
        if not found:
            sys.exit(f"this test needs {program}, which is not installed")
    size = len(gzip.compress((service.ROOT / "web/embed/strahl-picture.js").read_bytes(), 9))
    print(f"strahl-picture.js: {size} bytes gzip of {BUDGET}")
    modules = service.node("embed", *PACKAGES)
    program = service.ROOT / "tests" / "external" / "embed.mjs"
    strahl = os.environ.get("STRAHL_BINARY") or service.PROGRAM
    with tempfile.TemporaryDirectory() as folder:
        command = ["node", program, modules, browser, strahl, folder, *sys.argv[1:]]
        failed = subprocess.run(command, cwd=service.ROOT).returncode
    sys.exit(failed or size > BUDGET)


if __name__ == "__main__":
    main()
