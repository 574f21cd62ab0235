#!/usr/bin/env python3
"""Two tenants: one sends hostile requests, the other one renders small pictures all the time and must not notice.

    cargo build --release && python3 tests/external/hostile.py [--only NAME,NAME] [--program PATH] [--seconds 10]

For each of hostile_requests.py it starts the service and prints what it took. `!` marks what broke a promise: the other
tenant waits at most 1 s, in 99 of 100 cases 0.3 s; cancel and DELETE of a job answer within 1 s; the processor rests soon
after the client has left. The exit code is 1 if there was any.
"""

import argparse
import collections
import http.client
import itertools
import json
import multiprocessing
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402
from hostile_requests import JSON, REQUESTS, different, scene, sphere  # noqa: E402

WORST, P99, REMOVED, REST = 1.0, 0.3, 1.0, 1.0
PATIENCE = 30  # seconds until the processor counts as never at rest
SMALL = scene([sphere([0, 0, 0], 1, "red")], (32, 20), materials={"red": {"reflection": 0.2}})


def ask(address, key, method, path, headers=JSON, body=b"", timeout=60):
    """Status and body of an answer."""
    client = http.client.HTTPConnection(address, timeout=timeout)
    try:
        client.request(method, path, body or None, headers | key)
        answer = client.getresponse()
        return answer.status, answer.read()
    finally:
        client.close()


class Neighbour:
    """A tenant that renders one small picture after another, each a different one."""

    def __init__(self, address, key):
        self.address, self.key, self.seconds, self.refused = address, key, [], collections.Counter()
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def run(self):
        for number in itertools.count():
            if self.ended.is_set():
                return
            started = time.monotonic()
            try:
                status, _ = ask(self.address, self.key, "POST", "/v1/render", JSON, different(SMALL, number))
            except OSError as error:
                status = type(error).__name__
            self.seconds.append(time.monotonic() - started)
            if status != 200:
                self.refused[status] += 1
                time.sleep(0.01)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()

    def said(self):
        """Median, 99th percentile and worst, and whether they are as promised."""
        sorted_ = sorted(self.seconds)
        p50, p99, worst = (sorted_[int(share * (len(sorted_) - 1))] for share in (0.5, 0.99, 1))
        kept = worst <= WORST and p99 <= P99 and not self.refused
        refused = "".join(f" {status}x{count}" for status, count in self.refused.items())
        return f"{ms(p50):>6} {ms(p99):>7} {ms(worst):>7}{'' if kept else ' !'}{refused}", kept


def ms(seconds):
    return f"{seconds * 1e3:.0f}"


def attack(address, key, hostile, until, results):
    """Sends hostile requests until then, each as soon as the one before is answered or left; leaves the last ones."""
    make, lock, numbers = hostile.make(), threading.Lock(), itertools.count()

    def client():
        before = None
        while True:
            with lock:
                method, path, headers, body = make(next(numbers), before)
            patience = min(hostile.leave, until - time.time())
            if patience <= 0:
                return
            started = time.monotonic()
            try:
                before = ask(address, key, method, path, headers, body, patience)
                status = before[0]
            except TimeoutError:
                status = "left"
            except OSError as error:
                status = type(error).__name__
            results.put((status, time.monotonic() - started, len(body)))

    clients = [threading.Thread(target=client, daemon=True) for _ in range(hostile.clients)]
    for each in clients:
        each.start()
    for each in clients:
        each.join(max(0, until - time.time()) + 1)
    results.close()
    results.join_thread()
    os._exit(0)  # cuts off those that still wait


def seconds_to_rest(running):
    """Seconds until the processor has nothing to do for a third of a second; None if that takes too long."""
    started, calm = time.monotonic(), 0
    before = running.processor_seconds()
    while time.monotonic() - started < PATIENCE:
        time.sleep(0.1)
        now = running.processor_seconds()
        calm, before = (calm + 1 if now - before < 0.02 else 0), now
        if calm == 3:
            return time.monotonic() - started - 0.3
    return None


def rest(seconds):
    """How that is written, and whether it is as promised."""
    kept = seconds is not None and seconds <= REST
    return (f"{seconds:.1f}" if seconds is not None else f">{PATIENCE}") + ("" if kept else " !"), kept


def requests(running, keys, hostile, seconds):
    """The row of a request that is sent for some seconds."""
    results, until = multiprocessing.Queue(), time.time() + seconds
    with Neighbour(running.address, keys[1]) as neighbour:
        if hostile:
            sender = multiprocessing.Process(target=attack, args=(running.address, keys[0], hostile, until, results))
            sender.start()
        time.sleep(max(0, until - time.time()))
        neighbour.ended.set()
        rested, calm = ("", True) if hostile and hostile.goes_on else rest(seconds_to_rest(running))
    answers, sent = collections.Counter(), 0
    while hostile and (sender.is_alive() or not results.empty()):
        while not results.empty():
            status, _, size = results.get()
            answers[status] += 1
            sent = max(sent, size)
        sender.join(0.05)
    row, kept = neighbour.said()
    said = " ".join(f"{status}x{count}" for status, count in answers.items()) if hostile else "nothing"
    return f"{size_of(sent):>8} {row:24} {rested:>7}  {running.memory():>6.0f}  {said}", kept and calm


def size_of(sent):
    return f"{sent / 1e6:.1f} MB" if sent >= 1e6 else f"{sent / 1e3:.1f} kB"


def jobs(running, keys, hostile):
    """The row of two jobs, of which one is cancelled and one is deleted while they run."""
    text, cells, kept = hostile.scene(), [], True
    with Neighbour(running.address, keys[1]) as neighbour:
        for number, (method, suffix) in enumerate((("POST", "/cancel"), ("DELETE", ""))):
            started = time.monotonic()
            status, answer = ask(running.address, keys[0], "POST", "/v1/jobs", JSON, b'{"scene": ' + different(text, number) + b"}")
            cells.append(f"{status} {ms(time.monotonic() - started)}")
            if status != 202:
                continue
            time.sleep(3)
            started = time.monotonic()
            try:
                status, _ = ask(running.address, keys[0], method, f"/v1/jobs/{json.loads(answer)['id']}{suffix}")
            except TimeoutError:
                status = "never"
            took = time.monotonic() - started
            in_time = took <= REMOVED and status in (200, 202, 204, 409)
            cells.append(f"{method} {status} {ms(took)}{'' if in_time else ' !'}")
            kept &= in_time
        neighbour.ended.set()
        rested, calm = rest(seconds_to_rest(running))
    row, small = neighbour.said()
    return f"{'':8} {row:24} {rested:>7}  {running.memory():>6.0f}  {', '.join(cells)}", kept and calm and small


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--only", type=lambda names: names.split(","), default=list(REQUESTS), help=", ".join(REQUESTS))
    arguments.add_argument("--program", type=pathlib.Path, default=service.PROGRAM)
    arguments.add_argument("--seconds", type=float, default=10, help="that a request is sent again and again")
    arguments.add_argument("--jobs", choices=("too", "no", "only"), default="too", help="whether jobs of the same scenes are sent")
    chosen = arguments.parse_args()
    print(f"{'request':24} {'sent':>8} {'p50 ms':>6} {'p99 ms':>7} {'worst':>7}   {'rest s':>12}  {'MB':>6}  answers", flush=True)
    kept = True
    rows = [("(nothing)", lambda *at: requests(*at, None, chosen.seconds))]
    for name in chosen.only:
        hostile = REQUESTS[name]
        if chosen.jobs != "only":
            rows.append((name, lambda *at, hostile=hostile: requests(*at, hostile, chosen.seconds)))
        if chosen.jobs != "no" and hostile.scene:
            rows.append((f"{name}, job", lambda *at, hostile=hostile: jobs(*at, hostile)))
    for name, row in rows:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            keys = [service.key(folder / "keys.toml", tenant, program=chosen.program) for tenant in ("acme", "bolt")]
            flags = ["--keys", folder / "keys.toml", "--data", folder / "data"]
            running = service.Service(*flags, program=chosen.program, log=folder / "log")
            try:
                said, good = row(running, keys)
            except (OSError, FileNotFoundError) as error:
                said, good = f"! the service has ended: {error!r} {(folder / 'log').read_text()[-300:]}", False
            print(f"{name:24} {said}", flush=True)
            kept &= good
            if running.process.poll() is None:
                running.stop(signal.SIGKILL)
    sys.exit(not kept)


if __name__ == "__main__":
    main()
