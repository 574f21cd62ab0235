"""The renderers that are compared, as commands, and what a command takes.

strahl is the built program (or STRAHL_BINARY). F3D and what compares pictures come from PyPI into target/models/python,
model-viewer and puppeteer-core from npm into target/models/node; model-viewer needs node and Chromium (or CHROMIUM=path).
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
OUT = ROOT / "target" / "models"
SIDE = 512

FROM_PYPI = ["f3d==4.0.0", "flip-evaluator==1.7", "numpy==2.4.6", "pillow==11.3.0"]
FROM_NPM = ["@google/model-viewer@4.4.0", "puppeteer-core@25.16.0"]

# What models are called. A .gltf and an .obj may need files beside them.
ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl")


@dataclass
class Took:
    """What a command took: seconds, processor seconds and the most memory in bytes; or why there is no picture."""

    wall: float
    cpu: float
    memory: int
    refused: str | None


class Tree(threading.Thread):
    """Watches a process with all below it: their processor seconds, and the most memory of all together."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.pid, self.most, self.seconds, self.over = pid, 0, {}, threading.Event()

    def run(self):
        while not self.over.wait(0.05):
            below, parents = {self.pid}, {}
            for folder in Path("/proc").iterdir():
                if folder.name.isdigit():
                    try:
                        # After the name in parentheses: state, parent, ...; the 14th and 15th field are user and system time.
                        fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
                    except OSError:
                        continue
                    parents[int(folder.name)] = (int(fields[1]), int(fields[11]) + int(fields[12]))
            while more := {pid for pid, (parent, _) in parents.items() if parent in below} - below:
                below |= more
            for pid in below & parents.keys():
                self.seconds[pid] = parents[pid][1] / os.sysconf("SC_CLK_TCK")
            self.most = max(self.most, sum(map(share, below)))


def share(pid):
    """A process's own memory and its share of what it shares, in bytes."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
        return next(int(line.split()[1]) << 10 for line in lines if line.startswith("Pss:"))
    except (OSError, StopIteration):
        return 0


def run(command, picture, tree=False, env=None):
    """Runs a command that writes a picture. The kernel counts one process exactly; a tree of processes is watched.

    Why there is no picture is what it says last, with files by their names alone.
    """
    OUT.mkdir(parents=True, exist_ok=True)
    picture.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as said:
        figures = Path(folder) / "took"
        launched = [sys.executable, "-I", "-S", HERE / "launch.py", figures, *command]
        process = subprocess.Popen(launched, stdin=subprocess.DEVNULL, stdout=said, stderr=said, env=env)
        watched = Tree(process.pid)
        if tree:
            watched.start()
        process.wait()
        watched.over.set()
        said.seek(0)
        lines = said.read().decode(errors="replace").strip().splitlines()
        code, wall, cpu, memory = map(float, figures.read_text().split())
    refused = None
    if code != 0 or not picture.exists():
        why = lines[-1].strip() if lines else f"exit code {code:.0f}"
        refused = re.sub(r"(\S*/)([^/\s]+)", r"\2", why)
    if tree:
        cpu, memory = max(cpu, sum(watched.seconds.values())), max(memory, watched.most)
    return Took(wall, cpu, int(memory), refused)


def program():
    """strahl itself."""
    path = Path(os.environ.get("STRAHL_BINARY") or ROOT / "target" / "release" / "strahl")
    if not path.exists():
        sys.exit(f"{path} is missing: run `cargo build --release`, or say with STRAHL_BINARY where strahl is")
    return path


def install(command, what):
    if subprocess.run(command).returncode != 0:
        sys.exit(f"{what} cannot be installed into {OUT}: see above")


def python():
    """The Python of an environment with what PyPI has of it."""
    folder = OUT / "python"
    if not (folder / "complete").exists():
        install([sys.executable, "-m", "venv", "--clear", folder], "an environment of Python")
        install([folder / "bin" / "pip", "install", "--quiet", *FROM_PYPI], "F3D and FLIP")
        (folder / "complete").touch()
    return folder / "bin" / "python"


def node():
    """The folder of modules with what npm has of it; None without node or Chromium."""
    if not (shutil.which("node") and shutil.which("npm") and chromium()):
        return None
    folder = OUT / "node"
    if not (folder / "complete").exists():
        folder.mkdir(parents=True, exist_ok=True)
        options = ["--prefix", folder, "--no-fund", "--no-audit", "--ignore-scripts", "--silent"]
        install(["npm", "install", *options, *FROM_NPM], "model-viewer")
        (folder / "complete").touch()
    return folder / "node_modules"


def chromium():
    return os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")


def strahl(model, picture, *flags):
    return run([program(), "render", model, "-o", picture, *flags], picture)


def f3d(model, picture, *camera):
    """`camera`: eye, target and vertical angle as seven numbers."""
    # Mesa's rasteriser, even where there is a graphics card.
    env = {**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1"}
    return run([python(), HERE / "f3d_picture.py", model, picture, str(SIDE), *map(str, camera)], picture, env=env)


def model_viewer(model, picture, *camera):
    """`camera`: theta, phi, radius, target and vertical angle as seven numbers."""
    program = HERE / "model_viewer.mjs"
    return run(["node", program, node(), chromium(), model, picture, str(SIDE), *map(str, camera)], picture, tree=True)


def models(places):
    """All models in folders, and those that are named; files with parts missing are among them."""
    found = []
    for place in map(Path, places):
        if not place.exists():
            sys.exit(f"{place} does not exist")
        below = sorted(place.rglob("*")) if place.is_dir() else [place]
        found += [path for path in below if path.suffix.lower() in ENDINGS and "bad" not in path.parts]
    return found


def pictures(*what):
    """Asks pictures.py, which needs packages of PyPI; its lines as numbers."""
    asked = subprocess.run([python(), HERE / "pictures.py", *map(str, what)], capture_output=True, text=True)
    if asked.returncode != 0:
        sys.exit(asked.stderr)
    return [float(number) for number in asked.stdout.split()]
