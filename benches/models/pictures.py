"""What is asked of pictures, in an environment with Pillow, numpy and NVIDIA's FLIP: prints numbers.

    flip REFERENCE PICTURE               mean FLIP over white, and how far the silhouettes overlap (intersection over union)
    codes A B                            largest difference in codes over white, and of 99 % of the pixels
    outline PICTURE CODES                share of the outline that differs by so many codes from a white page
    beside PICTURE REFERENCE...          puts a picture over white, with others beside it, into its own file
"""

import sys

import numpy as np
from PIL import Image

# Alpha from which a pixel belongs to the silhouette: shadows on the floor are fainter.
SOLID = 0.9


def read(path):
    """Colors over white from 0 to 255, and alpha from 0 to 1."""
    pixels = np.asarray(Image.open(path).convert("RGBA"), dtype=np.float64)
    alpha = pixels[:, :, 3:] / 255
    return pixels[:, :, :3] * alpha + 255 * (1 - alpha), alpha[:, :, 0]


def flip(reference, picture):
    import flip_evaluator

    (a, alpha_a), (b, alpha_b) = read(reference), read(picture)
    _, mean, _ = flip_evaluator.evaluate((a / 255).astype(np.float32), (b / 255).astype(np.float32), "LDR")
    a, b = alpha_a > SOLID, alpha_b > SOLID
    print(mean, (a & b).sum() / max((a | b).sum(), 1))


def codes(a, b):
    apart = np.abs(read(a)[0] - read(b)[0]).max(axis=2)
    print(apart.max(), np.quantile(apart, 0.99))


def outline(picture, least):
    """The outline are the solid pixels with a neighbour that is not; each is asked outside and inside of it, two pixels far."""
    colors, alpha = read(picture)
    solid = alpha > SOLID
    wide = np.pad(solid, 1)
    inner = wide[:-2, 1:-1] & wide[2:, 1:-1] & wide[1:-1, :-2] & wide[1:-1, 2:]
    border = solid & ~inner
    differs = np.abs(255 - colors).max(axis=2) >= float(least)
    print((border & differs).sum() / max(border.sum(), 1))


def beside(picture, *references):
    shown = [Image.fromarray(read(path)[0].round().astype(np.uint8)) for path in (picture, *references)]
    sheet = Image.new("RGB", (sum(one.width for one in shown), max(one.height for one in shown)), "white")
    for number, one in enumerate(shown):
        sheet.paste(one, (sum(before.width for before in shown[:number]), 0))
    sheet.save(picture)


if __name__ == "__main__":
    {"flip": flip, "codes": codes, "outline": outline, "beside": beside}[sys.argv[1]](*sys.argv[2:])
