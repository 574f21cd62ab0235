#!/usr/bin/env python3
"""The scenes of the comparison, described once and written for POV-Ray, for the C++ programs and for strahl.

    scenes.py FOLDER [SCENE ...]

W1 is Whitted's pair of balls over a checkerboard, 1920 x 1080; W2 a sphere flake of 7,381 spheres, W2d6 one of 597,871;
W3 a mesh of a million triangles; W4 a thousand glass balls; W5 three balls under a square lamp, W7 the same through a lens;
W6 a mesh of 160,000 triangles with a picture on it, and bumps: a normal map, and for POV-Ray, which has none, their heights.
Right-handed; vfov is the full vertical angle. Needs numpy.
"""

import base64
import json
import math
import os
import struct
import sys
import zlib

import numpy as np


def mat(color, kd=0.0, ks=0.0, shine=1.0, kr=0.0, kt=0.0, ior=1.0, color2=None, size=1.0, amb=0.05):
    return dict(color=color, kd=kd, ks=ks, shine=shine, kr=kr, kt=kt, ior=ior, color2=color2, size=size, amb=amb)


def scene(**k):
    s = dict(
        bg=[0.078, 0.361, 0.753], spheres=np.zeros((0, 4)), sph_mat=np.zeros(0, int), meshes=[], depth=5, adc=1 / 255.0,
        area=None, lens=None, uvs=None, pictures=None
    )
    s.update(k)
    return s


def quad(a, b, c, d):  # two triangles, counter-clockwise
    return np.array([a, b, c, d], float), None, np.array([[0, 1, 2], [0, 2, 3]])


def W1():
    m = [
        mat([0.9, 0.9, 0.2], kd=0.8, color2=[0.8, 0.1, 0.1]),  # checker floor, tile 1
        mat([1, 1, 1], kd=0.1, ks=0.6, shine=80, kr=0.8),  # mirror
        mat([1, 1, 1], kd=0.02, ks=0.6, shine=120, kr=0.08, kt=0.9, ior=1.5),  # glass
    ]
    V, N, F = quad((-10, 0, 14), (10, 0, 14), (10, 0, -26), (-10, 0, -26))
    return scene(
        name="W1",
        res=(1920, 1080),
        eye=[0, 2.2, 7],
        at=[0, 1.3, 0],
        up=[0, 1, 0],
        vfov=40.0,
        lights=[([6, 9, 8], [1.0, 1.0, 1.0])],
        mats=m,
        meshes=[(V, N, F, 0)],
        spheres=np.array([[-1.1, 1.25, -1.2, 1.25], [1.0, 1.15, 1.6, 0.95]]),
        sph_mat=np.array([1, 2]),
        depth=8,
    )


def rot(axis, ang):
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    c, s = math.cos(ang), math.sin(ang)
    t = 1 - c
    return np.array(
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ]
    )


def W2(depth=4, name="W2"):
    """SPD 'balls': sphereflake, 9 children of 1/3 radius per sphere, on a floor, 3 lights (re-derived, not Haines' code)."""
    d = 1 / math.sqrt(2)
    trio = np.array([[d, d, 0], [d, 0, -d], [0, d, -d]])
    trio = trio @ rot((1, -1, 0), math.asin(2 / math.sqrt(6))).T
    kids = np.concatenate([trio @ rot((0, 0, 1), k * 2 * math.pi / 3).T for k in range(3)])
    out, level = [], [(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.5)]
    for k in range(depth + 1):
        out += [(*c, r) for c, _, r in level]
        if k == depth:
            break
        nxt = []
        for c, dr, r in level:
            M = (
                np.eye(3)
                if dr[2] >= 1
                else rot((0, 1, 0), math.pi) if dr[2] <= -1 else rot((-dr[1], dr[0], 0), math.acos(dr[2]))
            )
            nxt += [(c + v * (r + r / 3), v, r / 3) for v in kids @ M.T]
        level = nxt
    s = np.array(out)
    n = len(s)
    L = 1 / math.sqrt(3)
    m = [mat([1, 0.75, 0.33], kd=0.8), mat([1, 0.9, 0.7], kd=0.5, ks=0.5, shine=3.0827, kr=0.5)]
    V, N, F = quad((12, 12, -0.5), (-12, 12, -0.5), (-12, -12, -0.5), (12, -12, -0.5))
    return scene(
        name=name,
        res=(1024, 1024),
        eye=[2.1, 1.3, 1.7],
        at=[0, 0, 0],
        up=[0, 0, 1],
        vfov=45.0,
        lights=[(p, [L] * 3) for p in ([4, 3, 2], [1, -4, 4], [-3, 1, 5])],
        mats=m,
        meshes=[(V, N, F, 0)],
        spheres=s,
        sph_mat=np.full(n, 1),
        depth=5,
    )


def W3(nu=1000, nv=502):
    """displaced sphere, exactly nu*(nv-2)*2 = 1,000,000 triangles with smooth normals, on a floor; diffuse Phong, 1 light."""
    th = np.linspace(0, math.pi, nv)[1:-1][:, None]
    ph = (np.arange(nu) * 2 * math.pi / nu)[None, :]

    def r(t, p):
        return (
            1
            + 0.16 * np.sin(5 * p) * np.sin(4 * t) * np.sin(t)
            + 0.05 * np.sin(23 * p + 2 * np.cos(7 * t)) * np.sin(19 * t) * np.sin(t) ** 2
            + 0.012 * np.sin(97 * p) * np.sin(83 * t) * np.sin(t) ** 2
        )

    def P(t, p):
        R = r(t, p)
        return np.stack([R * np.sin(t) * np.cos(p), R * np.cos(t) + 0 * p, R * np.sin(t) * np.sin(p)], -1).reshape(
            -1, 3
        )

    e = 1e-4
    V = P(th, ph)
    N = np.cross(P(th, ph + e) - P(th, ph - e), P(th + e, ph) - P(th - e, ph))
    N *= np.sign((N * V).sum(1))[:, None]
    N /= np.linalg.norm(N, axis=1)[:, None]
    V = np.concatenate([V, [[0, 1, 0], [0, -1, 0]]])
    N = np.concatenate([N, [[0, 1, 0], [0, -1, 0]]])
    i = np.arange(nv - 3)[:, None] * nu
    j = np.arange(nu)[None, :]
    k = (j + 1) % nu
    a, b, c, d = [(x).reshape(-1) for x in (i + j, i + k, i + nu + j, i + nu + k)]
    j, k = j.ravel(), k.ravel()
    top = len(V) - 2
    last = (nv - 3) * nu
    F = np.concatenate(
        [
            np.stack([a, b, d], 1),
            np.stack([a, d, c], 1),
            np.stack([np.full(nu, top), k, j], 1),
            np.stack([np.full(nu, top + 1), last + j, last + k], 1),
        ]
    )
    fl = quad((-30, -1.15, 30), (30, -1.15, 30), (30, -1.15, -30), (-30, -1.15, -30))
    m = [mat([0.75, 0.75, 0.8], kd=0.8), mat([0.85, 0.6, 0.4], kd=0.8, ks=0.2, shine=20)]
    return scene(
        name="W3",
        res=(1024, 1024),
        eye=[1.7, 1.6, 2.3],
        at=[0, -0.1, 0],
        up=[0, 1, 0],
        vfov=40.0,
        lights=[([5, 6, 1], [1.0, 1.0, 1.0])],
        mats=m,
        meshes=[(V, N, F, 1), (*fl, 0)],
        depth=5,
    )


def W4():
    g = np.arange(10) - 4.5
    c = np.stack(np.meshgrid(g, g, g, indexing="ij"), -1).reshape(-1, 3)
    n = len(c)
    s = np.concatenate([c, np.full((n, 1), 0.42)], 1)
    m = [
        mat([0.9, 0.9, 0.9], kd=0.8, color2=[0.2, 0.2, 0.25], size=1.0),
        mat([1, 1, 1], ks=0.3, shine=60, kr=0.1, kt=0.88, ior=1.5),
    ]
    V, N, F = quad((-30, -6, 30), (30, -6, 30), (30, -6, -30), (-30, -6, -30))
    return scene(
        name="W4",
        res=(256, 256),
        eye=[9, 7, 14],
        at=[0, -0.5, 0],
        up=[0, 1, 0],
        vfov=42.0,
        lights=[([8, 15, 12], [0.7, 0.7, 0.7]), ([-12, 10, 6], [0.4, 0.4, 0.4])],
        mats=m,
        meshes=[(V, N, F, 0)],
        spheres=s,
        sph_mat=np.full(n, 1),
        depth=10,
    )


def W5(name="W5", **more):
    m = [
        mat([0.9, 0.9, 0.85], kd=0.8, color2=[0.35, 0.4, 0.5]),
        mat([0.8, 0.25, 0.2], kd=0.8, ks=0.3, shine=60),
        mat([0.3, 0.5, 0.8], kd=0.8, ks=0.3, shine=60),
        mat([1, 1, 1], kd=0.1, ks=0.6, shine=80, kr=0.8),
    ]
    V, N, F = quad((-10, 0, 14), (10, 0, 14), (10, 0, -26), (-10, 0, -26))
    return scene(**{**dict(
        name=name,
        res=(640, 360),
        eye=[0, 2.2, 7],
        at=[0, 1.0, 0],
        up=[0, 1, 0],
        vfov=40.0,
        lights=[([3, 6, 4], [1.0, 1.0, 1.0])],
        area=([2, 0, 0], [0, 0, 2]),
        mats=m,
        meshes=[(V, N, F, 0)],
        spheres=np.array([[-1.9, 0.9, 0.5, 0.9], [1.9, 0.7, 1.9, 0.7], [0.4, 1.25, -2.2, 1.25]]),
        sph_mat=np.array([1, 2, 3]),
    ), **more})


def png(pixels):
    """A picture of 8-bit codes, red, green and blue, the upper row first."""
    height, width, _ = pixels.shape
    part = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype(np.uint8))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", header) + part(b"IDAT", zlib.compress(rows)) + part(b"IEND", b"")


def W6(n=256, nu=400, nv=200, bump=0.012):
    """A vase. Its picture and its bumps repeat four times around it."""
    u, v = np.meshgrid(np.arange(nu + 1) / nu, np.arange(nv + 1) / nv)
    radius = 0.9 + 0.35 * np.sin(2.3 * np.pi * v + 0.6)
    turn = 2 * np.pi * u
    V = np.stack([radius * np.sin(turn), 2.6 * v, radius * np.cos(turn)], -1).reshape(-1, 3)
    slope = 0.35 * 2.3 * np.pi * np.cos(2.3 * np.pi * v + 0.6) / 2.6
    N = np.stack([np.sin(turn), -slope, np.cos(turn)], -1).reshape(-1, 3)
    N /= np.linalg.norm(N, axis=1)[:, None]
    a = (np.arange(nv)[:, None] * (nu + 1) + np.arange(nu)).reshape(-1)
    b, c, d = a + 1, a + nu + 2, a + nu + 1
    F = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    UV = np.stack([4 * u, 2 * v], -1).reshape(-1, 2)
    x, y = np.meshgrid(np.arange(n) / n, np.arange(n) / n)
    height = 0.5 + 0.5 * np.sin(16 * np.pi * x) * np.sin(16 * np.pi * y)
    stripes = (np.sin(8 * np.pi * (x + y)) > 0)[..., None]
    color = np.where(stripes, [205, 120, 60], [90, 60, 110]) * (0.8 + 0.2 * height[..., None])
    # Heights are in units of the picture's width; the normal's y goes up, rows go down.
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * bump * n / 2
    dy = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) * bump * n / 2
    normal = np.stack([-dx, -dy, np.ones_like(dx)], -1)
    normal /= np.linalg.norm(normal, axis=-1)[..., None]
    grey = np.repeat(np.round(255 * height)[..., None], 3, 2)
    m = [mat([0.9, 0.9, 0.85], kd=0.8), mat([1, 1, 1], kd=1.0, ks=0.3, shine=40, amb=1 / 16)]
    floor = quad((-10, 0, 14), (10, 0, 14), (10, 0, -26), (-10, 0, -26))
    return scene(
        name="W6",
        res=(1024, 1024),
        eye=[0, 2.4, 6],
        at=[0, 1.25, 0],
        up=[0, 1, 0],
        vfov=32.0,
        lights=[([4, 6, 5], [1.0, 1.0, 1.0])],
        mats=m,
        meshes=[(*floor, 0), (V, N, F, 1)],
        uvs={1: UV},
        pictures={1: dict(color=png(color), normal=png(np.round(127.5 + 127.5 * normal)), height=png(grey), bump=bump)},
    )


def W7():
    return W5("W7", area=None, lens=(0.25, 6.5))


# Those whose samples choose: only for equal_error.py.
CHOOSING = dict(W5=W5, W7=W7)
SCENES = dict(W1=W1, W2=W2, W2d6=lambda: W2(6, "W2d6"), W3=W3, W4=W4, W6=W6)


def basis(s):
    e, a, u = (np.array(s[k], float) for k in ("eye", "at", "up"))
    d = a - e
    d /= np.linalg.norm(d)
    r = np.cross(d, u)
    r /= np.linalg.norm(r)
    return e, d, r, np.cross(r, d)


v3 = lambda p: "<%.9g,%.9g,%.9g>" % tuple(p)


def pov(s, f):
    e, d, r, u = basis(s)
    w, h = s["res"]
    lens = ""
    if s["lens"]:
        # POV-Ray's apertures are twice the diameter of the lens, as measured.
        lens = " aperture %.9g focal_point %s BLUR" % (2 * s["lens"][0], v3(e + d * s["lens"][1]))
    f.write(
        "#version 3.7;\nglobal_settings{assumed_gamma 1.0 max_trace_level %d adc_bailout %.9g ambient_light 1}\n"
        % (s["depth"], s["adc"])
    )
    f.write(
        "background{rgb %s}\ncamera{location %s direction %s right %s up %s%s}\n"
        % (v3(s["bg"]), v3(e), v3(d * 0.5 / math.tan(math.radians(s["vfov"]) / 2)), v3(r * w / h), v3(u), lens)
    )
    # In scenes that choose, the command line says how well: the file reads POINTS, ADAPTIVE and BLUR (see equal_error.py).
    for p, c in s["lights"]:
        area = " area_light %s,%s,POINTS,POINTS ADAPTIVE jitter" % tuple(map(v3, s["area"])) if s["area"] else ""
        f.write("light_source{%s rgb %s%s}\n" % (v3(p), v3(c), area))
    for i, m in enumerate(s["mats"]):
        t = " transmit %g" % m["kt"] if m["kt"] else ""
        pig = (
            ("checker rgb %s rgb %s scale %g translate y*-.5" % (v3(m["color"]), v3(m["color2"]), m["size"]))
            if m["color2"]
            else "rgb %s%s" % (v3(m["color"]), t)
        )
        # POV multiplies diffuse/ambient by pigment opacity (1-transmit); undo it so kd means kd in every engine
        k = 1 / (1 - m["kt"])
        bumps = ""
        if s["pictures"] and i in s["pictures"]:
            pictures = s["pictures"][i]
            for what in ("color", "height"):
                with open(os.path.join(os.path.dirname(f.name), f"{s['name']}_{what}.png"), "wb") as file:
                    file.write(pictures[what])
            pig = 'image_map{png "%s_color.png" gamma srgb interpolate 2}' % s["name"]
            bumps = 'normal{bump_map{png "%s_height.png" interpolate 2 bump_size %g}}' % (s["name"], 130 * pictures["bump"])
        f.write(
            "#declare M%d=texture{%spigment{%s}%sfinish{ambient %g diffuse %g phong %g phong_size %g reflection{%g}}}\n"
            % (i, "uv_mapping " if bumps else "", pig, bumps, m["amb"] * k, m["kd"] * k, m["ks"], m["shine"], m["kr"])
        )
    for (x, y, z, R), k in zip(s["spheres"], s["sph_mat"]):
        i = s["mats"][k]
        f.write(
            "sphere{<%.9g,%.9g,%.9g>,%.9g texture{M%d}%s}\n"
            % (x, y, z, R, k, " interior{ior %g}" % i["ior"] if i["kt"] else "")
        )
    for mesh, (V, N, F, k) in enumerate(s["meshes"]):
        if len(F) <= 2:
            for t in F:
                f.write("triangle{%s,%s,%s texture{M%d}}\n" % (*(v3(V[j]) for j in t), k))
            continue
        f.write("mesh2{vertex_vectors{%d,\n" % len(V))
        f.write(",\n".join(map(v3, V)))
        if N is not None:
            f.write("}normal_vectors{%d,\n" % len(N))
            f.write(",\n".join(map(v3, N)))
        if s["uvs"] and mesh in s["uvs"]:
            f.write("}uv_vectors{%d,\n" % len(V))
            f.write(",\n".join("<%.9g,%.9g>" % tuple(uv) for uv in s["uvs"][mesh]))
        f.write("}face_indices{%d,\n" % len(F))
        f.write(",\n".join("<%d,%d,%d>" % tuple(t) for t in F))
        f.write("}texture{M%d}}\n" % k)


def binary(s, f):
    """little-endian; read by the C++ programs. The struct calls are the whole format."""
    e, d, r, u = basis(s)
    w, h = s["res"]
    t = math.tan(math.radians(s["vfov"]) / 2)
    f.write(
        struct.pack(
            "<4sIIIIIIIf",
            b"WSC1",
            w,
            h,
            s["depth"],
            len(s["lights"]),
            len(s["mats"]),
            len(s["spheres"]),
            len(s["meshes"]),
            s["adc"],
        )
    )
    for v in (e, d, r * t * w / h, u * t, s["bg"]):
        f.write(struct.pack("<3f", *v))
    for p, c in s["lights"]:
        f.write(struct.pack("<6f", *p, *c))
    for m in s["mats"]:
        f.write(
            struct.pack(
                "<15f",
                *m["color"],
                *(m["color2"] or m["color"]),
                m["size"] if m["color2"] else 0,
                m["amb"],
                m["kd"],
                m["ks"],
                m["shine"],
                m["kr"],
                m["kt"],
                m["ior"],
                0,
            )
        )
    f.write(s["spheres"].astype("<f4").tobytes())
    f.write(s["sph_mat"].astype("<u4").tobytes())
    for V, N, F, k in s["meshes"]:
        f.write(struct.pack("<IIII", len(V), len(F), int(N is not None), k))
        f.write(V.astype("<f4").tobytes())
        if N is not None:
            f.write(N.astype("<f4").tobytes())
        f.write(F.astype("<u4").tobytes())


def strahl(s, f):
    """Scene JSON version 1. POV-Ray attenuates shadows by transparent bodies, so the scene asks for that too."""
    A = 1 / 16.0  # scene ambient; a material's own ambient makes it amb * color

    def image(data):
        return dict(image=dict(source="data:image/png;base64," + base64.b64encode(data).decode()))

    def material(i, m):
        d = dict(diffuse=[m["kd"] * c for c in m["color"]], specular=m["ks"], shininess=m["shine"])
        if m["color2"]:
            assert abs(m["amb"] - A * m["kd"]) < 1e-12  # default ambient = diffuse
            d["diffuse"] = dict(
                checker=dict(
                    a=[m["kd"] * c for c in m["color"]], b=[m["kd"] * c for c in m["color2"]], size=m["size"], axes="xz"
                )
            )
        else:
            d["ambient"] = [m["amb"] / A * c for c in m["color"]]
        if s["pictures"] and i in s["pictures"]:
            d.update(diffuse=image(s["pictures"][i]["color"]), normal_map=image(s["pictures"][i]["normal"]))
            del d["ambient"]  # by default that of the picture
        if m["kr"]:
            d["reflection"] = m["kr"]
        if m["kt"]:
            d["transmission"] = m["kt"]
            d["ior"] = m["ior"]
        return d

    w, h = s["res"]
    pinhole = dict(eye=s["eye"], look_at=s["at"], up=s["up"], vfov_deg=s["vfov"])
    if s["lens"]:
        pinhole.update(aperture=s["lens"][0], focus_distance=s["lens"][1])
    area = dict(area=dict(parallelogram=dict(u=s["area"][0], v=s["area"][1]))) if s["area"] else {}
    render = dict(max_depth=s["depth"], antialias=True, shadows="opaque")
    if not (s["area"] or s["lens"]):
        render.update(accuracy=dict(fixed={}), min_weight=s["adc"], samples=1, antialias=False, shadows="transmissive")
    objs = [
        dict(sphere=dict(center=list(map(float, q[:3])), radius=float(q[3]), material="m%d" % k))
        for q, k in zip(s["spheres"], s["sph_mat"])
    ]
    for mesh, (V, N, F, k) in enumerate(s["meshes"]):
        m = dict(vertices=V.tolist(), faces=F.tolist(), material="m%d" % k)
        if N is not None:
            m["normals"] = N.tolist()
        if s["uvs"] and mesh in s["uvs"]:
            m["uvs"] = s["uvs"][mesh].tolist()
        objs.append(dict(mesh=m))
    json.dump(
        dict(
            version=1,
            name=s["name"],
            image=dict(width=w, height=h),
            camera=dict(pinhole=pinhole),
            background=s["bg"],
            ambient=[A] * 3,
            lights=[dict(point=dict(position=list(p), color=list(c), **area)) for p, c in s["lights"]],
            materials={"m%d" % i: material(i, m) for i, m in enumerate(s["mats"])},
            objects=objs,
            render=render,
        ),
        f,
    )


def main():
    folder, names = sys.argv[1], sys.argv[2:] or SCENES
    for name in names:
        made = {**SCENES, **CHOOSING}[name]()
        for extension, write, mode in (("pov", pov, "w"), ("bin", binary, "wb"), ("json", strahl, "w")):
            with open(os.path.join(folder, name + "." + extension), mode) as file:
                write(made, file)
        triangles = sum(len(mesh[2]) for mesh in made["meshes"])
        print(f"{name}: {len(made['spheres'])} spheres, {triangles} triangles", flush=True)


if __name__ == "__main__":
    main()
