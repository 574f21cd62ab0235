"""A picture in parts, from coarse to fine (`multipart/mixed`, RFC 2046)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .picture import Picture, picture_of_report
from .problems import Damaged, Unreachable, problem_of

_MOST_HEAD = 4_096


@dataclass(frozen=True)
class Pass:
    """A picture on its way. Each of its pixels stands for `scale` x `scale` of those of `region`."""

    picture: Picture
    scale: int
    #: `(x, y, width, height)`; None for the picture itself.
    region: tuple[int, int, int, int] | None
    #: Whether this is the picture itself, to the bytes of `Client.render`.
    final: bool
    #: Milliseconds until the end, estimated.
    eta_ms: float | None
    #: The cost report of the picture itself.
    report: dict[str, Any] | None = None


class Parts:
    """Takes the bytes of an answer and gives the pictures in it."""

    def __init__(self) -> None:
        self._rest = bytearray()
        # Where the bytes of the part begin and end; 0 while its head is not there.
        self._start = self._end = 0
        self._head: dict[str, Any] = {}
        self._type = ""
        self._file: tuple[bytes, str] | None = None

    def feed(self, part: bytes) -> Iterator[Pass]:
        self._rest += part
        while self._end or self._begin():
            if len(self._rest) < self._end + 2:
                return
            body = bytes(self._rest[self._start : self._end])
            del self._rest[: self._end + 2]
            self._end = 0
            if (told := self._take(self._type, body)) is not None:
                yield told

    def _begin(self) -> bool:
        """Reads the head of the next part, if it is there."""
        end = self._rest.find(b"\r\n\r\n", 0, _MOST_HEAD)
        if end < 0:
            if len(self._rest) > _MOST_HEAD:
                raise Damaged("a part of the picture does not begin")
            return False
        fields = dict(line.split(": ", 1) for line in self._rest[:end].decode("latin1").split("\r\n") if ": " in line)
        length = fields.get("Content-Length", "")
        if not length.isdecimal():
            raise Damaged("a part of the picture does not say how long it is")
        self._type, self._start = fields.get("Content-Type", ""), end + 4
        self._end = self._start + int(length)
        return True

    def _take(self, media_type: str, body: bytes) -> Pass | None:
        if media_type != "application/json":
            self._file = (body, media_type)
            return None if self._head.get("final") else self._pass(None)
        try:
            about = json.loads(body)
        except ValueError as error:
            raise Damaged("a part of the picture is not JSON") from error
        if not isinstance(about, dict):
            raise Damaged("a part of the picture is no object")
        if "problem" in about:
            raise problem_of(_status(about["problem"]), about["problem"])
        if "report" in about:
            return self._pass(about["report"])
        self._head = about
        return None

    def _pass(self, report: dict[str, Any] | None) -> Pass:
        if self._file is None:
            raise Damaged("the picture is missing in its answer")
        head, (content, media_type) = self._head, self._file
        try:
            region = (head["x"], head["y"], head["w"], head["h"]) if "x" in head else None
            picture = picture_of_report(content, media_type, head, report)
            return Pass(picture, head["scale"], region, bool(head["final"]), head.get("eta_ms"), report)
        except (KeyError, TypeError, AttributeError) as error:
            raise Damaged(f"a part of the picture is not as the service writes it: {error!r}") from error


def _status(problem: Any) -> int:
    status = problem.get("status") if isinstance(problem, dict) else None
    return status if isinstance(status, int) else 500


class Finer:
    """Passes over several tries: what is no finer than what came before is left out."""

    def __init__(self) -> None:
        self._scale: int | None = None
        self.over = False

    def take(self, told: Pass) -> bool:
        """Whether it is for the caller."""
        self.over = told.final
        if not told.final and self._scale is not None and told.scale >= self._scale:
            return False
        self._scale = told.scale
        return True

    def torn(self) -> Unreachable:
        return Unreachable("the answer broke off before the picture")
