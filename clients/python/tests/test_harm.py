"""Cut connections, a service that is killed, wrong keys, busy services, thousands of events."""

import json
import signal
import socket
import subprocess
import threading
import time

import httpx
import pytest
from conftest import BINARY, SCENE, Service, busy_scene

import strahl
from strahl import Client
from strahl.events import Parser
from strahl.parts import Parts


def test_a_stream_that_is_cut_goes_on_without_gaps(between):
    client = Client(between.url)
    job = client.jobs.submit(busy_scene("cut"), width=320, height=240, samples=96)
    between.cut_after, between.cuts = 1_200, 3
    events = list(job.events())
    assert between.cuts == 0, "nothing was cut"
    numbers = [event.data["seq"] for event in events]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), numbers
    assert events[-1].name == "succeeded"
    asked = [part for part in between.requests if b"/events" in part.split(b"\r\n", 1)[0]]
    # The first connections may break before the first event.
    assert len(asked) >= 4 and all(b"last-event-id: " in part.lower() for part in asked[3:])
    assert list(job.events(events[-1].id)) == [], "nothing comes after the last"


def test_a_picture_that_is_cut_is_asked_for_again(between, tmp_path):
    client = Client(between.url)
    whole = client.render(SCENE, width=200, height=150).content
    between.cut_after, between.cuts = 1_000, 2
    assert client.render(SCENE, width=200, height=150).content == whole
    job = client.jobs.submit(SCENE, width=200, height=150)
    job.refresh(wait=20)
    between.cut_after, between.cuts = 1_000, 1
    job.download(tmp_path / "a.png")
    assert len((tmp_path / "a.png").read_bytes()) > 1_000
    between.cut_after, between.cuts = 3_000, 1
    scales = [one.scale for one in client.stream(SCENE, width=400, height=300)]
    assert between.cuts == 0 and scales == sorted(set(scales), reverse=True) and scales[-1] == 1
    between.cut_after, between.cuts = 100, 100
    with pytest.raises(strahl.Unreachable):
        Client(between.url, retries=1).render(SCENE, width=201, height=150)
    with pytest.raises(strahl.Unreachable):
        strahl.Job(Client(between.url, retries=1), job.view).download(tmp_path / "b.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png"]


def test_a_job_outlives_the_service(tmp_path):
    service = Service("--data", tmp_path / "data")
    client = Client(service.url, retries=8)
    job = client.jobs.submit(busy_scene("killed"), width=320, height=240, samples=64)
    seen = []
    following = threading.Thread(target=lambda: seen.extend(job.progress()))
    following.start()
    while job.refresh().view["progress"]["tiles_done"] < 2:
        time.sleep(0.05)
    service.stop(signal.SIGKILL)
    time.sleep(0.5)
    service = Service("--data", tmp_path / "data", port=service.port)
    try:
        following.join(120)
        assert not following.is_alive() and seen[-1].state == "succeeded"
        assert [one.fraction for one in seen] == sorted(one.fraction for one in seen)
        assert job.wait(timeout=120).numpy().shape == (240, 320, 3)
        assert job.view["stats"]["tiles_recovered"] >= 1
    finally:
        service.stop()
    with pytest.raises(strahl.Unreachable):
        Client(service.url, retries=0).version()


def test_keys(tmp_path):
    keys = tmp_path / "keys.toml"

    def new(tenant, scopes):
        command = [BINARY, "key", "new", "--tenant", tenant, "--scopes", scopes, "--file", keys]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    key, reader = new("acme", "render,jobs,read"), new("acme", "read")
    service = Service("--keys", keys)
    try:
        with Client(service.url, key=key) as client:
            job = client.jobs.submit(SCENE)
            prefix = client.capability(job_id=job.id, ttl=60)["prefix"]
            job.wait(timeout=120)
            assert httpx.get(f"{service.url}{prefix}/v1/jobs/{job.id}").json()["state"] == "succeeded"
        for wrong in (None, "rk_wrong", "x" * 5_000):
            with pytest.raises(strahl.Unauthorized):
                Client(service.url, key=wrong).render(SCENE)
        with pytest.raises(strahl.Forbidden) as caught:
            Client(service.url, key=reader).render(SCENE)
        assert caught.value.document["scope"] == "render"
        assert Client(service.url, key=reader).jobs.get(job.id).state == "succeeded"
    finally:
        service.stop()


def answers(*responses, retries=3):
    """A client of a service that gives these answers, and the requests it got."""
    left, got = list(responses), []

    def answer(request):
        got.append(request)
        status, headers, body = left.pop(0)
        return httpx.Response(status, headers=headers, content=body)

    return Client("http://strahl.test", transport=httpx.MockTransport(answer), retries=retries), got


BUSY = (503, {"retry-after": "0", "content-type": "application/problem+json"}, b'{"type":"/problems/saturated","detail":"busy"}')
LIMITED = (429, {"retry-after": "0"}, b'{"type":"/problems/rate-limited","detail":"used up"}')
VERSION = (200, {}, b'{"name":"strahl"}')


def test_a_busy_service_is_asked_again_as_often_as_allowed():
    client, got = answers(BUSY, LIMITED, BUSY, VERSION)
    assert client.version()["name"] == "strahl" and len(got) == 4
    client, got = answers(BUSY, BUSY, BUSY, LIMITED)
    with pytest.raises(strahl.RateLimited) as caught:
        client.version()
    assert (len(got), caught.value.retry_after) == (4, 0)
    client, got = answers((503, {"retry-after": "1"}, b""), VERSION)
    started = time.monotonic()
    client.version()
    assert time.monotonic() - started >= 1


def test_the_same_key_goes_with_each_try_of_a_job():
    client, got = answers(BUSY, (202, {}, b'{"id":"a","state":"queued"}'))
    client.jobs.submit(SCENE)
    keys = {request.headers["idempotency-key"] for request in got}
    assert len(got) == 2 and len(keys) == 1


def test_a_service_that_is_silent_is_waited_for_as_long_as_the_client_says():
    with socket.create_server(("127.0.0.1", 0)) as silent, pytest.raises(strahl.Unreachable, match="timed out"):
        # Asked five times more, it would take half a minute.
        Client(f"http://127.0.0.1:{silent.getsockname()[1]}", timeout=0.2).version()


def test_what_is_no_answer_of_the_service_is_said_as_it_is():
    client, _ = answers((404, {"content-type": "text/html"}, b"<h1>nginx</h1>"))
    with pytest.raises(strahl.NotFound, match="404"):
        client.version()
    client, _ = answers(*[(200, {}, b"<html>not JSON")] * 2, retries=1)
    with pytest.raises(strahl.Damaged):
        client.version()
    client, got = answers((504, {}, b'{"type":"/problems/render-deadline","detail":"slow","suggest":"tiles"}'))
    with pytest.raises(strahl.TooSlow):
        client.render(SCENE)
    assert len(got) == 1, "what is too slow is not asked for again"
    damaged = (200, {"repr-digest": "sha-256=:AAAA:"}, b"picture")
    client, got = answers(*[damaged] * 2, retries=1)
    with pytest.raises(strahl.Damaged, match="SHA-256"):
        client.render(SCENE)
    hostile = {"errors": [None, {"pointer": 7, "detail": None}, {"line": "x"}], "type": None, "detail": ["x"], "more": "many"}
    client, _ = answers((422, {}, json.dumps(hostile).encode()))
    with pytest.raises(strahl.Problem) as caught:
        client.version()
    assert str(caught.value)


def test_thousands_of_events_come_in_any_pieces():
    lines = "".join(f"id: {n}\nevent: tile\ndata: {json.dumps({'seq': n, 'name': 'ü' * (n % 7)})}\n\n: beat\n\n" for n in range(5_000))
    text = ("retry: 2000\n\n" + lines).encode()
    for size in (1, 7, 4_096, len(text)):
        parser = Parser()
        events = [event for at in range(0, len(text), size) for event in parser.feed(text[at : at + size])]
        assert [event.data["seq"] for event in events] == list(range(5_000)), size
    with pytest.raises(strahl.Damaged):
        list(Parser().feed(b"x" * (2 << 20)))
    with pytest.raises(strahl.Damaged):
        list(Parser().feed(b"event: tile\ndata: {\n\n"))


def part(media_type, body):
    return b"--b\r\nContent-Type: %b\r\nContent-Length: %d\r\n\r\n%b\r\n" % (media_type, len(body), body)


def test_parts_of_a_picture_come_in_any_pieces():
    head = {"pass": 0, "scale": 8, "x": 0, "y": 0, "w": 8, "h": 8, "eta_ms": None, "final": False}
    picture = b"\r\n\r\n--b--" * 50
    answer = part(b"application/json", json.dumps(head).encode()) + part(b"image/png", picture)
    end = part(b"application/json", b'{"scale":1,"final":true}') + part(b"image/png", picture) + part(b"application/json", b'{"report":null}')
    for size in (1, 5, 100, 10_000):
        parts, text = Parts(), answer + end + b"--b--\r\n"
        passes = [told for at in range(0, len(text), size) for told in parts.feed(text[at : at + size])]
        assert [(told.scale, told.final, told.picture.content) for told in passes] == [(8, False, picture), (1, True, picture)]
    assert [told.scale for told in Parts().feed(answer + end[:-20])] == [8], "without its report the picture is not there"
    with pytest.raises(strahl.Busy):
        list(Parts().feed(answer + part(b"application/json", b'{"problem":{"status":503,"detail":"busy"}}')))
    for broken in (b"x" * 5_000, part(b"application/json", b"{"), b"--b\r\nContent-Length: -1\r\n\r\n", part(b"application/json", b'{"report":{}}')):
        with pytest.raises(strahl.Damaged):
            list(Parts().feed(broken))


def test_a_huge_scene_is_refused_or_rendered(service):
    client = Client(service.url)
    balls = [{"sphere": {"center": [i % 100, i // 100, -50], "radius": 0.4}} for i in range(20_000)]
    assert client.render({**SCENE, "objects": balls}).numpy().shape == (32, 48, 3)
    with pytest.raises(strahl.TooLarge):
        client.render(b'{"version": 1, "name": "' + b"x" * (70 << 20) + b'"}')
