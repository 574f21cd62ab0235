#!/usr/bin/env python3
"""The IIIF validator against the service: Image API 3.0, level 2, no failures.

    cargo build --release && python3 tests/external/iiif.py [ROUNDS]

It installs the validator (PyPI) into target/external. The image it wants is a scene: scenes/iiif/squares.json. It
chooses regions and sizes at random, so it runs several times.
"""

import subprocess
import sys

import service

VALIDATOR = "iiif-validator==1.0.5"
# What it calls level 3, but the service has. Two of its tests cannot be passed: format_webp calls what only Python 2 has,
# and size_up wants ^max to be the image's own size, where section 4.2 wants the largest that maxArea allows.
FURTHER = ["linkheader_canonical", "linkheader_profile", "rot_mirror", "rot_mirror_180"]


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    validate = service.python(VALIDATOR) / "iiif-validate.py"
    with service.running("--cors-origin", "*") as address:
        image = service.add(address, "scenes/iiif/squares.json")["image_id"]
        about = [validate, "-s", address, "-p", "iiif/3", "-i", image, "--version=3.0", "-v"]
        further = [part for name in FURTHER for part in ("--test", name)]
        for _ in range(rounds):
            for what, count in ((["--level", "2"], 33), (further, len(FURTHER))):
                done = subprocess.run([*about, *what], capture_output=True, text=True)
                said = done.stdout + done.stderr
                if done.returncode != 0 or f"({count} tests, 0 failures)" not in said:
                    sys.exit(f"the validator is not content:\n{said}")
    print(f"IIIF Image API 3.0: 33 tests of level 2 and {len(FURTHER)} of level 3, {rounds} times, 0 failures")


if __name__ == "__main__":
    main()
