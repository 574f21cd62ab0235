"""The real service on a free port, and something between it and the client that can do harm."""

import os
import pathlib
import re
import signal
import socket
import subprocess
import threading

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BINARY = os.environ.get("STRAHL_BINARY") or ROOT / "target" / "release" / "strahl"

SCENE = {
    "version": 1,
    "image": {"width": 48, "height": 32},
    "camera": {"pinhole": {"eye": [0, 1, 5], "look_at": [0, 0.5, 0]}},
    "background": [0.3, 0.5, 0.8],
    "lights": [{"point": {"position": [3, 5, 4]}}],
    "materials": {"red": {"diffuse": [0.8, 0.2, 0.1], "specular": 0.5, "reflection": 0.2}},
    "objects": [
        {"sphere": {"center": [0, 1, 0], "radius": 1, "material": "red"}},
        {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0]}},
    ],
}


def busy_scene(name):
    """A scene that takes a second or more as a job, and that no other test has."""
    mirrors = {"diffuse": 0.1, "reflection": 0.9}
    walls = [{"plane": {"point": [0, 0, z], "normal": [0, 0, -z], "material": "mirror"}} for z in (-3, 9)]
    return {**SCENE, "name": name, "materials": {**SCENE["materials"], "mirror": mirrors}, "objects": SCENE["objects"] + walls,
            "render": {"max_depth": 60, "accuracy": {"fixed": {}}, "antialias": False}}


class Service:
    """The program; `url` is its address."""

    def __init__(self, *flags, port=0):
        command = [BINARY, "serve", "--listen", f"127.0.0.1:{port}", *map(str, flags)]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        said = ""
        for line in self.process.stderr:
            said += line
            if found := re.search(r"listening on (http://\S+)", line):
                self.url = found[1]
                break
        else:
            raise RuntimeError(f"the service has not started: {said}")
        self.port = int(self.url.rsplit(":", 1)[1])
        threading.Thread(target=self.process.stderr.read, daemon=True).start()

    def stop(self, how=signal.SIGTERM):
        self.process.send_signal(how)
        self.process.wait(timeout=60)


class Between:
    """A proxy of bytes. `cut_after` bytes of an answer it closes the connection, `cuts` times."""

    def __init__(self, port):
        self.port, self.cut_after, self.cuts, self.requests = port, 0, 0, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client):
        service = socket.create_connection(("127.0.0.1", self.port))

        def forth():
            while part := _receive(client):
                self.requests.append(part)
                # The service answers to its own name only.
                named = re.sub(rb"(?i)host: 127\.0\.0\.1:\d+", b"Host: 127.0.0.1:%d" % self.port, part)
                try:
                    service.sendall(named)
                except OSError:
                    return
            service.close()

        threading.Thread(target=forth, daemon=True).start()
        sent = 0
        while part := _receive(service):
            cut = self.cuts > 0 and sent + len(part) > self.cut_after
            try:
                client.sendall(part[: max(0, self.cut_after - sent)] if cut else part)
            except OSError:
                break
            sent += len(part)
            if cut:
                self.cuts -= 1
                break
        for end in (client, service):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            end.close()

    def close(self):
        self.listener.close()


def _receive(end):
    try:
        return end.recv(65536)
    except OSError:
        return b""


@pytest.fixture(scope="session")
def service():
    running = Service()
    yield running
    running.stop()


@pytest.fixture
def between(service):
    proxy = Between(service.port)
    yield proxy
    proxy.close()
