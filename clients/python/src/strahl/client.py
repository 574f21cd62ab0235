"""The blocking client. `generate.py` makes this file of `aio.py`."""

from __future__ import annotations

import hashlib
import math
import os
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar, Unpack

import httpx

from . import calls, contract
from .calls import Call, ImageLike, PictureOptions, RenderOptions, SceneLike, Settings
from .events import SILENCE, Event, Follower, Meter, Progress, progress_of
from .parts import Finer, Parts, Pass
from .picture import Picture, check_digest
from .problems import InvalidArgument, Problem, Unreachable, failure_of
from .retry import FAILURES, Backoff, give_up

T = TypeVar("T")


class Client:
    """A service. Without `url` and `key`, STRAHL_URL and STRAHL_KEY say which.

    Requests to a service that is busy (429, 503) or away are sent again, up to `retries` times, when `Retry-After` says.
    `timeout` is in seconds, for each request, and `math.inf` is no limit. A stream is asked for again if it is silent so long.
    """

    def __init__(self, url: str | None = None, *, key: str | None = None, timeout: float = 60.0, retries: int = 5,
                 transport: httpx.BaseTransport | None = None) -> None:
        self.retries = retries
        self._timeout = calls.limit_of(timeout)
        self._http = httpx.Client(base_url=calls.base_of(url), headers=calls.key_of(key), timeout=self._timeout, transport=transport)
        self.jobs = Jobs(self)
        self.assets = Assets(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Closes all connections."""
        self._http.close()

    def render(self, scene: SceneLike, /, **options: Unpack[RenderOptions]) -> Picture:
        """The picture of a scene."""
        return self._do(calls.render(scene, options))

    def turntable(self, scene: SceneLike, /, count: int = 36, *, format: calls.Animation = "png",
                        sheet: tuple[int, int] | None = None, **settings: Unpack[Settings]) -> Picture:
        """Pictures from all around a scene or a model, as an animation, or on a sheet of columns and rows."""
        while (picture := self._do(calls.turntable(scene, count, format, sheet, settings))) is None:
            # It goes on as a job, which the same request finds again.
            time.sleep(1)
        return picture

    def tile(self, scene: SceneLike, /, region: Sequence[int], **options: Unpack[RenderOptions]) -> Picture:
        """A region `(x, y, width, height)` of the picture: the same bytes as in the whole."""
        return self._do(calls.tile(scene, region, options))

    def stream(self, scene: SceneLike, /, **options: Unpack[PictureOptions]) -> Iterator[Pass]:
        """The picture from coarse to fine; the last pass is the picture itself. Who stops listening cancels the render."""
        call, backoff, finer = calls.streamed(scene, options), Backoff(self.retries), Finer()
        while True:
            answered = False
            try:
                headers = {**call.headers, "Accept": "multipart/mixed"}
                with self._stream("POST", call.path, headers, self._timeout, call.query, call.body) as response:
                    parts, answered = Parts(), True
                    for chunk in response.iter_bytes():
                        for told in parts.feed(chunk):
                            if finer.take(told):
                                yield told
                error: Exception = finer.torn()
            except FAILURES as broken:
                error = broken
            if finer.over:
                return
            # Who gives a time wants to wait no longer than that for an answer; one that falls silent is torn.
            late = isinstance(error, httpx.TimeoutException) and not answered
            if (seconds := None if late else backoff.next(error)) is None:
                give_up(error, self._http.base_url)
            time.sleep(seconds)

    def explain(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> contract.Plan:
        """The plan: effects, why, and what they should cost."""
        return self._do(calls.explain(scene, settings))

    def explain_each(self, scene: SceneLike, settings: Sequence[Settings]) -> contract.SettingsEstimates:
        """The plan, and what the picture should cost with each of up to 32 settings."""
        return self._do(calls.explain_each(scene, settings))

    def analyze(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> contract.Analyzed:
        """The plan, and what the picture cost."""
        return self._do(calls.analyze(scene, settings))

    def compare(self, a: ImageLike, b: ImageLike) -> contract.PictureDifference:
        """How far b is from a, in codes and as people see it. Each is an image id, a scene, or a scene with settings."""
        return self._do(calls.compare(a, b))

    def difference(self, a: ImageLike, b: ImageLike, *, format: str = "png", gain: int | None = None) -> Picture:
        """A picture of how far b is from a: `png` (codes times `gain`), `pfm` (light of b less that of a), `flip`."""
        return self._do(calls.difference(a, b, format, gain))

    def tradeoff(self, scene: SceneLike, /, *, seconds: float | None = None, **settings: Unpack[Settings]) -> contract.Tradeoff:
        """What accuracy costs, measured in so many seconds."""
        return self._do(calls.tradeoff(scene, seconds, settings))

    def validate(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> list[contract.SceneProblem]:
        """Warnings about a scene. One with mistakes raises `InvalidScene`, which has all of them."""
        return self._do(calls.validate(scene, settings))

    def map(self, scene: SceneLike, /, of: str, *, format: str = "pfm", step: int | None = None,
            **settings: Unpack[Settings]) -> Picture:
        """A map of the picture: `proved`, `rays`, `time`, `depth`, `samples` of each pixel."""
        return self._do(calls.map_of(scene, of, format, step, settings))

    def tree(self, scene: SceneLike, /, x: int, y: int, *, all_samples: bool = False,
             **settings: Unpack[Settings]) -> contract.RayTree:
        """The rays behind a pixel."""
        return self._do(calls.tree(scene, x, y, all_samples, settings))

    def rays(self, scene: SceneLike, /, queries: Iterable[contract.RayQuery],
             **settings: Unpack[Settings]) -> list[contract.RayAnswer]:
        """What rays hit."""
        return self._do(calls.rays(scene, queries, settings))

    def add_scene(self, scene: SceneLike, /, *, zoom: int | None = None, **settings: Unpack[Settings]) -> contract.KnownScene:
        """Stores a scene. The answer has its ids, and the addresses of its picture and tiles."""
        return self._do(calls.add_scene(scene, zoom, settings))

    def image(self, image_id: str, *, format: calls.Format = "png", bits: int | None = None, quality: int | None = None) -> Picture:
        """The picture of an image id."""
        return self._do(calls.image(image_id, format, {"bits": bits, "quality": quality}))

    def capability(self, *, job_id: str | None = None, image_id: str | None = None, scene_id: str | None = None,
                   ttl: int | None = None) -> contract.Capability:
        """A prefix of paths with which pages can read one job, picture or scene without a key."""
        return self._do(calls.capability(job_id, image_id, scene_id, ttl))

    def source(self, scene_id: str) -> str:
        """The text of a stored scene as you have sent it."""
        return self._do(calls.source(scene_id))

    def me(self) -> contract.KeyInfo:
        """Whose key it is, what it may do, and what is left of its limits."""
        return self._do(calls.get("/v1/me", contract.KeyInfo))

    def queue(self) -> contract.QueueStatus:
        """Who has the renderer and waits for it."""
        return self._do(calls.get("/v1/queue", contract.QueueStatus))

    def limits(self) -> contract.AllLimits:
        """What a request may ask for."""
        return self._do(calls.get("/v1/limits", contract.AllLimits))

    def version(self) -> contract.Version:
        """The service's version."""
        return self._do(calls.get("/v1/version", contract.Version))

    def _do(self, call: Call[T], end: float = math.inf) -> T:
        """Asks, again if the service is busy or away, and reads the answer. Raises `TimeoutError` at the time `end`."""
        backoff = Backoff(self.retries, following=call.following)
        while (left := end - time.monotonic()) > 0:
            try:
                return call.read(self._send(call, left))
            except FAILURES as error:
                if (left := end - time.monotonic()) <= 0:
                    break
                repeatable = call.repeatable or isinstance(error, (Problem, httpx.ConnectError))
                # Who gives a time wants to wait no longer than that.
                seconds = backoff.next(error) if repeatable and not isinstance(error, httpx.TimeoutException) else None
                if seconds is None:
                    give_up(error, self._http.base_url)
            time.sleep(min(seconds, left))
        raise TimeoutError

    def _send(self, call: Call[T], left: float) -> httpx.Response:
        limit, content = min(self._timeout + call.patience, left), bytearray()
        until = time.monotonic() + limit
        stream = self._http.stream(call.method, call.path, params=call.query or None, headers=call.headers, content=call.body, timeout=limit)
        with stream as begun:
            # httpx limits the wait for each piece, and there is no end of small pieces.
            for piece in begun.iter_bytes():
                content += piece
                if time.monotonic() > until:
                    raise httpx.ReadTimeout("timed out: the answer has no end")
        # The content is unpacked already.
        headers = {name: value for name, value in begun.headers.items() if name != "content-encoding"}
        response = httpx.Response(begun.status_code, headers=headers, content=bytes(content))
        calls.check(response)
        return response

    @contextmanager
    def _stream(self, method: str, path: str, headers: Mapping[str, str], read: float, query: Mapping[str, str] | None = None,
                      body: bytes | None = None) -> Iterator[httpx.Response]:
        timeout = httpx.Timeout(self._timeout, read=read)
        stream = self._http.stream(method, path, params=query, headers=headers, content=body, timeout=timeout)
        with stream as response:
            if not response.is_success:
                response.read()
            # An answer of 204 has no type.
            calls.check(response, None if response.status_code == 204 else headers.get("Accept"))
            yield response

    def _follow(self, path: str, follower: Follower, query: Mapping[str, str] | None = None) -> Iterator[Event]:
        """The events of a stream, which goes on after the last one if it breaks, until the service has no more (204)."""
        while True:
            error: Exception = Unreachable("the stream of events ends too soon")
            try:
                with self._stream("GET", path, follower.headers(), SILENCE, query) as response:
                    if response.status_code == 204:
                        return
                    follower.opened()
                    for part in response.iter_bytes():
                        for event in follower.feed(part):
                            yield event
            except FAILURES as broken:
                error = broken
            if follower.over:
                return
            time.sleep(follower.next(error, self._http.base_url))


class Assets:
    """Files that scenes name by their SHA-256, models and pictures: `client.assets`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def add(self, content: bytes | Path, /) -> str:
        """Sends a file unless the service has it from you; its name in scenes: `sha256:` and digits."""
        content = calls.asset_bytes(content)
        name = calls.asset_name(content)
        if self.missing([name]):
            self._client._do(calls.send_asset(content))
        return name

    def missing(self, names: Iterable[str]) -> list[str]:
        """Those that you have yet to send, by their digits."""
        return self._client._do(calls.missing_assets(names))

    def delete(self, name: str) -> None:
        """Forgets one. Scenes that name it are refused then."""
        self._client._do(calls.delete_asset(name))


class Jobs:
    """The jobs of a service: `client.jobs`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def submit(self, scene: SceneLike, /, *, priority: int | None = None, labels: Sequence[str] = (),
               webhook: str | None = None, store: str | bool = False,
               idempotency_key: str | None = None, wait: int | None = None, frames: contract.Sequence | None = None,
               **options: Unpack[PictureOptions]) -> Job:
        """Submits a job. The same `idempotency_key` with the same request gives the same job. After its end, `webhook` is a URL
        that hears of it, and `store` the name of its picture in the service's store, or True for a name of its own. `frames` makes
        a sequence of it, such as `{"count": 36, "turntable": {}}`."""
        view = self._client._do(
            calls.submit(scene, options, priority, labels, webhook, store, idempotency_key, wait, frames))
        return Job(self._client, view)

    def get(self, job_id: str) -> Job:
        """The job of an id."""
        return Job(self._client, self._client._do(calls.job(job_id)))

    def list(self, *, state: str | None = None, label: str | None = None) -> Iterator[Job]:
        """All jobs of the tenant, the newest first."""
        cursor = None
        while True:
            page = self._client._do(calls.jobs(state, label, None, cursor))
            for view in page["jobs"]:
                yield Job(self._client, view)
            if (cursor := page["next"]) is None:
                return

    def events(self, *, label: str | None = None) -> Iterator[Event]:
        """What happens to all jobs of the tenant, with `created` and `removed` as they come and go, without an end.

        First comes a snapshot of each job that has not ended, also when the stream begins again after it broke: it cannot be
        continued.
        """
        follower = Follower(retries=self._client.retries, endless=True)
        return self._client._follow("/v1/events", follower, calls.query_of({"label": label}))


class Job:
    """A job. `view` is what the service last said about it."""

    def __init__(self, client: Client, view: contract.JobView) -> None:
        self._client = client
        self.view = view

    @property
    def id(self) -> str:
        return self.view["id"]

    @property
    def state(self) -> str:
        return self.view["state"]

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.state}>"

    def refresh(self, *, wait: int | None = None) -> Self:
        """Asks for it again; `wait` seconds at most for its end."""
        self.view = self._client._do(calls.job(self.id, wait))
        return self

    def events(self, since: str = "") -> Iterator[Event]:
        """What happens to it, until it has ended. A stream that breaks goes on after the last event."""
        return self._client._follow(f"/v1/jobs/{self.id}/events", Follower(since, self._client.retries))

    def progress(self) -> Iterator[Progress]:
        """How far it is, until it has ended."""
        meter = Meter()
        for event in self.events():
            if (progress := meter.take(event)) is not None:
                yield progress

    def wait(self, *, timeout: float | None = None, on_progress: Callable[[Progress], object] | None = None) -> Picture:
        """Waits for its end; its picture. Raises `JobFailed`, and `TimeoutError` if it goes on after so many seconds.

        `on_progress` is told each second how far it is; `progress` tells it at once.
        """
        if timeout is not None and math.isnan(timeout):
            raise InvalidArgument("timeout must be a number of seconds")
        end = math.inf if timeout is None else time.monotonic() + timeout
        while self.state in {"queued", "running"}:
            # So that an answer comes in time.
            patience = 1 if on_progress else max(1, int(min(20, end - time.monotonic())))
            try:
                self.view = self._client._do(calls.job(self.id, patience), end)
            except TimeoutError:
                raise TimeoutError(f"job {self.id} is {self.state} after {timeout} seconds") from None
            if on_progress:
                on_progress(progress_of(self.view))
        return self.result()

    def result(self) -> Picture:
        """Its picture, if it has succeeded."""
        if self.state in {"failed", "canceled"}:
            raise failure_of(self.view)
        return self._client._do(calls.job_result(self.id))

    def download(self, path: str | os.PathLike[str]) -> None:
        """Writes its picture to a file, without keeping it in memory. The file is there only if it is whole."""
        # Of its own: two downloads to one file do not mix.
        part = f"{os.fspath(path)}.{uuid.uuid4().hex[:8]}.part"
        backoff = Backoff(self._client.retries, following=True)
        try:
            while True:
                digest, answered = hashlib.sha256(), False
                try:
                    with self._client._stream("GET", f"/v1/jobs/{self.id}/image", {}, self._client._timeout) as response:
                        calls.check_picture(response)
                        answered = True
                        with open(part, "wb") as file:
                            for chunk in response.iter_bytes():
                                file.write(chunk)
                                digest.update(chunk)
                        check_digest(digest.digest(), response.headers)
                    return os.replace(part, path)
                except FAILURES as error:
                    late = isinstance(error, httpx.TimeoutException) and not answered
                    if (seconds := None if late else backoff.next(error)) is None:
                        give_up(error, self._client._http.base_url)
                time.sleep(seconds)
        finally:
            # Also if it is cancelled, or the disk is full.
            with suppress(FileNotFoundError):
                os.remove(part)

    def frames(self) -> contract.FrameList:
        """The finished frames of a sequence, with what each cost and how far it may be off."""
        return self._client._do(calls.job_frames(self.id))

    def frame(self, number: int) -> Picture:
        """A frame of a sequence, from 0, as soon as it is finished."""
        return self._client._do(calls.job_picture(self.id, f"frames/{number:d}"))

    def animation(self, format: calls.Animation = "png") -> Picture:
        """All frames of a sequence that has succeeded."""
        return self._client._do(calls.job_picture(self.id, "animation", {"format": format}))

    def sheet(self, columns: int | None = None) -> Picture:
        """The finished frames of a sequence, small and side by side."""
        return self._client._do(calls.job_picture(self.id, "sheet", {"columns": columns}))

    def preview(self) -> Picture:
        """The picture so far, at most 1,024 pixels a side; waits for the first coarse one."""
        return self._client._do(calls.job_picture(self.id, "preview"))

    def tile(self, region: Sequence[int]) -> Picture:
        """A region `(x, y, width, height)` as soon as it is finished; it is rendered next."""
        query = dict(zip("xywh", region, strict=True))
        return self._client._do(calls.job_picture(self.id, "tile", query))

    def cancel(self) -> Self:
        """Stops it. One that has ended already raises `Conflict`."""
        self.view = self._client._do(calls.cancel(self.id))
        return self

    def prioritize(self, priority: int) -> Self:
        """Changes its priority, 0 to 100."""
        self.view = self._client._do(calls.prioritize(self.id, priority, None))
        return self

    def delete(self) -> None:
        """Forgets it and its picture."""
        self._client._do(calls.delete(self.id))

