"""Requests that a hostile client sends: small to send and long to answer, each in its own way.

REQUESTS has them by name. A request is a function of no arguments that returns another one: of a number, which makes its
text different each time so that no cache answers, and of the answer before, or None. That gives method, path, headers and body.
"""

import base64
import gzip
import json
import random
import struct
import zlib
from dataclasses import dataclass
from typing import Callable

JSON = {"Content-Type": "application/json"}
CAMERA = {"pinhole": {"eye": [0, 0, 5], "look_at": [0, 0, 0]}}
GLASS = {"diffuse": 0, "reflection": 0.5, "transmission": 0.5, "ior": 1.5}
MIRROR = {"diffuse": 0.1, "reflection": 0.9}
FLAT = {"planar": {"axes": "xy"}}
ENDLESS = {"max_depth": 100_000, "min_weight": 0}
SAMPLES = 1024


@dataclass(frozen=True)
class Hostile:
    """A kind of request, how many clients send it at one time, and after how many seconds they leave without an answer."""

    make: Callable
    clients: int = 1
    leave: float = 60
    scene: Callable | None = None  # for a job about the same scene
    goes_on: bool = False  # what was accepted is worked on when the clients have left


def scene(objects, size=(64, 40), **rest):
    """The text of a scene; objects may be text already."""
    about = {"version": 1, "image": {"width": size[0], "height": size[1]}, "camera": CAMERA} | rest
    objects = objects if isinstance(objects, str) else json.dumps(objects)
    return f'{json.dumps(about)[:-1]}, "objects": {objects}}}'


def different(text, number):
    """Scenes that differ in nothing that takes time."""
    return b'{"ambient": 0.1%06d, ' % number + text[1:].encode()


def sphere(center, radius, material="glass"):
    return {"sphere": {"center": center, "radius": radius, "material": material}}


def grid(side, radius=0.45):
    at = [i - (side - 1) / 2 for i in range(side)]
    return [sphere([x, y, z], radius) for x in at for y in at for z in at]


def point_lights(count):
    chance = random.Random(1)
    return [{"point": {"position": [chance.uniform(-0.9, 0.9) for _ in range(3)], "intensity": 0.01}} for _ in range(count)]


def png(side, level=1):
    """A grey PNG that is small to send, or at level 0 as large as its pixels."""
    rows = bytes((side + 1) * side)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, level)) + chunk(b"IEND", b"")
    return "data:image/png;base64," + base64.b64encode(data).decode()


def instances():
    """2^31 spheres at one place, in a corner of the picture that a pilot does not look at."""
    definitions = {"d0": [{"sphere": {"center": [0, 0, 0], "radius": 1}}]}
    for i in range(1, 32):
        turned = [{"rotate_deg": {"axis": [1, 2, 3], "angle": angle * i}} for angle in (1, -1)]
        definitions[f"d{i}"] = [{"instance": {"of": f"d{i - 1}", "transform": turn}} for turn in turned]
    corner = {"scale": 0.004, "translate": [3.2, 1.8, 0]}
    return scene([{"instance": {"of": "d31", "transform": corner}}], (960, 540), definitions=definitions)


def nff_spheres(number, _=None):
    about = f"b 0.1 0.1 0.1{number:06}\nv\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 512 512\nf 1 1 1 .5 .5 9 .5 1.5\n"
    headers = {"Content-Type": "text/x-nff", "Content-Encoding": "gzip"}
    return "POST", "/v1/render", headers, gzip.compress(about.encode() + b"s 0 0 0 1\n" * 1_900_000, 6)


def balls(size, samples):
    return scene(grid(9), size, materials={"glass": GLASS}, render=ENDLESS | {"samples": samples, "antialias": False})


def box(size, render, lights=1_000):
    room = {"box": {"min": [-6, -6, -6], "max": [6, 6, 6], "hollow": True, "material": "mirror"}}
    about = {"materials": {"mirror": MIRROR}, "lights": point_lights(lights), "render": render}
    return scene([room, sphere([0, 0, 0], 1, "mirror")], size, **about)


def motion_tori():
    torus = {"torus": {"center": [0, 0, 0], "major_radius": 1, "minor_radius": 0.3}}
    turn = lambda i: {"rotate_deg": {"axis": [1, i % 7, i % 11], "angle": 36_000}}
    groups = [{"group": {"objects": [torus], "motion": turn(i)}} for i in range(1_000)]
    return scene(groups, (200, 200), render={"samples": SAMPLES})


def glass_tori():
    chance = random.Random(3)
    place = lambda: [chance.uniform(-1, 1) for _ in range(3)]
    rings = {"major_radius": 1, "minor_radius": 0.4, "material": "glass"}
    tori = [{"torus": {"center": place(), "axis": place()} | rings} for _ in range(20_000)]
    return scene(tori, (960, 540), materials={"glass": GLASS}, render={"max_depth": 100})


def unknown_names():
    chance = random.Random(6)
    word = lambda: "".join(chance.choices("abcdefgh", k=64))
    materials = {word(): {} for _ in range(100_000)}
    return scene([sphere([0, 0, 0], 1, word()) for _ in range(60)], materials=materials)


def many(what, count, **rest):
    return scene("[" + ",".join([what] * count) + "]", **rest)


def equal_spheres():
    return many('{"sphere":{"center":[0,0,0],"radius":1}}', 1_400_000, size=(960, 540))


def equal_triangles():
    faces = ",".join(["[0,1,2]"] * 3_000_000)
    return scene(f'[{{"mesh": {{"vertices": [[-1,-1,0],[1,-1,0],[0,1,0]], "faces": [{faces}]}}}}]', (960, 540))


def different_spheres():
    chance = random.Random(4)
    place = lambda: ",".join(f"{chance.uniform(-2, 2):.2f}" for _ in range(3))
    spheres = ",".join(f'{{"sphere":{{"center":[{place()}],"radius":0.1}}}}' for _ in range(1_200_000))
    return scene(f"[{spheres}]", (960, 540))


def planes():
    """Planes have no box, so a ray meets each of them."""
    chance = random.Random(5)
    normal = lambda: [chance.uniform(-1, 1), chance.uniform(-1, 1), 3]
    return scene([{"plane": {"point": [0, 0, -5], "normal": normal()}} for _ in range(200_000)], (960, 540))


def sheets():
    """Shadows of light through 100,000 panes: one shadow ray passes all of them."""
    at = lambda z: [[-9, -9, z], [9, -9, z], [9, 9, z], [-9, 9, z]]
    panes = [{"quad": {"vertices": at(i / 1e5), "material": "pane"}} for i in range(100_000)]
    floor = {"plane": {"point": [0, 0, -1], "normal": [0, 0, 1]}}
    about = {"materials": {"pane": {"diffuse": 0, "transmission": 1}}, "lights": point_lights(20)}
    return scene([*panes, floor], render=ENDLESS | {"shadows": "transmissive"}, **about)


def nested_glass():
    """Dispersion in balls within balls, each sample with a wavelength of its own."""
    onion = [sphere([0, 0, 0], 2 - i / 16) for i in range(31)]
    render = ENDLESS | {"samples": SAMPLES}
    return scene(onion, (240, 240), materials={"glass": GLASS | {"dispersion": 0.2}}, render=render)


def noise():
    grain = {"noise": {"size": 1e-3, "octaves": 12}}
    rough = {"diffuse": {"noise": {"a": 0, "b": 1, "octaves": 12}}, "bump": {"height": 1, "texture": grain}, "roughness": 1, "reflection": 0.9}
    floor = {"plane": {"point": [0, -1, 0], "normal": [0, 1, 0], "material": "rough"}}
    render = {"samples": SAMPLES, "color_bleeding": True, "max_depth": 100}
    return scene([floor, sphere([0, 0, 0], 1, "rough")], (240, 240), materials={"rough": rough}, render=render)


def textures():
    """The largest pictures that scenes may hold, as few bytes."""
    image = {"image": {"source": png(4096), "mapping": FLAT}}
    about = {"materials": {"glass": {"diffuse": image, "reflection": 0.5}}}
    return scene([sphere([0, 0, 0], 1)], **about)


def broken_pictures():
    whole = png(150, 0)
    source = lambda i: whole[: -40 - 4 * (i % 9)] + "AAAA"
    materials = {f"m{i}": {"diffuse": {"image": {"source": source(i), "mapping": FLAT}}} for i in range(800)}
    return scene([sphere([0, 0, 0], 1, f"m{i}") for i in range(800)], materials=materials)


def environment():
    about = {"environment": {"image": png(4096)}, "materials": {"glass": MIRROR | {"roughness": 1}}}
    return scene([sphere([0, 0, 0], 1)], (960, 540), render={"samples": 100}, **about)


def polygons():
    """Combs of 10,000 corners, which take the longest to cut into triangles."""
    teeth = [[x / 2500 - 1, (x % 2) * (1 - x / 1e4), 0] for x in range(9_998)]
    corners = [*teeth, [9, -1, 0], [-1, -1, 0]]
    return scene([{"polygon": {"vertices": corners}}] * 2, (960, 540))


def definitions():
    ball = [{"sphere": {"center": [0, 0, 0], "radius": 1}}]
    known = {f"a definition with the number {i}": ball for i in range(200_000)}
    return scene([{"instance": {"of": name}} for name in known], definitions=known)


def wrong_shapes():
    return many('{"sphere":{"centre":[0,0,0],"radius":"1"}}', 1_000_000)


def hall(size, render):
    mirrors = [{"plane": {"point": [0, 0, z], "normal": [0, 0.001, -z], "material": "mirror"}} for z in (-6, 6)]
    about = {"materials": {"mirror": {"diffuse": 0.01, "reflection": 0.99999}}, "render": render}
    return scene([*mirrors, sphere([0, 0, 0], 1, "mirror")], size, **about)


def asked(text, path="/v1/render", before=b"", after=b"", headers=JSON):
    """The request about a scene."""

    def make():
        made = text()
        return lambda number, _: ("POST", path, headers, before + different(made, number) + after)

    return make


def rays_of(text):
    ray = b'{"origin": [3.2, 1.8, 5], "direction": [0, 0, -1]}'
    return asked(text, "/v1/rays", b'{"rays": [' + b", ".join([ray] * 100_000) + b'], "scene": ', b"}")


def tiles():
    """Tiles of a scene that is known: deep inside it, and all of it."""

    def make():
        text = hall((4096, 2560), {"max_depth": 1_000, "min_weight": 0})

        def send(number, before):
            if number == 0 or before is None or before[0] not in (200, 201, 503):
                return "POST", "/v1/scenes?zoom=4", JSON, different(text, 7)
            if number == 1 or not send.image:
                send.image = json.loads(before[1]).get("image_id") or send.image
            x, y = 256 * (number % 60), 256 * (number // 60 % 40)
            return "GET", f"/iiif/3/{send.image}/{x},{y},256,256/256,/0/default.png", {}, b""

        send.image = None
        return send

    return make


def job_storm():
    """Jobs that are submitted, cancelled and deleted, in turn."""

    def make():
        text = hall((2880, 2880), {"max_depth": 10_000, "min_weight": 0, "samples": 4})
        send_to = {}

        def send(number, before):
            if number % 3 == 1 and before and before[0] == 202:
                send_to["job"] = json.loads(before[1])["id"]
            if number % 3 and send_to.get("job"):
                method, suffix = (("POST", "/cancel"), ("DELETE", ""))[number % 3 - 1]
                return method, f"/v1/jobs/{send_to['job']}{suffix}", JSON, b""
            return "POST", "/v1/jobs", JSON, b'{"scene": ' + different(text, number) + b"}"

        return send

    return make


def of(text, job=True, path="/v1/render", **rest):
    return Hostile(asked(text, path), scene=text if job else None, **rest)


ONE_PIXEL = lambda: balls((1, 1), SAMPLES)  # noqa: E731
TREE = lambda: balls((64, 40), 1)  # noqa: E731
LARGE_BALLS = lambda: balls((640, 400), 64)  # noqa: E731
MANY_LIGHTS = lambda: box((250, 250), {"samples": SAMPLES})  # noqa: E731
LIGHTS_8MP = lambda: box((3520, 2340), {"samples": 7})  # noqa: E731
PROVED = lambda: hall((2880, 2880), {"accuracy": {"proved": {"max_codes": 0}}})  # noqa: E731
SURE = lambda: hall((960, 540), {"accuracy": {"statistical": {"half_width": 0.25, "confidence": 0.999}}})  # noqa: E731
TIMED = lambda: box((960, 540), {"accuracy": {"time": {"ms": 25_000}}})  # noqa: E731
NOISE_8MP = lambda: scene([sphere([0, 0, 0], 3, "n")], (3520, 2340), materials={"n": {"diffuse": {"noise": {"a": 0, "b": 1}}}})  # noqa: E731

REQUESTS = {
    # Those of the first attack.
    "instances": of(instances),
    "nff-spheres": Hostile(lambda: nff_spheres),
    "one-pixel": of(ONE_PIXEL),
    "glass-tree": of(TREE),
    "lights": of(MANY_LIGHTS),
    "motion": of(motion_tori),
    "glass-tori": of(glass_tori),
    "unknown-names": of(unknown_names),
    "equal-spheres": of(equal_spheres, job=False),
    "lights-8mp": of(LIGHTS_8MP),
    "equal-triangles": of(equal_triangles, job=False),
    "spheres": of(different_spheres, job=False),
    # Further ways to the same end.
    "planes": of(planes),
    "sheets": of(sheets),
    "nested-glass": of(nested_glass),
    "noise": of(noise),
    "textures": of(textures),
    "broken-pictures": of(broken_pictures, job=False),
    "environment": of(environment),
    "polygons": of(polygons),
    "definitions": of(definitions, job=False),
    "wrong-shapes": of(wrong_shapes, job=False),
    "proved-0": of(PROVED),
    "sure": of(SURE),
    "time": of(TIMED),
    "tree": of(ONE_PIXEL, False, "/v1/tree?x=0&y=0"),
    "map": of(TREE, False, "/v1/map?of=time"),
    "explain": of(MANY_LIGHTS, False, "/v1/explain"),
    "analyze": of(MANY_LIGHTS, False, "/v1/explain?analyze=1"),
    "tradeoff": of(TREE, False, "/v1/tradeoff?seconds=20"),
    "validate": of(equal_spheres, False, "/v1/scenes/validate"),
    "rays": Hostile(rays_of(instances)),
    "tiles": Hostile(tiles(), clients=8),
    "webp": of(NOISE_8MP, False, "/v1/render?format=webp&antialias=0"),
    "exr": of(NOISE_8MP, False, "/v1/render?format=exr&antialias=0"),
    "png-16": of(NOISE_8MP, False, "/v1/render?bits=16&antialias=0"),
    "crowd": of(LARGE_BALLS, False, clients=40),
    "leavers": of(LARGE_BALLS, False, clients=20, leave=0.05),
    "job-storm": Hostile(job_storm(), clients=8, goes_on=True),
}
