#!/usr/bin/env python3
"""What the service adds to a request: cached pictures, tiles and 304s beside a bare axum handler that sends the same bytes,
and probes beside renders on all threads.

    apt-get install wrk
    cargo build --release --bin strahl --example bare_handler
    python3 benches/service/load.py                # under two minutes, into target/service
    python3 benches/service/load.py --record       # and write the figures beside this program

The two servers are asked in turn, round by round, so that what disturbs the machine disturbs both; what counts is the
median of the rounds' ratios. The log is written into a file, as it would be.
"""

import argparse
import datetime
import json
import os
import re
import socket
import statistics
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

sys.dont_write_bytecode = True  # leaves nothing beside this file
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
OUT = ROOT / "target" / "service"
sys.path.append(str(HERE.parent))
from machine import commit, machine  # noqa: E402

SCENE = ROOT / "scenes/whitted/whitted.json"
SLOW = ROOT / "scenes/mirrors/hall.json"
CONNECTIONS = 32
PROBES = 500
JSON = {"Content-Type": "application/json"}


@contextmanager
def running(command, log, addresses):
    """A server, and the addresses that it says it listens on."""
    with open(log, "w") as sink:
        server = subprocess.Popen(command, stdout=sink, stderr=sink)
    try:
        deadline = time.monotonic() + 10
        while len(found := re.findall(r"http://[\d.:]+", log.read_text())) < addresses:
            if time.monotonic() > deadline or server.poll() is not None:
                sys.exit(f"{command[0]} does not listen: see {log}")
            time.sleep(0.01)
        yield server, found
    finally:
        server.terminate()
        server.wait()


def resident(server):
    """Bytes of resident memory, in MB."""
    status = Path(f"/proc/{server.pid}/status").read_text()
    return round(int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1024, 1)


def ask(url, body=None, headers=None):
    request = urllib.request.Request(url, data=body, headers=headers or {})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return answer.read(), answer.headers


def prepare(base):
    """Has the pictures made, and says what is asked for: path and settings for wrk, and what to compare it with."""
    scene = SCENE.read_bytes()
    cases, files = {}, []

    def case(name, path, bytes_, **settings):
        number = len(files)
        (OUT / f"{number}.png").write_bytes(bytes_)
        files.append(OUT / f"{number}.png")
        cases[name] = {"path": path, "bytes": len(bytes_), "beside": f"/{number}", "settings": settings}

    whole, headers = ask(f"{base}/v1/render", scene, JSON)
    picture = headers["Content-Location"]
    case("picture", picture, whole)
    small, headers = ask(f"{base}/v1/render?width=64&height=36", scene, JSON)
    case("small picture", headers["Content-Location"], small)
    case("POST of the scene", "/v1/render", whole, LOAD_METHOD="POST", LOAD_BODY=str(SCENE))
    opened, _ = ask(f"{base}/v1/scenes?zoom=1", scene, JSON)
    tile = f"/dzi/{json.loads(opened)['image_id']}_files/11/1_1.png"
    case("tile", tile, ask(base + tile)[0])
    _, headers = ask(base + picture)
    cases["304"] = {"path": picture, "bytes": 0, "beside": "/unchanged", "settings": {"LOAD_TAG": headers["ETag"]}}
    return cases, files


def wrk(url, settings, seconds):
    command = ["wrk", "-t", "1", "-c", str(CONNECTIONS), "-d", f"{seconds}s", "-s", str(HERE / "wrk.lua"), url]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True)
    found = re.search(r"^figures (.*)$", done.stdout, re.MULTILINE)
    if not found:
        sys.exit(f"wrk failed: {done.stdout}{done.stderr}")
    figures = json.loads(found[1])
    if figures["failed"]:
        sys.exit(f"{figures['failed']} of {figures['requests']} requests to {url} failed")
    return {"per_s": figures["requests"] / figures["us"] * 1e6, "p50_ms": figures["p50_us"] / 1e3,
            "p99_ms": figures["p99_us"] / 1e3}


def compare(cases, base, bare, rounds, seconds):
    """Medians for both servers, and the median of the ratios of requests per second."""
    taken = {name: {"strahl": [], "bare": []} for name in cases}
    for turn in range(rounds):
        for name, case in cases.items():
            taken[name]["bare"].append(wrk(bare + case["beside"], case["settings"], seconds))
            taken[name]["strahl"].append(wrk(base + case["path"], case["settings"], seconds))
        print(f"round {turn + 1} of {rounds}", file=sys.stderr, flush=True)

    def medians(runs):
        return {key: round(statistics.median(run[key] for run in runs), 2) for key in runs[0]}

    def row(name, runs):
        ratios = [ours["per_s"] / theirs["per_s"] for ours, theirs in zip(runs["strahl"], runs["bare"])]
        return {"case": name, "bytes": cases[name]["bytes"], "strahl": medians(runs["strahl"]),
                "bare": medians(runs["bare"]), "share": round(statistics.median(ratios), 3)}

    return [row(name, runs) for name, runs in taken.items()]


def begin_render(base, depth):
    """A render that nobody waits for; depths differ, so that each is work of its own."""
    host, port = base.removeprefix("http://").split(":")
    stream = socket.create_connection((host, int(port)))
    body = SLOW.read_bytes()
    head = (f"POST /v1/render?width=1920&height=1080&samples=16&max_depth={depth} HTTP/1.1\r\nHost: {host}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n")
    stream.sendall(head.encode() + body)
    return stream


def probe(listeners):
    """Milliseconds of probes, each over a connection of its own, while every thread renders."""
    clients = next(iter(listeners.values()))
    busy = [begin_render(clients, 900 + number) for number in range(8)]
    while json.loads(ask(f"{clients}/readyz")[0])["running"] == 0:
        time.sleep(0.01)
    times = {name: [] for name in listeners}
    for _ in range(PROBES):
        for name, base in listeners.items():
            asked = time.perf_counter()
            ask(f"{base}/livez")
            times[name].append((time.perf_counter() - asked) * 1e3)
            time.sleep(0.005)
    still = json.loads(ask(f"{clients}/readyz")[0])
    if still["running"] == 0:
        sys.exit("the renders ended before the probes did")
    for stream in busy:
        stream.close()

    def quantile(sorted_times, share):
        return round(sorted_times[min(int(share * len(sorted_times)), len(sorted_times) - 1)], 2)

    return [{"listener": name, "p50_ms": quantile(sorted(taken), 0.5), "p99_ms": quantile(sorted(taken), 0.99),
             "max_ms": round(max(taken), 2)} for name, taken in times.items()]


def report(figures):
    for row in figures["cached"]:
        ours, theirs = row["strahl"], row["bare"]
        print(f"{row['case']} ({row['bytes']:,} bytes): {ours['per_s']:,.0f} requests/s, p50 {ours['p50_ms']} ms, "
              f"p99 {ours['p99_ms']} ms; bare {theirs['per_s']:,.0f}, {theirs['p50_ms']}, {theirs['p99_ms']}; "
              f"share {row['share']}")
    for row in figures["livez"]:
        print(f"/livez on the {row['listener']} listener beside renders: p50 {row['p50_ms']} ms, p99 {row['p99_ms']} ms, "
              f"longest {row['max_ms']} ms")
    print(f"resident memory: {figures['idle_mb']} MB idle, {figures['after_mb']} MB afterwards")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="times each server is asked for each thing")
    parser.add_argument("--seconds", type=int, default=2, help="of each of these")
    parser.add_argument("--programs", type=Path, default=ROOT / "target/release", help="folder of the programs")
    parser.add_argument("--record", action="store_true", help="write load.json beside this program")
    asked = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    figures = {"date": datetime.date.today().isoformat(), "machine": machine(), "commit": commit(),
               "rounds": asked.rounds, "seconds": asked.seconds, "connections": CONNECTIONS}
    command = [str(asked.programs / "strahl"), "serve", "--listen", "127.0.0.1:0", "--admin-listen", "127.0.0.1:0"]
    with running(command, OUT / "strahl.log", 2) as (server, (admin, base)):
        time.sleep(0.5)
        figures["idle_mb"] = resident(server)
        cases, files = prepare(base)
        command = [str(asked.programs / "examples/bare_handler"), *map(str, files)]
        with running(command, OUT / "bare.log", 1) as (_, (bare,)):
            figures["cached"] = compare(cases, base, bare, asked.rounds, asked.seconds)
        figures["livez"] = probe({"clients'": base, "operators'": admin})
        figures["after_mb"] = resident(server)
    report(figures)
    for folder in [OUT, HERE] if asked.record else [OUT]:
        (folder / "load.json").write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
