#!/usr/bin/env python3
"""Draws the small pictures of the scenes with textures, and writes these scenes. Run it from any folder."""
import base64
import math
import struct
import zlib

from generate import write


def png(width, height, pixel):
    """A picture of pixel(x, y) as a data URL; colors are sRGB from 0 to 255, y goes down."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    code = lambda x: max(0, min(255, round(x)))
    rows = [bytes(code(c) for x in range(width) for c in pixel(x, y)) for y in range(height)]
    # As they are, or as differences from the rows above, whichever is shorter.
    above = [bytes(3 * width)] + rows
    differences = b"".join(b"\2" + bytes((a - b) & 255 for a, b in zip(*pair)) for pair in zip(rows, above))
    data = min((zlib.compress(rows, 9) for rows in (b"".join(b"\0" + row for row in rows), differences)), key=len)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    file = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    return "data:image/png;base64," + base64.b64encode(file).decode()


def smooth(pixel):
    """The mean of nine points of each pixel."""
    def mean(x, y):
        points = [pixel(x + dx / 3, y + dy / 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        return [sum(channel) / 9 for channel in zip(*points)]
    return mean


def mix(a, b, t):
    t = max(0.0, min(1.0, t))
    return [x + (y - x) * t for x, y in zip(a, b)]


def hills(p, waves):
    """A smooth function of a direction: a sum of waves whose directions are spread by the golden angle."""
    total = 0.0
    for k in range(waves):
        z = 1 - 2 * (k + 0.5) / waves
        r, turn = math.sqrt(1 - z * z), k * math.pi * (3 - math.sqrt(5))
        axis = (r * math.cos(turn), z, r * math.sin(turn))
        frequency = 2 + 1.3 * (k % 7)
        total += math.sin(frequency * sum(a * b for a, b in zip(axis, p)) * 2 + 1.7 * k) / frequency
    return total


def direction(x, y, width, height):
    longitude, latitude = ((x + 0.5) / width - 0.5) * 2 * math.pi, (0.5 - (y + 0.5) / height) * math.pi
    return (math.cos(latitude) * math.sin(longitude), math.sin(latitude), math.cos(latitude) * math.cos(longitude))


def globe():
    width, height = 160, 80
    def pixel(x, y):
        p = direction(x, y, width, height)
        land = hills(p, 23)
        if abs(p[1]) + 0.1 * land > 0.9:
            return (240, 245, 250)
        if land < 0.12:
            return (24, 70, 140) if land < -0.2 else (36, 100, 170)
        return (64, 120, 50) if land < 0.5 else (170, 140, 90) if land < 0.8 else (120, 90, 60)
    return png(width, height, smooth(pixel))


def tile():
    """A floor tile: rings and a star, blue on white."""
    n = 48
    def pixel(x, y):
        u, v = (x + 0.5) / n * 2 - 1, (y + 0.5) / n * 2 - 1
        r, turn = math.hypot(u, v), math.atan2(v, u)
        star = 0.34 + 0.16 * math.cos(8 * turn)
        corner = math.hypot(abs(u) - 1, abs(v) - 1)
        blue, light, white = (30, 60, 120), (110, 150, 200), (235, 232, 220)
        if max(abs(u), abs(v)) > 0.96:
            return (120, 115, 105)
        if r < star:
            return blue if r < star - 0.12 or r > star - 0.05 else white
        if 0.62 < r < 0.72 or corner < 0.34:
            return light if corner > 0.2 else blue
        return white
    return png(n, n, smooth(pixel))


def poster():
    """A setting sun above the sea."""
    width, height = 60, 40
    def pixel(x, y):
        u, v = (x + 0.5) / width, 1 - (y + 0.5) / height
        frame = min(u * 1.5, 1.5 - u * 1.5, v, 1 - v)
        if frame < 0.06:
            return (70, 45, 25)
        sun = math.hypot((u - 0.5) * 1.5, v - 0.45)
        if v > 0.4:
            return (255, 236, 170) if sun < 0.17 else mix((250, 150, 70), (80, 70, 130), (v - 0.4) * 2)
        glitter = abs(u - 0.5) < 0.06 + 0.25 * (0.4 - v) and round(y) % 3 == 0
        return (255, 210, 140) if glitter else mix((40, 60, 110), (150, 100, 110), v / 0.4)
    return png(width, height, smooth(pixel))


def textures():
    u = 1.5
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "textures: a globe, marble of noise, a gradient, a picture on a mesh, tiles to the horizon",
        "image": {"width": 640, "height": 360},
        "camera": {"pinhole": {"eye": [0, 2.2, 7.5], "look_at": [0, 1.05, 0], "vfov_deg": 36}},
        "background": "#b8c8dc",
        "ambient": 0.3,
        "lights": [{"point": {"position": [-5, 8, 7], "color": [0.85, 0.82, 0.75]}}],
        "materials": {
            "tiles": {"diffuse": {"image": {"source": tile(), "mapping": {"planar": {"axes": "xz", "size": 1.2}}}},
                      "reflection": 0.12},
            "globe": {"diffuse": {"image": {"source": globe(), "mapping": {"spherical": {
                "center": [-2.2, 1.1, 0], "axis": [0.4, 1, 0.1]}}}}, "specular": 0.3, "shininess": 40},
            "marble": {"diffuse": {"noise": {"a": "#1a0c06", "b": "#fff4dc", "size": 0.45, "octaves": 5}},
                       "specular": 0.5, "shininess": 80},
            "dawn": {"diffuse": {"gradient": {"from": [0, 0, 0], "to": [0, 1.8, 0], "a": "#e8452c", "b": "#ffd84a"}}},
            "poster": {"diffuse": {"image": {"source": poster(), "wrap": "clamp"}}},
        },
        "objects": [
            {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0], "material": "tiles"}},
            {"sphere": {"center": [-2.2, 1.1, 0], "radius": 1.1, "material": "globe"}},
            {"sphere": {"center": [0.2, 0.6, 2.2], "radius": 0.6, "material": "marble"}},
            {"cone": {"base": [2.4, 0, 0.2], "base_radius": 0.75, "top": [2.4, 1.8, 0.2], "material": "dawn"}},
            {"mesh": {"vertices": [[-0.7 * u, 0.3, -2], [1.3 * u, 0.3, -2.6], [1.3 * u, 1.6 * u, -2.6], [-0.7 * u, 1.6 * u, -2]],
                      "faces": [[0, 1, 2], [0, 2, 3]], "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]], "material": "poster"}},
        ],
        "render": {"max_depth": 3},
    }


def bricks():
    """Normals of a wall, two courses high, from its heights."""
    n = 64
    def height(x, y):
        x, y = x % n, y % n
        course = y // 32
        along = y % 32
        from_joint = (x + 32 * course) % 64
        edge = min(from_joint, 63 - from_joint, along, 31 - along)
        rough = 0.25 * math.sin(x * 2 * math.pi / 16 + 3 * course) * math.sin(y * 2 * math.pi / 32 + 1)
        return min(edge, 4) * 0.8 + rough * 1.5
    def pixel(x, y):
        right, up = (height(x + 1, y) - height(x - 1, y)) / 2, (height(x, y - 1) - height(x, y + 1)) / 2
        length = math.sqrt(right * right + up * up + 1)
        return [128 + 127 * c / length for c in (-right, -up, 1)]
    return png(n, n, pixel)


def medal():
    """Heights of a star within rings."""
    n = 96
    def pixel(x, y):
        u, v = (x + 0.5) / n * 2 - 1, 1 - (y + 0.5) / n * 2
        r, turn = math.hypot(u, v), math.atan2(u, v)
        # Distance to the five points' edges, as a ridge from the middle.
        fold = abs((turn * 5 / (2 * math.pi) + 0.5) % 1 - 0.5) * 2
        star = max(0.0, 0.62 * (1 - 0.62 * fold) - r)
        ring = max(0.0, 1 - abs(r - 0.8) / 0.06)
        return [255 * max(min(star * 2.4, 0.9), 0.8 * math.sqrt(ring))] * 3
    return png(n, n, pixel)


def bump():
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "bumps: an orange, a medal, a brick wall from a normal map, and water that is a flat mirror",
        "image": {"width": 640, "height": 360},
        "camera": {"pinhole": {"eye": [0, 1.9, 7], "look_at": [0, 1.0, 0], "vfov_deg": 36}},
        "background": "#cfd8e2",
        "ambient": 0.16,
        "lights": [{"point": {"position": [-6, 6, 5], "color": [0.95, 0.9, 0.8]}}],
        "materials": {
            "orange": {"diffuse": "#e8801c", "specular": 0.45, "shininess": 25,
                       "bump": {"height": 0.05, "texture": {"noise": {"size": 0.09, "octaves": 2}}}},
            "gold": {"diffuse": "#a8781c", "specular": [0.9, 0.75, 0.4], "shininess": 30, "reflection": [0.25, 0.2, 0.1],
                     "bump": {"height": 0.3, "texture": {"image": {"source": medal(), "wrap": "clamp", "mapping": {
                         "planar": {"axes": "xy", "size": 2.4}}}}}},
            "wall": {"diffuse": "#a4553c", "normal_map": {"image": {"source": bricks(), "mapping": {
                "planar": {"axes": "xy", "size": 1.0}}}}},
            "water": {"diffuse": [0.02, 0.05, 0.06], "reflection": 0.75,
                      "bump": {"height": 0.03, "texture": {"noise": {"size": 0.7, "octaves": 3}}}},
        },
        "objects": [
            {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0], "material": "water"}},
            {"box": {"min": [-9, 0, -2], "max": [9, 2.6, -1.5], "material": "wall"}},
            {"sphere": {"center": [-1.6, 1.05, 0.6], "radius": 0.95, "material": "orange"}},
            {"group": {"objects": [{"cylinder": {"base": [1.2, 1.2, -0.12], "top": [1.2, 1.2, 0], "radius": 1.2,
                                                 "material": "gold"}}],
                       "transform": {"rotate_deg": {"axis": [0, 1, 0], "angle": -18}, "translate": [0.4, 0.05, 0.7]}}},
        ],
        "render": {"max_depth": 4},
    }


def valley():
    """A meadow under an evening sky, all around."""
    width, height = 1024, 512
    def pixel(x, y):
        p = direction(x, y, width, height)
        longitude = (x + 0.5) / width * 2 * math.pi
        ridge = 0.1 + 0.05 * math.sin(3 * longitude + 1) + 0.04 * math.sin(7 * longitude) + 0.015 * math.sin(17 * longitude + 2)
        ridge += 0.008 * math.sin(41 * longitude + 1) + 0.004 * math.sin(97 * longitude)
        near = 0.01 + 0.02 * math.sin(2 * longitude + 4) + 0.01 * math.sin(9 * longitude)
        sun = (0.62, 0.32, -0.716)
        glow = max(0.0, sum(a * b for a, b in zip(p, sun)))
        if p[1] < near:
            stripe = 0.5 + 0.5 * math.sin(14 / (0.12 - p[1] + near))
            return mix((70, 98, 38), (104, 130, 52), stripe * 0.7 * min(1, 0.3 - p[1]))
        if p[1] < ridge:
            return mix((90, 100, 130), (60, 84, 92), (ridge - p[1]) * 9)
        sky = mix((255, 206, 150), (64, 110, 190), (p[1] - 0.05) ** 0.5 if p[1] > 0.05 else 0)
        cloud = max(0.0, hills((1.2 * p[0], 3 * p[1], 1.2 * p[2]), 9) + 0.1) * min(1, p[1] * 3)
        sky = mix(sky, (255, 250, 240), 0.55 * cloud)
        return mix(mix(sky, (255, 235, 190), glow ** 12 * 0.8), (255, 255, 250), (glow - 0.994) * 600)
    return png(width, height, smooth(pixel))


def environment():
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "environment map: a mirror, glass and gold in a valley that is a picture",
        "image": {"width": 640, "height": 360},
        "camera": {"pinhole": {"eye": [0, 1.4, 6.5], "look_at": [0, 0.95, 0], "vfov_deg": 38}},
        "environment": {"image": valley(), "rotate_deg": 20, "intensity": 1},
        "ambient": 0.25,
        "lights": [{"directional": {"direction": [-0.85, -0.45, 0.45], "color": [0.9, 0.8, 0.65]}}],
        "materials": {
            "mirror": {"diffuse": 0.02, "reflection": 0.95, "specular": 0.6, "shininess": 400},
            "glass": {"diffuse": 0, "specular": 0.6, "shininess": 400, "reflection": 0.08, "transmission": 0.92, "ior": 1.5},
            "gold": {"diffuse": [0.12, 0.08, 0.02], "reflection": [0.85, 0.62, 0.25], "specular": 0.4, "shininess": 120},
            "stone": {"diffuse": {"noise": {"a": "#5a544c", "b": "#b8aea0", "size": 0.5, "octaves": 6}}},
        },
        "objects": [
            {"cylinder": {"base": [0, -0.25, 0], "top": [0, 0, 0], "radius": 3, "material": "stone"}},
            {"sphere": {"center": [-1.5, 1, -0.3], "radius": 1, "material": "mirror"}},
            {"sphere": {"center": [0.55, 0.75, 0.9], "radius": 0.75, "material": "glass"}},
            {"torus": {"center": [1.75, 0.85, -0.8], "axis": [-0.4, 0.3, 1], "major_radius": 0.6, "minor_radius": 0.24, "material": "gold"}},
        ],
        "render": {"max_depth": 8},
    }


if __name__ == "__main__":
    write("effects/textures.json", textures(), ("materials", "objects"))
    write("effects/bump.json", bump(), ("materials", "objects"))
    write("effects/environment.json", environment(), ("materials", "objects"))
