"""The asynchronous client. `generate.py` makes `client.py`, the blocking one, of this file."""

from __future__ import annotations

import hashlib
import math
import os
import time
import uuid
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar, Unpack

import anyio
import httpx

from . import calls, contract
from .calls import Call, ImageLike, PictureOptions, RenderOptions, SceneLike, Settings
from .events import SILENCE, Event, Follower, Meter, Progress, progress_of
from .parts import Finer, Parts, Pass
from .picture import Picture, check_digest
from .problems import InvalidArgument, Problem, Unreachable, failure_of
from .retry import FAILURES, Backoff, give_up

T = TypeVar("T")


class AsyncClient:
    """A service. Without `url` and `key`, STRAHL_URL and STRAHL_KEY say which.

    Requests to a service that is busy (429, 503) or away are sent again, up to `retries` times, when `Retry-After` says.
    `timeout` is in seconds, for each request, and `math.inf` is no limit. A stream is asked for again if it is silent so long.
    """

    def __init__(self, url: str | None = None, *, key: str | None = None, timeout: float = 60.0, retries: int = 5,
                 transport: httpx.AsyncBaseTransport | None = None) -> None:
        self.retries = retries
        self._timeout = calls.limit_of(timeout)
        self._http = httpx.AsyncClient(base_url=calls.base_of(url), headers=calls.key_of(key), timeout=self._timeout, transport=transport)
        self.jobs = AsyncJobs(self)
        self.assets = AsyncAssets(self)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        await self.close()

    async def close(self) -> None:
        """Closes all connections."""
        await self._http.aclose()

    async def render(self, scene: SceneLike, /, **options: Unpack[RenderOptions]) -> Picture:
        """The picture of a scene."""
        return await self._do(calls.render(scene, options))

    async def turntable(self, scene: SceneLike, /, count: int = 36, *, format: calls.Animation = "png",
                        sheet: tuple[int, int] | None = None, **settings: Unpack[Settings]) -> Picture:
        """Pictures from all around a scene or a model, as an animation, or on a sheet of columns and rows."""
        while (picture := await self._do(calls.turntable(scene, count, format, sheet, settings))) is None:
            # It goes on as a job, which the same request finds again.
            await anyio.sleep(1)
        return picture

    async def tile(self, scene: SceneLike, /, region: Sequence[int], **options: Unpack[RenderOptions]) -> Picture:
        """A region `(x, y, width, height)` of the picture: the same bytes as in the whole."""
        return await self._do(calls.tile(scene, region, options))

    async def stream(self, scene: SceneLike, /, **options: Unpack[PictureOptions]) -> AsyncIterator[Pass]:
        """The picture from coarse to fine; the last pass is the picture itself. Who stops listening cancels the render."""
        call, backoff, finer = calls.streamed(scene, options), Backoff(self.retries), Finer()
        while True:
            answered = False
            try:
                headers = {**call.headers, "Accept": "multipart/mixed"}
                async with self._stream("POST", call.path, headers, self._timeout, call.query, call.body) as response:
                    parts, answered = Parts(), True
                    async for chunk in response.aiter_bytes():
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
            await anyio.sleep(seconds)

    async def explain(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> contract.Plan:
        """The plan: effects, why, and what they should cost."""
        return await self._do(calls.explain(scene, settings))

    async def explain_each(self, scene: SceneLike, settings: Sequence[Settings]) -> contract.SettingsEstimates:
        """The plan, and what the picture should cost with each of up to 32 settings."""
        return await self._do(calls.explain_each(scene, settings))

    async def analyze(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> contract.Analyzed:
        """The plan, and what the picture cost."""
        return await self._do(calls.analyze(scene, settings))

    async def compare(self, a: ImageLike, b: ImageLike) -> contract.PictureDifference:
        """How far b is from a, in codes and as people see it. Each is an image id, a scene, or a scene with settings."""
        return await self._do(calls.compare(a, b))

    async def difference(self, a: ImageLike, b: ImageLike, *, format: str = "png", gain: int | None = None) -> Picture:
        """A picture of how far b is from a: `png` (codes times `gain`), `pfm` (light of b less that of a), `flip`."""
        return await self._do(calls.difference(a, b, format, gain))

    async def tradeoff(self, scene: SceneLike, /, *, seconds: float | None = None, **settings: Unpack[Settings]) -> contract.Tradeoff:
        """What accuracy costs, measured in so many seconds."""
        return await self._do(calls.tradeoff(scene, seconds, settings))

    async def validate(self, scene: SceneLike, /, **settings: Unpack[Settings]) -> list[contract.SceneProblem]:
        """Warnings about a scene. One with mistakes raises `InvalidScene`, which has all of them."""
        return await self._do(calls.validate(scene, settings))

    async def map(self, scene: SceneLike, /, of: str, *, format: str = "pfm", step: int | None = None,
            **settings: Unpack[Settings]) -> Picture:
        """A map of the picture: `proved`, `rays`, `time`, `depth`, `samples` of each pixel."""
        return await self._do(calls.map_of(scene, of, format, step, settings))

    async def tree(self, scene: SceneLike, /, x: int, y: int, *, all_samples: bool = False,
             **settings: Unpack[Settings]) -> contract.RayTree:
        """The rays behind a pixel."""
        return await self._do(calls.tree(scene, x, y, all_samples, settings))

    async def rays(self, scene: SceneLike, /, queries: Iterable[contract.RayQuery],
             **settings: Unpack[Settings]) -> list[contract.RayAnswer]:
        """What rays hit."""
        return await self._do(calls.rays(scene, queries, settings))

    async def add_scene(self, scene: SceneLike, /, *, zoom: int | None = None, **settings: Unpack[Settings]) -> contract.KnownScene:
        """Stores a scene. The answer has its ids, and the addresses of its picture and tiles."""
        return await self._do(calls.add_scene(scene, zoom, settings))

    async def image(self, image_id: str, *, format: calls.Format = "png", bits: int | None = None, quality: int | None = None) -> Picture:
        """The picture of an image id."""
        return await self._do(calls.image(image_id, format, {"bits": bits, "quality": quality}))

    async def capability(self, *, job_id: str | None = None, image_id: str | None = None, scene_id: str | None = None,
                   ttl: int | None = None) -> contract.Capability:
        """A prefix of paths with which pages can read one job, picture or scene without a key."""
        return await self._do(calls.capability(job_id, image_id, scene_id, ttl))

    async def source(self, scene_id: str) -> str:
        """The text of a stored scene as you have sent it."""
        return await self._do(calls.source(scene_id))

    async def me(self) -> contract.KeyInfo:
        """Whose key it is, what it may do, and what is left of its limits."""
        return await self._do(calls.get("/v1/me", contract.KeyInfo))

    async def queue(self) -> contract.QueueStatus:
        """Who has the renderer and waits for it."""
        return await self._do(calls.get("/v1/queue", contract.QueueStatus))

    async def limits(self) -> contract.AllLimits:
        """What a request may ask for."""
        return await self._do(calls.get("/v1/limits", contract.AllLimits))

    async def version(self) -> contract.Version:
        """The service's version."""
        return await self._do(calls.get("/v1/version", contract.Version))

    async def _do(self, call: Call[T], end: float = math.inf) -> T:
        """Asks, again if the service is busy or away, and reads the answer. Raises `TimeoutError` at the time `end`."""
        backoff = Backoff(self.retries, following=call.following)
        while (left := end - time.monotonic()) > 0:
            try:
                return call.read(await self._send(call, left))
            except FAILURES as error:
                if (left := end - time.monotonic()) <= 0:
                    break
                repeatable = call.repeatable or isinstance(error, (Problem, httpx.ConnectError))
                # Who gives a time wants to wait no longer than that.
                seconds = backoff.next(error) if repeatable and not isinstance(error, httpx.TimeoutException) else None
                if seconds is None:
                    give_up(error, self._http.base_url)
            await anyio.sleep(min(seconds, left))
        raise TimeoutError

    async def _send(self, call: Call[T], left: float) -> httpx.Response:
        limit, content = min(self._timeout + call.patience, left), bytearray()
        until = time.monotonic() + limit
        stream = self._http.stream(call.method, call.path, params=call.query or None, headers=call.headers, content=call.body, timeout=limit)
        async with stream as begun:
            # httpx limits the wait for each piece, and there is no end of small pieces.
            async for piece in begun.aiter_bytes():
                content += piece
                if time.monotonic() > until:
                    raise httpx.ReadTimeout("timed out: the answer has no end")
        # The content is unpacked already.
        headers = {name: value for name, value in begun.headers.items() if name != "content-encoding"}
        response = httpx.Response(begun.status_code, headers=headers, content=bytes(content))
        calls.check(response)
        return response

    @asynccontextmanager
    async def _stream(self, method: str, path: str, headers: Mapping[str, str], read: float, query: Mapping[str, str] | None = None,
                      body: bytes | None = None) -> AsyncIterator[httpx.Response]:
        timeout = httpx.Timeout(self._timeout, read=read)
        stream = self._http.stream(method, path, params=query, headers=headers, content=body, timeout=timeout)
        async with stream as response:
            if not response.is_success:
                await response.aread()
            # An answer of 204 has no type.
            calls.check(response, None if response.status_code == 204 else headers.get("Accept"))
            yield response

    async def _follow(self, path: str, follower: Follower, query: Mapping[str, str] | None = None) -> AsyncIterator[Event]:
        """The events of a stream, which goes on after the last one if it breaks, until the service has no more (204)."""
        while True:
            error: Exception = Unreachable("the stream of events ends too soon")
            try:
                async with self._stream("GET", path, follower.headers(), SILENCE, query) as response:
                    if response.status_code == 204:
                        return
                    follower.opened()
                    async for part in response.aiter_bytes():
                        for event in follower.feed(part):
                            yield event
            except FAILURES as broken:
                error = broken
            if follower.over:
                return
            await anyio.sleep(follower.next(error, self._http.base_url))


class AsyncAssets:
    """Files that scenes name by their SHA-256, models and pictures: `client.assets`."""

    def __init__(self, client: AsyncClient) -> None:
        self._client = client

    async def add(self, content: bytes | Path, /) -> str:
        """Sends a file unless the service has it from you; its name in scenes: `sha256:` and digits."""
        content = calls.asset_bytes(content)
        name = calls.asset_name(content)
        if await self.missing([name]):
            await self._client._do(calls.send_asset(content))
        return name

    async def missing(self, names: Iterable[str]) -> list[str]:
        """Those that you have yet to send, by their digits."""
        return await self._client._do(calls.missing_assets(names))

    async def delete(self, name: str) -> None:
        """Forgets one. Scenes that name it are refused then."""
        await self._client._do(calls.delete_asset(name))


class AsyncJobs:
    """The jobs of a service: `client.jobs`."""

    def __init__(self, client: AsyncClient) -> None:
        self._client = client

    async def submit(self, scene: SceneLike, /, *, priority: int | None = None, labels: Sequence[str] = (),
               webhook: str | None = None, store: str | bool = False,
               idempotency_key: str | None = None, wait: int | None = None, frames: contract.Sequence | None = None,
               **options: Unpack[PictureOptions]) -> AsyncJob:
        """Submits a job. The same `idempotency_key` with the same request gives the same job. After its end, `webhook` is a URL
        that hears of it, and `store` the name of its picture in the service's store, or True for a name of its own. `frames` makes
        a sequence of it, such as `{"count": 36, "turntable": {}}`."""
        view = await self._client._do(
            calls.submit(scene, options, priority, labels, webhook, store, idempotency_key, wait, frames))
        return AsyncJob(self._client, view)

    async def get(self, job_id: str) -> AsyncJob:
        """The job of an id."""
        return AsyncJob(self._client, await self._client._do(calls.job(job_id)))

    async def list(self, *, state: str | None = None, label: str | None = None) -> AsyncIterator[AsyncJob]:
        """All jobs of the tenant, the newest first."""
        cursor = None
        while True:
            page = await self._client._do(calls.jobs(state, label, None, cursor))
            for view in page["jobs"]:
                yield AsyncJob(self._client, view)
            if (cursor := page["next"]) is None:
                return

    def events(self, *, label: str | None = None) -> AsyncIterator[Event]:
        """What happens to all jobs of the tenant, with `created` and `removed` as they come and go, without an end.

        First comes a snapshot of each job that has not ended, also when the stream begins again after it broke: it cannot be
        continued.
        """
        follower = Follower(retries=self._client.retries, endless=True)
        return self._client._follow("/v1/events", follower, calls.query_of({"label": label}))


class AsyncJob:
    """A job. `view` is what the service last said about it."""

    def __init__(self, client: AsyncClient, view: contract.JobView) -> None:
        self._client = client
        self.view = view

    @property
    def id(self) -> str:
        return self.view["id"]

    @property
    def state(self) -> str:
        return self.view["state"]

    def __repr__(self) -> str:
        return f"<AsyncJob {self.id} {self.state}>"

    async def refresh(self, *, wait: int | None = None) -> Self:
        """Asks for it again; `wait` seconds at most for its end."""
        self.view = await self._client._do(calls.job(self.id, wait))
        return self

    def events(self, since: str = "") -> AsyncIterator[Event]:
        """What happens to it, until it has ended. A stream that breaks goes on after the last event."""
        return self._client._follow(f"/v1/jobs/{self.id}/events", Follower(since, self._client.retries))

    async def progress(self) -> AsyncIterator[Progress]:
        """How far it is, until it has ended."""
        meter = Meter()
        async for event in self.events():
            if (progress := meter.take(event)) is not None:
                yield progress

    async def wait(self, *, timeout: float | None = None, on_progress: Callable[[Progress], object] | None = None) -> Picture:
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
                self.view = await self._client._do(calls.job(self.id, patience), end)
            except TimeoutError:
                raise TimeoutError(f"job {self.id} is {self.state} after {timeout} seconds") from None
            if on_progress:
                on_progress(progress_of(self.view))
        return await self.result()

    async def result(self) -> Picture:
        """Its picture, if it has succeeded."""
        if self.state in {"failed", "canceled"}:
            raise failure_of(self.view)
        return await self._client._do(calls.job_result(self.id))

    async def download(self, path: str | os.PathLike[str]) -> None:
        """Writes its picture to a file, without keeping it in memory. The file is there only if it is whole."""
        # Of its own: two downloads to one file do not mix.
        part = f"{os.fspath(path)}.{uuid.uuid4().hex[:8]}.part"
        backoff = Backoff(self._client.retries, following=True)
        try:
            while True:
                digest, answered = hashlib.sha256(), False
                try:
                    async with self._client._stream("GET", f"/v1/jobs/{self.id}/image", {}, self._client._timeout) as response:
                        calls.check_picture(response)
                        answered = True
                        with open(part, "wb") as file:
                            async for chunk in response.aiter_bytes():
                                file.write(chunk)
                                digest.update(chunk)
                        check_digest(digest.digest(), response.headers)
                    return os.replace(part, path)
                except FAILURES as error:
                    late = isinstance(error, httpx.TimeoutException) and not answered
                    if (seconds := None if late else backoff.next(error)) is None:
                        give_up(error, self._client._http.base_url)
                await anyio.sleep(seconds)
        finally:
            # Also if it is cancelled, or the disk is full.
            with suppress(FileNotFoundError):
                os.remove(part)

    async def frames(self) -> contract.FrameList:
        """The finished frames of a sequence, with what each cost and how far it may be off."""
        return await self._client._do(calls.job_frames(self.id))

    async def frame(self, number: int) -> Picture:
        """A frame of a sequence, from 0, as soon as it is finished."""
        return await self._client._do(calls.job_picture(self.id, f"frames/{number:d}"))

    async def animation(self, format: calls.Animation = "png") -> Picture:
        """All frames of a sequence that has succeeded."""
        return await self._client._do(calls.job_picture(self.id, "animation", {"format": format}))

    async def sheet(self, columns: int | None = None) -> Picture:
        """The finished frames of a sequence, small and side by side."""
        return await self._client._do(calls.job_picture(self.id, "sheet", {"columns": columns}))

    async def preview(self) -> Picture:
        """The picture so far, at most 1,024 pixels a side; waits for the first coarse one."""
        return await self._client._do(calls.job_picture(self.id, "preview"))

    async def tile(self, region: Sequence[int]) -> Picture:
        """A region `(x, y, width, height)` as soon as it is finished; it is rendered next."""
        query = dict(zip("xywh", region, strict=True))
        return await self._client._do(calls.job_picture(self.id, "tile", query))

    async def cancel(self) -> Self:
        """Stops it. One that has ended already raises `Conflict`."""
        self.view = await self._client._do(calls.cancel(self.id))
        return self

    async def prioritize(self, priority: int) -> Self:
        """Changes its priority, 0 to 100."""
        self.view = await self._client._do(calls.prioritize(self.id, priority, None))
        return self

    async def delete(self) -> None:
        """Forgets it and its picture."""
        await self._client._do(calls.delete(self.id))

