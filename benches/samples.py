#!/usr/bin/env python3
"""What it takes to sample each pixel as its error asks for, beside as many samples everywhere.

    cargo build --release
    python3 benches/samples.py                       # a table in Markdown; some ten minutes, most of them for references
    python3 benches/samples.py --width 320 --before PATH/TO/ANOTHER/strahl

References have 4,096 samples: a picture of twice the size with 1,024, whose pixels are averaged four by four. They are kept in
target/samples, where they may be deleted. Errors are root mean squares over pixels and channels, in 8-bit codes with fractions.
"For an equal error" are the rays divided by those of as many samples everywhere, between 4 and 256, with that error. `--before`
compares with another program: its rays and errors, and the user time on one thread as the median of interleaved rounds.
"""

import argparse
import array
import json
import math
import resource
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "target" / "samples"
SCENES = ["soft_shadows", "gloss", "motion_blur", "dispersion", "color_bleeding", "depth_of_field"]
COUNTS = [4, 8, 16, 32, 64, 128, 256]
KINDS = ["camera", "shadow", "reflected", "transmitted", "gathered"]


def read(path):
    """Width, height and the numbers of a PFM, from its lowest row up."""
    header, size, scale, numbers = path.read_bytes().split(b"\n", 3)
    assert header == b"PF" and float(scale) < 0
    width, height = map(int, size.split())
    floats = array.array("f")
    floats.frombytes(numbers)
    return width, height, floats


def folded(path):
    """A picture of half the size: the mean of each four pixels."""
    width, height, numbers = read(path)
    row = 3 * width
    return [(numbers[i] + numbers[i + 3] + numbers[i + row] + numbers[i + row + 3]) / 4
            for y in range(0, height, 2) for x in range(0, row, 6) for i in range(y * row + x, y * row + x + 3)]


def code(light):
    light = min(max(light, 0), 1)
    return 255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055)


class Scene:
    def __init__(self, name, width, height):
        self.path = ROOT / "scenes/effects" / f"{name}.json"
        self.name, self.size = name, (width, height)
        self.reference = None

    def render(self, program, path, samples=None, scale=1, threads=None):
        """Renders a picture; its rays and the user seconds it took."""
        width, height = self.size
        stats = OUT / "stats.json"
        command = [program, "render", self.path, "-o", path, "--antialias", "false", "--stats", stats,
                   "--width", str(scale * width), "--height", str(scale * height)]
        command += ["--samples", str(samples)] if samples else []
        command += ["--threads", str(threads)] if threads else []
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(command, check=True, capture_output=True)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        rays = json.loads(stats.read_text())["cost"]["rays"]
        return sum(rays[kind] for kind in KINDS), seconds

    def refer(self, program):
        path = OUT / f"{self.name}.{self.size[0]}.pfm"
        if not path.exists():
            partial = path.with_suffix(".partial.pfm")
            self.render(program, partial, 1024, 2)
            partial.rename(path)
        self.reference = [code(light) for light in folded(path)]

    def measure(self, program, samples=None):
        """Rays, error, and the share of the pixels more than 1.5 codes off."""
        picture = OUT / "picture.pfm"
        rays, _ = self.render(program, picture, samples)
        off = [abs(code(light) - known) for light, known in zip(read(picture)[2], self.reference)]
        far = sum(max(off[i:i + 3]) > 1.5 for i in range(0, len(off), 3))
        return rays, math.sqrt(sum(each * each for each in off) / len(off)), 3 * far / len(off)


def rays_for(error, curve):
    """Rays of as many samples everywhere with an error, between those that were measured."""
    for (few, high), (many, low) in zip(curve, curve[1:]):
        if low <= error:
            break
    share = math.log(high / error) / math.log(high / low)
    return few * (many / few) ** share


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--before", type=Path, help="another program")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    program = ROOT / "target/release/strahl"
    print("| scene | rays, of 64 | error, of 64 | for an equal error | beyond 1.5 codes | at 64 |", end="")
    print(" before: rays, error | user time |" if arguments.before else "")
    print("|---|---|---|---|---|---|" + ("---|---|" if arguments.before else ""))
    for name in SCENES:
        scene = Scene(name, arguments.width, arguments.width * 9 // 16)
        scene.refer(program)
        fixed = {count: scene.measure(program, count) for count in COUNTS}
        rays, error, far = scene.measure(program)
        equal = rays / rays_for(error, [fixed[count][:2] for count in COUNTS])
        print(f"| {name} | {rays / fixed[64][0]:.2f} | {error / fixed[64][1]:.2f} | {equal:.2f} | {far:.3f} "
              f"| {fixed[64][2]:.3f} |", end="")
        if arguments.before:
            old_rays, old_error, _ = scene.measure(arguments.before)
            times = [[scene.render(each, OUT / "picture.pfm", threads=1)[1] for each in (program, arguments.before)]
                     for _ in range(arguments.rounds)]
            new, old = (statistics.median(column) for column in zip(*times))
            print(f" {rays / old_rays:.2f}, {error / old_error:.2f} | {new / old:.2f} |", end="")
        print(flush=True)


if __name__ == "__main__":
    main()
