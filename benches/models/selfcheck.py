#!/usr/bin/env python3
"""Models that check their reader: parts of them must look alike, whichever way the file says it.

    cargo build --release
    python3 benches/models/selfcheck.py FOLDER...

Each part is rendered alone by a camera without perspective, so that the pixels of two parts lie in the same places of them, and compared
with the part that shows how it should look: the largest difference in 8-bit codes, and that of 99 % of the pixels. The goal is 2 codes.
Models that are not in the folders are left out. OrientationTest, MultiUVTest, VertexColorTest and the ticks of TextureSettingsTest have
no such parts, or draw them in other places of their squares: look at them in the gallery.
"""

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
sys.path.append(str(Path(__file__).resolve().parent))
import renderers  # noqa: E402
from renderers import OUT, ROOT  # noqa: E402
from scenes import imported, picture_of, without_floor  # noqa: E402

MOST = 2
SIDE = 128
# Of a part: not its edge, where its neighbours begin.
INNER = 0.98

# Models as tables: the side of a part, the rows by name and y of their middle, x of the part that shows how it should look, and x of
# the others.
TABLES = [
    ("TextureSettingsTest", 0.9, {"single-sided": 2.5447, "clamp s": 0.4674, "clamp t": -0.5696}, 2.6008, [0.4548]),
    # The sample is drawn 0.0055 further to the right than the parts with a transform: its coordinates say so.
    ("TextureTransformMultiTest", 0.18, {"base color": 0.75, "emission": 0.5, "normal": 0.25, "metal, rough": 0.0,
                                         "occlusion": -0.25, "unlit": -0.5}, 0.6, [0.1 - 0.0055, 0.35 - 0.0055]),
    ("TextureTransformMultiTest", 0.18, {"clearcoat": -0.75, "clearcoat rough": -1.0, "clearcoat normal": -1.25}, 0.1, [0.35]),
    ("TextureEncodingTest", 1.9, {"base color": 2.0, "emissive": -1.0, "metal, rough": -4.0}, -2.75, [0.25, 3.25, 6.25]),
    ("TextureLinearInterpolationTest", 1.9, {"emissive": -1.0}, -1.5, [1.5]),
    # Inside of the balls, without the arrows that are printed beside them: silver, then gold.
    ("NormalTangentMirrorTest", 0.13, {"silver 1": 0.8, "silver 2": 0.4, "silver 3": 0.0, "silver 4": -0.4, "silver 5": -0.8}, -0.9546,
     [-0.6293, -0.2912]),
    ("NormalTangentMirrorTest", 0.13, {"gold 1": 0.8, "gold 2": 0.4, "gold 3": 0.0, "gold 4": -0.4, "gold 5": -0.8}, 0.6199,
     [0.9408, 1.2636]),
]
CHECKS = [(model, f"{row} {number}", side, (ideal, y), (x, y)) for model, side, rows, ideal, others in TABLES
          for row, y in rows.items() for number, x in enumerate(others, 1)]


def part(scene, side, x, y, picture):
    """Renders a square of the model, seen from its front."""
    size = INNER * side
    camera = {"orthographic": {"eye": [x, y, 50], "look_at": [x, y, 0], "up": [0, 1, 0], "height": size}}
    took = picture_of({**scene, "camera": camera, "image": {"width": SIDE, "height": SIDE}}, picture)
    if took.refused:
        sys.exit(took.refused)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("places", nargs="*", type=Path, default=[ROOT / "tests/inputs/models"], metavar="FOLDER",
                        help="folders with the models")
    asked = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    found = {path.stem: path for path in renderers.models(asked.places)}
    if not any(model in found for model, *_ in CHECKS):
        sys.exit(f"the folders have none of these models: {', '.join(dict.fromkeys(model for model, *_ in CHECKS))}")
    print("| Model | part | largest difference, codes | of 99 % of the pixels | |\n|---|---|---|---|---|")
    scenes, failed = {}, False
    for name, row, side, ideal, tested in CHECKS:
        if name not in found:
            continue
        if name not in scenes:
            scenes[name] = without_floor(imported(found[name], "--view", "front", "--light", "studio"))
        part(scenes[name], side, *ideal, OUT / "ideal.png")
        part(scenes[name], side, *tested, OUT / "part.png")
        most, nearly = renderers.pictures("codes", OUT / "ideal.png", OUT / "part.png")
        failed |= nearly > MOST
        print(f"| {name} | {row} | {most:.0f} | {nearly:.0f} | {'' if nearly <= MOST else 'differs'} |", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
