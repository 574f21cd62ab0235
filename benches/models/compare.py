#!/usr/bin/env python3
"""strahl beside F3D and model-viewer on the same models, in one interleaved run.

    cargo build --release
    python3 benches/models/compare.py                            # tests/inputs/models, three rounds; some minutes
    python3 benches/models/compare.py FOLDER --peers f3d         # other models, and without a browser
    python3 benches/models/compare.py --large                    # models of 125,000 to a million triangles, made here
    python3 benches/models/compare.py FOLDER --flip              # also FLIP against FOLDER/reference, if it has one

Each renderer is started anew for each picture of 512 x 512 pixels, as it would be on a server, and chooses its own camera. The table
has medians: processor seconds of all processes, seconds, the most memory in MB. FLIP is against pictures by other renderers, through
their cameras and over white; their lights are others, so only their order means something. The tables and every single figure are
kept in target/models/comparison.{md,json}.
"""

import argparse
import dataclasses
import datetime
import json
import os
import statistics
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
import renderers  # noqa: E402
from machine import commit, machine  # noqa: E402
from made import large  # noqa: E402
from renderers import OUT, ROOT, SIDE  # noqa: E402
from scenes import as_seen, imported, picture_of, references, triangles  # noqa: E402

PEERS = {"f3d": "F3D", "model-viewer": "model-viewer"}
# Renderers read glTF alone, or all formats.
READS = {"model-viewer": (".glb", ".gltf")}


def render(name, model, picture, camera=()):
    program = {"strahl": renderers.strahl, "f3d": renderers.f3d, "model-viewer": renderers.model_viewer}[name]
    return program(model, picture, *camera)


def measure(model, names, rounds):
    """What each renderer takes, one figure for each round."""
    names = [name for name in names if model.suffix.lower() in READS.get(name, renderers.ENDINGS)]
    took = {name: [] for name in names}
    for turn in range(rounds):
        # Every round in another order, since the first after a pause may be slower.
        for name in names[turn % len(names):] + names[:turn % len(names)]:
            if took[name] and took[name][-1].refused:
                continue
            flags = ("--width", str(SIDE), "--height", str(SIDE)) if name == "strahl" else ()
            took[name].append(render(name, model, OUT / f"{model.stem}.{name}.png", flags))
    return took


def cell(took):
    if not took:
        return ""
    if refused := next((one.refused for one in took if one.refused), None):
        return f"refused: {refused[:90].replace('|', ' ')}"
    middle = {what: statistics.median(getattr(one, what) for one in took) for what in ("cpu", "wall", "memory")}
    return f"{middle['cpu']:.2f} / {middle['wall']:.2f} / {middle['memory'] / 1e6:.0f}"


def flip(reference, model, names):
    """FLIP and the overlap of silhouettes of each renderer, through the camera of a reference."""
    orbit = reference.orbit
    cameras = {"f3d": (*orbit.eye(), *orbit.target, orbit.angle),
               "model-viewer": (orbit.theta, orbit.phi, orbit.radius, *orbit.target, orbit.angle)}
    shown = {}
    for name in names:
        picture = OUT / f"{reference.picture.stem}.{name}.png"
        if name == "strahl":
            view = f"{orbit.theta},{orbit.phi}"
            took = picture_of(as_seen(imported(model, "--view", view), reference), picture)
        elif reference.size != (SIDE, SIDE) or name in reference.renderer:
            continue
        else:
            took = render(name, model, picture, cameras[name])
        shown[name] = None if took.refused else renderers.pictures("flip", reference.picture, picture)
    return shown


def report(figures, names):
    titles = {"strahl": "strahl", **PEERS}
    heads = " | ".join(titles[name] for name in names)
    lines = [f"{figures['date']}, {figures['machine']}, commit {figures['commit']}, {SIDE} x {SIDE} pixels, medians of "
             f"{figures['rounds']} interleaved rounds: processor seconds / seconds / MB.", "",
             f"| Model | triangles | {heads} |", "|---" * (len(names) + 2) + "|"]
    for model, (count, took) in figures["models"].items():
        count = "" if count is None else f"{count:,}"
        lines.append(f"| {model} | {count} | {' | '.join(cell(took.get(name)) for name in names)} |")
    lost = [model for model, (_, took) in figures["models"].items()
            if took["strahl"][0].refused and any(one and not one[0].refused for one in took.values())]
    lines += ["", f"Refused by strahl alone: {', '.join(lost) or 'none'}."]
    if figures["flip"]:
        lines += ["", "Mean FLIP against pictures by other renderers, and the overlap of the silhouettes:", "",
                  f"| Model | by | {heads} |", "|---" * (len(names) + 2) + "|"]
    for (model, by), shown in figures["flip"].items():
        cells = [f"{shown[name][0]:.3f}, {shown[name][1]:.3f}" if shown.get(name) else "" for name in names]
        lines.append(f"| {model} | {by} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def keep(figures, names):
    (OUT / "comparison.md").write_text(report(figures, names))
    plain = {**figures, "flip": {" by ".join(key): shown for key, shown in figures["flip"].items()}}
    (OUT / "comparison.json").write_text(json.dumps(plain, indent=1, default=dataclasses.asdict) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("places", nargs="*", type=Path, default=[ROOT / "tests/inputs/models"], metavar="FOLDER",
                        help="folders with models, or models")
    parser.add_argument("--rounds", type=int, default=3, help="pictures of each model by each renderer")
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=list(PEERS))
    parser.add_argument("--large", action="store_true", help="large models made here, in place of the folders")
    parser.add_argument("--flip", action="store_true", help="also compare with reference pictures")
    parser.add_argument("--only-flip", action="store_true", help="do nothing else")
    asked = parser.parse_args()
    names = ["strahl", *asked.peers]
    if "f3d" in names or asked.flip or asked.only_flip:
        renderers.python()
    if "model-viewer" in names and renderers.node() is None:
        print("without model-viewer: it needs node, npm and Chromium", file=sys.stderr)
        names.remove("model-viewer")
    OUT.mkdir(parents=True, exist_ok=True)
    figures = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(), "rounds": asked.rounds,
               "load": os.getloadavg()[0], "models": {}, "flip": {}}
    for model in large() if asked.large else () if asked.only_flip else renderers.models(asked.places):
        print(f"{model.name} ...", file=sys.stderr, flush=True)
        figures["models"][model.name] = (triangles(model), measure(model, names, asked.rounds))
        keep(figures, names)
    for folder in asked.places if asked.flip or asked.only_flip else ():
        for reference in references(folder):
            model = next((path for path in renderers.models(asked.places) if path.stem == reference.model), None)
            if model is not None:
                figures["flip"][reference.model, reference.renderer] = flip(reference, model, names)
                keep(figures, names)
    print(report(figures, names), end="")


if __name__ == "__main__":
    main()
