#!/usr/bin/env python3
"""What each effect costs where it is used: its scene with it, and without it, in turn.

    cargo build --release
    python3 benches/effects.py              # a table in Markdown; some two minutes
    python3 benches/effects.py --record     # and the figures in benches/effects.json

Time is that of the trace phase on all cores, as the median of interleaved rounds. "At equal samples" compares what one
sample costs; "as asked" is the whole picture with the samples that the scene gets by itself (one, or where it
calls for choices as many as the error of each pixel asks for), without antialiasing.
"""

import argparse
import copy
import datetime
import json
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
OUT = ROOT / "target" / "effects"
sys.path.append(str(HERE))
from machine import commit, machine  # noqa: E402

SIZE = ["--width", "480", "--height", "270"]


def drop(node, keys):
    """The scene without some keys, wherever they stand."""
    if isinstance(node, dict):
        return {key: drop(value, keys) for key, value in node.items() if key not in keys}
    return [drop(value, keys) for value in node] if isinstance(node, list) else node


def uniform(scene, kinds):
    """Patterns of these kinds in one color."""
    for material in scene["materials"].values():
        for key in ("diffuse", "ambient"):
            if isinstance(material.get(key), dict) and set(material[key]) & kinds:
                material[key] = 0.5
    return scene


# Effect: its scene, and the scene without it.
EFFECTS = {
    "soft shadows": ("soft_shadows", lambda s: drop(s, {"area"})),
    "gloss": ("gloss", lambda s: drop(s, {"roughness"})),
    "depth of field": ("depth_of_field", lambda s: drop(s, {"aperture", "focus_distance"})),
    "motion blur": ("motion_blur", lambda s: drop(s, {"motion"})),
    "dispersion": ("dispersion", lambda s: drop(s, {"dispersion"})),
    "color bleeding": ("color_bleeding", lambda s: drop(s, {"color_bleeding"})),
    "emission": ("emission", lambda s: drop(s, {"emission"})),
    "Fresnel": ("fresnel", lambda s: drop(s, {"fresnel"})),
    "absorption": ("absorption", lambda s: drop(s, {"absorption"})),
    "colored shadows": ("colored_shadows", lambda s: drop(s, {"shadows"})),
    "fog": ("fog", lambda s: drop(s, {"fog"})),
    "textures": ("textures", lambda s: uniform(s, {"image", "noise", "gradient"})),
    "bump and normal maps": ("bump", lambda s: drop(s, {"bump", "normal_map"})),
    "environment": ("environment", lambda s: drop(s, {"environment"})),
}


def trace_ms(scene, samples):
    stats = OUT / "stats.json"
    more = ["--samples", str(samples)] if samples else []
    command = [ROOT / "target/release/strahl", "render", scene, "-o", OUT / "out.png", "--antialias", "false",
               "--stats", stats, *SIZE, *more]
    subprocess.run(command, check=True, capture_output=True)
    return json.loads(stats.read_text())["cost"]["phases_ms"]["trace"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--record", action="store_true", help="write benches/effects.json")
    arguments = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    pairs = {}
    for effect, (name, without) in EFFECTS.items():
        path = ROOT / "scenes/effects" / f"{name}.json"
        plain = OUT / f"{name}.json"
        plain.write_text(json.dumps(without(copy.deepcopy(json.loads(path.read_text())))))
        pairs[effect] = (path, plain)
    times = {(effect, kind, samples): [] for effect in pairs for kind in (0, 1) for samples in (16, None)}
    for _ in range(arguments.rounds):
        for effect, kind, samples in times:
            times[effect, kind, samples].append(trace_ms(pairs[effect][kind], samples))
    figures = {}
    print("| effect | with it, ms | at equal samples | as asked |\n|---|---|---|---|")
    for effect in pairs:
        ms = {(kind, samples): statistics.median(times[effect, kind, samples])
              for kind in (0, 1) for samples in (16, None)}
        figures[effect] = {"ms": round(ms[0, None], 2), "at_equal_samples": round(ms[0, 16] / ms[1, 16], 2),
                           "as_asked": round(ms[0, None] / ms[1, None], 2)}
        print(f"| {effect} | {ms[0, None]:.1f} | {ms[0, 16] / ms[1, 16]:.2f} | {ms[0, None] / ms[1, None]:.1f} |")
    if arguments.record:
        record = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(),
                  "rounds": arguments.rounds, "effects": figures}
        (HERE / "effects.json").write_text(json.dumps(record, indent=2) + "\n")


if __name__ == "__main__":
    main()
