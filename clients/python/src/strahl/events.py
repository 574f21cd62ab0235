"""Server-Sent Events of jobs (WHATWG HTML, 9.2), and how a stream goes on after it broke."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import httpx

from . import contract
from .calls import header_value
from .problems import Damaged
from .retry import PATIENCE, Backoff, give_up, shown

#: Names of last events.
OVER = frozenset({"succeeded", "failed", "canceled"})
#: Seconds without a byte after which a stream is dead; the service sends a comment each 15 seconds.
SILENCE = 45.0
_MOST = 1 << 20
# Seconds before a stream is opened again: at least, and where it does not say how many.
_LEAST, _USUAL = 0.5, 1.0


@dataclass(frozen=True)
class Event:
    """What has happened to a job."""

    #: snapshot, queued, started, preview, tile, progress, succeeded, failed or canceled.
    name: str
    data: dict[str, Any]
    #: What continues the stream after it.
    id: str = ""

    @property
    def is_last(self) -> bool:
        return self.name in OVER


@dataclass(frozen=True)
class Progress:
    """How far a job is."""

    state: str
    #: From 0 to 1.
    fraction: float
    tiles_done: int
    tiles_total: int
    #: Milliseconds until the end, estimated.
    eta_ms: float | None = None


class Parser:
    """Takes bytes and gives events."""

    def __init__(self) -> None:
        self._rest = b""
        self._fields: dict[str, str] = {}
        #: Seconds before the stream is opened again, as it says.
        self.retry: float | None = None

    def feed(self, part: bytes) -> Iterator[Event]:
        *lines, self._rest = (self._rest + part).split(b"\n")
        if len(self._rest) > _MOST:
            raise Damaged("an event of the stream has no end")
        for raw in lines:
            line = raw.rstrip(b"\r").decode("utf-8", "replace")
            if line:
                field, _, value = line.partition(":")
                self._fields[field] = value = value.removeprefix(" ")
                if field == "retry" and value.isascii() and value.isdigit():
                    self.retry = float(value) / 1_000
                continue
            fields, self._fields = self._fields, {}
            if "data" in fields:
                try:
                    data = json.loads(fields["data"])
                except ValueError as error:
                    raise Damaged("an event of the stream is not JSON") from error
                if not isinstance(data, dict):
                    raise Damaged("an event of the stream is no object")
                yield Event(fields.get("event", "message"), data, fields.get("id", ""))


class Follower:
    """The state of a stream over its connections. One that is endless goes on after last events, for they are of one job each."""

    def __init__(self, since: str = "", retries: int = 5, *, endless: bool = False) -> None:
        self.last_id = header_value("the id of an event", since)
        self.over = False
        self._endless, self._retries, self._backoff = endless, retries, Backoff(retries, following=True)
        self._parser, self._answered = Parser(), False
        # Seconds to wait before each further connection, and before the next one, at least.
        self._usual = _USUAL
        self._pause: float | None = None

    def headers(self) -> dict[str, str]:
        return {"Accept": "text/event-stream", **({"Last-Event-ID": self.last_id} if self.last_id else {})}

    def opened(self) -> None:
        """Notes that the service has answered."""
        self._parser, self._answered = Parser(), True

    def feed(self, part: bytes) -> Iterator[Event]:
        """The events in some bytes that are for the caller."""
        for event in self._parser.feed(part):
            if event.name == "shutdown":
                said = event.data.get("retry_ms")
                self._pause = _bounded(said / 1_000 if isinstance(said, (int, float)) else 5.0)
                continue
            self.last_id = event.id or self.last_id
            self.over = event.is_last and not self._endless
            yield event
        if self._parser.retry is not None:
            self._usual = _bounded(self._parser.retry)

    def next(self, error: Exception, url: httpx.URL) -> float:
        """Seconds until the stream is opened again; raises if that is of no use."""
        # A stream that was answered is alive, also if nothing happened on it. What is damaged may be so each time.
        if self._answered and not isinstance(shown(error, url), Damaged):
            self._backoff = Backoff(self._retries, following=True)
        seconds, self._pause, self._answered = self._pause, None, False
        if seconds is None and (seconds := self._backoff.next(error)) is None:
            give_up(error, url)
        return max(seconds, self._usual)


def _bounded(seconds: float) -> float:
    """A pause that is not too short for the service, nor too long for who listens."""
    return min(max(seconds, _LEAST), PATIENCE)


class Meter:
    """Makes progress of events."""

    def __init__(self) -> None:
        self._state, self._done, self._total = "queued", 0, 0
        self._eta: float | None = None

    def take(self, event: Event) -> Progress | None:
        """The progress after an event; None if it says nothing about it."""
        data = event.data
        if event.name in {"preview", "shutdown"}:
            return None
        if event.name == "snapshot":
            self._state, self._total = data["state"], data["tiles_total"]
        elif event.name in OVER:
            self._state = event.name
        else:
            self._state = "queued" if event.name == "queued" else "running"
        # After a restart the service may know of fewer tiles than it had told.
        self._done = max(self._done, int(data.get("tiles_done", 0)))
        self._eta = data.get("eta_ms", self._eta)
        if event.name == "succeeded":
            self._done = self._total
        fraction = 1.0 if event.name == "succeeded" else self._done / self._total if self._total else 0.0
        return Progress(self._state, fraction, self._done, self._total, self._eta)


def progress_of(view: contract.JobView) -> Progress:
    """The progress in what the service says about a job."""
    progress = view["progress"]
    return Progress(view["state"], progress["fraction"], progress["tiles_done"], progress["tiles_total"], view["eta_ms"])
