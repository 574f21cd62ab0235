"""Models as scenes with a camera of our own: what `strahl import` prints, changed and rendered."""

import json
import math
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from renderers import OUT, program, run


def imported(model, *flags):
    """The scene of a model."""
    printed = subprocess.run([program(), "import", model, *flags], capture_output=True, check=True)
    return json.loads(printed.stdout)


def without_floor(scene):
    """Takes the floor out, which is there for its shadow alone: the last object, if it has that name."""
    if next(iter(scene["objects"][-1].values())).get("name") == "floor":
        scene["objects"].pop()
    return scene


def triangles(model):
    """As placed, or None for a model that is not read."""
    try:
        scene = without_floor(imported(model))
    except subprocess.CalledProcessError:
        return None
    meshes = {name: sum(len(one["mesh"]["faces"]) for one in of if "mesh" in one)
              for name, of in scene.get("definitions", {}).items()}
    return sum(len(one["mesh"]["faces"]) if "mesh" in one else meshes.get(one.get("instance", {}).get("of"), 0)
               for one in scene["objects"])


def picture_of(scene, picture, *flags):
    """Renders a scene; what it took."""
    OUT.mkdir(parents=True, exist_ok=True)
    file = OUT / "scene.json"
    file.write_text(json.dumps(scene))
    return run([program(), "render", file, "-o", picture, *flags], picture)


@dataclass
class Orbit:
    """A camera on an orbit: degrees around the model and from above, the distance, the middle, and the vertical angle."""

    theta: float
    phi: float
    radius: float
    target: tuple
    angle: float

    def eye(self):
        (sin_t, cos_t), (sin_p, cos_p) = ((math.sin(a), math.cos(a)) for a in map(math.radians, (self.theta, self.phi)))
        way = (sin_p * sin_t, cos_p, sin_p * cos_t)
        return [middle + self.radius * along for middle, along in zip(self.target, way)]

    def pinhole(self):
        return {"pinhole": {"eye": self.eye(), "look_at": list(self.target), "vfov_deg": self.angle}}


@dataclass
class Reference:
    """A picture by another renderer, and from where it is seen."""

    picture: Path
    model: str
    renderer: str
    size: tuple
    orbit: Orbit


def references(folder):
    """The pictures in `reference` of a folder of models, with the cameras that its MANIFEST.md tells."""
    found = []
    manifest = folder / "MANIFEST.md"
    for line in manifest.read_text().splitlines() if manifest.exists() else ():
        cells = [cell.strip() for cell in line.split("|")]
        path = folder / "reference" / cells[1] if len(cells) > 5 else folder
        if "orbit" not in line or not path.is_file():
            continue
        numbers = r"(-?[\d.e-]+)"
        told = cells[5]
        theta, phi, radius = map(float, re.search(rf"orbit {numbers}, {numbers}, {numbers}", told).groups())
        target = re.search(rf"target {numbers} {numbers} {numbers}", told)
        angle = re.search(rf"vfov {numbers}", told)
        # Pictures without these are of Khronos' comparison, whose cameras look at the origin at 45 degrees.
        target = tuple(map(float, target.groups())) if target else (0.0, 0.0, 0.0)
        orbit = Orbit(theta, phi, radius, target, float(angle.group(1)) if angle else 45.0)
        model, renderer = path.stem.split("__")
        size = tuple(map(int, cells[2].split(" x ")))
        found.append(Reference(path, model, renderer, size, orbit))
    return found


def as_seen(scene, reference):
    """A scene through the camera of a reference."""
    width, height = reference.size
    return {**scene, "camera": reference.orbit.pinhole(), "image": {"width": width, "height": height}}
