"""Cut connections, a service that is killed, wrong keys, busy services, thousands of events."""

import asyncio
import contextlib
import json
import math
import signal
import socket
import subprocess
import threading
import time
import traceback

import httpx
import pytest
from conftest import BINARY, SCENE, Service, busy_scene

import strahl
from strahl import AsyncClient, Client
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


def test_a_key_that_is_still_being_accepted_is_sent_again_and_no_other_conflict():
    pending = (409, {"retry-after": "0"}, b'{"type":"/problems/conflict","detail":"still being accepted"}')
    client, got = answers(pending, pending, (202, {}, b'{"id":"a","state":"queued"}'))
    assert client.jobs.submit(SCENE).id == "a" and len(got) == 3
    for other in (409, {}, b'{"type":"/problems/conflict"}'), (409, {"retry-after": "0"}, b'{"type":"/problems/job-not-finished"}'):
        client, got = answers(other)
        with pytest.raises(strahl.Problem):
            client.version()
        assert len(got) == 1


def test_the_same_key_goes_with_each_try_of_a_job():
    client, got = answers(BUSY, (202, {}, b'{"id":"a","state":"queued"}'))
    client.jobs.submit(SCENE)
    keys = {request.headers["idempotency-key"] for request in got}
    assert len(got) == 2 and len(keys) == 1


def test_a_service_that_is_silent_is_waited_for_as_long_as_the_client_says():
    with socket.create_server(("127.0.0.1", 0)) as silent, pytest.raises(strahl.Unreachable, match="timed out"):
        # Asked five times more, it would take half a minute.
        Client(f"http://127.0.0.1:{silent.getsockname()[1]}", timeout=0.2).version()


def test_an_answer_in_small_pieces_takes_no_longer_than_the_client_says():
    def dribble(listener):
        connection, _ = listener.accept()
        with contextlib.suppress(OSError):
            connection.recv(65536)
            connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n")
            for _ in range(50):
                connection.sendall(b" ")
                time.sleep(0.1)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=dribble, args=(listener,), daemon=True).start()
        started = time.monotonic()
        with pytest.raises(strahl.Unreachable, match="timed out"):
            Client(f"http://127.0.0.1:{listener.getsockname()[1]}", timeout=0.5).version()
        assert time.monotonic() - started < 2


@pytest.mark.parametrize("kind", [httpx.ConnectTimeout, httpx.WriteTimeout, httpx.PoolTimeout])
def test_a_time_that_is_over_is_over_for_each_part_of_a_request(kind, tmp_path):
    got = []

    def late(request):
        got.append(request)
        raise kind("timed out")

    client = Client("http://strahl.test", transport=httpx.MockTransport(late))
    job = strahl.Job(client, {"id": "a", "state": "succeeded"})
    asks = (client.version, lambda: list(client.stream(SCENE)), lambda: job.download(tmp_path / "a.png"))
    for number, ask in enumerate(asks, 1):
        with pytest.raises(strahl.Unreachable, match="timed out"):
            ask()
        assert len(got) == number


def test_a_wait_for_a_job_keeps_its_time():
    async def wait(client):
        async with client:
            await strahl.AsyncJob(client, {"id": "a", "state": "running"}).wait(timeout=0.5)

    def busy(_):
        return httpx.Response(503, headers={"retry-after": "30"})

    def waits(url, transport=None):
        yield lambda: strahl.Job(Client(url, transport=transport), {"id": "a", "state": "running"}).wait(timeout=0.5)
        yield lambda: asyncio.run(wait(AsyncClient(url, transport=transport)))

    def all_late(*some):
        for one in some:
            started = time.monotonic()
            with pytest.raises(TimeoutError, match=r"job a is running after 0\.5 seconds"):
                one()
            assert 0.5 <= time.monotonic() - started < 2

    with silent_after(b"", b"") as (url, _):
        all_late(*waits(url))
    all_late(*waits("http://strahl.test", httpx.MockTransport(busy)), *waits("http://127.0.0.1:1"))


def test_a_wait_that_ends_knows_how_far_the_job_is():
    def patient(request):
        time.sleep(int(request.headers["prefer"].removeprefix("wait=")))
        return httpx.Response(200, json={"id": "a", "state": "running"})

    job = strahl.Job(Client("http://strahl.test", transport=httpx.MockTransport(patient)), {"id": "a", "state": "queued"})
    with pytest.raises(TimeoutError, match=r"job a is running after 1\.5 seconds"):
        job.wait(timeout=1.5)


@contextlib.contextmanager
def silent_after(*beginnings):
    """A service that sends one of these on each connection, and then nothing; its URL, and how often it was asked."""
    asked, held = [], []

    def serve(listener):
        for beginning in beginnings:
            with contextlib.suppress(OSError):
                connection, _ = listener.accept()
                held.append(connection)
                asked.append(connection.recv(65536))
                connection.sendall(beginning)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=serve, args=(listener,), daemon=True).start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}", asked
    for connection in held:
        connection.close()


PARTS = b"HTTP/1.1 200 OK\r\nContent-Type: multipart/mixed; boundary=b\r\n\r\n"
COARSE = b'{"scale":8,"x":0,"y":0,"w":8,"h":8,"final":false}'


def test_a_stream_that_is_silent_is_waited_for_as_long_as_the_client_says():
    with silent_after(b"", b"") as (url, asked), pytest.raises(strahl.Unreachable, match="timed out"):
        list(Client(url, timeout=2, retries=1).stream(SCENE))
    assert len(asked) == 1, "who gives a time wants to wait no longer for an answer"
    coarse = PARTS + part(b"application/json", COARSE) + part(b"image/png", b"coarse")
    fine = PARTS + part(b"application/json", b'{"scale":1,"final":true}') + part(b"image/png", b"fine") + part(b"application/json", b'{"report":null}')
    with silent_after(coarse, fine) as (url, asked):
        assert [told.picture.content for told in Client(url, timeout=2, retries=1).stream(SCENE)] == [b"coarse", b"fine"]
    assert len(asked) == 2, "an answer that falls silent is asked for again"


@pytest.mark.parametrize("timeout", [0, -1, math.nan])
def test_a_timeout_that_is_none_is_refused(timeout):
    with pytest.raises(strahl.InvalidArgument, match="timeout"):
        Client(timeout=timeout)


def test_a_timeout_may_be_without_limit(service):
    client = Client(service.url, timeout=math.inf)
    assert client.version()["name"] == "strahl"
    assert client.jobs.submit(busy_scene("no limit")).wait(timeout=math.inf).content


IDLE = (200, {"content-type": "text/event-stream"}, b": ok\n\n")


def pauses_of(monkeypatch, *responses, retries=2):
    """The seconds that a client waits between connections to a stream, and what it ends with."""
    client, _ = answers(*responses, retries=retries)
    pauses = []
    monkeypatch.setattr("time.sleep", pauses.append)
    with pytest.raises(strahl.StrahlError) as caught:
        list(client.jobs.events())
    return pauses, caught.value


def test_an_idle_stream_that_is_cut_is_opened_again_and_again(monkeypatch):
    refused = (403, {}, b"{}")
    pauses, error = pauses_of(monkeypatch, *[IDLE] * 9, refused)
    assert isinstance(error, strahl.Forbidden) and len(pauses) == 9 and all(1 <= pause < 2 for pause in pauses), pauses
    for said in ("2500", "null", '"soon"'):
        shutdown = (*IDLE[:2], b'event: shutdown\ndata: {"retry_ms":%b}\n\n' % said.encode())
        pauses, _ = pauses_of(monkeypatch, shutdown, refused)
        assert pauses[0] == (2.5 if said == "2500" else 5), said
    for said, least in ((b"2500", 2.5), (b"0", 0.5), (b"9" * 400, 120), (b"soon", 1)):
        pauses, _ = pauses_of(monkeypatch, (*IDLE[:2], b"retry: " + said + b"\n\n"), refused)
        assert least <= pauses[0] < least + 0.5, said
    pauses, error = pauses_of(monkeypatch, IDLE, *[BUSY] * 2)
    assert isinstance(error, strahl.Busy) and len(pauses) == 2, "what does not answer is asked as often as allowed"
    pauses, error = pauses_of(monkeypatch, *[(*IDLE[:2], b"data: {\n\n")] * 3)
    assert isinstance(error, strahl.Damaged) and len(pauses) == 2, "what is damaged each time is asked for as often as allowed"


def test_no_error_shows_a_secret(monkeypatch):
    for key in ("se\ncret", "sec\u20acret", "sec\0ret", "s\u00e9cret"):
        with pytest.raises(strahl.InvalidArgument, match="key") as caught:
            Client("http://strahl.test", key=key)
        shown = "".join(traceback.format_exception(caught.value))
        assert key not in shown and repr(key)[1:-1] not in shown and "cret'" not in shown
    got = []
    transport = httpx.MockTransport(lambda request: got.append(request) or httpx.Response(200, content=VERSION[2]))
    monkeypatch.setenv("STRAHL_KEY", " secret\n")
    Client("http://strahl.test", transport=transport).version()
    assert got[0].headers["authorization"] == "Bearer secret"
    for url in ("http://me:secret@127.0.0.1:1/c/secret", "http://me:sec:secret@[::1"):
        with pytest.raises(strahl.StrahlError) as caught:
            Client(url, retries=0).version()
        assert "secret" not in str(caught.value)


def test_what_cannot_be_sent_is_said_at_once(service):
    client, started = Client(service.url), time.monotonic()
    with pytest.raises(strahl.InvalidArgument, match="idempotency key"):
        client.jobs.submit(SCENE, idempotency_key="a\nb")
    with pytest.raises(strahl.InvalidArgument, match="too long"):
        list(client.jobs.list(label="x" * 70_000))
    with pytest.raises(strahl.InvalidArgument, match="too long"):
        list(client.jobs.events(label="x" * 70_000))
    job = strahl.Job(client, {**client.jobs.submit(SCENE).view, "id": "a"})
    with pytest.raises(strahl.InvalidArgument):
        list(job.events("1\n2"))
    with pytest.raises(strahl.InvalidArgument, match="JSON"):
        client.render({**SCENE, "name": math.nan})
    with pytest.raises(strahl.InvalidArgument, match="UTF-8"):
        client.render('{"name":"\ud800"}')
    for url in ("127.0.0.1:8080", "localhost:8080", "ftp://a", "http://", "http://a:b"):
        with pytest.raises(strahl.InvalidArgument, match="http://127.0.0.1:8080"):
            Client(url)

    def refuse(request):
        raise httpx.LocalProtocolError("Illegal header value b'secret'")

    with pytest.raises(strahl.InvalidArgument) as caught:
        Client("http://strahl.test", transport=httpx.MockTransport(refuse)).version()
    assert "secret" not in "".join(traceback.format_exception(caught.value))
    assert time.monotonic() - started < 5, "nothing of this is tried again"


def test_what_only_renders_have_is_refused_before_it_is_sent():
    client, got = answers(retries=0)
    for ask in (lambda: client.jobs.submit(SCENE, layers="normal", format="exr"), lambda: list(client.stream(SCENE, layers="normal"))):
        with pytest.raises(strahl.InvalidArgument, match="has no layers"):
            ask()
    with pytest.raises(strahl.InvalidArgument, match="four numbers"):
        client.tile(SCENE, (0, 0, 9))
    with pytest.raises(strahl.InvalidArgument, match=r"\['night'\]"):
        client.jobs.submit(SCENE, labels="night")
    # `bytes` of a number would be so many zeros.
    for scene in (10**12, None, [], object()):
        with pytest.raises(strahl.InvalidArgument, match="a scene is"):
            client.render(scene)
    assert not got


def test_json_of_something_else_is_damaged():
    def asks(client):
        return [client.version, lambda: client.jobs.get("a"), lambda: list(client.jobs.list()), lambda: client.validate(SCENE),
                lambda: client.rays(SCENE, [])]

    for number in range(5):
        for body in (b"[]", b"null", b"5", *([b"{}"] if number > 1 else [])):
            with pytest.raises(strahl.Damaged, match="check that the URL"):
                asks(answers((200, {"content-type": "application/json"}, body), retries=0)[0])[number]()
    for head in (b"5", b"null", b"[]", b"{}", b'{"scale":1,"x":0,"final":false}'):
        with pytest.raises(strahl.Damaged):
            list(Parts().feed(part(b"application/json", head) + part(b"image/png", b"x")))
    for problem in (b"5", b'{"status":"x"}'):
        with pytest.raises(strahl.Problem):
            list(Parts().feed(part(b"application/json", b'{"problem":%b}' % problem)))


def test_a_download_that_ends_otherwise_leaves_nothing(tmp_path):
    class Cut(httpx.SyncByteStream):
        def __iter__(self):
            yield b"a part"
            raise KeyboardInterrupt

    answer = httpx.Response(200, headers={"content-type": "image/png"}, stream=Cut())
    client = Client("http://strahl.test", transport=httpx.MockTransport(lambda request: answer))
    with pytest.raises(KeyboardInterrupt):
        strahl.Job(client, {"id": "a", "state": "succeeded"}).download(tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_an_answer_that_cannot_be_unpacked_is_damaged(tmp_path):
    def asks(client):
        job = strahl.Job(client, {"id": "a", "state": "succeeded"})
        return [client.version, lambda: client.render(SCENE), lambda: list(client.stream(SCENE)), lambda: list(job.events()),
                lambda: list(client.jobs.events()), lambda: job.download(tmp_path / "a.png")]

    for number in range(6):
        kind = {2: "multipart/mixed", 3: "text/event-stream", 4: "text/event-stream", 5: "image/png"}.get(number, "application/json")

        def answer(request, kind=kind):
            stream = httpx.ByteStream(b"no gzip")
            return httpx.Response(200, headers={"content-encoding": "gzip", "content-type": kind}, stream=stream)

        with pytest.raises(strahl.Damaged, match="unpacked"):
            asks(Client("http://strahl.test", transport=httpx.MockTransport(answer), retries=0))[number]()
    assert not list(tmp_path.iterdir())


def test_a_page_is_no_answer_of_the_service():
    page = (200, {"content-type": "text/html; charset=utf-8"}, b"<html>")
    for ask in (lambda client: client.version(), lambda client: client.render(SCENE), lambda client: list(client.stream(SCENE)),
                lambda client: client.jobs.get("a"), lambda client: list(client.jobs.list()), lambda client: list(client.jobs.events()),
                lambda client: client.source("a"), lambda client: client.jobs.submit(SCENE)):
        client, _ = answers(page, retries=0)
        with pytest.raises(strahl.Damaged, match="text/html.* check that the URL is that of the service"):
            ask(client)
    for ask in (lambda client: list(client.stream(SCENE)), lambda client: list(client.jobs.events())):
        client, got = answers(*[(200, {"content-type": "text/plain"}, b"OK")] * 2, retries=1)
        with pytest.raises(strahl.Damaged, match="text/plain"):
            ask(client)
        assert len(got) == 2


def test_what_is_no_picture_is_damaged(tmp_path):
    def asks(client):
        job = strahl.Job(client, {"id": "a", "state": "succeeded"})
        return [lambda: client.render(SCENE), lambda: client.tile(SCENE, (0, 0, 1, 1)), lambda: client.turntable(SCENE, 2), job.wait,
                lambda: client.image("i_a"), lambda: job.download(tmp_path / "a.png")]

    said = [(200, "text/plain", b"OK"), (200, "application/json", b"{}"), (200, "application/xml", b"<a/>"), (200, "image/png", b""), (204, "", b"")]
    for status, kind, body in said:
        for number in range(6):
            client, _ = answers((status, {"content-type": kind} if kind else {}, body), retries=0)
            with pytest.raises(strahl.Damaged, match="picture.* check that the URL is that of the service"):
                asks(client)[number]()
    assert not list(tmp_path.iterdir())
    for kind in ("image/x-exr", "Image/PNG; a=b"):
        assert answers((200, {"content-type": kind}, b"x"))[0].render(SCENE).content == b"x"


STREAM = {"content-type": "text/event-stream"}
RUNNING = (200, {}, b'{"id":"a","state":"running"}')
DONE = (200, {}, b'{"id":"a","state":"succeeded"}')


@pytest.mark.parametrize("status", [500, 502, 504, 522])
def test_a_job_is_followed_although_a_gateway_cannot_reach_the_service(status, monkeypatch):
    monkeypatch.setattr("time.sleep", lambda _: None)
    gateway = (status, {"content-type": "text/html"}, b"<h1>gateway</h1>")
    began = (200, STREAM, b'id: 1\nevent: snapshot\ndata: {"state":"running","tiles_total":2}\n\n')
    ended = (200, STREAM, b"id: 2\nevent: succeeded\ndata: {}\n\n")
    client, got = answers(began, gateway, gateway, ended)
    assert [one.state for one in strahl.Job(client, {"id": "a"}).progress()] == ["running", "succeeded"]
    assert [request.headers.get("last-event-id") for request in got] == [None, "1", "1", "1"]
    client, got = answers(gateway, RUNNING, gateway, DONE, gateway, (200, {"content-type": "image/png"}, b"x"))
    assert strahl.Job(client, {"id": "a", "state": "running"}).wait().content == b"x" and len(got) == 6
    for ask in (lambda job: list(job.progress()), lambda job: job.wait()):
        client, got = answers(*[gateway] * 4)
        with pytest.raises(strahl.Problem, match=str(status)):
            ask(strahl.Job(client, {"id": "a", "state": "running"}))
        assert len(got) == 4, "it is asked as often as allowed"
        if status != 502:
            client, got = answers((status, {"content-type": "application/problem+json"}, b'{"type":"/problems/internal"}'))
            with pytest.raises(strahl.Problem):
                ask(strahl.Job(client, {"id": "a", "state": "running"}))
            assert len(got) == 1, "what the service says is so"


def test_pointers_are_decoded_as_far_as_they_can_be():
    for said, pointer in (("#/a%20b/%C3%BC~1", "/a b/\u00fc~1"), ("/a%20b", "/a%20b"), ("#/a%zz%C", "/a%zz%C"), ("#/%FF%C3", "/\ufffd\ufffd"), ("#", "")):
        client, _ = answers((422, {}, json.dumps({"errors": [{"pointer": said}]}).encode()))
        with pytest.raises(strahl.Problem) as caught:
            client.version()
        assert caught.value.mistakes[0].pointer == pointer


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
    damaged = (200, {"content-type": "image/png", "repr-digest": "sha-256=:AAAA:"}, b"picture")
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
