#!/usr/bin/env python3
"""strahl beside POV-Ray and a Whitted renderer on Embree, on the same scenes, in one interleaved run.

    python3 benches/peers/compare.py                   # sets up what is missing, builds strahl, seven rounds
    python3 benches/peers/compare.py --rounds 1 --scenes W1 W4

Prints a Markdown table, and keeps it with every single time in target/peers/comparison.{md,json}. On a shared machine
times swing by half, so only the ratios of one run mean something.
"""

import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
OUT = ROOT / "target" / "peers"
sys.path.append(str(HERE.parent))
from machine import commit, machine  # noqa: E402

BARE = ["W1", "W2", "W2d6", "W3", "W4"]
# Only POV-Ray and strahl have pictures on meshes.
TEXTURED = ["W6"]
# The same, each renderer antialiasing by its own rule: POV-Ray where neighbours differ by 0.03, with 16 samples.
ANTIALIASED = "+aa"
SCENES = BARE + TEXTURED + [name + ANTIALIASED for name in ("W1", "W2", "W3", "W4", "W6")]
STRAHL = "strahl"


def runners(scene, threads):
    """Name and command of each renderer of a scene; each prints `TIME seconds`."""
    if scene.endswith(ANTIALIASED):
        bare = scene.removesuffix(ANTIALIASED)
        return {
            "POV-Ray": ["run_povray.sh", bare, threads, "+A0.03 +AM1 +R4"],
            STRAHL: ["run_strahl.sh", bare, threads, "--antialias true"],
        }
    all_of_them = {
        "POV-Ray": ["run_povray.sh", scene, threads],
        "Embree, packets": ["run_embree.sh", scene, "hybrid", threads],
        "Embree, single rays": ["run_embree.sh", scene, "single", threads],
        "limit": ["run_limit.sh", scene, threads],
        STRAHL: ["run_strahl.sh", scene, threads],
    }
    # The limit knows no hierarchy.
    if scene in TEXTURED:
        return {name: all_of_them[name] for name in ("POV-Ray", STRAHL)}
    return {name: command for name, command in all_of_them.items() if name != "limit" or scene == "W1"}


def time(command):
    """Seconds of one render."""
    ended = subprocess.run([HERE / command[0], *command[1:]], capture_output=True, text=True)
    times = [line.split()[1] for line in ended.stdout.splitlines() if line.startswith("TIME ")]
    if not times:
        sys.exit(f"{' '.join(command)} printed no time\n{ended.stdout}{ended.stderr}")
    return float(times[-1])


def measure(scene, rounds, threads):
    """All times of each renderer, one for each round."""
    commands = list(runners(scene, threads).items())
    times = {name: [] for name, _ in commands}
    for turn in range(rounds):
        # Every round in another order, since the first after a pause may be slower.
        first = turn % len(commands)
        for name, command in commands[first:] + commands[:first]:
            times[name].append(time(command))
    return times


def ratio(times, name):
    """How many times as long as strahl: the median over the rounds, whose two times are from the same minute."""
    return statistics.median(other / ours for other, ours in zip(times[name], times[STRAHL]))


def table(figures):
    names = list(figures["times"]["W1"]) if "W1" in figures["times"] else list(next(iter(figures["times"].values())))
    others = [name for name in names if name != STRAHL]
    lines = [f"{figures['date']}, {figures['machine']}, {figures['threads']} threads, commit {figures['commit']}, "
             f"medians of {figures['rounds']} interleaved rounds, seconds of the trace phase; in brackets how many times "
             "as long as strahl.", "",
             f"| Scene | {STRAHL} | {' | '.join(others)} |", "|---" * (len(names) + 1) + "|"]
    for scene, times in figures["times"].items():
        cells = [f"{statistics.median(times[name]):.3f} ({ratio(times, name):.2f})" if name in times else ""
                 for name in others]
        lines.append(f"| {scene} | {statistics.median(times[STRAHL]):.3f} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7, help="times each renderer renders each scene")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=SCENES)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    asked = parser.parse_args()
    if not (OUT / "ready").exists():
        subprocess.run([HERE / "setup.sh"], check=True)
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    figures = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(),
               "threads": asked.threads, "rounds": asked.rounds, "times": {}}
    for scene in asked.scenes:
        print(f"{scene} ...", file=sys.stderr, flush=True)
        figures["times"][scene] = measure(scene, asked.rounds, str(asked.threads))
    (OUT / "comparison.json").write_text(json.dumps(figures, indent=1) + "\n")
    (OUT / "comparison.md").write_text(table(figures))
    print(table(figures), end="")


if __name__ == "__main__":
    main()
