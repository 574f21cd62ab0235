#!/usr/bin/env python3
"""Writes the scenes whose numbers come from formulas: sphere flakes, knot, coarse spheres. Run it from any folder."""
import json
import math
import os

HERE = os.path.dirname(os.path.abspath(__file__))


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotate(v, axis, angle):
    """Rodrigues' formula."""
    c, s = math.cos(angle), math.sin(angle)
    along = sum(a * b for a, b in zip(axis, v)) * (1 - c)
    w = cross(axis, v)
    return [x * c + y * s + a * along for x, y, a in zip(v, w, axis)]


def nine_directions():
    """Where the nine children of an SPD 'balls' sphere sit (Haines, SPD balls.c): six around, three on top."""
    d = 1 / math.sqrt(2)
    tilt = math.asin(2 / math.sqrt(6))
    trio = [rotate(v, unit([1, -1, 0]), tilt) for v in ([d, d, 0], [d, 0, -d], [0, d, -d])]
    return [rotate(v, [0, 0, 1], k * 2 * math.pi / 3) for k in range(3) for v in trio]


def child(of, v):
    """A copy at a third of the size, outside the unit sphere in direction v, its z axis along v."""
    transform = {"scale": 1 / 3, "translate": [round(4 / 3 * x, 12) for x in v]}
    angle = math.degrees(math.acos(max(-1.0, min(1.0, v[2]))))
    if angle > 1e-9:
        transform["rotate_deg"] = {"axis": [round(-v[1], 12), round(v[0], 12), 0], "angle": round(angle, 10)}
    return {"instance": {"of": of, "transform": transform}}


def flake(levels):
    sphere = {"sphere": {"center": [0, 0, 0], "radius": 1, "material": "balls"}}
    definitions = {"flake0": [sphere]}
    for k in range(1, levels + 1):
        definitions["flake%d" % k] = [sphere] + [child("flake%d" % (k - 1), v) for v in nine_directions()]
    light = [{"point": {"position": p, "color": round(1 / math.sqrt(3), 12)}} for p in ([4, 3, 2], [1, -4, 4], [-3, 1, 5])]
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "sphere flake, level %d: %s spheres (after E. Haines, SPD balls)" % (levels, "{:,}".format((9 ** (levels + 1) - 1) // 8)),
        "image": {"width": 512, "height": 512},
        "camera": {"pinhole": {"eye": [2.1, 1.3, 1.7], "look_at": [0, 0, 0], "up": [0, 0, 1], "vfov_deg": 45}},
        "background": [0.078, 0.361, 0.753],
        "ambient": 0.15,
        "lights": light,
        "materials": {
            "floor": {"diffuse": [0.8, 0.6, 0.264]},
            "balls": {"diffuse": [0.5, 0.45, 0.35], "specular": 0.5, "shininess": 3.0827, "reflection": 0.5},
        },
        "definitions": definitions,
        "objects": [
            {"quad": {"vertices": [[12, 12, -0.5], [-12, 12, -0.5], [-12, -12, -0.5], [12, -12, -0.5]], "material": "floor"}},
            {"instance": {"of": "flake%d" % levels, "transform": {"scale": 0.5}}},
        ],
    }


def knot(around=240, across=24, tube=0.32):
    """A (2,3) torus knot as a closed tube with smooth normals."""
    def center(t):
        r = 2 + math.cos(3 * t)
        return [r * math.cos(2 * t), math.sin(3 * t), r * math.sin(2 * t)]
    vertices, normals, faces = [], [], []
    for i in range(around):
        t = 2 * math.pi * i / around
        p, q = center(t), center(t + 1e-4)
        tangent = unit([b - a for a, b in zip(p, q)])
        u = unit(cross(tangent, [math.cos(2 * t), 0.3, math.sin(2 * t)]))
        v = cross(tangent, u)
        for k in range(across):
            a = 2 * math.pi * k / across
            n = unit([math.cos(a) * x + math.sin(a) * y for x, y in zip(u, v)])
            normals.append([round(x, 6) for x in n])
            vertices.append([round(c + tube * x, 6) for c, x in zip(p, n)])
    for i in range(around):
        for k in range(across):
            a, b = i * across + k, i * across + (k + 1) % across
            c, d = (i + 1) % around * across + k, (i + 1) % around * across + (k + 1) % across
            faces += [[a, d, c], [a, b, d]]
    return {"vertices": vertices, "faces": faces, "normals": normals, "material": "knot", "name": "trefoil"}


def knot_scene():
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "trefoil knot: a mesh of 11,520 triangles with smooth normals",
        "image": {"width": 640, "height": 480},
        "camera": {"pinhole": {"eye": [1.5, 6.5, 5.5], "look_at": [0, -0.3, 0], "vfov_deg": 45}},
        "background": [0.55, 0.65, 0.75],
        "ambient": 0.2,
        "lights": [{"point": {"position": [6, 10, 4], "color": 0.9}}],
        "materials": {
            "knot": {"diffuse": "#b4532a", "specular": 0.6, "shininess": 60, "reflection": 0.15},
            "floor": {"diffuse": {"checker": {"a": 0.7, "b": 0.25, "size": 1.5}}, "reflection": 0.1},
        },
        "objects": [
            {"plane": {"point": [0, -1.4, 0], "normal": [0, 1, 0], "material": "floor"}},
            {"mesh": knot()},
        ],
    }


def icosphere(levels):
    """Vertices and faces of a unit sphere: an icosahedron whose faces are cut in four."""
    g = (1 + math.sqrt(5)) / 2
    vertices = [unit(v) for a in (-1, 1) for b in (-g, g) for v in ([0, a, b], [a, b, 0], [b, 0, a])]
    near = lambda i, j: math.dist(vertices[i], vertices[j]) < 1.1
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near(a, b) and near(b, c) and near(c, a):
                    p, q, r = vertices[a], vertices[b], vertices[c]
                    normal = cross([y - x for x, y in zip(p, q)], [y - x for x, y in zip(p, r)])
                    outward = sum(x * y for x, y in zip(normal, p)) > 0
                    faces.append([a, b, c] if outward else [a, c, b])
    for _ in range(levels):
        middles, finer = {}, []

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                vertices.append(unit([x + y for x, y in zip(vertices[i], vertices[j])]))
                middles[key] = len(vertices) - 1
            return middles[key]
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        faces = finer
    return vertices, faces


def terminator_scene():
    """Coarse spheres in grazing light: with interpolated normals, flat, and finer; the last one is a true sphere."""
    def ball(levels, center, smooth):
        vertices, faces = icosphere(levels)
        place = lambda v: [round(c + x, 9) for c, x in zip(center, v)]
        mesh = {"vertices": [place(v) for v in vertices], "faces": faces, "material": "plaster"}
        if smooth:
            mesh["normals"] = [[round(x, 9) for x in v] for v in vertices]
        return {"mesh": mesh}
    return {
        "$schema": "../../api/scene.schema.json",
        "version": 1,
        "name": "shadow terminator: 80 facets smooth and flat, 320 smooth, and the sphere they stand for",
        "image": {"width": 640, "height": 360},
        "camera": {"pinhole": {"eye": [0, 3.2, 9], "look_at": [0, 0.9, 0], "vfov_deg": 32}},
        "background": [0.3, 0.35, 0.45],
        "ambient": 0.15,
        "lights": [{"directional": {"direction": [-1, -0.35, -0.25], "color": 0.9}}],
        "materials": {"plaster": {"diffuse": 0.8}, "floor": {"diffuse": 0.5}},
        "objects": [
            {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor"}},
            ball(1, [-3.6, 1, 0], True),
            ball(1, [-1.2, 1, -0.4], False),
            ball(2, [1.2, 1, 0], True),
            {"sphere": {"center": [3.6, 1, -0.4], "radius": 1, "material": "plaster"}},
            {"sphere": {"center": [-2.32, 1.5, 0.35], "radius": 0.14, "material": "plaster"}},
        ],
    }


def write(path, scene, wide_keys=("definitions", "objects")):
    """JSON with one line for each object or definition, so that ten levels of a flake are ten lines."""
    lines = []
    for key, value in scene.items():
        if key in wide_keys:
            opening, closing = ("{", "}") if isinstance(value, dict) else ("[", "]")
            items = ["    %s: %s" % (json.dumps(k), json.dumps(v)) for k, v in value.items()] if isinstance(value, dict) \
                else ["    " + json.dumps(v) for v in value]
            lines.append("  %s: %s\n%s\n  %s" % (json.dumps(key), opening, ",\n".join(items), closing))
        else:
            lines.append("  %s: %s" % (json.dumps(key), json.dumps(value)))
    with open(os.path.join(HERE, path), "w") as file:
        file.write("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    write("spheres/flake_4.json", flake(4))
    write("spheres/flake_9.json", flake(9))
    write("meshes/knot.json", knot_scene())
    write("hard/terminator.json", terminator_scene())
