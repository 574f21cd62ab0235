#!/usr/bin/env python3
"""The trade-off page in a browser: on a desktop and on a phone the answer, three pictures and the plot stand above the fold,
nothing is clipped, and no name covers another, in the browser's own fonts.

    cargo build --release && python3 tests/external/tradeoff_page.py

It needs Chromium (Debian: chromium or chromium-headless-shell; or CHROMIUM=path).
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import service

SCENES = [
    "scenes/mirrors/hall.json",
    "scenes/shapes/all.json",
    "scenes/refraction/glass_of_water.json",
    "scenes/whitted/whitted.json",
    "scenes/effects/soft_shadows.json",
    "scenes/iiif/squares.json",
]
SIZES = {"desktop": (1280, 800), "phone": (390, 844)}

# Runs in a frame of the size of the screen, since a headless window has a least width.
MEASURE = """
const box = (e) => { const b = e.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]; };
const seen = (e) => e.getClientRects().length > 0;
const plot = [...document.querySelectorAll('svg.choices')].find(seen);
const texts = [...plot.querySelectorAll('text')];
document.title = JSON.stringify({
  answer: box(document.querySelector('.answer')), pictures: [...document.querySelectorAll('.three img')].map(box),
  plot: box(plot), labels: texts.map((t) => [t.textContent, box(t)]), width: document.documentElement.scrollWidth,
  letters: Math.min(...texts.map((t) => parseFloat(getComputedStyle(t).fontSize) * plot.getBoundingClientRect().width / plot.viewBox.baseVal.width)),
});
"""


def measured(browser, page, size):
    """What the page measures of itself on a screen of a size."""
    width, height = size
    with tempfile.TemporaryDirectory() as folder:
        inner, outer = pathlib.Path(folder, "page.html"), pathlib.Path(folder, "screen.html")
        inner.write_text(page + f"<script>{MEASURE}</script>")
        outer.write_text(
            f'<iframe width="{width}" height="{height}" style="border:0" src="page.html"></iframe><script>'
            "onload = () => { document.title = frames[0].document.title; }</script>"
        )
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files", "--dump-dom"]
        dom = subprocess.run([*command, outer.as_uri()], capture_output=True, text=True, timeout=120).stdout
    return json.loads(re.search(r"<title>(\{.*?\})</title>", dom, re.S)[1].replace("&amp;", "&"))


def problems(seen, size):
    """What is wrong with what was measured."""
    width, height = size
    if seen["width"] > width:
        yield f"the page is {seen['width']} wide"
    for name, box in [("answer", seen["answer"]), ("plot", seen["plot"]), *(("picture", box) for box in seen["pictures"])]:
        if box[0] < 0 or box[2] > width or box[3] > height:
            yield f"the {name} is not above the fold: {box}"
    # Without bars beside them, so square ones are as narrow as they are high.
    if not seen["pictures"] or min(box[3] - box[1] for box in seen["pictures"]) < 85:
        yield "there are no pictures, or they are too small to see"
    if seen["letters"] < 11:
        yield f"letters of {seen['letters']} pixels"
    left, top, right, bottom = seen["plot"]
    for i, (name, box) in enumerate(seen["labels"]):
        if box[0] < left or box[2] > right or box[1] < top or box[3] > bottom:
            yield f"{name!r} is clipped"
        for other, there in seen["labels"][:i]:
            across, down = (min(box[2 + k], there[2 + k]) - max(box[k], there[k]) for k in (0, 1))
            # Boxes of text have room above and below the letters.
            if across > 1 and down > 4:
                yield f"{name!r} covers {other!r}"


def main():
    found = (shutil.which(name) for name in ("chromium", "chromium-headless-shell", "google-chrome"))
    browser = os.environ.get("CHROMIUM") or next(filter(None, found), None)
    if not browser:
        sys.exit("this test needs chromium, which is not installed")
    failures = 0
    for scene in SCENES:
        command = [service.PROGRAM, "tradeoff", service.ROOT / scene, "-o", "-", "--seconds", "8"]
        page = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        for name, size in SIZES.items():
            wrong = list(problems(measured(browser, page, size), size))
            print(f"{scene} on a {name}: {len(wrong)} problems")
            for problem in wrong:
                print(f"  {problem}")
            failures += len(wrong)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
