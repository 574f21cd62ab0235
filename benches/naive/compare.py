#!/usr/bin/env python3
"""What robustness costs, and what it buys.

Each patch beside this file replaces one robust ingredient of the kernels by the naive code of textbooks. This program
builds strahl as it is, without each ingredient and without all of them, counts the hard cases that each variant
survives, and times them all against each other in one interleaved run:

    python3 benches/naive/compare.py               # build what has changed, count, time; some 70 minutes at first
    python3 benches/naive/compare.py --mutations   # which tests notice each patch
    python3 benches/naive/compare.py --no-build --rounds 15 --record    # time again, and write the figures

It needs cargo, git and nothing but Python's own library. Everything it builds lies in target/naive.
"""

import argparse
import datetime
import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
sys.path.append(str(Path(__file__).resolve().parent.parent))
from machine import commit, machine  # noqa: E402
from plot import plot  # noqa: E402
from timing import time_variants  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "naive"
TREE = WORK / "tree"
PATCHES = sorted(path.stem for path in HERE.glob("*.patch"))
# Parts of the names of tests. Besides hard_cases, whose scorecard says more than that it fails.
TESTS = ["watertight", "secondary_rays", "accuracy", "analytic", "ground_truth", "properties", "random_scenes",
         "golden"]


def variants(only):
    """Name and patches of each variant."""
    everything = {"robust": [], "naive": PATCHES} | {f"robust - {name}": [name] for name in PATCHES}
    if not only:
        return everything
    return {name: patches for name, patches in everything.items() if patches == [] or name == "naive" and "all" in only
            or patches[0] in only and len(patches) == 1}


def folder(name):
    return WORK / name.replace(" - ", "-")


def sync(source, target):
    """Makes `target` a copy of `source`, but leaves files alone that are the same, so that cargo sees no change."""
    wanted = {path.relative_to(source) for path in source.rglob("*") if path.is_file()}
    for path in [path for path in target.rglob("*") if path.is_file()]:
        if path.relative_to(target) not in wanted:
            path.unlink()
    for name in wanted:
        old, new = target / name, source / name
        if not old.exists() or old.read_bytes() != new.read_bytes():
            old.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(new, old)


def fresh_tree(patches):
    """A copy of the source, patched, and the hash of all that is in it."""
    fresh = WORK / "fresh"
    shutil.rmtree(fresh, ignore_errors=True)
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0"):
        if name and (ROOT / name).is_file():
            (fresh / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, fresh / name)
    # Inside a repository, git would only see the files that it knows there.
    outside = os.environ | {"GIT_CEILING_DIRECTORIES": str(WORK)}
    for patch in patches:
        applied = subprocess.run(["git", "apply", str(HERE / f"{patch}.patch")], cwd=fresh, env=outside,
                                 capture_output=True, text=True)
        if applied.returncode != 0:
            sys.exit(f"{patch}.patch does not apply: mend it\n{applied.stderr}")
    shutil.rmtree(fresh / "benches" / "naive")
    digest = hashlib.sha256()
    for path in sorted(path for path in fresh.rglob("*") if path.is_file()):
        digest.update(str(path.relative_to(fresh)).encode() + b"\0" + path.read_bytes())
    return fresh, digest.hexdigest()


def unused_levels():
    """Flags that leave out the kernels for instruction sets that this machine would not choose: a third of the time."""
    try:
        flags = Path("/proc/cpuinfo").read_text()
    except OSError:
        return ""
    if "avx512_vpopcntdq" in flags and "gfni" in flags:
        return "--cfg disable_dispatch_sse4_2 --cfg disable_dispatch_avx2"
    return "--cfg disable_dispatch_sse4_2 --cfg disable_dispatch_avx512" if "avx2" in flags else ""


def cargo(*arguments):
    """Runs cargo in the tree of the variant at hand. It is the same folder for all, since cargo tells packages in one
    target folder apart by their paths below the workspace only; so each build compiles the package and nothing else."""
    environment = os.environ | {"CARGO_TARGET_DIR": str(WORK / "target"), "RUSTFLAGS": unused_levels()}
    return subprocess.run(["cargo", *arguments], cwd=TREE, env=environment, capture_output=True, text=True)


def build(name, patches, tests):
    """Builds a variant, counts the hard cases it survives and, if asked to, finds the tests that fail. Does nothing for
    what is up to date."""
    kept = folder(name)
    kept.mkdir(parents=True, exist_ok=True)
    fresh, digest = fresh_tree(patches)
    stamps = [kept / "built"] + ([kept / "tested"] if tests else [])
    if all(stamp.exists() and stamp.read_text() == digest for stamp in stamps):
        return
    sync(fresh, TREE)
    if not (kept / "built").exists() or (kept / "built").read_text() != digest:
        print(f"building {name} ...", flush=True)
        built = cargo("build", "--release", "--bin", "strahl", "--test", "renderer", "--message-format", "json")
        if built.returncode != 0:
            sys.exit(f"{name} does not build\n{built.stderr[-4000:]}")
        made = [json.loads(line) for line in built.stdout.splitlines() if line.startswith("{")]
        made = {message["target"]["name"]: message["executable"] for message in made if message.get("executable")}
        written = TREE / "target" / "hard-cases" / "scorecard.json"
        written.unlink(missing_ok=True)
        # Variants without an ingredient fail; how often is the question.
        subprocess.run([made["renderer"], "hard_cases"], cwd=TREE, capture_output=True)
        if not written.exists():
            sys.exit(f"hard_cases of {name} wrote no scorecard")
        shutil.copyfile(written, kept / "scorecard.json")
        for made_of in ["strahl", "renderer"]:
            shutil.copy2(made[made_of], kept / made_of)
        (kept / "built").write_text(digest)
    if tests:
        print(f"testing {name} ...", flush=True)
        (kept / "mutations.json").write_text(json.dumps(failing_tests(name, tests), indent=1) + "\n")
        (kept / "tested").write_text(digest)


def failing_tests(name, tests):
    """The tests of a variant that fail, of those that have one of `tests` in their name."""
    ended = subprocess.run([folder(name) / "renderer", *tests], cwd=TREE, capture_output=True, text=True)
    if "test result" not in ended.stdout:
        sys.exit(f"the tests of {name} do not run\n{ended.stderr[-4000:]}")
    return [line.split()[1] for line in ended.stdout.splitlines() if line.startswith("test ") and line.endswith("FAILED")]


def survived(name):
    card = json.loads((folder(name) / "scorecard.json").read_text())
    lost = sorted({row["case"] for row in card["rows"] if row["verdict"] != "pass" and row["precision"] == "single"})
    return card["survived"] | {"of": card["cases"], "lost_in_single": lost}


def list_mutations(names):
    """Which tests notice which patch."""
    for name in names:
        listing = json.loads((folder(name) / "mutations.json").read_text())
        cases = survived(name)
        print(f"\n{name}: {len(listing)} tests fail, and these hard cases in single precision:")
        print(f"  {' '.join(cases['lost_in_single'])}")
        for failed in listing:
            print(f"  {failed}")
        if not listing and cases == survived("robust"):
            print("  NO TEST NOTICES THIS")


def report(figures):
    of = figures["of"]
    print(f"\n| Variant | Time, single | for each ray | Time, double | Cases of {of}, single | double |")
    print("|" + "---|" * 6)
    for name, row in figures["variants"].items():
        cases = row["survived"]
        print(f"| {name} | {row['time']:.3f} | {row['time_per_ray']:.3f} | {row['double']:.3f} | "
              f"{cases['single']} | {cases['double']} |")
    print("time: that of naive in the same precision is 1; geometric mean over the scenes of medians of ratios")
    print(f"robust takes {figures['robust_to_naive']:.3f} times naive; "
          f"double takes {figures['double_to_single']:.2f} times single (robust)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="PATCH", help="these patches only; all stands for naive")
    parser.add_argument("--rounds", type=int, default=9, help="times each scene is traced by each variant")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--no-build", action="store_true", help="time the variants that are built already")
    parser.add_argument("--no-time", action="store_true", help="build and count only")
    parser.add_argument("--record", action="store_true", help="write robustness.json beside this program, and docs/pictures/robustness.svg")
    parser.add_argument("--mutations", action="store_true", help="list the tests that notice each patch")
    parser.add_argument("--tests", nargs="+", default=TESTS, help="parts of the names of the tests that --mutations runs")
    asked = parser.parse_args()
    if shutil.which("git") is None:
        sys.exit("git is missing: it applies the patches")
    chosen = variants(asked.only)
    if not asked.no_build:
        for name, patches in chosen.items():
            build(name, patches, asked.tests if asked.mutations and patches else [])
            print(f"{name}: {survived(name)}", flush=True)
    if asked.mutations:
        list_mutations([name for name, patches in chosen.items() if patches and (folder(name) / "tested").exists()])
    if asked.no_time or asked.mutations:
        return None
    chosen = [name for name in chosen if (folder(name) / "strahl").exists()]
    if "robust" not in chosen or "naive" not in chosen:
        sys.exit("both robust and naive must be built to compare them")
    figures = time_variants(ROOT, WORK, {name: folder(name) / "strahl" for name in chosen}, asked.rounds, asked.threads)
    for name in chosen:
        figures["variants"][name]["survived"] = survived(name)
    figures = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(),
               "rounds": asked.rounds, "of": survived("robust")["of"]} | figures
    report(figures)
    WORK.mkdir(parents=True, exist_ok=True)
    text = json.dumps(figures, indent=1) + "\n"
    (WORK / "robustness.json").write_text(text)
    (WORK / "robustness.svg").write_text(plot(figures))
    if asked.record:
        (HERE / "robustness.json").write_text(text)
        (ROOT / "docs/pictures/robustness.svg").write_text(plot(figures))
    return None


if __name__ == "__main__":
    main()
