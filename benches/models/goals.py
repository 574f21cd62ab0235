#!/usr/bin/env python3
"""What models may take, and how alike pictures must be: each goal beside what is reached.

    cargo build --release
    python3 benches/models/goals.py FOLDER...            # every row; some minutes
    python3 benches/models/goals.py FOLDER... --rows million outline

FOLDER has the models that a row names; rows whose models are missing say so. Two models of a million triangles are made by this
program. Times are medians of five pictures of 512 x 512 pixels by a program that is started anew, on all threads.
"""

import argparse
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
import renderers  # noqa: E402
from machine import commit, machine  # noqa: E402
from made import million, spheres  # noqa: E402
from renderers import OUT, ROOT, SIDE, program  # noqa: E402
from scenes import as_seen, imported, picture_of, references, without_floor  # noqa: E402

ROUNDS = 5


def took(model):
    """Medians of seconds and of bytes."""
    flags = ("--width", str(SIDE), "--height", str(SIDE))
    rounds = [renderers.strahl(model, OUT / "goal.png", *flags) for _ in range(ROUNDS)]
    if refused := rounds[0].refused:
        sys.exit(f"{model.name}: {refused}")
    return statistics.median(one.wall for one in rounds), statistics.median(one.memory for one in rounds)


class Missing(Exception):
    """A model is not in the folders."""


class Models:
    def __init__(self, places):
        self.places, self.paths = places, {path.stem: path for path in renderers.models(places)}

    def __call__(self, name):
        if name not in self.paths:
            raise Missing(f"{name} is in none of the folders")
        return self.paths[name]


def row_million(_):
    yield "a million triangles of its own", "at most 1.0 s", f"{took(million())[0]:.2f} s"


def row_spheres(_):
    yield "a million triangles in 98 balls of one mesh", "at most 0.3 s", f"{took(spheres())[0]:.2f} s"


def row_small(models):
    within = {name: path for name, path in models.paths.items() if 100e3 <= path.stat().st_size <= 4e6}
    for name, path in sorted(within.items()):
        try:
            yield f"{name}, {path.stat().st_size / 1e6:.1f} MB", "at most 0.5 s", f"{took(path)[0]:.2f} s"
        except SystemExit as refused:
            yield name, "at most 0.5 s", str(refused)


def row_memory(models):
    most, least = took(million())[1], took(models("Box"))[1]
    yield "memory of a million triangles, beyond that of a box", "at most 100 bytes a triangle", f"{(most - least) / 1e6:.0f}"


def row_pairs(models):
    for one, other in (("Fox", "Fox_meshopt"), ("RiggedFigure", "RiggedFigure_meshopt_c"), ("RiggedFigure", "RiggedFigure_draco"),
                       ("Box", "Box_draco")):
        try:
            files = [models(one), models(other)]
        except Missing as missing:
            yield f"{other} as {one}", "within 2 codes", str(missing)
            continue
        shown = [OUT / "one.png", OUT / "other.png"]
        refused = [renderers.strahl(model, picture).refused for model, picture in zip(files, shown)]
        if any(refused):
            yield f"{other} as {one}", "within 2 codes", f"refused: {refused[0] or refused[1]}"
            continue
        most, nearly = renderers.pictures("codes", *shown)
        yield f"{other} as {one}", "99 % of the pixels within 2 codes", f"{nearly:.0f}, all within {most:.0f}"


def row_outline(models):
    renderers.strahl(models("RiggedFigure"), OUT / "outline.png")
    share, = renderers.pictures("outline", OUT / "outline.png", 8)
    yield "outline of RiggedFigure over white that differs by 8 codes", "at least 10 %", f"{100 * share:.0f} %"


def row_bad(models):
    folders = [folder / "bad" for folder in models.places if (folder / "bad").is_dir()]
    files = [path for folder in folders for path in sorted(folder.rglob("*")) if path.suffix in (".gltf", ".glb")]
    if not files:
        raise Missing("no folder has broken files in `bad`")
    codes = [subprocess.run([program(), "validate", path], capture_output=True, timeout=10).returncode for path in files]
    ended = sum(code in (0, 1) for code in codes)
    yield "broken files that end in a report", f"{len(files)} of {len(files)}", f"{ended}, {codes.count(1)} of them refused"


def row_beside(models):
    """Its surroundings are model-viewer's, and nothing else shines."""
    for reference in (one for folder in models.places for one in references(folder) if "model-viewer" in one.renderer):
        orbit = reference.orbit
        scene = without_floor(imported(models(reference.model), "--view", f"{orbit.theta},{orbit.phi}"))
        scene["lights"] = []
        scene["environment"].update(rotate_deg=0.0, intensity=1.0)
        picture_of(as_seen(scene, reference), OUT / "beside.png")
        flip, overlap = renderers.pictures("flip", reference.picture, OUT / "beside.png")
        yield f"{reference.model} as {reference.renderer}", "FLIP 0.05, silhouettes 0.995", f"{flip:.3f}, {overlap:.3f}"


ROWS = {"million": row_million, "spheres": row_spheres, "small": row_small, "memory": row_memory, "pairs": row_pairs,
        "outline": row_outline, "bad": row_bad, "beside": row_beside}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("places", nargs="*", type=Path, default=[ROOT / "tests/inputs/models"], metavar="FOLDER")
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=list(ROWS))
    asked = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}, commit {commit()}\n\n| What | Goal | Reached |\n|---|---|---|")
    for row in asked.rows:
        try:
            for what, goal, reached in ROWS[row](Models(asked.places)):
                print(f"| {what} | {goal} | {reached} |", flush=True)
        except Missing as missing:
            print(f"| {row} | | {missing} |", flush=True)


if __name__ == "__main__":
    main()
