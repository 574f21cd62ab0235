#!/usr/bin/env python3
"""What the proof of the default mode costs: every scene with `--accuracy proved:1` and with `--accuracy fixed`, in turn.

    cargo build --release
    python3 benches/proof.py                       # a table in Markdown; some four minutes. Needs numpy
    python3 benches/proof.py --only hard --rounds 3
    python3 benches/proof.py --binary OTHER        # another program, to compare two

Antialiased pictures of 320 x 180 pixels on one thread. Times are seconds of processor time of the whole program but for loading,
which a picture of one pixel takes, too; of each the median over the rounds. Rays are exact. Codes are the most that the fixed
mode may be off.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
OUT = ROOT / "target" / "proof"
sys.path += [str(HERE), str(HERE / "peers")]
import scaling  # noqa: E402
import scenes as peers  # noqa: E402

MODES = ["fixed", "proved:1"]


def scenes(only):
    """Name, file and size of each."""
    OUT.mkdir(parents=True, exist_ok=True)
    wide = ["--width", "320", "--height", "180"]
    found = [(str(path.relative_to(ROOT / "scenes"))[:-5], path, wide) for path in sorted(ROOT.glob("scenes/*/*.json"))]
    glass = OUT / "W4.json"
    with open(glass, "w", encoding="utf-8") as file:
        peers.strahl(peers.W4(), file)
    found.append(("W4, 1,000 glass balls", glass, ["--width", "96", "--height", "96"]))
    for count in (64, 1000):
        lights = OUT / f"lights_{count}.json"
        lights.write_text(json.dumps(scaling.lit_by(count)))
        found.append((f"whitted, {count} lights", lights, ["--width", "96", "--height", "54"]))
    return [scene for scene in found if only in scene[0]]


def run(binary, path, options):
    """Seconds of processor time, and the report."""
    command = [binary, "render", path, "-o", OUT / "out.png", "--threads", "1", "--stats", OUT / "stats.json", *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return usage.ru_utime + usage.ru_stime, json.loads((OUT / "stats.json").read_text())


def traced(rays):
    return sum(rays[kind] for kind in ("camera", "shadow", "reflected", "transmitted", "gathered"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="", help="scenes with this in their name")
    parser.add_argument("--binary", default=ROOT / "target/release/strahl")
    arguments = parser.parse_args()
    shares = []
    print("| scene | fixed, ms | its codes | proved, time | rays |\n|---|---|---|---|---|")
    for name, path, size in scenes(arguments.only):
        options = {mode: ["--antialias", "true", "--accuracy", mode, *size] for mode in MODES}
        corner = ["--accuracy", "fixed", "--samples", "1", "--region", "0,0,1,1", *size]
        times = {mode: [] for mode in [*MODES, "load"]}
        rays, codes = {}, {}
        for _ in range(arguments.rounds):
            times["load"].append(run(arguments.binary, path, corner)[0])
            for mode in MODES:
                seconds, report = run(arguments.binary, path, options[mode])
                times[mode].append(seconds)
                rays[mode] = traced(report["cost"]["rays"])
                codes[mode] = report["error"]["proved"]["max_codes"]
        load = statistics.median(times["load"])
        fixed, proved = [max(statistics.median(times[mode]) - load, 1e-4) for mode in MODES]
        shares.append(proved / fixed)
        share = rays["proved:1"] / rays["fixed"]
        print(f"| {name} | {fixed * 1e3:.0f} | {codes['fixed']} | {proved / fixed:.2f} | {share:.2f} |", flush=True)
    print(f"\nmedian {statistics.median(shares):.2f}, most {max(shares):.2f}")


if __name__ == "__main__":
    main()
