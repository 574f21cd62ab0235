#!/usr/bin/env python3
"""A farm of real processes and everything that goes wrong with it. Each line is a figure; the exit code is 1 if one is wrong.

    cargo build --release && python3 tests/external/farm.py                   # everything, some 40 minutes
    python3 tests/external/farm.py kills --kills 200 --seed 1                 # some of it

kills     nodes, fronts and the broker are killed, stopped and told to end, at random, while two tenants submit jobs
leader    three brokers; the one that leads the work is killed, again and again
soak      100,000 empty tiles: memory and consumers stay as they are
waiting   100,000 tiles wait, and no node is there: memory of the front
overhead  one job on two nodes of one core, and on one machine with two threads, in turn; with --frames a sequence, a piece for each frame
latency   from publishing a piece of work to the begin at a node

No job may be lost, no byte may be wrong, each tile is stored once. STRAHL_NATS_SERVER=path takes another broker.
"""

import argparse
import collections
import http.client
import itertools
import json
import os
import pathlib
import random
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import uuid

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402
from broker import Broker, Listener, free_ports  # noqa: E402
from hostile import ask  # noqa: E402
from hostile_requests import JSON, box, different, hall, noise, scene, sphere  # noqa: E402

LEASE = 3  # seconds until work of a dead node goes to another
LOST_FOR = 300  # seconds that jobs have to end after the last disturbance
ENDS = ("succeeded", "failed", "canceled", "expired")
# What is rendered: some seconds of work each, in many tiles, and in several formats.
SCENES = [
    hall((600, 400), {"max_depth": 300, "min_weight": 0, "samples": 4}),
    box((300, 200), {"samples": 4, "max_depth": 5}, lights=50),
    noise().replace('"samples": 1024', '"samples": 16'),
]
OUTPUTS = [{"format": "png"}, {"format": "exr"}]
EMPTY = scene([sphere([0, 0, 100], 1)], (16384, 16), materials={"glass": {}})  # 256 tiles, nothing in sight


class Node:
    """A process that renders for the farm."""

    def __init__(self, farm, name):
        self.farm, self.name = farm, name
        self.start()

    def start(self):
        with open(self.farm.folder / f"{self.name}.log", "a") as log:
            self.process = subprocess.Popen([self.farm.program, "node", "--farm", self.farm.servers(), "--store", self.farm.folder / "store", "--slots", "1", "--name", self.name], stderr=log)

    def stop(self, signal):
        self.process.send_signal(signal)
        return self.process.wait(timeout=60)


class Farm:
    """Brokers, fronts and nodes, and what was found wrong."""

    def __init__(self, chosen, folder, brokers=1, fronts=2, nodes=3):
        self.chosen, self.folder, self.program = chosen, folder, chosen.program
        self.counts, self.wrong, self.chance = collections.Counter(), [], random.Random(chosen.seed)
        peers = free_ports(brokers) if brokers > 1 else None
        self.brokers = [Broker(folder, f"broker{at}", peers, at) for at in range(brokers)]
        for each in self.brokers:
            each.until_healthy()
        (folder / "store").mkdir()
        self.keys = [service.key(folder / "keys.toml", tenant, program=self.program) for tenant in ("acme", "bolt")]
        self.addresses = [f"127.0.0.1:{port}" for port in free_ports(fronts)]
        self.admins = [f"127.0.0.1:{port}" for port in free_ports(fronts)]
        self.fronts = [self.front(at) for at in range(fronts)]
        self.nodes = [Node(self, f"node{at}") for at in range(nodes)]

    def flags(self):
        return ["--farm", self.servers(), "--store", self.folder / "store", "--farm-lease", str(LEASE), "--farm-replicas", str(len(self.brokers))]

    def servers(self):
        return ",".join(f"nats://127.0.0.1:{each.port}" for each in self.brokers)

    def front(self, at):
        flags = ["--listen", self.addresses[at], "--admin-listen", self.admins[at], "--keys", self.folder / "keys.toml"]
        log = self.folder / f"front{at}.log"
        return service.Service(*flags, "--threads", "1", *self.flags(), program=self.program, log=log)

    def fail(self, what):
        self.wrong.append(what)
        print(f"WRONG: {what}", flush=True)

    def ask(self, tenant, method, path, headers=JSON, body=b"", timeout=30):
        """Status and body from any front, or None if it does not answer."""
        try:
            return ask(self.chance.choice(self.addresses), self.keys[tenant], method, path, headers, body, timeout)
        except (OSError, ValueError, http.client.HTTPException) as error:
            self.counts[f"no answer: {type(error).__name__}"] += 1
            time.sleep(0.2)
            return None

    def figures(self, at=0):
        """The metrics of a front that begin with strahl_farm, by name and labels."""
        _, text = ask(self.admins[at], {}, "GET", "/metrics")
        lines = (line.rpartition(" ") for line in text.decode().splitlines() if line.startswith("strahl_farm"))
        return {name: float(value) for name, _, value in lines}

    def close(self):
        for each in [*self.nodes, *self.fronts, *self.brokers]:
            if each.process.poll() is None:
                each.process.kill()
                each.process.wait()
        for log in self.folder.glob("*.log"):
            if not log.name.startswith("broker") and "panicked" in log.read_text():
                self.fail(f"a panic is in {log.name}")
        if self.wrong:
            kept = service.ROOT / "target" / "farm-logs"
            shutil.rmtree(kept, ignore_errors=True)
            kept.mkdir(parents=True)
            for log in self.folder.glob("*.log"):
                shutil.copy(log, kept)

    # What goes wrong. Each leaves all processes running.

    def kill_node(self):
        node = self.chance.choice(self.nodes)
        node.stop(signal.SIGKILL)
        time.sleep(self.chance.uniform(0, 2))
        node.start()

    def kill_all_nodes(self):
        for node in self.nodes:
            node.stop(signal.SIGKILL)
        time.sleep(self.chance.uniform(0, 2))
        for node in self.nodes:
            node.start()

    def end_node(self):
        node, begun = self.chance.choice(self.nodes), time.monotonic()
        code = node.stop(signal.SIGTERM)
        if code or time.monotonic() - begun > 30:
            self.fail(f"SIGTERM of a node: exit code {code} after {time.monotonic() - begun:.0f} s")
        node.start()

    def stop_node(self):
        node = self.chance.choice(self.nodes)
        node.process.send_signal(signal.SIGSTOP)
        time.sleep(self.chance.uniform(LEASE / 2, 3 * LEASE))
        node.process.send_signal(signal.SIGCONT)

    def kill_front(self):
        at = self.chance.randrange(len(self.fronts))
        self.fronts[at].stop(signal.SIGKILL)
        time.sleep(self.chance.uniform(0, 4))
        self.fronts[at] = self.front(at)

    def end_front(self):
        at, begun = self.chance.randrange(len(self.fronts)), time.monotonic()
        code = self.fronts[at].stop(signal.SIGTERM)
        if code or time.monotonic() - begun > 40:
            self.fail(f"SIGTERM of a front: exit code {code} after {time.monotonic() - begun:.0f} s")
        self.fronts[at] = self.front(at)

    def kill_broker(self, which=None):
        broker = which or self.chance.choice(self.brokers)
        broker.stop(signal.SIGKILL)
        time.sleep(self.chance.uniform(0, 3))
        broker.start()
        broker.until_healthy()

    def kill_leader(self):
        leader = next((each for each in self.brokers if each.leads("FARM_T")), None)
        self.counts["leaders killed"] += leader is not None
        self.kill_broker(leader)

    # What tenants do meanwhile.

    def jobs(self, tenant, right, ended, seed):
        """Jobs, one after the other; each has an end, and its picture is the right one."""
        chance = random.Random(seed)
        while not ended.is_set():
            which, output = chance.randrange(len(SCENES)), chance.randrange(len(OUTPUTS))
            scene = different(SCENES[which], 0)
            body = b'{"scene": %s, "output": %s}' % (scene, json.dumps(OUTPUTS[output]).encode())
            job = self.submit(tenant, body, ended)
            if job:
                self.follow(tenant, job, right[which, output], ended)

    def submit(self, tenant, body, ended):
        """The id of a new job. It is sent again until a front has taken it."""
        headers = JSON | {"Idempotency-Key": str(uuid.uuid4())}
        while not ended.is_set():
            answer = self.ask(tenant, "POST", "/v1/jobs", headers, body)
            if answer and answer[0] in (200, 202):
                self.counts["jobs"] += 1
                return json.loads(answer[1])["id"]
            if answer:
                self.counts[f"submit {answer[0]}"] += 1
                if answer[0] not in (409, 429, 503, 504):  # 409: another front was accepting it
                    self.fail(f"submitting a job: {answer[0]} {answer[1][:200]}")
            time.sleep(0.2)
        return None

    def follow(self, tenant, job, right, ended, patience=LOST_FOR):
        deadline, state = None, None
        while state not in ENDS:
            if ended.is_set():
                deadline = deadline or time.monotonic() + patience
            answer = self.ask(tenant, "GET", f"/v1/jobs/{job}")
            if answer and answer[0] == 404:
                return self.fail(f"a job is lost: {job}")
            state = json.loads(answer[1])["state"] if answer and answer[0] == 200 else None
            if deadline and time.monotonic() > deadline:
                return self.fail(f"a job does not end: {job} {state}")
            if state not in ENDS:
                time.sleep(0.2)
        self.counts[f"jobs {state}"] += 1
        if state != "succeeded":
            return self.fail(f"a job has {state}: {json.loads(answer[1]).get('problem') or answer[1][-400:]}")
        for _ in range(300):
            image = self.ask(tenant, "GET", f"/v1/jobs/{job}/image")
            if image and image[0] == 200:
                break
            time.sleep(0.2)
        if not image or image[0] != 200:
            return self.fail(f"a job's picture: {image and image[0]}")
        if right is not None and image[1] != right:
            return self.fail(f"a job's picture has wrong bytes: {len(image[1])} of {len(right)}")
        self.counts["right pictures"] += 1
        while (gone := self.ask(tenant, "DELETE", f"/v1/jobs/{job}")) is None or gone[0] not in (204, 404):
            time.sleep(0.2)
        return None

    def events(self, ended):
        """Follows the events of one job after the other. Numbers grow, over all fronts, and the last one is the end."""
        while not ended.is_set():
            body = b'{"scene": %s}' % different(SCENES[0], self.chance.randrange(10**6))
            if (job := self.submit(0, body, ended)) is None:
                return
            last, kind, deadline = 0, None, None
            while kind not in ("done", "failed", "canceled", *ENDS):
                deadline = deadline or (time.monotonic() + LOST_FOR if ended.is_set() else None)
                if deadline and time.monotonic() > deadline:
                    self.fail(f"the events of {job} do not end; the last is {last}, {kind}")
                    break
                address = self.chance.choice(self.addresses)
                try:
                    client = http.client.HTTPConnection(address, timeout=20)
                    more = {"Last-Event-ID": str(last)} if last else {}
                    client.request("GET", f"/v1/jobs/{job}/events", headers=self.keys[0] | more)
                    answer = client.getresponse()
                    if answer.status != 200:
                        time.sleep(0.3)
                        continue
                    self.counts["event streams"] += 1
                    for line in answer:
                        if line.startswith(b"id:"):
                            number = int(line[3:])
                            if number < last:
                                self.fail(f"events of {job} go back from {last} to {number}")
                            last = number
                        elif line.startswith(b"event:"):
                            kind = line[6:].strip().decode()
                            self.counts[f"event {kind}"] += 1
                except (OSError, http.client.HTTPException):
                    time.sleep(0.2)
                finally:
                    client.close()

    # What is looked at in the end.

    def check_the_end(self):
        """The broker holds no work, each stored tile is there once, and nobody has seen two results that differ."""
        broker = next((each for each in self.brokers if len(self.brokers) == 1 or each.leads("FARM_R")), self.brokers[0])
        for _ in range(100):
            streams = broker.streams()
            if streams["FARM_T"]["state"]["messages"] == 0:
                break
            time.sleep(0.3)
        work, results = streams["FARM_T"]["state"], streams["FARM_R"]["state"]
        if work["messages"]:
            self.fail(f"{work['messages']} pieces of work are left")
        if results.get("num_subjects", 0) != results["messages"]:
            self.fail(f"{results['messages']} results of {results.get('num_subjects')} tiles")
        self.counts["tiles stored"] = results["last_seq"]
        self.counts["results left"] = results["messages"]
        self.counts["dead letters"] = streams["FARM_DLQ"]["state"]["last_seq"]
        alarms = sum(value for at in range(len(self.fronts)) for name, value in self.figures(at).items() if "determinism" in name)
        if alarms:
            self.fail(f"{alarms:.0f} tiles were rendered with different bytes")


def undisturbed(program):
    """The right pictures of all scenes in all formats, without a farm."""
    running = service.Service("--insecure-no-auth", "--timeout", "600", program=program)
    try:
        right = {}
        for which, output in itertools.product(range(len(SCENES)), range(len(OUTPUTS))):
            query = "&".join(f"{key}={value}" for key, value in OUTPUTS[output].items())
            status, picture = ask(running.address, {}, "POST", f"/v1/render?{query}", JSON, different(SCENES[which], 0), timeout=600)
            assert status == 200, picture
            right[which, output] = picture
        return right
    finally:
        running.stop()


def disturbed(chosen, farm, right, disturbances, count):
    """Tenants submit jobs while `count` things go wrong."""
    ended = threading.Event()
    threads = [threading.Thread(target=farm.events, args=(ended,), daemon=True)]
    threads += [threading.Thread(target=farm.jobs, args=(at % 2, right, ended, at), daemon=True) for at in range(4)]
    for each in threads:
        each.start()
    try:
        for at in range(count):
            time.sleep(farm.chance.uniform(*chosen.pause))
            what = farm.chance.choice(disturbances)
            farm.counts[what.__name__] += 1
            print(f"{at + 1}/{count} {what.__name__}", flush=True)
            try:
                what()
            except subprocess.TimeoutExpired:
                farm.fail(f"{what.__name__}: a process does not end")
                break
    finally:
        ended.set()
        for each in threads:
            each.join()
    farm.check_the_end()


def kills(chosen, farm):
    often = [farm.kill_node] * 4 + [farm.kill_front] * 2 + [farm.kill_broker] * 2
    rest = [farm.kill_all_nodes, farm.end_node, farm.stop_node, farm.end_front]
    disturbed(chosen, farm, undisturbed(chosen.program), often + rest, chosen.kills)


def leader(chosen, farm):
    disturbed(chosen, farm, undisturbed(chosen.program), [farm.kill_leader], max(3, chosen.kills // 10))


def soak(chosen, farm):
    """Jobs of 256 empty tiles each, eight at a time. What the processes hold is looked at after a tenth, and in the end."""
    left, lock, ended, held = chosen.tiles // 256, threading.Lock(), threading.Event(), []
    numbers = itertools.count()

    def jobs(tenant):
        while next(numbers) < left:
            body = b'{"scene": %s}' % different(EMPTY, farm.chance.randrange(10**6))
            if job := farm.submit(tenant, body, ended):
                farm.follow(tenant, job, None, ended)

    def look():
        memory = {f"front{at}": front.memory("VmRSS") for at, front in enumerate(farm.fronts)}
        for node in farm.nodes:
            status = pathlib.Path(f"/proc/{node.process.pid}/status").read_text()
            memory[node.name] = int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1024
        return memory | {"broker": farm.brokers[0].memory(), "consumers": farm.brokers[0].consumers()}

    threads = [threading.Thread(target=jobs, args=(at % 2,), daemon=True) for at in range(8)]
    for each in threads:
        each.start()
    begun = time.monotonic()
    while any(each.is_alive() for each in threads):
        time.sleep(5)
        done = farm.counts["right pictures"]
        if done >= len(held) * left / 10:
            with lock:
                held.append(look())
            print(f"{done * 256:7} tiles, {time.monotonic() - begun:4.0f} s:", {what: round(value) for what, value in held[-1].items()}, flush=True)
    first, last = held[min(1, len(held) - 1)], look()
    print("after a tenth", first, "\nin the end   ", last)
    for what, value in last.items():
        if value > 1.5 * first[what] + (100 if what != "consumers" else 0):
            farm.fail(f"{what}: {first[what]:.0f} after a tenth, {value:.0f} in the end")
    farm.check_the_end()


def waiting(chosen, farm):
    """Jobs of 256 tiles each that nobody renders: what the front holds of each."""
    held, jobs = [], chosen.tiles // 256
    for number in range(jobs):
        if number % (jobs // 10) == 0:
            held.append(farm.fronts[0].memory("VmRSS"))
        body = b'{"scene": %s}' % different(EMPTY, number)
        status, text = ask(farm.addresses[0], farm.keys[number % 2], "POST", "/v1/jobs", JSON, body)
        if status != 202:
            return farm.fail(f"submitting job {number}: {status} {text}")
    held.append(farm.fronts[0].memory("VmRSS"))
    published = farm.brokers[0].streams()["FARM_T"]["state"]["messages"]
    print(f"{jobs * 256} tiles wait, {published} of their pieces at the broker; MB of the front, at each tenth:", *map(round, held))
    if held[-1] > 1.5 * held[1] + 50:
        farm.fail(f"{held[1]:.0f} MB after a tenth, {held[-1]:.0f} in the end")
    return None


def seconds_of(processes):
    """Processor seconds that processes have taken."""
    total = 0
    for process in processes:
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        total += int(fields[11]) + int(fields[12])
    return total / os.sysconf("SC_CLK_TCK")


def run_job(address, key, body):
    """Seconds that a job takes, from the request to its end."""
    begun = time.monotonic()
    status, text = ask(address, key, "POST", "/v1/jobs", JSON, body)
    assert status in (200, 202), text
    job = json.loads(text)["id"]
    while True:
        state = json.loads(ask(address, key, "GET", f"/v1/jobs/{job}")[1])
        if state["state"] in ENDS:
            assert state["state"] == "succeeded", state
            return time.monotonic() - begun
        time.sleep(0.05)


def overhead(chosen, farm):
    """One job of many pieces on two nodes of one core each, and on one machine with two threads, in turn."""
    size, samples, frames = chosen.size, chosen.samples, b""
    if chosen.frames:
        size, frames = (320, 200), b', "frames": {"count": %d, "turntable": {"degrees": 30}}' % chosen.frames
    alone = service.Service("--insecure-no-auth", "--threads", "2", program=chosen.program)
    rows = []
    try:
        for turn in range(chosen.rounds):
            body = b'{"scene": %s%s}' % (different(box(size, {"samples": samples, "max_depth": 5}, lights=10), turn), frames)
            first = farm.brokers[0].streams()["FARM_T"]["state"]["last_seq"]
            row = {}
            for where in ("farm", "alone") if turn % 2 else ("alone", "farm"):
                inside = [each.process for each in [*farm.nodes, *farm.fronts, *farm.brokers]] if where == "farm" else [alone.process]
                address, key = (farm.addresses[0], farm.keys[0]) if where == "farm" else (alone.address, {})
                spent = [seconds_of([each]) for each in inside]
                row[where] = [run_job(address, key, body), [seconds_of([each]) - before for each, before in zip(inside, spent)]]
            pieces = farm.brokers[0].streams()["FARM_T"]["state"]["last_seq"] - first
            rows.append((row["farm"][0] / row["alone"][0], sum(row["farm"][1]) / sum(row["alone"][1])))
            seconds = " + ".join(f"{each:.1f}" for each in row["farm"][1])
            print(f"{pieces} pieces; farm {row['farm'][0]:.1f} s ({seconds} of processors: nodes, front, broker), alone {row['alone'][0]:.1f} s ({row['alone'][1][0]:.1f})", flush=True)
    finally:
        alone.stop()
    wall, processors = (statistics.median(column) for column in zip(*rows))
    print(f"median of {len(rows)}: {wall:.3f} times as long, {processors:.3f} times the processors")


def latency(chosen, farm):
    """From publishing a piece of work to the begin at a node that waits: single small jobs, one after the other."""
    listener, published, took = Listener(farm.brokers[0].port, "farm.t.>", "farm.b.>"), {}, []

    def listen():
        for at, subject, _ in listener:
            job = subject.split(".")[5 if subject.startswith("farm.t.") else 2]
            if subject.startswith("farm.t."):
                published.setdefault(job, at)
            elif job in published:
                took.append(at - published.pop(job))

    thread = threading.Thread(target=listen, daemon=True)
    thread.start()
    for turn in range(chosen.jobs):
        run_job(farm.addresses[0], farm.keys[0], b'{"scene": %s}' % different(box((64, 40), {"samples": 1}, lights=1), turn))
    listener.close()
    took.sort()
    if not took:
        return farm.fail("no piece of work was seen")
    p50, p99 = (1e3 * took[int(share * (len(took) - 1))] for share in (0.5, 0.99))
    print(f"{len(took)} pieces, ms from publishing to begin: median {p50:.1f}, p99 {p99:.1f}, worst {1e3 * took[-1]:.1f}")
    return None


# Each with its brokers, fronts and nodes.
PARTS = {"kills": (kills, 1, 2, 3), "leader": (leader, 3, 2, 2), "soak": (soak, 1, 1, 2), "waiting": (waiting, 1, 1, 0), "overhead": (overhead, 1, 1, 2), "latency": (latency, 1, 1, 2)}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("parts", nargs="*", choices=[*PARTS, []])
    arguments.add_argument("--program", type=pathlib.Path, default=service.PROGRAM)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--kills", type=int, default=200)
    arguments.add_argument("--pause", type=float, nargs=2, default=(0.5, 4), metavar="SECONDS", help="shortest and longest between kills")
    arguments.add_argument("--tiles", type=int, default=100_000, help="of the soak, and of those that wait")
    arguments.add_argument("--rounds", type=int, default=5, help="of the overhead")
    arguments.add_argument("--size", type=int, nargs=2, default=(2048, 1280), metavar="PIXELS", help="of the overhead's picture")
    arguments.add_argument("--samples", type=int, default=16, help="of each of its pixels")
    arguments.add_argument("--frames", type=int, default=0, help="of the overhead's job, instead of one picture")
    arguments.add_argument("--jobs", type=int, default=300, help="of the latency")
    chosen = arguments.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # as with Ctrl-C, what was started ends, too
    failed = []
    for part in chosen.parts or PARTS:
        run, *sizes = PARTS[part]
        print(f"== {part}", flush=True)
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            farm = Farm(chosen, pathlib.Path(folder), *sizes)
            try:
                run(chosen, farm)
            except Exception as error:  # the processes' logs say why
                farm.fail(f"{type(error).__name__}: {error}")
            finally:
                farm.close()
        for what, count in sorted(farm.counts.items()):
            print(f"{what:28} {count:8}")
        print(f"== {part} took {time.monotonic() - started:.0f} s: {len(farm.wrong)} wrong" if farm.wrong else f"== {part} took {time.monotonic() - started:.0f} s: nothing is wrong", flush=True)
        failed += [part] * bool(farm.wrong)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
