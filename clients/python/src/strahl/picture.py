"""Pictures, with what they cost and how accurate they are."""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .problems import Damaged

if TYPE_CHECKING:
    import numpy

_EMPTY = hashlib.sha256().digest()
_MEMBER = re.compile(r'(?<![;\w])([\w-]+)(?:=(?:"((?:[^"\\]|\\.)*)"|([^,;\s]*)))?((?:;[^,]*)?)')


@dataclass(frozen=True)
class Error:
    """How far a picture may be from recursion without end, in codes: steps of an 8-bit channel."""

    #: It is proved that no pixel is further off. None: nothing is proved, and `why` says why.
    proved: int | None = None
    #: Share of the pixels that are proved to be identical.
    identical: float | None = None
    #: The depth of the recursion that it was compared with; None for recursion without end.
    depth: int | None = None
    #: Estimated error of sampling. None: unknown.
    estimated: float | None = None
    why: str | None = None


@dataclass(frozen=True)
class Picture:
    """A picture as the service sent it. `report` is there for pictures of jobs."""

    content: bytes
    media_type: str
    error: Error = Error()
    #: Rays by kind.
    rays: dict[str, int] = field(default_factory=dict)
    #: Milliseconds of each phase; empty if the picture existed already.
    timing: dict[str, float] = field(default_factory=dict)
    #: The effects that were simulated.
    effects: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    etag: str | None = None
    #: Its id, by which `Client.image` gets it again.
    image_id: str | None = None
    #: Whether the service had it already.
    cached: bool = False

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the file."""
        with open(path, "wb") as file:
            file.write(self.content)

    def numpy(self) -> numpy.ndarray[Any, Any]:
        """The pixels, rows from the top. PFM: linear light, float32. PNG, JPEG, WebP: sRGB codes, uint8."""
        import numpy

        if self.media_type == "image/x-portable-floatmap":
            return _portable_float_map(self.content)
        if self.media_type == "image/x-exr":
            raise ValueError("strahl reads no EXR: ask for format='pfm', which has the same linear light")
        if self.media_type == "image/png" and self.content[24] != 8:
            raise ValueError("PNG of 16 bits is not read here: ask for format='pfm', which has more than 16 bits")
        from PIL import Image

        with Image.open(io.BytesIO(self.content)) as image:
            return numpy.asarray(image)

    def _repr_png_(self) -> bytes | None:
        return self.content if self.media_type == "image/png" else None

    def _repr_jpeg_(self) -> bytes | None:
        return self.content if self.media_type == "image/jpeg" else None

    def __repr__(self) -> str:
        proved = "nothing proved" if self.error.proved is None else f"at most {self.error.proved} codes off"
        return f"<Picture {self.media_type}, {len(self.content)} bytes, {sum(self.rays.values())} rays, {proved}>"


def picture_of(content: bytes, headers: Mapping[str, str]) -> Picture:
    """The picture of an answer. A file that was damaged on its way is refused."""
    check_digest(hashlib.sha256(content).digest(), headers)
    found = re.search(r"/v1/images/(i_\w+)", headers.get("content-location", ""))
    timing = _members(headers.get("server-timing", ""))
    return Picture(
        content=content,
        media_type=headers.get("content-type", "").split(";")[0],
        error=error_of(headers.get("render-error", "")),
        rays={name: int(value) for name, (value, _) in _members(headers.get("render-rays", "")).items() if value.isdigit()},
        timing={name: float(dur[1]) for name, (_, more) in timing.items() if (dur := re.search(r";dur=([\d.]+)", more))},
        effects=[one for one in re.split(r"[,\s]+", headers.get("render-plan", "")) if one],
        warnings=[_text(text) for text in re.findall(r'"((?:[^"\\]|\\.)*)"', headers.get("render-warnings", ""))],
        etag=headers.get("etag"),
        image_id=found[1] if found else None,
        cached="picture;desc=hit" in headers.get("server-timing", ""),
    )


def picture_of_report(content: bytes, media_type: str, head: Mapping[str, Any], report: Mapping[str, Any] | None) -> Picture:
    """A picture of a streamed answer: `head` comes before it, `report` after it."""
    check_digest(hashlib.sha256(content).digest(), {"repr-digest": head.get("repr_digest") or ""})
    if report is None:
        return Picture(content, media_type, image_id=head.get("image_id"))
    proved, estimated, cost = report["error"]["proved"], report["error"]["estimated"], report["cost"]
    known = proved.get("max_codes")
    return Picture(
        content,
        media_type,
        error=Error(known, proved.get("identical_fraction"), proved.get("max_depth"),
                    estimated["half_width_codes"] if estimated else None, None if known is not None else proved.get("why")),
        rays=dict(cost["rays"]),
        timing=dict(cost["phases_ms"]),
        effects=[one["effect"] for one in report["plan"]["effects"] if one["state"] == "on"],
        warnings=[_warning(one) for one in report["plan"]["warnings"]],
        image_id=head.get("image_id"),
    )


def error_of(header: str) -> Error:
    """The header `Render-Error`."""
    members = {name: value for name, (value, _) in _members(header).items()}

    def number(name: str) -> float | None:
        try:
            return float(members[name])
        except (KeyError, ValueError):
            return None

    proved, depth = number("proved"), number("depth")
    return Error(
        proved=None if proved is None else int(proved),
        identical=number("identical"),
        depth=None if depth is None else int(depth),
        estimated=number("estimated"),
        why=members.get("why"),
    )


def check_digest(digest: bytes, headers: Mapping[str, str]) -> None:
    """Refuses an empty file, and compares with `Repr-Digest` (RFC 9530), if there is one."""
    if digest == _EMPTY:
        raise Damaged("the picture is empty: check that the URL is that of the service")
    found = re.search(r"sha-256=:([A-Za-z0-9+/=]+):", headers.get("repr-digest", ""))
    if found and base64.b64encode(digest).decode() != found[1]:
        raise Damaged("the picture was damaged on its way: its SHA-256 is not that of Repr-Digest")


def _members(header: str) -> dict[str, tuple[str, str]]:
    """Members of a dictionary or list (RFC 9651): name, value, parameters."""
    return {name: (_text(text) if text else value, more) for name, text, value, more in _MEMBER.findall(header)}


def _text(inside: str) -> str:
    """The text of what is inside the quotes of a string (RFC 9651): quotes and backslashes have a backslash before them."""
    return re.sub(r"\\(.)", r"\1", inside)


def _warning(warning: Mapping[str, Any]) -> str:
    """A warning of a report, in the words of `Render-Warnings`."""
    return f"{warning['pointer']}: {warning['detail']}" if warning["pointer"] else str(warning["detail"])


def _portable_float_map(content: bytes) -> numpy.ndarray[Any, Any]:
    import numpy

    kind, size, scale, pixels = content.split(b"\n", 3)
    width, height = (int(one) for one in size.split())
    channels = 3 if kind == b"PF" else 1
    order = "<f4" if float(scale) < 0 else ">f4"
    rows = numpy.frombuffer(pixels, order).reshape(height, width, channels)[::-1]
    return rows.astype(numpy.float32) if channels == 3 else rows[:, :, 0].astype(numpy.float32)
