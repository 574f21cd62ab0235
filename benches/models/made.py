"""Models of a given size, written into target/models once."""

import array
import json
import math
import struct

from renderers import OUT


def glb(path, json_part, binary):
    """Writes a glTF with its buffer in one file."""
    text = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(binary)}], **json_part}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def sphere(columns, rows, bumps):
    """A ball with waves: views and accessors of its positions, normals and triangles, and their bytes."""
    turns = [2 * math.pi * i / columns for i in range(columns)]
    around = [(math.cos(a), math.sin(a), bumps * math.sin(40 * a)) for a in turns]
    places, normals, faces = array.array("f"), array.array("f"), array.array("I")
    for row in range(rows + 1):
        tilt = math.pi * row / rows
        y, out, wave = math.cos(tilt), math.sin(tilt), math.sin(30 * tilt)
        for x, z, bump in around:
            far = 1 + bump * wave * out
            places.extend((far * out * x, far * y, far * out * z))
            normals.extend((out * x, y, out * z))
    for row in range(rows):
        for i in range(columns):
            a, b, c = row * columns + i, row * columns + (i + 1) % columns, (row + 1) * columns
            faces.extend((a, b, c + i, b, c + (i + 1) % columns, c + i))
    parts = [part.tobytes() for part in (places, normals, faces)]
    starts = [sum(map(len, parts[:i])) for i in range(3)]
    views = [{"buffer": 0, "byteOffset": at, "byteLength": len(part)} for at, part in zip(starts, parts)]
    vertices, far = len(places) // 3, 1 + abs(bumps)
    accessors = [{"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3", "min": [-far] * 3, "max": [far] * 3},
                 {"bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC3"},
                 {"bufferView": 2, "componentType": 5125, "count": len(faces), "type": "SCALAR"}]
    return {"bufferViews": views, "accessors": accessors}, b"".join(parts)


def ball(name, columns, rows):
    """One mesh of 2 * columns * rows triangles."""
    path = OUT / f"{name}.glb"
    if not path.exists():
        tables, binary = sphere(columns, rows, 0.05)
        primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}
        material = {"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.3, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.5}}
        glb(path, {**tables, "materials": [material], "meshes": [{"primitives": [primitive]}], "nodes": [{"mesh": 0}],
                   "scenes": [{"nodes": [0]}], "scene": 0}, binary)
    return path


def million():
    return ball("million", 1000, 500)


def spheres():
    """A million triangles in 98 balls of 98 materials on the same accessors, as Khronos' MetalRoughSpheresNoTextures has them."""
    path = OUT / "spheres.glb"
    if not path.exists():
        tables, binary = sphere(103, 52, 0)
        grid = [(i % 14, i // 14) for i in range(98)]
        materials = [{"pbrMetallicRoughness": {"metallicFactor": y / 6, "roughnessFactor": x / 13}} for x, y in grid]
        meshes = [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": i}]} for i in range(98)]
        nodes = [{"mesh": i, "translation": [2.2 * x, 2.2 * y, 0]} for i, (x, y) in enumerate(grid)]
        glb(path, {**tables, "materials": materials, "meshes": meshes, "nodes": nodes,
                   "scenes": [{"nodes": list(range(98))}], "scene": 0}, binary)
    return path


def large():
    """Models of 125,000 to a million triangles."""
    return [ball("eighth", 500, 125), ball("quarter", 500, 250), ball("half", 500, 500), million(), spheres()]
