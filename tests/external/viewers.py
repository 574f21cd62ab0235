#!/usr/bin/env python3
"""OpenSeadragon and Leaflet in a browser: every tile of every convention comes, also in a storm of panning and zooming.

    cargo build --release && python3 tests/external/viewers.py

It needs node, npm and Chromium (Debian: nodejs, npm, chromium; or CHROMIUM=path), and installs the viewers and
puppeteer-core (npm) into target/external.
"""

import os
import shutil
import subprocess
import sys

import service

PACKAGES = ["openseadragon@6.1.1", "leaflet@1.9.4", "puppeteer-core@25.16.0"]


def main():
    browser = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    for program, found in (("node", shutil.which("node")), ("npm", shutil.which("npm")), ("chromium", browser)):
        if not found:
            sys.exit(f"this test needs {program}, which is not installed")
    modules = service.node("viewers", *PACKAGES)
    with service.running() as address:
        known = service.add(address, "scenes/whitted/whitted.json", "?zoom=2")
        program = service.ROOT / "tests" / "external" / "viewers.mjs"
        command = ["node", program, modules, browser, f"http://{address}", known["image_id"]]
        sys.exit(subprocess.run(command).returncode)


if __name__ == "__main__":
    main()
