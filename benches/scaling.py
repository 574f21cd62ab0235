#!/usr/bin/env python3
"""How the time of a picture grows: with threads, with primitives, with pixels and with lights.

    cargo build --release
    python3 benches/scaling.py                         # five rounds, some minutes, into target/scaling
    python3 benches/scaling.py --rounds 15 --record    # and record numbers and drawing

It needs nothing but Python's own library. What is timed is the trace phase, without antialiasing, in single precision.
All points are measured in turn in each round, so that what disturbs the machine disturbs them all.
"""

import argparse
import datetime
import json
import math
import os
import statistics
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
OUT = ROOT / "target" / "scaling"
sys.path += [str(HERE / "naive"), str(ROOT / "scenes")]
from generate import flake  # noqa: E402
from machine import commit, machine  # noqa: E402
from panels import Panel, drawing  # noqa: E402
from timing import SCENES, trace  # noqa: E402

LEVELS = range(3, 10)
SIZES = [(240, 135), (480, 270), (960, 540), (1920, 1080)]
LIGHTS = [1, 2, 4, 8]


def written(name, scene):
    """The absolute path of a scene made here; beside it those of the repository are below `scenes`."""
    path = OUT / f"{name}.json"
    path.write_text(json.dumps(scene))
    return str(path)


def lit_by(count):
    """Whitted's picture with so many lights on a circle above it, together as bright as one."""
    scene = json.loads((ROOT / "scenes/whitted/whitted.json").read_text())
    turns = [2 * math.pi * i / count for i in range(count)]
    scene["lights"] = [{"point": {"position": [4 + 30 * math.cos(turn), 40, 30 * math.sin(turn)],
                                  "intensity": 1 / count}} for turn in turns]
    return scene


def points(threads):
    """Everything that is timed: a key, and scene, options and threads for it."""
    square = ["--width", "160", "--height", "160"]
    all_points = {}
    for scene, options in SCENES:
        for count in {1, threads}:
            all_points["threads", scene, count] = (scene, options, count)
    for level in LEVELS:
        all_points["primitives", level] = (written(f"flake_{level}", flake(level)), square, threads)
    for width, height in SIZES:
        options = ["--width", str(width), "--height", str(height)]
        all_points["pixels", width, height] = ("whitted/whitted.json", options, threads)
    for count in LIGHTS:
        all_points["lights", count] = (written(f"lights_{count}", lit_by(count)), [], threads)
    return all_points


def measure(binary, threads, rounds):
    """Median milliseconds and rays of each point."""
    all_points = points(threads)
    times = {key: [] for key in all_points}
    rays = {}
    for turn in range(rounds + 1):
        for key, (scene, options, count) in all_points.items():
            time, rays[key] = trace(ROOT, binary, scene, options, "single", count, OUT)
            # The first round warms caches.
            if turn > 0:
                times[key].append(time)
        print(f"round {turn} of {rounds}", file=sys.stderr, flush=True)

    def one(*key):
        return {"ms": round(statistics.median(times[key]), 3), "rays": rays[key]}

    def speedup(scene):
        ratios = [a / b for a, b in zip(times["threads", scene, 1], times["threads", scene, threads])]
        return {"scene": scene, "one_ms": one("threads", scene, 1)["ms"],
                "all_ms": one("threads", scene, threads)["ms"], "speedup": round(statistics.median(ratios), 3)}

    return {
        "threads": [speedup(scene) for scene, _ in SCENES],
        "primitives": [{"level": level, "spheres": (9 ** (level + 1) - 1) // 8} | one("primitives", level)
                       for level in LEVELS],
        "pixels": [{"width": w, "height": h} | one("pixels", w, h) for w, h in SIZES],
        "lights": [{"lights": count} | one("lights", count) for count in LIGHTS],
    }


def figure(figures):
    """The drawing: four panels."""
    threads, most = figures["threads"], figures["all_threads"]
    names = [row["scene"].split("/")[-1].split(".")[0] for row in threads]
    speed = Panel(f"Threads: times as fast on {most} as on one", "", "", [0, most], range(len(threads)))
    speed.bars(names, [row["speedup"] for row in threads])
    sizes = [row["spheres"] for row in figures["primitives"]]
    grown = [row["ms"] for row in figures["primitives"]]
    primitives = Panel("Primitives: a sphere flake of instances, levels 3 to 9", "spheres", "ms", sizes, [0, *grown],
                       log_x=True)
    primitives.line(sizes, grown)
    counts = [row["width"] * row["height"] for row in figures["pixels"]]
    took = [row["ms"] for row in figures["pixels"]]
    pixels = Panel("Pixels: whitted.json (dashed: in proportion)", "pixels", "ms", counts, took, log_x=True, log_y=True)
    pixels.line(counts, [took[-1] * count / counts[-1] for count in counts], dashed=True)
    pixels.line(counts, took)
    lights = [row["lights"] for row in figures["lights"]]
    lit = [row["ms"] for row in figures["lights"]]
    proportional = [lit[0] * count for count in lights]
    lighting = Panel("Lights: whitted.json (dashed: in proportion)", "lights", "ms", [0, *lights], [0, *proportional, *lit])
    lighting.line(lights, proportional, dashed=True)
    lighting.line(lights, lit)
    title = f"How the time of a picture grows ({figures['machine']}, {figures['date']})"
    return drawing(title, [speed, primitives, pixels, lighting])


def report(figures):
    for row in figures["threads"]:
        print(f"{row['scene']}: {row['one_ms']} ms on one thread, {row['speedup']} times as fast on "
              f"{figures['all_threads']}")
    for row in figures["primitives"]:
        print(f"{row['spheres']:,} spheres: {row['ms']} ms, {row['rays']:,} rays")
    for row in figures["pixels"]:
        print(f"{row['width']} x {row['height']}: {row['ms']} ms")
    for row in figures["lights"]:
        print(f"{row['lights']} lights: {row['ms']} ms, {row['rays']:,} rays")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="times each point is measured")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--strahl", type=Path, default=ROOT / "target/release/strahl", help="the program to time")
    parser.add_argument("--record", action="store_true", help="write scaling.json beside this program, and docs/pictures/scaling.svg")
    asked = parser.parse_args()
    if not asked.strahl.exists():
        sys.exit(f"there is no {asked.strahl}: cargo build --release")
    OUT.mkdir(parents=True, exist_ok=True)
    figures = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(),
               "rounds": asked.rounds, "all_threads": asked.threads}
    figures |= measure(asked.strahl, asked.threads, asked.rounds)
    report(figures)
    for numbers, drawing in [(OUT, OUT), (HERE, ROOT / "docs/pictures")] if asked.record else [(OUT, OUT)]:
        (numbers / "scaling.json").write_text(json.dumps(figures, indent=1) + "\n")
        (drawing / "scaling.svg").write_text(figure(figures))


if __name__ == "__main__":
    main()
