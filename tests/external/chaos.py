#!/usr/bin/env python3
"""Half an hour of everything that goes wrong: kills, stops, a full disk, a slow one, a clock that jumps, hostile requests.

    cargo build --release && python3 tests/external/chaos.py [--minutes 30] [--program PATH] [--seed 1]

Two tenants render and submit jobs meanwhile. In the end no job is lost, no picture has a wrong byte (each is compared with
that of an undisturbed service), small renders were answered while nothing but hostile requests disturbed them, and memory and
files are what they were. The exit code is 1 if not. As root the data is on a small disk of its own (tmpfs), which can be
full; with a C compiler disks can be slow and clocks wrong (disturb.c). What is left out is said.
"""

import argparse
import collections
import itertools
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import uuid

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402
from hostile import SMALL, ask, ms  # noqa: E402
from hostile_requests import JSON, REQUESTS, balls, box, different, hall, noise  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
DISK = 96  # MB of the disk that gets full
BUDGETS = ["--scene-cache-bytes", "50000000", "--picture-cache-bytes", "2000000", "--disk-cache-bytes", "5000000"]
WORST = 1.0  # seconds that a small render may take
RESTING = 500  # MB of memory that may be left in the end: budgets, and what an allocator keeps
LOST_FOR = 120  # seconds that jobs have to end after the last disturbance
# More than before that a process may hold at rest. Of tokio's threads for files those stay that its tick wakes in turn.
MORE = {"files": 2, "open files": 8, "threads": 16}

# What is rendered and compared: a few seconds of work each, some in many tiles, and in several formats.
SCENES = [
    hall((600, 400), {"max_depth": 300, "min_weight": 0, "samples": 4}),
    box((300, 200), {"samples": 4, "max_depth": 5}, lights=50),
    noise().replace('"samples": 1024', '"samples": 16'),
    balls((160, 120), 1).replace("100000", "8"),
]
OUTPUTS = [{"format": "png"}, {"format": "png", "bits": 16}, {"format": "exr"}, {"format": "webp"}]


class World:
    """The service that is disturbed, what happens to it, and what was found wrong."""

    def __init__(self, chosen, folder):
        self.chosen, self.folder, self.chance = chosen, folder, random.Random(chosen.seed)
        self.counts, self.wrong, self.small = collections.Counter(), [], []
        self.ended, self.quiet_since, self.running = threading.Event(), time.monotonic(), None
        self.keys = [service.key(folder / "keys.toml", tenant, program=chosen.program) for tenant in ("acme", "bolt")]
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = "%s:%d" % free.getsockname()
        self.data = folder / "disk"
        self.data.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK}m", "tmpfs", self.data], capture_output=True)
        self.has_disk = mounted.returncode == 0
        self.numbers = folder / "disturb"
        self.disturb(0, 0)
        library = folder / "disturb.so"
        made = shutil.which("cc") and subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", library, HERE / "disturb.c", "-ldl"])
        self.has_library = bool(made) and made.returncode == 0
        if self.has_library:
            os.environ |= {"LD_PRELOAD": str(library), "DISTURB": str(self.numbers)}

    def disturb(self, microseconds, seconds):
        """How slow the disk is and how wrong the clock, from now on; in place, since the file is mapped."""
        with open(self.numbers, "r+b" if self.numbers.exists() else "wb") as file:
            file.write(struct.pack("qq", microseconds, seconds))

    def start(self):
        flags = ["--listen", self.address, "--keys", self.folder / "keys.toml", "--data", self.data / "data", *BUDGETS]
        begun = time.monotonic()
        flags += ["--cache", self.folder / "cache"]
        self.running = service.Service(*flags, program=self.chosen.program, log=self.folder / "log")
        self.counts["starts"] += 1
        if (took := time.monotonic() - begun) > 10:
            self.fail(f"a start took {took:.0f} s")

    def fail(self, what):
        self.wrong.append(what)
        print(f"WRONG: {what}", flush=True)

    def ask(self, tenant, *request, timeout=60):
        """Status and body of an answer, or None while there is nobody to answer."""
        try:
            return ask(self.address, self.keys[tenant], *request, timeout=timeout)
        except (OSError, ValueError) as error:
            self.counts[type(error).__name__] += 1
            time.sleep(0.2)
            return None

    # What happens to the service. Each leaves it as it was.

    def kill(self):
        self.running.stop(signal.SIGKILL)
        self.start()

    def terminate(self):
        begun = time.monotonic()
        code = self.running.stop(signal.SIGTERM)
        if code or time.monotonic() - begun > 30:
            self.fail(f"SIGTERM: exit code {code} after {time.monotonic() - begun:.0f} s")
        self.start()

    def stop_and_go_on(self):
        self.running.process.send_signal(signal.SIGSTOP)
        time.sleep(self.chance.uniform(1, 12))
        self.running.process.send_signal(signal.SIGCONT)

    def full_disk(self):
        filler = self.data / "filler"
        try:
            with open(filler, "wb") as file:
                for size in (1 << 20, 1 << 12, 1):
                    while file.write(bytes(size)):
                        file.flush()
        except OSError:
            pass
        time.sleep(self.chance.uniform(1, 6))
        killed = self.chance.random() < 0.5
        if killed:
            self.running.stop(signal.SIGKILL)
        filler.unlink()
        if killed:
            self.start()

    def slow_disk(self):
        self.disturb(self.chance.choice([5_000, 50_000]), 0)
        time.sleep(self.chance.uniform(3, 10))
        if self.chance.random() < 0.5:
            self.kill()
        self.disturb(0, 0)

    def clock(self):
        # Less than pictures are kept for, or it would be right to delete them; far back, where nothing expires.
        self.disturb(0, self.chance.choice([-3_650 * 86_400, -3_600, 3_600, 86_400]))
        time.sleep(self.chance.uniform(1, 5))
        if self.chance.random() < 0.5:
            self.kill()
        self.disturb(0, 0)

    def disturbances(self):
        always = [self.kill, self.kill, self.terminate, self.stop_and_go_on]
        return always + [self.full_disk] * self.has_disk + [self.slow_disk, self.clock] * self.has_library

    def go_on(self):
        """Disturbs until the time is over."""
        end = time.monotonic() + 60 * self.chosen.minutes
        while time.monotonic() < end:
            time.sleep(self.chance.uniform(5, 20))
            what = self.chance.choice(self.disturbances())
            self.counts[what.__name__] += 1
            self.quiet_since = float("inf")
            try:
                what()
            except subprocess.TimeoutExpired:
                self.fail(f"{what.__name__}: the process does not end")
                self.running.process.kill()
                self.start()
            # Jobs go on from where they were, which takes a moment.
            self.quiet_since = time.monotonic() + 2
        self.ended.set()

    # What tenants do meanwhile.

    def small_renders(self):
        """Those that have to be answered soon, unless the service itself is disturbed."""
        for number in itertools.count():
            if self.ended.is_set():
                return
            begun, quiet_since = time.monotonic(), self.quiet_since
            answer = self.ask(1, "POST", "/v1/render", JSON, different(SMALL, number % 10**6))
            took = time.monotonic() - begun
            if begun > quiet_since == self.quiet_since:
                self.small.append(took)
                if answer is None or answer[0] != 200 or took > WORST:
                    self.fail(f"a small render: {answer and answer[0]} after {took:.1f} s")
            time.sleep(0.05)

    def renders(self, tenant, right):
        chance = random.Random(tenant)
        while not self.ended.is_set():
            which, output = chance.randrange(len(SCENES)), chance.randrange(len(OUTPUTS))
            answer = self.ask(tenant, "POST", f"/v1/render?{query(output)}", JSON, different(SCENES[which], 0))
            self.check("render", answer, right[which, output])
            time.sleep(0.02)

    def check(self, what, answer, right):
        if answer is None:
            return
        self.counts[f"{what} {answer[0]}"] += 1
        if answer[0] == 200 and answer[1] != right:
            self.fail(f"{what}: wrong bytes, {len(answer[1])} of {len(right)}")
        if answer[0] not in (200, 429, 503, 504):
            self.fail(f"{what}: {answer[0]} {answer[1][:200]}")

    def hostile(self):
        """One hostile request or job after another, each left or deleted after some seconds."""
        chance, names = random.Random(9), [name for name, known in REQUESTS.items() if known.scene]
        while not self.ended.is_set():
            name, number = chance.choice(names), chance.randrange(10**6)
            if chance.random() < 0.5:
                self.counts["hostile requests"] += 1
                self.ask(0, *REQUESTS[name].make()(number, None), timeout=3)
                continue
            self.counts["hostile jobs"] += 1
            answer = self.ask(0, "POST", "/v1/jobs", JSON, b'{"scene": %s}' % different(REQUESTS[name].scene(), number), timeout=10)
            time.sleep(2)
            if answer and answer[0] == 202:
                self.ask(0, "DELETE", f"/v1/jobs/{json.loads(answer[1])['id']}")

    def delete_the_rest(self):
        """Jobs that nobody could delete while the service was away."""
        for tenant in (0, 1):
            for job in json.loads(self.ask(tenant, "GET", "/v1/jobs?limit=200")[1])["jobs"]:
                if (answer := self.ask(tenant, "DELETE", f"/v1/jobs/{job['id']}")) is None or answer[0] != 204:
                    self.fail(f"DELETE of a job: {answer}")

    def jobs(self, tenant, right):
        """Jobs, one after the other; each has an end, and its picture is the right one."""
        chance = random.Random(10 + tenant)
        while not self.ended.is_set():
            which, output = chance.randrange(len(SCENES)), chance.randrange(len(OUTPUTS))
            body = b'{"scene": %s, "output": %s}' % (different(SCENES[which], 0), json.dumps(OUTPUTS[output]).encode())
            headers, job = JSON | {"Idempotency-Key": str(uuid.uuid4())}, None
            while job is None and not self.ended.is_set():
                answer = self.ask(tenant, "POST", "/v1/jobs", headers, body)
                if answer and answer[0] in (200, 202):
                    job = json.loads(answer[1])["id"]
                elif answer and answer[0] not in (429, 503, 504, 507) and not (answer[0] == 500 and self.has_disk):
                    self.fail(f"submitting a job: {answer[0]} {answer[1][:200]}")
            if job:
                self.counts["jobs"] += 1
                self.follow(tenant, job, right[which, output])

    def follow(self, tenant, job, right):
        deadline = None
        while True:
            if self.ended.is_set():
                deadline = deadline or time.monotonic() + LOST_FOR
            answer = self.ask(tenant, "GET", f"/v1/jobs/{job}")
            if answer and answer[0] == 404:
                return self.fail(f"a job is lost: {job}")
            state = json.loads(answer[1])["state"] if answer and answer[0] == 200 else None
            if state in ("succeeded", "failed", "canceled", "expired"):
                break
            if deadline and time.monotonic() > deadline:
                return self.fail(f"a job does not end: {state}")
            time.sleep(0.2)
        self.counts[f"jobs {state}"] += 1
        if state != "succeeded":
            # Reasons that are told: a full disk, and three ends of the process before a single tile was finished.
            said = json.loads(answer[1]).get("problem") or json.loads(answer[1]).get("failure") or answer[1][:400]
            self.counts["jobs abandoned"] += "abandoned" in str(said)
            return None if "storage" in str(said) or "abandoned" in str(said) else self.fail(f"a job has {state}: {said}")
        image = None
        while image is None or image[0] in (429, 503, 504):
            image = self.ask(tenant, "GET", f"/v1/jobs/{job}/image")
        self.check("job's picture", image, right)
        while (gone := self.ask(tenant, "DELETE", f"/v1/jobs/{job}")) is None or gone[0] not in (204, 404):
            time.sleep(0.2)


def query(output):
    return "&".join(f"{key}={value}" for key, value in OUTPUTS[output].items())


def undisturbed(program):
    """The right pictures of all scenes in all formats."""
    running = service.Service("--insecure-no-auth", program=program)
    try:
        right = {}
        for which, output in itertools.product(range(len(SCENES)), range(len(OUTPUTS))):
            status, picture = ask(running.address, {}, "POST", f"/v1/render?{query(output)}", JSON, different(SCENES[which], 0))
            assert status == 200, picture
            right[which, output] = picture
        return right
    finally:
        running.stop()


def holdings(running, data):
    """What a process holds: files in its folder, open files, threads."""
    process = pathlib.Path(f"/proc/{running.process.pid}")
    files = sum(len(files) for _, _, files in os.walk(data))
    opened, threads = (len(list((process / what).iterdir())) for what in ("fd", "task"))
    return {"files": files, "open files": opened, "threads": threads}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--minutes", type=float, default=30)
    arguments.add_argument("--program", type=pathlib.Path, default=service.PROGRAM)
    arguments.add_argument("--seed", type=int, default=1)
    chosen = arguments.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # as with Ctrl-C, what was started ends, too
    right = undisturbed(chosen.program)
    with tempfile.TemporaryDirectory() as folder:
        world = World(chosen, pathlib.Path(folder))
        for missing, what in ((world.has_disk, "a full disk (mount needs root)"), (world.has_library, "slow disks and clocks (no cc)")):
            if not missing:
                print(f"left out: {what}")
        try:
            world.start()
            before = holdings(world.running, world.data)
            threads = [threading.Thread(target=target) for target in (world.small_renders, world.hostile)]
            for tenant in (0, 1):
                threads += [threading.Thread(target=world.renders, args=(tenant, right))]
                threads += [threading.Thread(target=world.jobs, args=(tenant, right)) for _ in range(2)]
            for each in threads:
                each.start()
            world.go_on()
            for each in threads:
                each.join()
            world.delete_the_rest()
            time.sleep(15)  # connections end, threads rest
            after, memory = holdings(world.running, world.data), world.running.memory("VmRSS")
            for what, count in after.items():
                if count > before[what] + MORE[what]:
                    world.fail(f"{what}: {before[what]} before, {count} after")
            if memory > RESTING:
                world.fail(f"{memory:.0f} MB of memory at rest")
            world.running.stop()
        finally:
            world.ended.set()
            if world.running.process.poll() is None:
                world.running.process.kill()
            if "panicked" in (world.folder / "log").read_text():
                world.fail("a panic is in the log")
            if world.wrong:
                shutil.copy(world.folder / "log", HERE.parents[1] / "target" / "chaos.log")
            if world.has_disk:
                subprocess.run(["umount", "-l", world.data], check=False)
    for what, count in sorted(world.counts.items()):
        print(f"{what:28} {count:8}")
    small = sorted(world.small)
    if small:
        p50, p99, worst = (small[int(share * (len(small) - 1))] for share in (0.5, 0.99, 1))
        print(f"small renders in quiet times: {len(small)}, ms: median {ms(p50)}, p99 {ms(p99)}, worst {ms(worst)}")
    print(f"before {before}, after {after}, {memory:.0f} MB at rest")
    print(f"{len(world.wrong)} wrong" if world.wrong else "no job is lost, no byte is wrong")
    sys.exit(bool(world.wrong))


if __name__ == "__main__":
    main()
