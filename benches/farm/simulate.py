#!/usr/bin/env python3
"""A farm of hundreds of nodes whose rendering is a sleep, with a real broker: how much work it hands out, and how evenly.

    cargo build --release --features simulation --example farm_simulation && python3 benches/farm/simulate.py --nodes 500 --slots 4 --jobs 100
    python3 benches/farm/simulate.py --nodes 4 --slots 1 --picture 96 --tile-ms 42     # a picture of 4 s on four nodes

Nodes and coordinators are those of the program; only pixels are not made. It runs all of them, and the broker, on this machine:
the share of time that slots are busy falls where its processors are at their end. Figures are appended to benches/farm/farm.json
with --write.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "external"))
sys.dont_write_bytecode = True  # leaves nothing beside this file
from broker import Broker  # noqa: E402

PROGRAM = ROOT / "target" / "release" / "examples" / "farm_simulation"


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run(nodes, slots, jobs, tile_ms, seconds, more=()):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        broker = Broker(folder).until_healthy()
        try:
            sizes = ["--nodes", nodes, "--slots", slots, "--jobs", jobs, "--tile-ms", tile_ms, "--seconds", seconds, *more]
            farm = ["--farm", f"nats://127.0.0.1:{broker.port}", "--store", folder / "store", "--memory-bytes", 1 << 30]
            process = subprocess.Popen([PROGRAM, *map(str, [*sizes, *farm])], stdout=subprocess.PIPE, text=True)
            most = [0.0]

            def watch():
                while process.poll() is None:
                    most[0] = max(most[0], broker.memory())
                    time.sleep(0.5)

            thread = threading.Thread(target=watch)
            begun = time.monotonic()
            thread.start()
            line = process.stdout.readline()
            took, spent = time.monotonic() - begun, processor_seconds(broker.process.pid)
            own = processor_seconds(process.pid)
            consumers, connections = broker.consumers(), broker.ask("/varz")["connections"]
            process.wait(timeout=120)
            thread.join()
        finally:
            broker.stop()
    figures = json.loads(line)
    more = {"broker_mb": most[0], "broker_processors": spent / took, "own_processors": own / took, "consumers": consumers, "connections": connections}
    return figures | more


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--nodes", type=int, nargs="+", default=[500])
    arguments.add_argument("--slots", type=int, default=4)
    arguments.add_argument("--jobs", type=int, default=100)
    arguments.add_argument("--tile-ms", type=int, default=1000)
    arguments.add_argument("--seconds", type=int, default=60)
    arguments.add_argument("--picture", type=int, metavar="TILES", help="pictures of so many tiles that somebody waits for, instead of jobs")
    arguments.add_argument("--write", action="store_true")
    chosen = arguments.parse_args()
    rows = []
    for nodes in chosen.nodes:
        more = ["--picture-tiles", chosen.picture] if chosen.picture else []
        rows.append(run(nodes, chosen.slots, chosen.jobs, chosen.tile_ms, chosen.seconds, more))
        print({key: round(value, 3) for key, value in rows[-1].items()}, flush=True)
    if chosen.write:
        (ROOT / "benches" / "farm" / "farm.json").write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
