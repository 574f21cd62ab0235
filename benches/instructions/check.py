#!/usr/bin/env python3
"""Counts the instructions that the kernels take for small pictures, and compares them with recorded counts: an effect
that a scene does not call for must not cost it anything, and unlike times, counts can tell.

    cargo build --release
    python3 benches/instructions/check.py            # compare; exit code 1 if a count has changed
    python3 benches/instructions/check.py --record   # write counts.json

It needs valgrind. Counts depend on the compiler, the C library, valgrind and the instruction set it offers, so with others
nothing is compared. They do not depend on the processor: valgrind runs the same AVX2 code on Intel's and AMD's. Only what runs
inside of kernels counts, so waiting threads, start-up and the encoding of pictures do not: a count is the same each time.
"""

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from machine import machine  # noqa: E402

ROOT = HERE.parent.parent
COUNTS = HERE / "counts.json"
TOLERANCE = 0.001
# The functions that hold the kernels.
KERNELS = "strahl::render::kernels::*::run"

FLOOR = {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt"}}


def ball(material):
    return {"sphere": {"center": [0, 1, 0], "radius": 1, "material": material}}


def scene(objects, materials, **render):
    return {
        "version": 1,
        "camera": {"pinhole": {"eye": [0, 2, 6], "look_at": [0, 0.8, 0]}},
        "background": [0.3, 0.5, 0.8],
        "lights": [{"point": {"position": [4, 6, 3]}}],
        "materials": {"matt": {"diffuse": 0.7}, **materials},
        "objects": objects,
        "render": {"antialias": False, **render},
    }


SCENES = {
    "local": scene([FLOOR, ball("matt")], {}),
    "mirrors": scene([FLOOR, ball("mirror")], {"mirror": {"diffuse": 0.1, "reflection": 0.8}}),
    "clear": scene([FLOOR, ball("glass")], {"glass": {"diffuse": 0, "transmission": 0.9, "reflection": 0.05, "ior": 1.5}}),
    "clear, double": scene(
        [FLOOR, ball("glass")], {"glass": {"diffuse": 0, "transmission": 0.9, "ior": 1.5}}, precision="double"
    ),
    "everything: gloss": scene(
        [FLOOR, ball("satin")], {"satin": {"diffuse": 0.1, "reflection": 0.8, "roughness": 0.3}}, samples=4
    ),
    "unused materials": scene(
        [FLOOR, ball("matt")], {"glass": {"transmission": 0.9, "ior": 1.5}, "mirror": {"reflection": 0.8}}
    ),
}


BALLS = scene(
    [FLOOR, ball("mirror"), {"sphere": {"center": [1.8, 0.8, 1.5], "radius": 0.8, "material": "glass"}}],
    {
        "mirror": {"diffuse": 0.1, "specular": 0.6, "shininess": 80, "reflection": 0.8},
        "glass": {"diffuse": 0.02, "specular": 0.6, "reflection": 0.08, "transmission": 0.9, "ior": 1.5},
        "matt": {"diffuse": {"checker": {"a": [0.9, 0.9, 0.2], "b": [0.8, 0.1, 0.1]}}},
    },
)
GLASS_BALLS = {
    **scene(
        [FLOOR]
        + [
            {"sphere": {"center": [x - 4.5, y - 3.5, z - 4.5], "radius": 0.42, "material": "glass"}}
            for x in range(10)
            for y in range(10)
            for z in range(10)
        ],
        {"glass": {"specular": 0.3, "shininess": 60, "reflection": 0.1, "transmission": 0.88, "ior": 1.5}},
        max_depth=10,
        accuracy={"proved": {"max_codes": 1}},
    ),
    "camera": {"pinhole": {"eye": [9, 7, 14], "look_at": [0, 0.5, 0], "vfov_deg": 42}},
}


def repository(name):
    return json.loads((ROOT / "scenes" / f"{name}.json").read_text())


# What the peers' scenes are made of (benches/peers), small: each is counted bare and antialiased.
PEERS = {
    "W1: two balls": (BALLS, 96),
    "W2: a sphere flake": (repository("spheres/flake_4"), 64),
    "W3: a mesh": (repository("meshes/knot"), 96),
    "W4: glass balls": (GLASS_BALLS, 16),
}

MATT = {"red": {"diffuse": [0.7, 0.3, 0.2], "specular": 0.3, "reflection": 0.2}}
PLACES = [(x - 2.5, 0.5 + y, z - 2.5) for x in range(6) for y in range(3) for z in range(6)]


def pipes(place):
    """A ball, and pipes from it along each axis: open, closed, and a cone."""
    x, y, z = place
    return [
        {"sphere": {"center": place, "radius": 0.16, "material": "red"}},
        {"cylinder": {"base": place, "top": [x + 1, y, z], "radius": 0.07, "capped": False, "material": "red"}},
        {"cylinder": {"base": place, "top": [x, y + 1, z], "radius": 0.07, "material": "red"}},
        {"cone": {"base": place, "base_radius": 0.09, "top": [x, y, z + 1], "top_radius": 0.03, "material": "red"}},
    ]


def ring(place):
    axis = [place[0], 1, place[2]]
    return {"torus": {"center": place, "axis": axis, "major_radius": 0.35, "minor_radius": 0.1, "material": "red"}}


def copy(place):
    return {"instance": {"of": "ball", "transform": {"translate": place, "scale": 0.4}}}


# What else a leaf may hold, and what is looked up where a ray ends.
PARTS = {
    "frusta": (scene([part for place in PLACES for part in pipes(place)], MATT), 64),
    "tori": (scene([ring(place) for place in PLACES], MATT), 64),
    "copies of a ball": (
        {
            **scene([copy(place) for place in PLACES], MATT),
            "definitions": {"ball": [{"sphere": {"center": [0, 0, 0], "radius": 1, "material": "red"}}]},
        },
        96,
    ),
    "textures": (repository("effects/textures"), 64),
    "bumps": (repository("effects/bump"), 64),
}


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def conditions():
    """What counts depend on besides the program's source."""
    flags = Path("/proc/cpuinfo").read_text().split()
    return {
        "rustc": output("rustc", "--version").strip(),
        "valgrind": output("valgrind", "--version").strip(),
        "libc": " ".join(platform.libc_ver()),
        # Valgrind knows nothing newer and hides the rest.
        "level": "avx2" if "avx2" in flags else "sse2",
    }


def instructions(program, path, width=256):
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={KERNELS}"]
    command += [program, "render", path, "-o", os.devnull, "--format", "png"]
    command += ["--threads", "1", "--width", str(width), "--height", str(width * 3 // 4)]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    count = int(re.search(r"Collected : (\d+)", said).group(1))
    if count == 0:
        raise SystemExit(f"no function of the program is called {KERNELS}")
    return count


def cases():
    """Name, scene and width of everything that is counted."""
    for name, description in SCENES.items():
        yield name, description, 256
    for name, (description, width) in PEERS.items():
        for antialias, how in [(False, ""), (True, ", antialiased")]:
            render = {**description.get("render", {}), "antialias": antialias}
            yield name + how, {**description, "render": render}, width
    for name, (description, width) in PARTS.items():
        render = {**description.get("render", {}), "antialias": False}
        yield name, {**description, "render": render}, width


def count_all(program):
    counts = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, description, width in cases():
            path = os.path.join(folder, "scene.json")
            Path(path).write_text(json.dumps(description))
            plan = json.loads(output(program, "explain", path, "--format", "json"))
            took = instructions(program, path, width)
            counts[name] = {"kernel": plan["kernel"], "instructions": took}
            print(f"{name:<34}{plan['kernel']:<42}{took:>14,}", flush=True)
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "target/release/strahl"))
    parser.add_argument("--record", action="store_true", help="write counts.json")
    args = parser.parse_args()
    if not shutil.which("valgrind"):
        print("skipped: there is no valgrind")
        return 0
    now = conditions()
    if args.record:
        recorded = {"conditions": now, "processor": machine(), "counts": count_all(args.program)}
        COUNTS.write_text(json.dumps(recorded, indent=2) + "\n")
        return 0
    return 1 if compare(count_all(args.program), now) else 0


def compare(counted, now):
    """How many counts are not as recorded; it says which."""
    wrong = 0
    # On any machine: effects of materials that nothing uses take no instruction.
    extra = counted["unused materials"]["instructions"] / counted["local"]["instructions"] - 1
    if abs(extra) > TOLERANCE:
        print(f"unused materials: {extra:+.2%} instructions")
        wrong += 1
    recorded = json.loads(COUNTS.read_text())
    if recorded["conditions"] != now:
        print(f"not compared with recorded counts, which are of {recorded['conditions']}; this is {now}")
        return wrong
    for name, new in counted.items():
        old = recorded["counts"].get(name)
        if old is None:
            print(f"{name}: not recorded yet")
            wrong += 1
            continue
        change = new["instructions"] / old["instructions"] - 1
        if abs(change) > TOLERANCE or new["kernel"] != old["kernel"]:
            print(f"{name}: {change:+.2%} instructions ({old['kernel']} to {new['kernel']})")
            wrong += 1
    print("all counts are as recorded" if wrong == 0 else f"{wrong} counts have changed")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
