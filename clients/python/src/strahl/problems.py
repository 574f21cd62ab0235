"""What can go wrong, as exceptions. Problems of the service are documents (RFC 9457), one class for each kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

if TYPE_CHECKING:
    from . import contract

__all__ = [
    "Busy", "Conflict", "Damaged", "Forbidden", "Gone", "InvalidArgument", "InvalidRequest", "InvalidScene", "JobFailed", "Mistake",
    "NotFound", "Problem", "RateLimited", "StrahlError", "TooLarge", "TooSlow", "Unauthorized", "Unreachable",
]


class StrahlError(Exception):
    """Anything that this package raises."""


class Unreachable(StrahlError):
    """The service does not answer, or its answer broke off, also when asked again."""


class Damaged(StrahlError):
    """What arrived is not what the service has sent."""


class InvalidArgument(StrahlError, ValueError):
    """An argument that cannot be sent: the service was not asked."""


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong with a request or a scene."""

    code: str
    detail: str
    #: Where it is in the scene: a JSON pointer, such as `/objects/3/sphere/radius`.
    pointer: str | None = None
    #: The query parameter that is wrong.
    parameter: str | None = None
    #: Line and column in the body, from 1.
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = self.pointer if self.pointer is not None else self.parameter
        at = f"line {self.line}, column {self.column}: " if self.line is not None else ""
        return printable(f"{at}{place + ': ' if place else ''}{self.detail}")


class Problem(StrahlError):
    """An answer that is a problem."""

    def __init__(self, status: int, document: dict[str, Any], retry_after: float | None = None, is_gateway: bool = False) -> None:
        self.status = status
        #: The whole document.
        self.document = document
        #: What kind it is: the last part of `type`.
        self.slug = str(document.get("type") or "").rsplit("/", 1)[-1]
        self.title = str(document.get("title") or f"HTTP {status}")
        self.detail = str(document.get("detail") or "")
        #: The request's id, which the log of the service has, too.
        self.request_id = str(document.get("instance") or "")
        #: Seconds to wait before the next try.
        self.retry_after = retry_after
        #: Whether it is a server error of something before the service, whose own are documents.
        self.is_gateway = is_gateway
        entries = document.get("errors")
        self.mistakes = [_mistake(one) for one in entries if isinstance(one, dict)] if isinstance(entries, list) else []
        #: How many more mistakes there are.
        self.more = document.get("more") or 0
        #: The limit that was exceeded, `{"name", "max"}`.
        self.limit: dict[str, Any] | None = document.get("limit")
        super().__init__(self._text())

    def _text(self) -> str:
        lines = [f"{self.title} ({self.status})" + (f": {self.detail}" if self.detail else "")]
        # The detail of a single mistake says the same.
        lines += [f"  {one}" for one in self.mistakes if len(self.mistakes) > 1 or one.line is not None]
        lines += [f"  and {self.more} more"] if self.more else []
        return "\n".join(printable(line) for line in lines)


class InvalidScene(Problem):
    """The scene has mistakes: `mistakes` has all of them with pointer, line and column."""


class InvalidRequest(Problem):
    """A parameter or the body is wrong."""


class Unauthorized(Problem):
    """The service asks for another key."""


class Forbidden(Problem):
    """The key may not do this."""


class NotFound(Problem):
    """There is nothing of this name."""


class Gone(NotFound):
    """There is nothing of this name any more."""


class Conflict(Problem):
    """The job's state does not allow this."""


class JobFailed(Problem):
    """The job has ended without a picture."""


class TooLarge(Problem):
    """The picture or the scene is beyond a limit: `limit` names it."""


class TooSlow(Problem):
    """The render took longer than one answer may: submit a job."""


class Busy(Problem):
    """The service is busy or about to stop, also after `retry_after` seconds."""


class RateLimited(Busy):
    """The tenant has used up its units."""


_BY_SLUG: dict[str, type[Problem]] = {
    "invalid-scene": InvalidScene, "invalid-json": InvalidScene, "invalid-nff": InvalidScene,
    "job-failed": JobFailed, "gone": Gone, "render-deadline": TooSlow,
}
_BY_STATUS: dict[int, type[Problem]] = {
    400: InvalidRequest, 401: Unauthorized, 403: Forbidden, 404: NotFound, 409: Conflict, 410: Gone, 412: Conflict,
    413: TooLarge, 415: InvalidRequest, 422: InvalidRequest, 429: RateLimited, 503: Busy, 504: TooSlow,
}


def problem_of(status: int, document: Any, retry_after: float | None = None, is_gateway: bool = False) -> Problem:
    """The exception for a document. An answer of a proxy may be no document at all."""
    if not isinstance(document, dict):
        document = {"detail": str(document)[:500]} if document else {}
    slug = str(document.get("type") or "").rsplit("/", 1)[-1]
    return _BY_SLUG.get(slug, _BY_STATUS.get(status, Problem))(status, document, retry_after, is_gateway)


def failure_of(view: contract.JobView) -> JobFailed:
    """Why a job has no picture."""
    failure = view.get("problem")
    canceled = {"type": "/problems/job-failed", "title": "The job has no picture", "detail": f"job {view['id']} was canceled"}
    document = dict(failure) if failure else canceled
    return JobFailed(int(str(document.get("status", 409))), document)


def _mistake(entry: dict[str, Any]) -> Mistake:
    pointer = entry.get("pointer")
    return Mistake(
        code=str(entry.get("code", "")),
        detail=str(entry.get("detail", "")),
        pointer=_pointer(pointer) if isinstance(pointer, str) else None,
        parameter=entry.get("parameter"),
        line=entry.get("line"),
        column=entry.get("column"),
    )


def _pointer(text: str) -> str:
    """A JSON pointer. One that is a URI fragment is percent-encoded (RFC 6901, 6)."""
    return unquote(text[1:]) if text.startswith("#") else text


def printable(text: str) -> str:
    """Text for a terminal: names in scenes may contain what controls one."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
