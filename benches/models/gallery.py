#!/usr/bin/env python3
"""A page of all models of some folders: the picture that each gives without any setting, what it cost, what is proved of it, what is
not as the file says, and which are refused.

    cargo build --release
    python3 benches/models/gallery.py                    # of tests/inputs/models, into target/models/gallery.md
    python3 benches/models/gallery.py FOLDER... -o docs/models-gallery.md --pictures docs/pictures/models

A model's source and licence are told by a table of a README.md or MANIFEST.md beside it or above it, with the columns file, source and
licence. Models without are rendered, but not shown. `--look FOLDER` writes the pictures for looking at them: 512 x 512
pixels over white, each beside its reference by another renderer.
"""

import argparse
import fnmatch
import json
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
import renderers  # noqa: E402
from machine import machine  # noqa: E402
from renderers import OUT, ROOT, program  # noqa: E402
from scenes import as_seen, imported, picture_of, references, triangles  # noqa: E402


@dataclass
class Shown:
    """A model's picture and report, or why there is none."""

    model: Path
    picture: Path
    refused: str | None = None
    warnings: list = field(default_factory=list)
    report: dict | None = None


def render(model, picture, *flags):
    stats = OUT / "stats.json"
    ended = subprocess.run([program(), "render", model, "-o", picture, "--stats", stats, *flags], capture_output=True, text=True)
    said = [line.replace(f"{model}: ", "").replace(str(model), model.name) for line in ended.stderr.splitlines()]
    if ended.returncode != 0:
        # The first line says that there is a problem, the next one which.
        return Shown(model, picture, refused=" ".join(said[1:2] or said) or f"exit code {ended.returncode}")
    marked = [line.removeprefix("warning: ") for line in said if line.startswith("warning: ")]
    return Shown(model, picture, warnings=marked, report=json.loads(stats.read_text()))


def rows(table):
    """The rows of the Markdown tables of a file that have the columns file, source and licence."""
    columns = None
    for line in table.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        heads = [cell.lower().rstrip("s") for cell in cells]
        if {"file", "source", "licence"} <= set(heads):
            columns = [heads.index(name) for name in ("file", "source", "licence")]
        elif columns and line.startswith("|") and len(cells) > max(columns):
            yield tuple(cells[column] for column in columns)


def origin(model):
    """Source and licence of a model, or None."""
    for folder in model.parents:
        for table in (folder / "README.md", folder / "MANIFEST.md"):
            if not table.is_file():
                continue
            name = model.relative_to(folder).as_posix()
            for files, source, licence in rows(table):
                quoted = re.findall(r"`([^`]+)`", files) or [files]
                if any(fnmatch.fnmatch(name, one) for one in quoted):
                    return source.replace("`", ""), licence
    return None


def bound(report):
    """What is proved, and what the samples tell, in codes."""
    proved, estimated = report["error"]["proved"], report["error"]["estimated"]
    words = "nothing proved" if proved.get("max_codes") is None else str(proved["max_codes"])
    return words + (f"; likely {estimated['half_width_codes']:.1f}" if estimated else "")


def cell(text):
    """Text as it is in a cell of a table."""
    return re.sub(r"([|<>*])", r"\\\1", text.strip())


def page(all_shown, side, target):
    shown = [one for one in all_shown if one.refused is None and origin(one.model)]
    refused = [one for one in all_shown if one.refused is not None]
    lines = [
        "# Models by others", "",
        f"These are the pictures that `strahl render MODEL` makes of models by others, without any setting but the size of {side} x "
        f"{side} pixels: {len(shown)} pictures and {len(refused)} refusals, on {machine()}. `benches/models/gallery.py` makes this page.",
        "", "- **Time** is from the file to the picture.",
        "- **Error bound** is in codes, the 255 steps of a color channel. The first figure is proved: no pixel differs by more from "
        "endless recursion. The second is likely: what more samples would change.",
        "- **Warnings** tell what is not as the file says. [Models](models.md#what-of-gltf-is-read) explains them.", "",
        "| Picture | Model | Triangles | Time | Error bound | Warnings |", "|---|---|---|---|---|---|",
    ]
    for one in shown:
        path = one.picture.resolve().relative_to(target.resolve().parent).as_posix()
        warnings = "<br>".join(map(cell, one.warnings)) or "none"
        lines.append(f"| ![{cell(one.model.stem)}]({path}) | {cell(one.model.name)} | {triangles(one.model):,} | "
                     f"{one.report['cost']['wall_ms']:.0f} ms | {bound(one.report)} | {warnings} |")
    lines += ["", "## Refused", "", "| Model | Why |", "|---|---|"]
    lines += [f"| {cell(one.model.name)} | {cell(one.refused.removeprefix('error: '))} |" for one in refused]
    lines += ["", "## Sources and licences", "", "Nobody of this project made these models; *packed* means that the files of one "
              "model were put into one .glb.", "", "| Model | Source | Licence |", "|---|---|---|"]
    lines += [f"| {cell(one.model.name)} | {' | '.join(map(cell, origin(one.model)))} |" for one in shown]
    target.write_text("\n".join(lines) + "\n")


def look(places, folder):
    """Pictures for a person: over white, and through the cameras of references with these beside them."""
    size = ("--width", "512", "--height", "512")
    models = renderers.models(places)
    for model in models:
        one = render(model, folder / f"{model.name}.png", *size)
        if one.refused is None:
            renderers.pictures("beside", one.picture)
            said = "; ".join((f"{one.report['cost']['wall_ms']:.0f} ms, {bound(one.report)}", *one.warnings))
        print(f"{model.name}: {one.refused or said}", flush=True)
    for reference in (one for place in places if place.is_dir() for one in references(place)):
        model = next((path for path in models if path.stem == reference.model), None)
        if model is not None:
            view = f"{reference.orbit.theta},{reference.orbit.phi}"
            picture = folder / f"{reference.picture.stem}.beside.png"
            picture_of(as_seen(imported(model, "--view", view), reference), picture)
            renderers.pictures("beside", picture, reference.picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("places", nargs="*", type=Path, default=[ROOT / "tests/inputs/models"], metavar="FOLDER")
    parser.add_argument("-o", "--output", type=Path, default=OUT / "gallery.md", help="the page")
    parser.add_argument("--pictures", type=Path, default=OUT / "gallery", help="folder of the pictures, at or below that of the page")
    parser.add_argument("--side", type=int, default=192, help="pixels across and down")
    parser.add_argument("--look", type=Path, metavar="FOLDER", help="large pictures to look at, and no page")
    asked = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    if asked.look:
        asked.look.mkdir(parents=True, exist_ok=True)
        return look(asked.places, asked.look)
    models = renderers.models(asked.places)
    asked.pictures.mkdir(parents=True, exist_ok=True)
    size = ("--width", str(asked.side), "--height", str(asked.side))
    # Files of one name in two formats are two pictures.
    all_shown = [render(model, asked.pictures / f"{model.stem}-{model.suffix[1:]}.png", *size) for model in models]
    for one in all_shown:
        if one.refused is None and origin(one.model) is None:
            print(f"{one.model.name} is not shown: no table tells its licence", file=sys.stderr)
            one.picture.unlink()
    page(all_shown, asked.side, asked.output)


if __name__ == "__main__":
    main()
