#!/usr/bin/env python3
"""strahl beside POV-Ray and Mitsuba at equal error, on scenes whose samples choose: W5 soft shadows, W7 depth of field.

    python3 benches/peers/equal_error.py [--rounds 3]

Each renderer is held against its own converged picture, since their images differ a little. strahl renders as it does by
default. The others render with several settings each. Their time at strahl's error is interpolated between the two settings
around it, on logarithmic scales. All render in turn; only ratios of one run mean something. The table is kept in
target/peers/equal_error.md.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
OUT = ROOT / "target" / "peers"
sys.path.append(str(HERE.parent))
THREADS = str(os.cpu_count())

# What POV-Ray is told: points of a lamp's edge and how they are chosen, samples of a lens, and antialiasing.
POV = {
    "W5": {
        "reference": ("17", "", "", "+A0.0 +AM1 +R5 +J1.0"),
        "settings": [
            (points, "adaptive 1", "", antialias)
            for points in ("5", "9", "17")
            for antialias in ("-A", "+A0.1 +AM2 +R2", "+A0.03 +AM2 +R3")
        ],
    },
    "W7": {
        "reference": ("", "", "blur_samples 1000,1000 confidence 0.999999 variance 0", "-A"),
        "settings": [
            ("", "", f"blur_samples {least},{most} confidence {confidence} variance 1/{variance}", "-A")
            for least, most, confidence, variance in
            [(7, 19, 0.9, 128), (7, 37, 0.9, 1000), (19, 61, 0.9, 1000), (19, 91, 0.95, 10000), (37, 200, 0.95, 10000),
             (100, 400, 0.99, 100000)]
        ],
    },
}
# Samples of each pixel.
MITSUBA = {"reference": 1024, "settings": [4, 16, 64, 256]}


def pixels(path):
    """Linear light of a PFM, or codes of a 16-bit PPM, as sRGB codes from 0 to 255."""
    data = path.read_bytes()
    lines = []
    while len(lines) < 3:
        line, data = data.split(b"\n", 1)
        lines += [] if line.startswith(b"#") else [line]
    (kind, size, scale), body = lines, data
    width, height = map(int, size.split())
    if kind == b"P6":
        return np.frombuffer(body, ">u2").reshape(height, width, 3) * (255 / 65535)
    assert kind == b"PF" and float(scale) < 0
    return codes(np.frombuffer(body, "<f4").reshape(height, width, 3)[::-1])


def codes(light):
    light = np.clip(light.astype(float), 0, 1)
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def run(command, **more):
    ended = subprocess.run(command, cwd=OUT, capture_output=True, text=True, **more)
    if ended.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{ended.stdout}{ended.stderr}")
    return ended.stdout + ended.stderr


def strahl(scene, *more):
    run([ROOT / "target/release/strahl", "render", f"{scene}.json", "-o", "strahl.pfm", "--threads", THREADS, "--stats",
         "strahl.json", *more])
    return json.loads((OUT / "strahl.json").read_text())["cost"]["phases_ms"]["trace"] / 1000, pixels(OUT / "strahl.pfm")


def pov(scene, points, adaptive, blur, antialias):
    text = (OUT / f"{scene}.pov").read_text()
    for name, value in (("POINTS", points), ("ADAPTIVE", adaptive), ("BLUR", blur)):
        text = text.replace(name, value)
    (OUT / "told.pov").write_text(text)
    width, height = size(scene)
    said = run(["povray", "+Itold.pov", "+Opov.ppm", "+FP16", f"+W{width}", f"+H{height}", f"+WT{THREADS}", "-D", "-V",
                "File_Gamma=sRGB", *antialias.split()], env={**os.environ, "HOME": str(OUT)})
    line = next(line for line in said.splitlines() if "Trace Time" in line)
    return float(line.split("(")[1].split()[0]), pixels(OUT / "pov.ppm")


def size(scene):
    image = json.loads((OUT / f"{scene}.json").read_text())["image"]
    return image["width"], image["height"]


def mitsuba_scene(scene):
    """What a scene is in Mitsuba: its lamp is a square that shines on both sides, its phong lobes are left out."""
    made = scenes.CHOOSING[scene]()
    rgb = lambda color, k=1: {"type": "rgb", "value": [c * k for c in color]}

    def bsdf(m):
        diffuse = {"type": "diffuse", "reflectance": rgb(m["color"], m["kd"])}
        if m["color2"]:
            diffuse["reflectance"] = {"type": "checkerboard", "color0": rgb(m["color"], m["kd"]),
                                      "color1": rgb(m["color2"], m["kd"]), "to_uv": mi.ScalarTransform4f().scale([10, 20, 1])}
        if m["kr"]:
            mirror = {"type": "conductor", "specular_reflectance": rgb([1, 1, 1])}
            return {"type": "twosided", "inner": {"type": "blendbsdf", "weight": m["kr"], "a": diffuse, "b": mirror}}
        return {"type": "twosided", "inner": diffuse}

    width, height = made["res"]
    sensor = {"type": "perspective", "fov": made["vfov"], "fov_axis": "y",
              "to_world": mi.ScalarTransform4f().look_at(origin=made["eye"], target=made["at"], up=made["up"]),
              "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}},
              "sampler": {"type": "multijitter"}}
    if made["lens"]:
        sensor.update(type="thinlens", aperture_radius=made["lens"][0] / 2, focus_distance=made["lens"][1])
    built = {"type": "scene", "integrator": {"type": "path", "max_depth": 3, "hide_emitters": True}, "sensor": sensor}
    (position, color), = made["lights"]
    power = float(np.dot(position, position))
    if made["area"]:
        edge = made["area"][0][0]
        to_world = mi.ScalarTransform4f().translate(position).rotate([1, 0, 0], 90).scale([edge / 2, edge / 2, 1])
        built["lamp"] = {"type": "rectangle", "to_world": to_world,
                         "emitter": {"type": "area", "radiance": rgb(color, 3.14 * power / edge**2)}}
    else:
        built["lamp"] = {"type": "point", "position": position, "intensity": rgb(color, 3.14 * power)}
    built["floor"] = {"type": "rectangle", "bsdf": bsdf(made["mats"][0]),
                      "to_world": mi.ScalarTransform4f().translate([0, 0, -6]).rotate([1, 0, 0], -90).scale([10, 20, 1])}
    for i, (ball, k) in enumerate(zip(made["spheres"], made["sph_mat"])):
        built[f"ball{i}"] = {"type": "sphere", "center": [float(c) for c in ball[:3]], "radius": float(ball[3]),
                             "bsdf": bsdf(made["mats"][k])}
    return mi.load_dict(built)


def mitsuba(scene, samples):
    """Seconds of the second render: the first one compiles."""
    for seed in range(2):
        started = time.monotonic()
        image = mi.render(scene, seed=seed, spp=samples)
        dr.eval(image)
        dr.sync_thread()
        seconds = time.monotonic() - started
    return seconds, codes(np.array(image))


def error(picture, reference):
    return float(np.sqrt(((picture - reference) ** 2).mean()))


def at_error(wanted, curve):
    """The time of a renderer at an error, from (error, seconds) of its settings: along the best of them."""
    best = []
    for off, seconds in sorted(curve):
        if not best or seconds < best[-1][1]:
            best.append((off, seconds))
    for (fine, slow), (coarse, quick) in zip(best, best[1:]):
        if fine <= wanted <= coarse:
            share = np.log(wanted / fine) / np.log(coarse / fine)
            return float(np.exp((1 - share) * np.log(slow) + share * np.log(quick))), ""
    off, seconds = best[0] if wanted < best[0][0] else best[-1]
    return seconds, f", at {off:.2f}"


def measure(scene, rounds):
    references = {"strahl": strahl(scene, "--samples", "1024")[1], "POV-Ray": pov(scene, *POV[scene]["reference"])[1]}
    in_mitsuba = mitsuba_scene(scene) if mi else None
    if mi:
        references["Mitsuba"] = mitsuba(in_mitsuba, MITSUBA["reference"])[1]
    rows = []
    for _ in range(rounds):
        seconds, picture = strahl(scene)
        wanted = error(picture, references["strahl"])
        curves = {"POV-Ray": [pov(scene, *setting) for setting in POV[scene]["settings"]]}
        if mi:
            curves["Mitsuba"] = [mitsuba(in_mitsuba, samples) for samples in MITSUBA["settings"]]
        row = {"strahl": (seconds, wanted, "")}
        for name, curve in curves.items():
            curve = [(error(picture, references[name]), time) for time, picture in curve]
            print(scene, name, [(round(off, 3), round(time, 3)) for off, time in sorted(curve)], file=sys.stderr)
            row[name] = (at_error(wanted, curve)[0], wanted, at_error(wanted, curve)[1])
        rows.append(row)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--scenes", nargs="+", choices=list(POV), default=list(POV))
    asked = parser.parse_args()
    others = ["POV-Ray"] + (["Mitsuba"] if mi else [])
    lines = [f"| Scene | RMS error, codes | strahl, s | {' | '.join(f'{name}, s (times strahl)' for name in others)} |",
             "|---" * (3 + len(others)) + "|"]
    for scene in asked.scenes:
        run([sys.executable, HERE / "scenes.py", ".", scene])
        rows = measure(scene, asked.rounds)
        middle = lambda name: statistics.median(row[name][0] for row in rows)
        cells = []
        for name in others:
            ratio = statistics.median(row[name][0] / row["strahl"][0] for row in rows)
            cells.append(f"{middle(name):.2f} ({ratio:.1f}{rows[0][name][2]})")
        lines.append(f"| {scene} | {rows[0]['strahl'][1]:.2f} | {middle('strahl'):.3f} | {' | '.join(cells)} |")
    table = "\n".join(lines) + "\n"
    (OUT / "equal_error.md").write_text(table)
    print(table, end="")


def in_its_environment():
    """Runs this file again with the packages that setup.sh installed."""
    python = OUT / "venv" / "bin" / "python"
    if Path(sys.prefix) != OUT / "venv":
        if not (OUT / "ready").exists():
            subprocess.run([HERE / "setup.sh"], check=True)
        os.execv(python, [python, *sys.argv])


if __name__ == "__main__":
    in_its_environment()
    import time

    import numpy as np
    import scenes

    try:
        import drjit as dr
        import mitsuba as mi

        mi.set_variant("llvm_ad_rgb")
    except ImportError:
        mi = None
    main()
