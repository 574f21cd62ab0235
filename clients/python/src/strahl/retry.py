"""When something is tried again."""

from __future__ import annotations

import random
from typing import NoReturn

import httpx

from .problems import Damaged, InvalidArgument, Problem, StrahlError, Unreachable

#: Longest wait that is taken from a Retry-After, in seconds.
PATIENCE = 120.0
#: Longest wait without one.
LONGEST = 30.0
#: What a request can end with: errors of this package, and those of httpx.
FAILURES = (StrahlError, httpx.HTTPError, httpx.InvalidURL)
_BUSY = frozenset({429, 502, 503})
# The request was not sent, and never will be.
_UNSENT = (httpx.InvalidURL, httpx.LocalProtocolError, httpx.UnsupportedProtocol)


class Backoff:
    """When to try again: as the service says, else twice as long each time."""

    def __init__(self, retries: int, *, following: bool = False) -> None:
        # Whether a job is followed: what a gateway says of a service that it cannot reach is a break then.
        self._retries, self._tries, self._following = retries, 0, following

    def next(self, error: Exception) -> float | None:
        """Seconds until the next try; None if there is none."""
        if self._tries >= self._retries or isinstance(error, _UNSENT):
            return None
        self._tries += 1
        if isinstance(error, Problem):
            # A request with the same idempotency key that is still being accepted is a conflict for a moment.
            is_busy = error.status in _BUSY or (error.slug == "conflict" and error.retry_after is not None)
            if not is_busy and not (self._following and error.is_gateway):
                return None
            # Clients that were refused together do not come back together, and none too early.
            if error.retry_after is not None:
                return min(error.retry_after, PATIENCE) * random.uniform(1.0, 1.25)
        return min(0.25 * 2.0**self._tries, LONGEST) * random.uniform(0.75, 1.25)


def shown(error: Exception, url: httpx.URL) -> StrahlError:
    """An error of the connection as one of this package. Of the URL it shows the host only: the rest may be secret."""
    if isinstance(error, StrahlError):
        return error
    host = f"{url.scheme}://{url.netloc.decode()}"
    if isinstance(error, httpx.DecodingError):
        return Damaged(f"{host}: the answer cannot be unpacked: {error}")
    if isinstance(error, httpx.LocalProtocolError):
        # Its text has the header, and that may be the key.
        return InvalidArgument(f"{host}: HTTP cannot carry the request")
    if isinstance(error, _UNSENT):
        return InvalidArgument(f"{host}: the request cannot be sent: {error}")
    return Unreachable(f"{host}: {error or type(error).__name__}")


def give_up(error: Exception, url: httpx.URL) -> NoReturn:
    """Raises an error of the connection as one of this package. What httpx does not send is no cause: it may show the key."""
    if isinstance(error, StrahlError):
        raise error
    raise shown(error, url) from None if isinstance(error, _UNSENT) else error
