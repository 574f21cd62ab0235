"""When something is tried again."""

from __future__ import annotations

import random

import httpx

from .problems import Problem, StrahlError, Unreachable

#: Longest wait that is taken from a Retry-After, in seconds.
PATIENCE = 120.0
#: Longest wait without one.
LONGEST = 30.0
_BUSY = frozenset({429, 502, 503})


class Backoff:
    """When to try again: as the service says, else twice as long each time."""

    def __init__(self, retries: int) -> None:
        self._retries, self._tries = retries, 0

    def next(self, error: Exception) -> float | None:
        """Seconds until the next try; None if there is none."""
        if self._tries >= self._retries:
            return None
        self._tries += 1
        if isinstance(error, Problem):
            if error.status not in _BUSY:
                return None
            if error.retry_after is not None:
                return min(error.retry_after, PATIENCE)
        # Clients that were refused together do not come back together.
        return min(0.25 * 2.0**self._tries, LONGEST) * random.uniform(0.75, 1.25)


def shown(error: Exception, url: httpx.URL) -> StrahlError:
    """An error of the connection as one of this package."""
    if isinstance(error, StrahlError):
        return error
    return Unreachable(f"{url}: {error or type(error).__name__}")
