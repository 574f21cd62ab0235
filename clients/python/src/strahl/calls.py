"""Requests without a network: what is sent, and how the answer is read. Both clients use them."""

from __future__ import annotations

import hashlib
import json
import os
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Literal, NoReturn, TypeAlias, TypedDict, TypeVar, cast

import httpx

from . import contract
from .picture import Picture, picture_of
from .problems import Damaged, InvalidArgument, problem_of

T = TypeVar("T")

#: A scene: a `dict`, its JSON text, or a file of JSON or NFF, plain or gzip.
SceneLike: TypeAlias = "Mapping[str, Any] | str | bytes | Path"
Format: TypeAlias = Literal["png", "jpg", "webp", "exr", "pfm"]
#: Of animations. `gif` has 256 colors a frame, and the warnings of its picture say how far they are off.
Animation: TypeAlias = Literal["png", "webp", "gif"]
# Longest limit of a connection that sockets take, in seconds: three weeks, which no request lasts.
_LONGEST = 2_000_000.0


class Settings(TypedDict, total=False):
    """Settings over the scene's."""

    width: int
    height: int
    max_depth: int
    min_weight: float
    #: `fixed`, `proved:1`, `time:200`, `rays:1000000` or `statistical:2`.
    accuracy: str
    samples: int
    antialias: bool
    fidelity: Literal["fast", "faithful"]
    precision: Literal["single", "double"]
    #: `scene`, `transparent`, or a color as `rrggbb`.
    background: str
    #: In stops.
    exposure: float
    tone: Literal["none", "khronos_pbr_neutral", "agx"]
    #: `og`, in place of width and height.
    size: Literal["og"]
    #: Multiplies width and height, the scene's where they are not given.
    dpr: float
    # Of models only.
    animation: int | str
    camera: int
    light: str
    scene: int
    strict: bool
    t: float
    up: str
    variant: int | str
    view: str


#: One of two pictures: an image id, a scene, or a scene with settings.
ImageLike: TypeAlias = "SceneLike | tuple[SceneLike, Settings]"


class Output(TypedDict, total=False):
    """How a picture is written."""

    format: Format
    bits: Literal[8, 16]
    quality: int


class PictureOptions(Settings, Output, total=False):
    """Settings, and how the picture is written."""


class RenderOptions(PictureOptions, total=False):
    """Of a picture in one answer: streams and jobs have no layers."""

    #: Further layers of an EXR, as a list or with commas.
    layers: str | Sequence[str]


@dataclass(frozen=True)
class Call(Generic[T]):
    """A request and how its answer is read."""

    method: str
    path: str
    read: Callable[[httpx.Response], T]
    query: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes | None = None
    #: Whether it may be sent again although it may have been received.
    repeatable: bool = True
    #: Seconds that the service may take for the answer beyond the usual.
    patience: float = 0.0
    #: Whether it follows a job, which goes on whatever a gateway says.
    following: bool = False


def check(response: httpx.Response, wanted: str | None = None) -> None:
    """Raises the problem that an answer is. A success must be of the wanted type, and is never a page."""
    if not response.is_success:
        _refuse(response)
    kind = _kind(response)
    if kind == "text/html" or (wanted and kind != wanted):
        raise _foreign(response, wanted or "what was asked for")


def _refuse(response: httpx.Response) -> NoReturn:
    try:
        document: Any = response.json()
    except ValueError:
        document = response.text
    # A date would need a clock that agrees; the service sends seconds.
    after = response.headers.get("retry-after", "")
    is_gateway = response.status_code >= 500 and _kind(response) != "application/problem+json"
    raise problem_of(response.status_code, document, float(after) if after.isdecimal() else None, is_gateway)


def _kind(response: httpx.Response) -> str:
    return str(response.headers.get("content-type", "")).split(";")[0].strip().lower()


def _foreign(response: httpx.Response, wanted: str) -> Damaged:
    """An answer that is not the service's: mostly the URL is that of something else."""
    return Damaged(f"the answer is {_kind(response) or 'of no type'}, not {wanted}: check that the URL is that of the service")


def _json(response: httpx.Response) -> dict[str, Any]:
    """All answers in JSON are objects."""
    try:
        answer = response.json()
    except ValueError as error:
        raise _foreign(response, "JSON") from error
    if not isinstance(answer, dict):
        raise _foreign(response, "an object in JSON")
    return answer


def _read(_: type[T]) -> Callable[[httpx.Response], T]:
    return lambda response: cast(T, _json(response))


def _with_list(response: httpx.Response, name: str) -> dict[str, Any]:
    answer = _json(response)
    if not isinstance(answer.get(name), list):
        raise _foreign(response, f"an object with {name}")
    return answer


def _list(name: str, _: type[T]) -> Callable[[httpx.Response], list[T]]:
    return lambda response: cast(list[T], _with_list(response, name)[name])


def check_picture(response: httpx.Response) -> None:
    """Refuses an answer that is none of the service's pictures."""
    if not _kind(response).startswith("image/"):
        raise _foreign(response, "a picture")


def _picture(response: httpx.Response) -> Picture:
    check_picture(response)
    return picture_of(response.content, response.headers)


def _picture_or_job(response: httpx.Response) -> Picture | None:
    return None if response.status_code == 202 else _picture(response)


def _nothing(_: httpx.Response) -> None:
    return None


_MEDIA_TYPES = {
    ".nff": "text/x-nff", ".aff": "text/x-nff", ".glb": "model/gltf-binary", ".gltf": "model/gltf+json",
    ".obj": "model/obj", ".stl": "model/stl", ".ply": "model/ply",
}


def scene_body(scene: SceneLike) -> tuple[bytes, str]:
    """The bytes of a scene or a model, and their media type."""
    if isinstance(scene, Path):
        endings = [ending.lower() for ending in scene.suffixes]
        packed = bool(endings) and endings[-1] == ".gz"
        media_type = "application/gzip" if packed else _MEDIA_TYPES.get(endings[-1] if endings else "", "application/json")
        return scene.read_bytes(), media_type
    if isinstance(scene, Mapping):
        return _json_text(scene), "application/json"
    if isinstance(scene, str):
        return _utf8(scene), "application/json"
    if not isinstance(scene, (bytes, bytearray, memoryview)):
        # `bytes` of a number would be as many zeros.
        raise InvalidArgument(f"a scene is a dict, its JSON text, its bytes or a Path, not {type(scene).__name__}")
    content = bytes(scene)
    # The service knows models by their content.
    start = content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    return content, "application/json" if start in (b"{", b"") else "application/octet-stream"


def _json_text(value: Any) -> bytes:
    try:
        # NaN is no JSON; the service would not say where it is.
        return json.dumps(value, allow_nan=False).encode()
    except ValueError as error:
        raise InvalidArgument(f"this is no JSON: {error}") from error


def _utf8(text: str) -> bytes:
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise InvalidArgument(f"the text of the scene is no UTF-8: {error.reason} at character {error.start}") from error


def query_of(options: Mapping[str, Any]) -> dict[str, str]:
    """Parameters of a query: what is None is left out, and lists have commas."""
    return {name: _word(value) for name, value in options.items() if value is not None}


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return ",".join(map(_word, value)) if isinstance(value, list | tuple) else str(value)


def about_scene(path: str, scene: SceneLike, read: Callable[[httpx.Response], T], options: Mapping[str, Any],
                accept: str = "application/json", patience: float = 0.0) -> Call[T]:
    body, media_type = scene_body(scene)
    headers = {"Content-Type": media_type, "Accept": accept}
    return Call("POST", path, read, query_of(options), headers, body, patience=patience)


def render(scene: SceneLike, options: Mapping[str, Any]) -> Call[Picture]:
    return about_scene("/v1/render", scene, _picture, options, "*/*")


def streamed(scene: SceneLike, options: Mapping[str, Any]) -> Call[Picture]:
    without_layers("a stream", options)
    return render(scene, options)


def without_layers(what: str, options: Mapping[str, Any]) -> None:
    """Refuses what the types have not, before a scene is sent for nothing."""
    if options.get("layers") is not None:
        raise InvalidArgument(f"{what} has no layers: `render` and `tile` have them")


def turntable(scene: SceneLike, count: int, format: Animation, sheet: tuple[int, int] | None,
              settings: Mapping[str, Any]) -> Call[Picture | None]:
    shown = {"format": format} if sheet is None else {"sheet": f"{sheet[0]}x{sheet[1]}"}
    return about_scene("/v1/render", scene, _picture_or_job, {"turntable": count, **shown, **settings}, "*/*", patience=60)


def tile(scene: SceneLike, region: Sequence[int], options: Mapping[str, Any]) -> Call[Picture]:
    if len(region) != 4:
        raise InvalidArgument(f"a region has four numbers, (x, y, width, height), not {len(region)}")
    x, y, width, height = region
    return about_scene("/v1/render/tile", scene, _picture, {"x": x, "y": y, "w": width, "h": height, **options}, "*/*")


def explain(scene: SceneLike, options: Mapping[str, Any]) -> Call[contract.Plan]:
    return about_scene("/v1/explain", scene, _read(contract.Plan), options)


def explain_each(scene: SceneLike, settings: Sequence[Settings]) -> Call[contract.SettingsEstimates]:
    body = b'{"scene":%b,"settings":%b}' % (_json_scene(scene), _json_text(list(settings)))
    return Call("POST", "/v1/explain", _read(contract.SettingsEstimates), headers={"Content-Type": "application/json"}, body=body)


def analyze(scene: SceneLike, options: Mapping[str, Any]) -> Call[contract.Analyzed]:
    return about_scene("/v1/explain", scene, _read(contract.Analyzed), {"analyze": True, **options})


def compare(a: ImageLike, b: ImageLike) -> Call[contract.PictureDifference]:
    headers = {"Content-Type": "application/json"}
    return Call("POST", "/v1/compare", _read(contract.PictureDifference), headers=headers, body=_pair(a, b), patience=30)


def difference(a: ImageLike, b: ImageLike, format: str, gain: int | None) -> Call[Picture]:
    headers = {"Content-Type": "application/json"}
    return Call("POST", "/v1/compare", _picture, query_of({"format": format, "gain": gain}), headers, _pair(a, b), patience=30)


def _pair(a: ImageLike, b: ImageLike) -> bytes:
    return b'{"a":%b,"b":%b}' % (_side(a), _side(b))


def _side(one: ImageLike) -> bytes:
    """An image id, or a scene with settings or without."""
    if isinstance(one, str) and one.startswith("i_"):
        return json.dumps({"image": one}).encode()
    scene, settings = one if isinstance(one, tuple) else (one, {})
    return b'{"scene":%b,"settings":%b}' % (_json_scene(scene), _json_text(settings))


def source(scene_id: str) -> Call[str]:
    return Call("GET", f"/v1/scenes/{_id(scene_id)}/source", lambda response: response.text)


def tradeoff(scene: SceneLike, seconds: float | None, options: Mapping[str, Any]) -> Call[contract.Tradeoff]:
    query = {"seconds": seconds, "format": "json", **options}
    return about_scene("/v1/tradeoff", scene, _read(contract.Tradeoff), query, patience=seconds or 10.0)


def validate(scene: SceneLike, options: Mapping[str, Any]) -> Call[list[contract.SceneProblem]]:
    return about_scene("/v1/scenes/validate", scene, _list("warnings", contract.SceneProblem), options)


def map_of(scene: SceneLike, of: str, format: str, step: int | None, options: Mapping[str, Any]) -> Call[Picture]:
    return about_scene("/v1/map", scene, _picture, {"of": of, "format": format, "step": step, **options}, "*/*")


def tree(scene: SceneLike, x: int, y: int, all_samples: bool, options: Mapping[str, Any]) -> Call[contract.RayTree]:
    query = {"x": x, "y": y, "all_samples": all_samples or None, **options}
    return about_scene("/v1/tree", scene, _read(contract.RayTree), query)


def rays(scene: SceneLike, queries: Iterable[contract.RayQuery], options: Mapping[str, Any]) -> Call[list[contract.RayAnswer]]:
    body = b'{"scene":%b,"rays":%b}' % (_json_scene(scene), _json_text(list(queries)))
    return Call("POST", "/v1/rays", _list("answers", contract.RayAnswer), query_of(options), {"Content-Type": "application/json"}, body)


def add_scene(scene: SceneLike, zoom: int | None, options: Mapping[str, Any]) -> Call[contract.KnownScene]:
    return about_scene("/v1/scenes", scene, _read(contract.KnownScene), {"zoom": zoom, **options})


def image(image_id: str, format: str, options: Mapping[str, Any]) -> Call[Picture]:
    return Call("GET", f"/v1/images/{_id(image_id)}.{format}", _picture, query_of(options))


def get(path: str, of: type[T]) -> Call[T]:
    return Call("GET", path, _read(of))


def capability(job_id: str | None, image_id: str | None, scene_id: str | None, ttl: int | None) -> Call[contract.Capability]:
    wanted = {"job_id": job_id, "image_id": image_id, "scene_id": scene_id, "ttl": ttl}
    body = json.dumps({name: value for name, value in wanted.items() if value is not None}).encode()
    return Call("POST", "/v1/capabilities", _read(contract.Capability), headers={"Content-Type": "application/json"}, body=body)


def submit(scene: SceneLike, options: Mapping[str, Any], priority: int | None, labels: Sequence[str],
           webhook: str | None, store: str | bool, idempotency_key: str | None, wait: int | None,
           frames: contract.Sequence | None) -> Call[contract.JobView]:
    without_layers("a job", options)
    if isinstance(labels, str):
        raise InvalidArgument(f"labels are a list, such as [{labels!r}]: a text is a list of its letters")
    output = {name: str(value) if name == "bits" else value for name, value in options.items()
              if name in Output.__annotations__ and value is not None}
    settings = {name: value for name, value in options.items() if name not in Output.__annotations__ and value is not None}
    about = {"settings": settings, "output": output, "labels": list(labels), **({} if priority is None else {"priority": priority})}
    about |= {} if frames is None else {"frames": frames}
    about |= {} if webhook is None else {"webhook": {"url": webhook}}
    about |= {} if store is False else {"store": {} if store is True else {"key": store}}
    # The scene's text goes in as it is, so that lines of mistakes are its own where it stands alone.
    body = b'{"scene":%b,%b' % (_json_scene(scene), _json_text(about)[1:])
    # With a key it can be sent again without becoming two jobs.
    key = header_value("the idempotency key", idempotency_key or str(uuid.uuid4()))
    headers = {"Content-Type": "application/json", "Idempotency-Key": key}
    if wait:
        headers["Prefer"] = f"wait={wait}"
    return Call("POST", "/v1/jobs", _read(contract.JobView), headers=headers, body=body, patience=wait or 0)


def job(job_id: str, wait: int | None = None) -> Call[contract.JobView]:
    headers = {"Prefer": f"wait={wait}"} if wait else {}
    return Call("GET", f"/v1/jobs/{_id(job_id)}", _read(contract.JobView), headers=headers, patience=wait or 0, following=True)


def jobs(state: str | None, label: str | None, limit: int | None, cursor: str | None) -> Call[contract.JobList]:
    query = query_of({"state": state, "label": label, "limit": limit, "cursor": cursor})
    return Call("GET", "/v1/jobs", lambda response: cast(contract.JobList, _with_list(response, "jobs")), query)


def cancel(job_id: str) -> Call[contract.JobView]:
    return Call("POST", f"/v1/jobs/{_id(job_id)}/cancel", _read(contract.JobView), repeatable=False)


def delete(job_id: str) -> Call[None]:
    return Call("DELETE", f"/v1/jobs/{_id(job_id)}", _nothing, repeatable=False)


def prioritize(job_id: str, priority: int, etag: str | None) -> Call[contract.JobView]:
    headers = {"Content-Type": "application/merge-patch+json", **({"If-Match": etag} if etag else {})}
    body = json.dumps({"priority": priority}).encode()
    return Call("PATCH", f"/v1/jobs/{_id(job_id)}", _read(contract.JobView), headers=headers, body=body)


def job_picture(job_id: str, part: str, query: Mapping[str, Any] | None = None) -> Call[Picture]:
    return Call("GET", f"/v1/jobs/{_id(job_id)}/{part}", _picture, query_of(query or {}), patience=30)


def job_result(job_id: str) -> Call[Picture]:
    return Call("GET", f"/v1/jobs/{_id(job_id)}/image", _picture, patience=30, following=True)


def job_frames(job_id: str) -> Call[contract.FrameList]:
    return Call("GET", f"/v1/jobs/{_id(job_id)}/frames", lambda response: cast(contract.FrameList, _with_list(response, "frames")))


def send_asset(content: bytes) -> Call[contract.SentAsset]:
    digits = hashlib.sha256(content).hexdigest()
    headers = {"Content-Type": "application/octet-stream"}
    return Call("PUT", f"/v1/assets/{digits}", _read(contract.SentAsset), headers=headers, body=content)


def missing_assets(names: Iterable[str]) -> Call[list[str]]:
    body = _json_text({"sha256": list(names)})
    return Call("POST", "/v1/assets/missing", _list("missing", str), headers={"Content-Type": "application/json"}, body=body)


def delete_asset(name: str) -> Call[None]:
    return Call("DELETE", f"/v1/assets/{_id(name.removeprefix('sha256:'))}", _nothing, repeatable=False)


def asset_bytes(content: bytes | Path) -> bytes:
    if isinstance(content, Path):
        return content.read_bytes()
    if not isinstance(content, (bytes, bytearray, memoryview)):
        raise InvalidArgument(f"an asset is its bytes or a Path, not {type(content).__name__}")
    return bytes(content)


def asset_name(content: bytes) -> str:
    return f"sha256:{hashlib.sha256(content).hexdigest()}"


def _json_scene(scene: SceneLike) -> bytes:
    body, media_type = scene_body(scene)
    if media_type != "application/json":
        raise InvalidArgument("this request takes a scene in JSON; NFF and models can be rendered and explained")
    return body


def _id(text: str) -> str:
    """An id as a part of a path, whatever it is."""
    if not text or not all(c.isascii() and (c.isalnum() or c in "-_") for c in text):
        raise InvalidArgument(f"{text!r} is no id: ids have letters, digits, - and _")
    return text


def base_of(url: str | None) -> httpx.URL:
    """The service's address: the one that is given, or that of the environment, or the one of a desk."""
    try:
        base = httpx.URL((url or os.environ.get("STRAHL_URL") or "http://127.0.0.1:8080").strip().rstrip("/"))
    except httpx.InvalidURL:
        base = httpx.URL()
    if base.scheme not in {"http", "https"} or not base.host:
        # It is not shown, for it may have a password.
        raise InvalidArgument("the URL of the service must be one of http or https, such as http://127.0.0.1:8080")
    return base


def key_of(key: str | None) -> dict[str, str]:
    key = (key or os.environ.get("STRAHL_KEY") or "").strip()
    return {"Authorization": f"Bearer {header_value('the key', key)}"} if key else {}


def header_value(what: str, text: str) -> str:
    """Text for a header, which is checked here: httpx would show it in its error."""
    if not all(" " <= c <= "~" for c in text):
        raise InvalidArgument(f"{what} has characters that no header may have: it must be printable ASCII in one line")
    return text


def limit_of(timeout: float) -> float:
    """Seconds that a request may take. Infinity is no limit."""
    if not timeout > 0:
        raise InvalidArgument(f"timeout must be seconds above 0, and is {timeout}: math.inf is no limit")
    return min(timeout, _LONGEST)

