"""Times variants of strahl against each other, interleaved, so that what disturbs the machine disturbs them all."""

import json
import math
import statistics
import subprocess

# Scene and options: spheres, triangles, mirrors, glass, instances; each traces for some 50 to 300 ms.
SCENES = [
    ("whitted/whitted.json", []),
    ("spheres/flake_4.json", ["--width", "256", "--height", "256"]),
    ("spheres/flake_9.json", ["--width", "96", "--height", "96"]),
    ("meshes/knot.json", []),
    ("mirrors/hall.json", []),
    ("refraction/glass_of_water.json", ["--width", "240", "--height", "240"]),
    ("refraction/water_glass_diamond.json", []),
    ("balls_s4.nff.gz", ["--width", "256", "--height", "256"]),
    ("teapot_s12.nff.gz", []),
    ("mount_s6.nff.gz", ["--width", "384", "--height", "384"]),
    ("tetra_s6.nff.gz", ["--width", "1024", "--height", "1024"]),
    ("gears_s1.nff", ["--width", "384", "--height", "384"]),
]


def trace(root, binary, scene, options, precision, threads, scratch):
    """Milliseconds of the trace phase, and rays."""
    path = root / ("tests/inputs/nff" if ".nff" in scene else "scenes") / scene
    subprocess.run([binary, "render", path, "-o", scratch / "timing.png", "--stats", scratch / "timing.json",
                    "--antialias", "false", "--threads", str(threads), "--precision", precision, *options],
                   check=True, capture_output=True)
    cost = json.loads((scratch / "timing.json").read_text())["cost"]
    rays = sum(cost["rays"][kind] for kind in ["camera", "shadow", "reflected", "transmitted"])
    return cost["phases_ms"]["trace"], rays


def mean(ratios):
    """Geometric."""
    return math.exp(statistics.fmean(math.log(ratio) for ratio in ratios))


def time_variants(root, scratch, binaries, rounds, threads):
    """Ratios to the variant `naive`: for each scene the median over the rounds, then the geometric mean."""
    scenes = {}
    for scene, options in SCENES:
        runs = {(name, precision): [] for name in binaries for precision in ["single", "double"]}
        rays = {}
        for round in range(rounds + 1):
            # Every round in another order, since the first after a pause may be slower.
            order = list(runs)
            order = order[round % len(order):] + order[:round % len(order)]
            for name, precision in order:
                time, count = trace(root, binaries[name], scene, options, precision, threads, scratch)
                rays[name, precision] = count
                # The first round warms caches.
                if round > 0:
                    runs[name, precision].append(time)

        def ratio(one, other):
            return statistics.median(a / b for a, b in zip(runs[one], runs[other]))

        row = {"naive_ms": round_to(statistics.median(runs["naive", "single"])), "variants": {}}
        for name in binaries:
            single, double = ((ratio((name, p), ("naive", p)), rays[name, p] / rays["naive", p])
                              for p in ["single", "double"])
            row["variants"][name] = {"time": round_to(single[0]), "rays": round_to(single[1], 4),
                                     "double": round_to(double[0])}
        row["double_to_single"] = round_to(ratio(("robust", "double"), ("robust", "single")))
        scenes[scene] = row
        line = ", ".join(f"{name} {values['time']}" for name, values in row["variants"].items())
        print(f"{scene}: naive {row['naive_ms']} ms; {line}; double {row['double_to_single']}", flush=True)

    def over_scenes(name, value):
        return round_to(mean([value(row["variants"][name]) for row in scenes.values()]))

    figures = {name: {"time": over_scenes(name, lambda v: v["time"]),
                      "time_per_ray": over_scenes(name, lambda v: v["time"] / v["rays"]),
                      "double": over_scenes(name, lambda v: v["double"])} for name in binaries}
    return {"robust_to_naive": figures["robust"]["time"],
            "double_to_single": round_to(mean([row["double_to_single"] for row in scenes.values()])),
            "variants": figures, "scenes": scenes}


def round_to(value, digits=3):
    return round(value, digits)
