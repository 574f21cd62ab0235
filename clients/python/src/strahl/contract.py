"""Types of the contract. `generate.py` writes this file from `api/openapi.json`."""

from __future__ import annotations

from typing import Any, Literal, NotRequired, TypeAlias, TypedDict

# How accurate a picture must be, or how much it may cost.
Accuracy: TypeAlias = "dict[Literal['fixed'], Fixed] | dict[Literal['proved'], Proved] | dict[Literal['time'], Time] | dict[Literal['rays'], Rays] | dict[Literal['statistical'], Statistical]"


class AdaptiveSamples(TypedDict):
    """How many samples the pixels asked for."""

    # Of a pixel, on average.
    mean: float
    # Most of a pixel.
    most: int
    # Share of the pixels that asked for no more; the others got the most that are allowed.
    settled_fraction: float


class AllLimits(TypedDict):
    """All limits by the names that problems quote."""

    # Limits of what is delivered after jobs.
    deliveries: DeliveryLimits
    # Limits of jobs.
    jobs: JobLimits
    # Limits of one request: bytes, seconds (`_s`) and counts. Null: not available here.
    request: RequestLimits
    # Limits of scenes.
    scene: dict[str, float]
    # Concurrency limits of the caller's tenant, and units in a minute. Null: unlimited.
    tenant: TenantLimits


# What alpha means.
AlphaMode: TypeAlias = "Literal['blend'] | Literal['mask']"


class Analyzed(TypedDict):
    """A plan, and what rendering the picture has cost."""

    # Time and rays.
    actual: PictureCost
    # Depth of the recursion.
    depth: Depth
    # Every effect the renderer knows.
    effects: list[Effect]
    # Estimate of the picture.
    estimate: NotRequired[Estimate | None]
    # Milliseconds that the plan took, with its estimates, but without loading the scene.
    explain_ms: float
    # Features it contains besides camera and shadow rays, as `REFLECTION|TRANSMISSION`. `LOCAL`: none.
    kernel: str
    # Hash of all that selects machine code: kernel, precision, instruction set, version.
    kernel_hash: str
    # Effects of light that no ray of the picture simulates.
    not_simulated: list[str]
    # Most primitives that lie around one point. A ray may take as many steps there, which the estimate does not
    # include.
    overlap: float
    # Floating-point format.
    precision: Precision
    # Features that the scene does not need.
    superset_of_needed: list[str]
    # Warnings about the scene.
    warnings: list[SceneProblem]


class AngularArea(TypedDict):
    """A disc in the sky."""

    # Its angular diameter in degrees, 0 to 90; the sun's is 0.53.
    angle_deg: float


# Areas that light comes from, each point of them with the same share of its intensity, with no regard to the
# angle it leaves at.
Area: TypeAlias = "dict[Literal['disc'], DiscArea] | dict[Literal['parallelogram'], ParallelogramArea]"


class AssetHashes(TypedDict):
    """Assets that somebody needs."""

    # Their SHA-256 in hexadecimal digits, with or without `sha256:` before them.
    sha256: list[str]


class Attenuation(TypedDict):
    """What a body absorbs: it lets `color` pass over a length of `distance`."""

    # The share of light that passes, above 0 to 1 in each channel.
    color: Color
    # The length, in scene units, above 0.
    distance: float


# A set of axes.
Axes: TypeAlias = "Literal['x', 'y', 'z', 'xy', 'xz', 'yz', 'xyz']"


class AxisBox(TypedDict):
    """Box with sides parallel to the axes. It may be flat in one direction."""

    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # Upper corner, in no coordinate below `min`.
    max: list[float]
    # Lower corner.
    min: list[float]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]


class Bump(TypedDict):
    """Bumps: the surface is shaded as if it were raised along its normal, but its outline stays."""

    # Height of white above black, in units of object space, at least 0.
    height: float
    # The heights.
    texture: Relief


# Anything that is not JSON.
Bytes: TypeAlias = "str"


# Projections. All have `eye`, `look_at` and `up`.
Camera: TypeAlias = "dict[Literal['pinhole'], PinholeCamera] | dict[Literal['orthographic'], OrthographicCamera] | dict[Literal['fisheye'], FisheyeCamera] | dict[Literal['omnimax'], FisheyeCamera] | dict[Literal['panorama'], PanoramaCamera] | dict[Literal['cylinder'], CylinderCamera]"


class CameraKey(TypedDict):
    """What a camera is at a time. What a key does not say is between the keys before and after it that do, and what
    no key says is as the scene says."""

    # Diameter of the lens of a pinhole camera.
    aperture: NotRequired[float | None]
    # How fast it goes from here to the next key. Default: steady.
    ease: NotRequired[Ease]
    # Eye point.
    eye: NotRequired[list[float] | None]
    # Distance of the plane in focus of a pinhole camera.
    focus_distance: NotRequired[float | None]
    # Angle across the circle of a fisheye or an omnimax.
    fov_deg: NotRequired[float | None]
    # Height of the picture of an orthographic camera, in scene units.
    height: NotRequired[float | None]
    # Horizontal angle of view of cameras that have one.
    hfov_deg: NotRequired[float | None]
    # Point in the middle of the picture.
    look_at: NotRequired[list[float] | None]
    # When, from 0, the first frame, to 1, the last one. On a closed path, below 1, where the path begins again.
    t: float
    # Up direction.
    up: NotRequired[list[float] | None]
    # Vertical angle of view of cameras that have one.
    vfov_deg: NotRequired[float | None]


class Capability(TypedDict):
    """A capability."""

    # When it expires, in seconds since 1970.
    expires: int
    # Prefix of paths, such as `/v1/jobs/{id}/events` or `/iiif/3/{id}/info.json`.
    prefix: str


class CapabilityRequest(TypedDict):
    """What a capability is for: a job, a picture or a scene."""

    # Id of a picture.
    image_id: NotRequired[str | None]
    # Id of a job.
    job_id: NotRequired[str | None]
    # Id of a scene, whose text is to be read.
    scene_id: NotRequired[str | None]
    # Lifetime in seconds, 3600 by default.
    ttl: NotRequired[int | None]


class Checker(TypedDict):
    """Checkerboard: tile `a` where the sum of floor(p / size) over the named axes is even, in object space."""

    # Color of the even tiles.
    a: Color
    # The axes that count. Default `"xz"`, a floor.
    axes: NotRequired[Axes]
    # Color of the odd tiles.
    b: Color
    # Edge of a tile in scene units, above 0. Default 1.
    size: NotRequired[float]


class Circumstances(TypedDict):
    """On what, when and how a trade-off was measured."""

    # Width and height that the scene or the request asks for.
    asked_size: list[int]
    # Day it was measured on, by Coordinated Universal Time.
    date: str
    # Instruction set.
    instructions: str
    # Seconds it might take.
    seconds: float
    # Width and height of the pictures that were compared.
    size: list[int]
    # Threads that rendered.
    threads: int
    # What times are.
    times: str
    # Seconds it took.
    took_seconds: float
    # Version of the renderer.
    version: str


class CodeErrors(TypedDict):
    """How two pictures of 8-bit codes differ. A pixel's error is that of its worst channel. Where there is alpha,
    colors are those over black, and each channel is off by at least as much as alpha."""

    # Errors in codes.
    error: ErrorSpread
    # Share of pixels that are the same in all channels.
    identical: float
    # 10 log10(255^2 / mean square error) over all channels, in decibels; none for the same picture.
    psnr: float | None


# A color: a grey number, linear [r, g, b], or sRGB "#rrggbb". No channel below 0.
Color: TypeAlias = "float | list[float] | str"


# A value, or a picture times a value: {"factor": ..., "image": "..."}.
ColorChannel: TypeAlias = "Color | dict[Literal['channel'], TexelChannel | None] | dict[Literal['enlarged'], Enlarged] | dict[Literal['factor'], Color] | dict[Literal['image'], str] | dict[Literal['transform'], UvTransform] | dict[Literal['uv'], int] | dict[Literal['wrap'], Wraps]"


class CompareRequest(TypedDict):
    """Two pictures."""

    # The one that is compared with, as a reference is.
    a: CompareSide
    # The other.
    b: CompareSide


class CompareSide(TypedDict):
    """An image id, or a scene with settings."""

    # An image id.
    image: NotRequired[str | None]
    # A scene.
    scene: NotRequired[Scene]
    # Settings that replace the scene's, by the names of the query parameters of `POST /v1/render`.
    settings: NotRequired[Overrides]


class Cone(TypedDict):
    """Circular cone or its frustum from `base` to `top`."""

    # Centre of one end.
    base: list[float]
    # Radius at the base, at least 0.
    base_radius: float
    # Whether discs close its ends. Default true.
    capped: NotRequired[bool]
    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Centre of the other end.
    top: list[float]
    # Radius at the top, at least 0; not both 0. Default 0.
    top_radius: NotRequired[float]


class CostReport(TypedDict):
    """The cost report."""

    # Time and rays.
    cost: PictureCost
    # How far the picture may be from the exact one.
    error: ErrorBounds
    # The effects, which of them are on and why, and how deep rays go.
    plan: Plan
    # What renders the same pixels again.
    replay: Replay


class Cylinder(TypedDict):
    """Circular cylinder from `base` to `top`."""

    # Centre of one end.
    base: list[float]
    # Whether discs close its ends. Default true.
    capped: NotRequired[bool]
    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Radius, above 0.
    radius: float
    # Centre of the other end.
    top: list[float]


class CylinderCamera(TypedDict):
    """Cylindrical panorama."""

    # Eye point.
    eye: list[float]
    # Angle across the picture in degrees, above 0, at most 360. Default 180.
    hfov_deg: NotRequired[float]
    # Point in the middle of the picture.
    look_at: list[float]
    # Up direction, the cylinder's axis. Default +y.
    up: NotRequired[list[float]]
    # Angle down the picture's middle column in degrees, above 0 and below 180. Default 60.
    vfov_deg: NotRequired[float]


class DeliveryLimits(TypedDict):
    """What is delivered after jobs."""

    # Whether pictures can be put into a store.
    store: bool
    # Attempts to send a message to a webhook, or a picture to the store, before it is given up.
    webhook_attempts: int
    # Accept webhooks of http://, whose messages anybody on the way can read.
    webhook_http: bool
    # Messages of one tenant that are sent at one time.
    webhook_parallel: int
    # Seconds from the first attempt to the second. Each later one waits four times as long, up to an hour.
    webhook_retry_s: float
    # Seconds that a receiver may take to answer.
    webhook_timeout_s: float


# How far a delivery is.
DeliveryState: TypeAlias = "Literal['pending'] | Literal['delivered'] | Literal['dead']"


class DeliveryView(TypedDict):
    """A delivery after the end of a job."""

    # Attempts so far.
    attempts: int
    # When it arrived or was given up (RFC 3339).
    ended_at: NotRequired[str | None]
    # Why the last attempt failed.
    error: NotRequired[str | None]
    # When it is tried next, after an attempt that failed (RFC 3339).
    next_attempt_at: NotRequired[str | None]
    # How far it is.
    state: DeliveryState
    # Where it goes.
    url: str


class Depth(TypedDict):
    """How long chains of rays get."""

    # JSON pointers of what sends rays on.
    because: list[str]
    # A depth at which no chain is cut off: 1 where no surface sends rays on. Null elsewhere.
    proved_sufficient: int | None
    # Rays in the longest chain of the rendered picture. Null where only a plan was asked for.
    reached: int | None
    # `render.max_depth`, if the scene names one.
    requested: int | None
    # Why, in a sentence.
    why: str


class Difference(TypedDict):
    """How far a picture is from its reference, by every measure."""

    # CIEDE2000; 1 is just visible.
    ciede2000: ErrorSpread
    # In 8-bit codes of the worst channel.
    codes: CodeErrors
    # FLIP, 0 to 1.
    flip: ErrorSpread
    # Square root of the mean square over all channels, in codes.
    rms_codes: float


# A color, or a pattern: {"checker": {...}}, "gradient", "image" or "noise".
Diffuse: TypeAlias = "Color | dict[Literal['checker'], Checker] | dict[Literal['gradient'], Gradient] | dict[Literal['image'], ImageMap] | dict[Literal['noise'], Noise]"


class DirectionalLight(TypedDict):
    """Directional light."""

    # How large it is in the sky; shadows get soft edges. Default: a point.
    area: NotRequired[AngularArea | None]
    # Its color. Default white.
    color: NotRequired[Color]
    # The direction its light travels in.
    direction: list[float]
    # Factor on the color, at least 0. Default 1.
    intensity: NotRequired[float]


class Disc(TypedDict):
    """Flat disc."""

    # Centre.
    center: list[float]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Direction of its front, any length but 0.
    normal: list[float]
    # Radius, above 0.
    radius: float


class DiscArea(TypedDict):
    """A disc around a light's position."""

    # Radius in scene units, at least 0.
    radius: float


# The speed between two keys. All are polynomials, which give the same bits on every machine.
Ease: TypeAlias = "Literal['linear'] | Literal['in'] | Literal['out'] | Literal['in_out']"


class Effect(TypedDict):
    """One effect."""

    # Actual cost.
    act: NotRequired[EffectCost | None]
    # JSON pointers of the keys that ask for it, at most 10.
    because: list[str]
    # Its name, a token of letters and `_`.
    effect: str
    # Estimated cost.
    est: NotRequired[EffectEstimate | None]
    # Why, in a sentence.
    reason: str
    # Whether it is simulated.
    state: EffectState
    # Values of those keys, if they are short.
    values: NotRequired[dict[str, Any]]


class EffectCost(TypedDict):
    """Actual cost of an effect."""

    # The same as `share_ms`, under its former name.
    ms_estimated: float | None
    # Its own rays, counted.
    rays: int
    # Milliseconds that the picture would save without this one effect, measured by a pilot without it. Below 0 if
    # it would take longer. Null if the effect is off, or cannot be left out alone.
    saves_ms: float | None
    # Milliseconds that its own rays took: their number times what rays of their kind took in the pilot. Null if its
    # time is part of other effects' rays.
    share_ms: float | None


class EffectEstimate(TypedDict):
    """Estimate of an effect."""

    # Milliseconds of wall time on all threads. Null if its time is part of other effects' rays.
    ms: float | None
    # Its own rays.
    rays: int
    # Their 95 % interval.
    rays_ci: list[int]


# States of an effect.
EffectState: TypeAlias = "Literal['on'] | Literal['removed'] | Literal['off']"


class EndedRay(TypedDict):
    """A ray that was not followed."""

    # How many 8-bit codes the pixel could have changed with it, at most; 255 if nothing bounds that.
    codes: int
    # Its kind.
    kind: RayKind
    # The weight it would have had.
    weight: list[float]
    # `depth`, `weight`, `budget`, or `roulette`, where others stand for it.
    why: str


# What pixels of a picture look like where they are larger than those of the rendered one.
Enlarged: TypeAlias = "Literal['smooth'] | Literal['nearest']"


class Environment(TypedDict):
    """Environment: the radiance of rays that hit nothing, by their direction, in place of `background`. One of
    `image`, `sky` and `studio`."""

    # Equirectangular PNG, JPEG, WebP, Radiance HDR or OpenEXR, as `panorama` cameras make it:
    # `"data:image/png;base64,..."`, or the name of a file beside the scene. Its middle is seen in direction -z, its
    # upper edge in direction +y.
    image: NotRequired[str | None]
    # Factor on its colors, at least 0. Default 1.
    intensity: NotRequired[float]
    # Whether it lights surfaces. Default `"none"`.
    light: NotRequired[EnvironmentLight]
    # Turns it around the y axis, in degrees, counter-clockwise seen from above, -360 to 360. Default 0.
    rotate_deg: NotRequired[float]
    # A clear sky over dull ground: `{}` for its colors by day.
    sky: NotRequired[Sky | None]
    # A photographer's studio with bright walls and soft panels of light: `{}`.
    studio: NotRequired[Studio | None]


# What an environment does to surfaces.
EnvironmentLight: TypeAlias = "Literal['none'] | Literal['fast']"


class ErrorBounds(TypedDict):
    """Error bounds by how they are known. Null means unknown, not exact."""

    # Bounds that likely hold. Null where pixels have one sample and are not compared with their neighbours.
    estimated: EstimatedError | None
    # Errors measured against a reference picture.
    measured: float | None
    # Bounds that certainly hold.
    proved: ProvedError


class ErrorEntry(TypedDict):
    """One thing that is wrong."""

    # The kind of mistake.
    code: str
    # Column in the line, from 1.
    column: NotRequired[int | None]
    # What is wrong, and what to do.
    detail: str
    # Line in the body, from 1.
    line: NotRequired[int | None]
    # Offset in a binary body, from 0.
    offset: NotRequired[int | None]
    # The query parameter that is wrong.
    parameter: NotRequired[str | None]
    # Where it is in the body: a JSON pointer as a URI fragment.
    pointer: NotRequired[str | None]


# Where an error comes from.
ErrorSource: TypeAlias = "Literal['truncation'] | Literal['total']"


class ErrorSpread(TypedDict):
    """How errors are spread over a picture."""

    # The largest.
    max: float
    # Their mean.
    mean: float
    # 95 % are not larger.
    p95: float
    # 99 % are not larger.
    p99: float
    # 99.9 % are not larger.
    p999: float


class Estimate(TypedDict):
    """Estimate of a picture."""

    # Whether even the pilot's first pixels took too long: then the picture takes at least what is said here.
    at_least: NotRequired[bool]
    # Camera rays.
    camera_rays: int
    # Milliseconds of wall time for tracing on `threads`, if nothing else runs on them.
    ms: float
    # Their 95 % interval.
    ms_ci: list[float]
    # Milliseconds of the pilot.
    pilot_ms: float
    # Pixels traced by the pilot.
    pilot_pixels: int
    # Pixels of the picture or its region.
    pixels: int
    # All rays, including shadow rays.
    rays: int
    # Their 95 % interval.
    rays_ci: list[int]
    # Pixels that antialiasing refines.
    refined_pixels: int
    # Threads of the pool.
    threads: int
    # Pixels whose proof is given up, since it would take too many rays: their bound is larger than what was asked
    # for.
    unproved_pixels: NotRequired[int]


class EstimatedError(TypedDict):
    """Error of sampling, estimated from the samples themselves."""

    # 8-bit codes that a share of the pixels is likely not further off, in the channel that is least sure.
    half_width_codes: float
    # How it was estimated.
    method: str
    # Where each pixel gets as many samples as its error asks for.
    samples: NotRequired[AdaptiveSamples | None]
    # That share.
    share_of_pixels: float
    # In the mode `statistical`: whether the target was reached.
    target: NotRequired[SamplingTarget | None]


class ExampleEntry(TypedDict):
    """ExampleEntry"""

    # What it shows, in a sentence.
    about: str
    # Where its text is.
    href: str
    # Its id, two words.
    id: str
    title: str


class Examples(TypedDict):
    """Scenes to begin with."""

    examples: list[ExampleEntry]


# The plan of a scene, with `actual` if the picture was rendered, or the estimates of several settings.
ExplainAnswer: TypeAlias = "Analyzed | Plan | SettingsEstimates"


# How a light fades with the distance d.
Falloff: TypeAlias = "Literal['none'] | dict[Literal['linear'], LinearFalloff] | Literal['inverse_square'] | dict[Literal['windowed'], WindowedFalloff]"


class FarmBacklog(TypedDict):
    """Seconds of one slot."""

    # Jobs of low priority.
    bulk: float
    # Renders that somebody waits for.
    hi: float
    # Jobs.
    norm: float


class FarmFaults(TypedDict):
    """What has gone wrong."""

    # What the broker has refused, such as missing permissions.
    broker_errors: int
    # Pieces that were given up; their jobs have failed.
    dead_letters: int
    # Tiles of which two nodes have made different pixels.
    determinism_alarms: int
    # How often the broker had no room for more work.
    queue_full: int
    # Slow pieces that a second node rendered, too.
    rendered_twice: int
    # Pieces that were lost, as when a node ends, and were sent again.
    sent_again: int


class FarmFigures(TypedDict):
    """The farm in figures."""

    # Seconds of one slot that the work takes which this front has for nodes, by how urgent it is.
    backlog_seconds: FarmBacklog
    # Pieces that nodes render now.
    busy: int
    # Whether the service reaches the broker now.
    connected: bool
    # What the nodes there are have done.
    done: FarmWorkDone
    # Each node. Null without the scope `admin`.
    each: list[FarmNode] | None
    # Nodes by how they are.
    nodes: FarmNodeCounts
    # Pieces that nodes which take work can render at one time.
    slots: int
    # What has gone wrong since this front was started.
    trouble: FarmFaults


class FarmNode(TypedDict):
    """A node."""

    # Pieces it renders now.
    busy: int
    # Pieces that failed.
    failures: int
    # Id of its process.
    id: str
    # What people call it.
    name: str
    # Pieces it has done.
    pieces: int
    # Why it is so.
    reason: str | None
    # Whether it renders the same pixels as this front. Only then it gets work of this front.
    same_renderer: bool
    # Pieces it renders at one time.
    slots: int
    # Seconds since it was started.
    started_s: int
    # How it is.
    state: NodeState
    # Tiles in them.
    tiles: int
    # The program's version.
    version: str


class FarmNodeCounts(TypedDict):
    """Nodes by how they are."""

    # They finish what they have, and end.
    draining: int
    # They take no work, since they do not trust themselves.
    excluded: int
    # They take work.
    ready: int


class FarmStatus(TypedDict):
    """The farm, if there is one."""

    # Null: the service renders itself.
    farm: FarmFigures | None


class FarmWorkDone(TypedDict):
    """What nodes have done since they were started."""

    # Seconds that slots have rendered.
    busy_seconds: float
    # Pieces that failed.
    failures: int
    # Pieces of work.
    pieces: int
    # Tiles in them.
    tiles: int


# How light gets from everywhere to surfaces.
Fidelity: TypeAlias = "Literal['fast'] | Literal['faithful']"


class Film(TypedDict):
    """How the light of a picture becomes the colors of its file. Light itself does not change, nor what is proved
    about it."""

    # What the camera sees where nothing is. Default: the scene's background.
    background: NotRequired[FilmBackground]
    # Exposure in stops, between -32 and 32: each doubles all light, before `tone`. Default 0.
    exposure: NotRequired[float]
    # How light brighter than white is compressed. Default: not at all. EXR and PFM keep the light as it is, without
    # exposure and tone.
    tone: NotRequired[ToneMapping]


# What the camera sees where nothing is.
FilmBackground: TypeAlias = "Literal['scene'] | Literal['transparent'] | dict[Literal['color'], Color]"


class FinerReference(TypedDict):
    """How much a reference changes on the small picture of the warm-up when its rays are followed further."""

    # The largest change of any pixel, in 8-bit codes.
    max_codes: int
    # Weight below which a ray is not followed then.
    min_weight: float


class FisheyeCamera(TypedDict):
    """Fisheye and dome."""

    # Eye point.
    eye: list[float]
    # Full angle across the circle in degrees, above 0, at most 360. Default 180.
    fov_deg: NotRequired[float]
    # Point in the middle of the circle.
    look_at: list[float]
    # Up direction. Default +y.
    up: NotRequired[list[float]]


# Parameters of the fixed mode: none.
Fixed: TypeAlias = "dict[str, Any]"


class Fog(TypedDict):
    """Fog outside of all closed bodies that transmit light. Over a length d it lets exp(-density d) of the light
    pass and replaces the rest by its own color. Rays that hit nothing pass through all of it, so fog without
    falloff hides the background. Fog affects camera, reflected and transmitted rays, but not the light from
    lights to surfaces."""

    # Radiance of dense fog. Default 0.8 grey.
    color: NotRequired[Color]
    # Optical depth of one scene unit, at least 0. 0 is no fog.
    density: float
    # Falloff with height. Default: none.
    height: NotRequired[FogHeight | None]


class FogHeight(TypedDict):
    """Fog that thins out with height: the density is constant up to y = base, and density exp(-(y - base)/falloff)
    above."""

    # y in scene units above which it thins out. Default 0.
    base: NotRequired[float]
    # Height in scene units over which the density falls to 1/e, above 0.
    falloff: float


class FormatEntry(TypedDict):
    """A format of pictures."""

    # Whether it holds linear floats.
    linear: bool
    # Whether it holds exactly the codes that were computed.
    lossless: bool
    # Its media type.
    media_type: str
    # Its name in queries, and its file ending.
    name: str
    # Query parameters for this format only, each as a JSON Schema.
    parameters: dict[str, dict[str, Any]]


class Formats(TypedDict):
    """The formats of pictures."""

    # All formats.
    formats: list[FormatEntry]


class FrameList(TypedDict):
    """Frames of a sequence."""

    # Those that are finished.
    frames: list[FrameReport]
    # Their sums, and the worst of their bounds.
    sequence: SequenceReport


class FrameReport(TypedDict):
    """A finished frame."""

    # How many of 255 codes of sampling error are likely. Null where nothing is known of it.
    estimated_codes: float | None
    # Id of its picture, if it has one.
    image_id: str | None
    # Its number, from 0.
    number: int
    # Its path.
    path: str
    # How many of 255 codes it is proved to be off at most. Null where there is no proof.
    proved_codes: int | None
    # All its rays.
    rays: int
    # Milliseconds of tracing.
    trace_ms: float


# How reflection and transmission depend on the angle of incidence theta.
Fresnel: TypeAlias = "Literal['none'] | Literal['dielectric'] | Literal['conductor']"


# A color that changes evenly from one point of object space to another, and is constant beyond them.
Gradient = TypedDict('Gradient', {
    'a': 'Color',
    'b': 'Color',
    'from': 'list[float]',
    'to': 'list[float]',
})


class Grain(TypedDict):
    """Noise as a height, from 0 to 1."""

    # Octaves, 1 to 12. Default 4.
    octaves: NotRequired[int]
    # Size of the coarsest features in scene units, above 0. Default 1.
    size: NotRequired[float]


class Group(TypedDict):
    """Objects that are transformed together."""

    # How it moves while the shutter is open, which blurs it. Default: not at all.
    motion: NotRequired[Motion | None]
    # A name, for people. At most 256 bytes.
    name: NotRequired[str | None]
    # The objects of the group.
    objects: list[Object]
    # Transform of the group. Default: none.
    transform: NotRequired[Transform]


# The description of an image by the IIIF Image API 3.0, section 5.
ImageInfo = TypedDict('ImageInfo', {
    '@context': 'str',
    'extraFeatures': 'list[str]',
    'extraFormats': 'list[str]',
    'extraQualities': 'list[str]',
    'height': 'int',
    'id': 'str',
    'maxArea': 'int',
    'preferredFormats': 'list[str]',
    'profile': 'str',
    'protocol': 'str',
    'sizes': 'list[InfoSize]',
    'tiles': 'list[InfoTile]',
    'type': 'str',
    'width': 'int',
})


class ImageMap(TypedDict):
    """A picture on a surface. Its middle is at (1/2, 1/2), u goes to the right and v up."""

    # Mapping of the picture to the surface. Default `"uv"`.
    mapping: NotRequired[Mapping]
    # PNG, JPEG, WebP or KTX 2.0 (Basis Universal): `"data:image/png;base64,..."`, or the name of a file beside the
    # scene, where files may be read. Transparency is ignored. Decoders of JPEG may round differently on other
    # processors; those of PNG do not.
    source: str
    # The texture beyond the edges of the picture. Default `"repeat"`.
    wrap: NotRequired[Wrap]


class ImageSize(TypedDict):
    """Size of the picture in pixels."""

    # Pixels down, 1 to 16384. Default 540.
    height: NotRequired[int]
    # Pixels across, 1 to 16384. Default 960.
    width: NotRequired[int]


class ImportWarning(TypedDict):
    """What of a model is approximated, left out or assumed."""

    # What happens to it.
    code: ImportWarningCode
    # One sentence, of at most 1024 characters.
    detail: str
    # The fidelity that it holds for. Default: each.
    fidelity: NotRequired[Fidelity | None]


# What happens to something of a model.
ImportWarningCode: TypeAlias = "Literal['not-simulated', 'approximated', 'skipped', 'assumed']"


class InfoSize(TypedDict):
    """A size of an image."""

    # Pixels down.
    height: int
    # `Size`.
    type: str
    # Pixels across.
    width: int


class InfoTile(TypedDict):
    """Tiles of an image."""

    # Pixels down.
    height: int
    # Pixels of the image for one pixel of a tile, across and down.
    scaleFactors: list[int]
    # `Tile`.
    type: str
    # Pixels across.
    width: int


class Instance(TypedDict):
    """One placed copy of a definition. Copies share the memory of the definition."""

    # How it moves while the shutter is open, which blurs it. Default: not at all.
    motion: NotRequired[Motion | None]
    # A name, for people. At most 256 bytes.
    name: NotRequired[str | None]
    # Name in `definitions`.
    of: str
    # Transform of the copy. Default: none.
    transform: NotRequired[Transform]


class JobChange(TypedDict):
    """A change of a job."""

    # 0 to 100.
    priority: NotRequired[int | None]


class JobCounts(TypedDict):
    """How many jobs there are."""

    # Jobs that are rendered.
    running: int
    # Jobs that wait.
    waiting: int


class JobFailure(TypedDict):
    """A problem inside of another document."""

    # What is wrong, and what to do.
    detail: str
    # The status that an answer with this problem has.
    status: int
    # What kind of problem it is.
    title: str
    # Path of the page about this kind of problem, `/problems/{slug}`.
    type: str


class JobFrames(TypedDict):
    """What is known of a job's frames without its sequence."""

    # How many there are.
    count: int
    # How many are finished.
    done: int
    # How often animations are shown; 0: again and again.
    loops: int
    # Frames a second of animations.
    rate: float


class JobLimits(TypedDict):
    """Limits of jobs, and how long they are kept."""

    # Bytes that the scenes and pictures of jobs may take on disk. If there is no room, the oldest pictures of the
    # tenant that has most are deleted. The scene of one job may take half of it, and so may its tiles and its
    # picture.
    data_bytes: int
    # Whether jobs outlive the service.
    durable: bool
    # Pixels of a job's picture.
    job_max_pixels: int
    # Samples of a job's picture: its pixels times the samples of each.
    job_max_samples_total: int
    # Bytes of memory that running jobs may take together [default: half of what the machine, or its container,
    # has].
    job_memory_bytes: int
    # Seconds that a job may run.
    job_timeout_s: float
    # Jobs that wait or run; one more is answered with 503.
    jobs: int
    # Ended jobs of one tenant that are kept; of more, the oldest are forgotten.
    keep_jobs: int
    # Seconds that a job's picture is kept.
    keep_pictures_s: float
    # Seconds that a job is remembered after its end, or after its picture was deleted.
    keep_records_s: float


class JobLinks(TypedDict):
    """Paths of a job and what belongs to it, and of its picture and tiles if they have ids."""

    # All of them in one file.
    animation: NotRequired[str | None]
    # Stops it.
    cancel: str
    # The description of the image for DZI.
    dzi: NotRequired[str | None]
    # Its events.
    events: str
    # The frames of a sequence.
    frames: NotRequired[str | None]
    # The description of the image for IIIF.
    iiif: NotRequired[str | None]
    # The picture.
    image: str
    # The picture by its id.
    picture: NotRequired[str | None]
    # The picture so far.
    preview: str
    # The canonical text of its scene, with the settings in it.
    scene: NotRequired[str | None]
    # The job.
    self: str
    # All of them on a contact sheet.
    sheet: NotRequired[str | None]
    # The description of the image's tiles for XYZ.
    xyz: NotRequired[str | None]


class JobList(TypedDict):
    """Jobs, the newest first."""

    # The jobs.
    jobs: list[JobView]
    # `cursor` of the next page; null on the last one.
    next: str | None


class JobProgress(TypedDict):
    """Progress of a job."""

    # From 0 to 1.
    fraction: float
    # Rays of the finished tiles.
    rays: int
    # Finished tiles.
    tiles_done: int
    # All tiles.
    tiles_total: int


class JobRequest(TypedDict):
    """A request for a job."""

    # Frames of the scene: a sequence. Default: a single picture.
    frames: NotRequired[Sequence | None]
    # Labels, by which jobs can be listed.
    labels: NotRequired[list[str]]
    # Format of the picture, by the names of the query parameters of `POST /v1/render`.
    output: NotRequired[PictureOutput]
    # Priority among the tenant's jobs, from 0 to 100, 50 by default.
    priority: NotRequired[int | None]
    # The scene.
    scene: Scene
    # Settings that replace the scene's, by the names of the query parameters of `POST /v1/render`.
    settings: NotRequired[Overrides]
    # Puts the picture and its cost report into the store of the service when the job has succeeded.
    store: NotRequired[StoreRequest | None]
    # A receiver that hears how the job ends.
    webhook: NotRequired[WebhookRequest | None]


# State of a job.
JobState: TypeAlias = "Literal['queued'] | Literal['running'] | Literal['succeeded'] | Literal['failed'] | Literal['canceled'] | Literal['expired']"


class JobStats(TypedDict):
    """Cost of a job, over all restarts."""

    # Milliseconds spent reading and building the scene, since the last restart.
    bvh_ms: float
    # Milliseconds of encoding the picture.
    encode_ms: float
    # Bytes of the picture file.
    picture_bytes: int
    # Milliseconds from acceptance until it was first started.
    queue_ms: float
    # Rays of all tiles.
    rays: int
    # Milliseconds of tracing, since the last restart.
    render_ms: float
    # Whether the picture existed already and nothing was rendered.
    reused: bool
    # Tiles that were finished before the last restart and not rendered again.
    tiles_recovered: int


class JobView(TypedDict):
    """A job."""

    # When it was accepted (RFC 3339).
    created_at: str
    # Estimated milliseconds on a machine that does nothing else.
    estimate_ms: float
    # Estimated milliseconds until it is done.
    eta_ms: float | None
    # When it will be deleted.
    expires_at: str | None
    # When it ended.
    finished_at: str | None
    # The frames of a sequence.
    frames: NotRequired[JobFrames | None]
    # Pixels down.
    height: int
    # A UUID of version 7.
    id: str
    # Id of the picture, if it has one.
    image_id: str | None
    # The owner's labels.
    labels: list[str]
    # Paths of the job and what belongs to it.
    links: JobLinks
    # Its position among the tenant's waiting jobs, from 1.
    position: int | None
    # 0 to 100.
    priority: int
    # Why it failed.
    problem: NotRequired[JobFailure | None]
    # Its progress.
    progress: JobProgress
    # What the picture cost, and how far it may be from the exact one. Only in the answer about a single job that
    # has succeeded.
    report: NotRequired[CostReport | None]
    # Id of the scene with the settings in it. Null if its picture depends on a clock or on files.
    scene_id: str | None
    # What the frames of a sequence cost, and the worst of their bounds. Only in the answer about a single job that
    # has succeeded.
    sequence: NotRequired[SequenceReport | None]
    # When it was first started.
    started_at: str | None
    # Its state.
    state: JobState
    # Its cost.
    stats: JobStats
    # Its picture in the store, if it asked for that.
    store: NotRequired[StoredView | None]
    # The tenant that owns it.
    tenant: str
    # Edge of a tile in pixels; 0 if the picture is one tile.
    tile: int
    # The message about its end, if it has a webhook.
    webhook: NotRequired[DeliveryView | None]
    # Pixels across.
    width: int


class KeyInfo(TypedDict):
    """The tenant of a key."""

    # Bytes of the assets that it has sent.
    asset_bytes: int
    # Waiting and running jobs that it may have.
    most_jobs: int
    # Event streams that it may have open.
    most_streams: int
    # Whether the service asks for keys. Without them everybody is the same tenant.
    needs_keys: bool
    # What the key may do.
    scopes: list[Scope]
    # Its name.
    tenant: str
    # What is left of the units of a minute. Null: unlimited.
    units: RateLimitUnits | None
    # The tenant's share of the renderer beside others.
    weight: int


class KnownScene(TypedDict):
    """A stored scene."""

    # Estimated rays and milliseconds of its picture.
    estimate: Estimate
    # Pixels down.
    height: int
    # The id of its picture, opened as 2^zoom times its size.
    image_id: str
    # Paths of the scene, its picture and its tiles.
    links: SceneLinks
    # Its id: a hash of what it says, not of how it was written.
    scene_id: str
    # Warnings about the scene.
    warnings: list[SceneProblem]
    # Pixels across.
    width: int
    # The scene was opened as 2^zoom times its size.
    zoom: int


# Light sources.
Light: TypeAlias = "dict[Literal['point'], PointLight] | dict[Literal['directional'], DirectionalLight] | dict[Literal['spot'], SpotLight]"


class LimitEntry(TypedDict):
    """A limit by name."""

    # The largest value allowed.
    max: int
    # Its name in `/v1/limits`.
    name: str


class LinearFalloff(TypedDict):
    """Parameters of the linear falloff."""

    # Distance at which the light is gone, above 0.
    reach: float


# Mapping of a picture to a surface.
Mapping: TypeAlias = "Literal['uv'] | dict[Literal['planar'], Planar] | dict[Literal['spherical'], Spherical]"


class Material(TypedDict):
    """How a surface reflects and transmits light: `L = L_Phong + r_s L_s + r_t L_t` with `L_Phong = k_a I_a + sum
    over lights (k_d (N.L) + k_s (R.V)^m) I`."""

    # sigma of the law of Beer and Lambert, per scene unit: over a length d inside, a closed body lets exp(-sigma d)
    # of the light pass. Lengths are in world space, so a larger instance is darker. Where bodies overlap the
    # smaller one decides. Shadow rays are absorbed if `render.shadows` is `"transmissive"`. Default 0.
    absorption: NotRequired[Color]
    # k_a, factor on the scene's ambient light. Default: the diffuse color.
    ambient: NotRequired[Diffuse | None]
    # Bumps on the surface. Default: none.
    bump: NotRequired[Bump | None]
    # k_d, a color or a texture. Default 0.8 grey.
    diffuse: NotRequired[Diffuse]
    # Mean dispersion n_F - n_C, the difference of the indices of blue (486.1 nm) and red light (656.3 nm), 0 to
    # 0.2; `ior` is that of yellow light (587.6 nm). Crown glass has 0.008, flint 0.026, diamond 0.025. Default 0.
    dispersion: NotRequired[float]
    # Radiance that the surface emits on both sides. It is visible, but not a light source: it does not light other
    # surfaces, except by `render.color_bleeding`. Default 0.
    emission: NotRequired[Color]
    # How reflection and transmission depend on the angle of incidence. Default `"none"`. For shadow rays only
    # `transmission` counts.
    fresnel: NotRequired[Fresnel]
    # Index of refraction, 0.01 to 100. Default 1.5.
    ior: NotRequired[float]
    # Normals from a picture, not together with `bump`. Default: none.
    normal_map: NotRequired[NormalMap | None]
    # Whether rays hit the surface only from its front. Default false.
    one_sided: NotRequired[bool]
    # A material as in glTF, in place of all keys above but `one_sided`. Default: none.
    pbr: NotRequired[Pbr | None]
    # r_s, factor on the light of the reflected ray. Default 0.
    reflection: NotRequired[Color]
    # Roughness for reflected and transmitted rays, 0 to 1: the square root of the width alpha of the GGX
    # distribution of facets. Default 0, a perfect mirror.
    roughness: NotRequired[float]
    # m, the Phong exponent, 0 to 1e6. Default 32.
    shininess: NotRequired[float]
    # k_s, strength of the Phong highlight. Default 0.
    specular: NotRequired[Color]
    # r_t, factor on the light of the transmitted ray. Default 0.
    transmission: NotRequired[Color]


class MeasuredErrors(TypedDict):
    """Errors of one picture, kept apart by where they come from. None: there was no reference to measure against."""

    # Of too few samples: of the reference with the same samples against that with 64.
    sampling: Difference | None
    # Of both: against the reference with 64 samples.
    total: Difference | None
    # Of ending the recursion, and of rounding: against the same samples followed as far as the reference's.
    truncation: Difference | None


class Mesh(TypedDict):
    """Triangles over shared vertices; fronts see their corners counter-clockwise. The fronts bound one body."""

    # Colors, linear red, green, blue and alpha for each vertex, 0 to 1. They multiply `base_color` and `opacity` of
    # a `pbr` material; others ignore them.
    colors: NotRequired[list[list[float]] | None]
    # Three indices of vertices each, from 0.
    faces: list[list[int]]
    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Shading normals, one for each vertex; without them faces are flat.
    normals: NotRequired[list[list[float]] | None]
    # For the normal map of a `pbr` material, one for each vertex: the direction in which the first texture
    # coordinate grows, and 1 or -1, which turns the direction of the second. Default: as the texture coordinates
    # say.
    tangents: NotRequired[list[list[float]] | None]
    # Texture coordinates, one pair for each vertex.
    uvs: NotRequired[list[list[float]] | None]
    # Other texture coordinates, one pair for each vertex.
    uvs1: NotRequired[list[list[float]] | None]
    # The points.
    vertices: list[list[float]]


class MissingAssets(TypedDict):
    """Assets that have to be sent."""

    # Their SHA-256 in hexadecimal digits.
    missing: list[str]


class Motion(TypedDict):
    """A steady motion while the shutter is open, from the position that `transform` gives. Rotation comes before
    translation."""

    # A point of the axis of rotation. Default: the origin.
    center: NotRequired[list[float] | None]
    # Rotated around an axis through `center`.
    rotate_deg: NotRequired[Rotation | None]
    # Moved by.
    translate: NotRequired[list[float] | None]


# One of several in a file: its place, from 0, or its name.
NameOrIndex: TypeAlias = "int | str"


# How a node is.
NodeState: TypeAlias = "Literal['ready'] | Literal['draining'] | Literal['excluded']"


class Noise(TypedDict):
    """Clouds between two colors: Perlin's gradient noise (2002) in object space. Each octave has half the size and
    half the strength of the one before."""

    # Color where the noise is lowest.
    a: Color
    # Color where the noise is highest.
    b: Color
    # Octaves, 1 to 12. Default 4.
    octaves: NotRequired[int]
    # Size of the coarsest features in scene units, above 0. Default 1.
    size: NotRequired[float]


class NormalMap(TypedDict):
    """Normals from a picture: red, green and blue from 0 to 255 are x, y and z from -1 to 1, where x is the
    direction in which u grows, y that of v (up in the picture, as in OpenGL), and z the normal; 128 is 0."""

    # The picture.
    image: ImageMap


# A value, or a picture times a value: {"factor": ..., "image": "..."}.
NumberChannel: TypeAlias = "float | dict[Literal['channel'], TexelChannel | None] | dict[Literal['enlarged'], Enlarged] | dict[Literal['factor'], float] | dict[Literal['image'], str] | dict[Literal['transform'], UvTransform] | dict[Literal['uv'], int] | dict[Literal['wrap'], Wraps]"


# Things in a scene. `sphere`, `box`, `torus`, `mesh`, capped `cylinder` and `cone` and the half-space of a
# `plane` are closed bodies: light that passes their surface is refracted. `disc`, `triangle`, `quad`, `polygon`
# and uncapped `cylinder` and `cone` enclose nothing: they are infinitely thin, and light passes them without
# bending.
Object: TypeAlias = "dict[Literal['sphere'], Sphere] | dict[Literal['plane'], Plane] | dict[Literal['disc'], Disc] | dict[Literal['triangle'], Triangle] | dict[Literal['quad'], Quad] | dict[Literal['box'], AxisBox] | dict[Literal['cylinder'], Cylinder] | dict[Literal['cone'], Cone] | dict[Literal['torus'], Torus] | dict[Literal['mesh'], Mesh] | dict[Literal['polygon'], Polygon] | dict[Literal['group'], Group] | dict[Literal['instance'], Instance] | dict[Literal['model'], PlacedModel]"


class ObjectMap(TypedDict):
    """Whose surface is seen in each pixel."""

    # Numbers in a row.
    columns: int
    # Pixels down.
    h: int
    # What is seen, in the order in which it is met, row by row.
    objects: list[SeenObject]
    # Rows.
    rows: int
    # Row by row, pairs of a number and how often it comes next: 0 where nothing is seen, n for the n-th of
    # `objects`.
    runs: list[list[int]]
    # Each number stands for so many pixels across and down.
    step: int
    # Pixels across.
    w: int
    # The part of the picture: left edge.
    x: int
    # Upper edge.
    y: int


class Opacity(TypedDict):
    """How much of a surface is there."""

    # The share of the surface that is there, 0 to 1. The fourth number of a mesh's `colors` multiplies it. Default
    # 1.
    alpha: NotRequired[NumberChannel]
    # With `"mask"`: the least alpha at which the surface is there, 0 to 1. Default 0.5.
    cutoff: NotRequired[float]
    # What `alpha` means. Default `"blend"`.
    mode: NotRequired[AlphaMode]


class OrthographicCamera(TypedDict):
    """Parallel projection."""

    # Point in the middle of the plane on which the rays start.
    eye: list[float]
    # Height of the picture in scene units, above 0.
    height: float
    # Point in the middle of the picture.
    look_at: list[float]
    # Up direction. Default +y.
    up: NotRequired[list[float]]


class Overrides(TypedDict):
    """Settings over the scene's."""

    # What ends the recursion: `fixed`, `proved:CODES`, `time:MILLISECONDS`, `rays:COUNT`, or `statistical:CODES`
    # with `,CONFIDENCE` after it or not.
    accuracy: NotRequired[str]
    # Which animation of a model's file, by its place from 0 or its name.
    animation: NotRequired[str]
    # Whether pixels that differ from a neighbor get more samples.
    antialias: NotRequired[bool]
    # What the camera sees where nothing is: `scene`, `transparent`, or a color as rrggbb, which the picture shows
    # as it is.
    background: NotRequired[str]
    # Which camera of a model's file sees it, from 0.
    camera: NotRequired[int]
    # Pixels of the device for each of width and height, which are the scene's where they are not given.
    dpr: NotRequired[float]
    # Exposure in stops, each of which doubles the light, in place of the scene's.
    exposure: NotRequired[float]
    # How light gets from everywhere to surfaces.
    fidelity: NotRequired[Literal['fast', 'faithful']]
    # Pixels down, in place of the scene's.
    height: NotRequired[int]
    # Which lights shine on a model.
    light: NotRequired[Literal['auto', 'studio', 'file']]
    # Longest chain of rays; the primary ray counts 1.
    max_depth: NotRequired[int]
    # Weight below which a ray is not followed.
    min_weight: NotRequired[float]
    # Floating-point format of the whole trace.
    precision: NotRequired[Literal['single', 'double']]
    # Samples for each pixel.
    samples: NotRequired[int]
    # Which scene of a model's file, from 0.
    scene: NotRequired[int]
    # A size by its name, in place of width and height: `og` is that of a preview of a page, 1200 x 630.
    size: NotRequired[Literal['og']]
    # Whether what a model requires and is not simulated is refused.
    strict: NotRequired[bool]
    # Seconds since the start of the animation.
    t: NotRequired[float]
    # How light brighter than white is compressed, in place of what the scene says.
    tone: NotRequired[Literal['none', 'khronos_pbr_neutral', 'agx']]
    # Which axis of a model is up.
    up: NotRequired[Literal['y', 'z']]
    # Which variant of a model's materials, by its place from 0 or its name.
    variant: NotRequired[str]
    # From where a model is seen: three_quarter (default), front, back, left, right, top, bottom, iso, or two angles
    # in degrees around it and from above, as 30,70.
    view: NotRequired[str]
    # Pixels across, in place of the scene's.
    width: NotRequired[int]


class PanoramaCamera(TypedDict):
    """Equirectangular panorama."""

    # Eye point.
    eye: list[float]
    # Angle across the picture in degrees, above 0, at most 360. Default 360.
    hfov_deg: NotRequired[float]
    # Point in the middle of the picture.
    look_at: list[float]
    # Up direction. Default +y.
    up: NotRequired[list[float]]
    # Angle down the picture in degrees, above 0, at most 180. Default 180.
    vfov_deg: NotRequired[float]


class ParallelogramArea(TypedDict):
    """A parallelogram whose middle is a light's position."""

    # One edge.
    u: list[float]
    # The other edge.
    v: list[float]


class Pbr(TypedDict):
    """A material of metal, plastic, glass or lacquer, as glTF 2.0 describes it in appendix B. Names, defaults and
    meanings are those of glTF. It replaces all other keys of a material but `one_sided`."""

    # What a closed body absorbs. Default: nothing.
    attenuation: NotRequired[Attenuation | None]
    # Color of what is scattered, or of a metal's reflection, 0 to 1 in each channel. The `colors` of a mesh
    # multiply it. Default white.
    base_color: NotRequired[ColorChannel]
    # Strength of a layer of lacquer over all, 0 to 1. Default 0.
    clearcoat: NotRequired[NumberChannel]
    # Normals of the lacquer from a picture, as in `normal`. Default: none; the lacquer is even, also over a surface
    # with `normal`.
    clearcoat_normal: NotRequired[dict[Literal['channel'], TexelChannel | None] | dict[Literal['enlarged'], Enlarged] | dict[Literal['factor'], float] | dict[Literal['image'], str] | dict[Literal['transform'], UvTransform] | dict[Literal['uv'], int] | dict[Literal['wrap'], Wraps] | None]
    # Roughness of the lacquer, 0 to 1. Default 0.
    clearcoat_roughness: NotRequired[NumberChannel]
    # 20 over the Abbe number. What follows, a mean dispersion of (ior - 1)/20 times this, is limited to 0.2.
    # Default 0: none.
    dispersion: NotRequired[float]
    # With `shadow_catcher`: the border of the picture in which shadows fade, as a share of its width and height, 0
    # to 0.5, so that none ends as if cut off at an edge. Pinhole and orthographic cameras only. Default 0.
    edge_fade: NotRequired[float]
    # Radiance that the surface emits. It lights no other surface. Default 0.
    emissive: NotRequired[ColorChannel]
    # Index of refraction, 1 to 100. Default 1.5.
    ior: NotRequired[float]
    # 1 for metals, 0 for all else. Default 1.
    metallic: NotRequired[NumberChannel]
    # Normals from a picture, as in `normal_map`; `factor` multiplies x and y. Default: none.
    normal: NotRequired[dict[Literal['channel'], TexelChannel | None] | dict[Literal['enlarged'], Enlarged] | dict[Literal['factor'], float] | dict[Literal['image'], str] | dict[Literal['transform'], UvTransform] | dict[Literal['uv'], int] | dict[Literal['wrap'], Wraps] | None]
    # The share of the light from all around that reaches the surface: 1 + factor (texel - 1). It does not dim
    # lights. Default: all.
    occlusion: NotRequired[dict[Literal['channel'], TexelChannel | None] | dict[Literal['enlarged'], Enlarged] | dict[Literal['factor'], float] | dict[Literal['image'], str] | dict[Literal['transform'], UvTransform] | dict[Literal['uv'], int] | dict[Literal['wrap'], Wraps] | None]
    # How much of the surface is there; light goes straight through the rest, and so do shadow rays. Default: all.
    opacity: NotRequired[Opacity | None]
    # Roughness, 0 to 1: the square root of the width alpha of the GGX distribution of facets. Default 1.
    roughness: NotRequired[NumberChannel]
    # Whether the surface shows shadows alone: light goes straight on through it, but for the share of all light
    # that bodies hide from it. No other key but `edge_fade` counts; the fourth number of a mesh's `colors` is how
    # much of the shadows is seen. Default false.
    shadow_catcher: NotRequired[bool]
    # Strength of a dielectric's reflection, 0 to 1. Default 1.
    specular: NotRequired[NumberChannel]
    # Color of a dielectric's reflection at normal incidence, on which it is a factor: above 1 more is reflected
    # than `ior` says, at most all. Default white.
    specular_color: NotRequired[ColorChannel]
    # Whether the surface is a thin sheet that does not bend light, also if its mesh is closed. Default false.
    thin: NotRequired[bool]
    # The share of what a dielectric does not mirror that passes through it, colored by `base_color`; the rest is
    # scattered. Default 0.
    transmission: NotRequired[NumberChannel]
    # Whether the surface shows `base_color` whatever the light is, and nothing else. A film with
    # `"khronos_pbr_neutral"` shows it as it is, also if it is exposed, up to the code 226; brighter colors fade
    # with all others. Default false.
    unlit: NotRequired[bool]


class PhaseTimes(TypedDict):
    """Milliseconds by phase, in order."""

    # Building bounding volume hierarchies.
    bvh: float
    # Reading the scene.
    parse: float
    # Checking and compiling it.
    plan: float
    # Encoding the picture, whatever its format.
    png: float
    # The part of `trace` that antialiasing took.
    refine: float
    # Tracing.
    trace: float


class PictureCost(TypedDict):
    """Time and rays."""

    # Camera rays that hit something.
    camera_hits: int
    # Rays in the longest chain.
    deepest: int
    # Milliseconds by phase.
    phases_ms: PhaseTimes
    # Estimate that was made before, from a few of the pixels.
    predicted: NotRequired[Estimate | None]
    # How far a picture of the modes `time` and `rays` came.
    progress: NotRequired[RenderProgress | None]
    # Rays by kind.
    rays: RayCounts
    # What antialiasing added.
    refined: Refined
    # Threads of the pool.
    threads: int
    # Milliseconds from the scene's bytes to the picture's.
    wall_ms: float


class PictureDifference(TypedDict):
    """How far two pictures are from each other."""

    # The id of `a`, if it has one.
    a: str | None
    # The id of `b`.
    b: str | None
    # CIEDE2000; 1 is just visible. Null likewise.
    ciede2000: ErrorSpread | None
    # In 8-bit codes of the worst channel.
    codes: CodeErrors
    # FLIP, 0 to 1, with `a` as the reference. Null for pictures of more than 4,194,304 pixels.
    flip: ErrorSpread | None
    # Pixels down.
    height: int
    # Square root of the mean square over all channels, in codes.
    rms_codes: float
    # Whether all codes are the same.
    same: bool
    # Pixels across.
    width: int


class PictureOutput(TypedDict):
    """How a picture is written."""

    # Bits for each channel of a PNG; other formats refuse it.
    bits: NotRequired[Literal['8', '16']]
    # Format of the picture, whatever `Accept` says.
    format: NotRequired[Literal['png', 'jpg', 'webp', 'exr', 'pfm']]
    # Quality of a JPEG, 90 if it is not given; other formats refuse it.
    quality: NotRequired[int]


class PinholeCamera(TypedDict):
    """Perspective camera."""

    # Diameter of the lens in scene units, at least 0. Objects away from the focus distance are blurred. Default 0:
    # a pinhole, for which everything is sharp.
    aperture: NotRequired[float]
    # Eye point.
    eye: list[float]
    # Distance of the plane in focus, along the view direction, above 0. Default: the distance of `look_at`.
    focus_distance: NotRequired[float | None]
    # Point in the middle of the picture.
    look_at: list[float]
    # Up direction. Default +y.
    up: NotRequired[list[float]]
    # Full vertical angle of view in degrees, edge to edge, above 0 and below 180. Default 45.
    vfov_deg: NotRequired[float]


class PlacedModel(TypedDict):
    """A model that another program has written: glTF, OBJ, STL or PLY. Its meshes and materials are in its file;
    camera, lights and floor are the scene's."""

    # Which of its animations is played, by its place from 0 or its name. Default: none, the pose at rest.
    animation: NotRequired[NameOrIndex | None]
    # The file: `sha256:` and the digits of an asset, or the name of a file. It is whole, without other parts.
    asset: str
    # Materials in place of its own, by their names in the file.
    materials: NotRequired[dict[str, Material]]
    # How it moves while the shutter is open, which blurs it. Default: not at all.
    motion: NotRequired[Motion | None]
    # A name, for people. At most 256 bytes.
    name: NotRequired[str | None]
    # Which of its scenes, from 0. Default: the one that it names.
    scene: NotRequired[int | None]
    # Seconds since the start of the animation, at least 0, of the first one if none is named.
    t: NotRequired[float | None]
    # Where it is put. Default: as it is in its file.
    transform: NotRequired[Transform]
    # Which axis of it is up. Default: z for STL, y for all else.
    up: NotRequired[UpAxis | None]
    # Which of its variants of materials, by its place from 0 or its name.
    variant: NotRequired[NameOrIndex | None]


class Plan(TypedDict):
    """The plan of a scene."""

    # Depth of the recursion.
    depth: Depth
    # Every effect the renderer knows.
    effects: list[Effect]
    # Estimate of the picture.
    estimate: NotRequired[Estimate | None]
    # Milliseconds that the plan took, with its estimates, but without loading the scene.
    explain_ms: float
    # Features it contains besides camera and shadow rays, as `REFLECTION|TRANSMISSION`. `LOCAL`: none.
    kernel: str
    # Hash of all that selects machine code: kernel, precision, instruction set, version.
    kernel_hash: str
    # Effects of light that no ray of the picture simulates.
    not_simulated: list[str]
    # Most primitives that lie around one point. A ray may take as many steps there, which the estimate does not
    # include.
    overlap: float
    # Floating-point format.
    precision: Precision
    # Features that the scene does not need.
    superset_of_needed: list[str]
    # Warnings about the scene.
    warnings: list[SceneProblem]


class Planar(TypedDict):
    """A picture projected along an axis. Its lower left corner lies at the origin of object space."""

    # The plane it lies in. Default `"xz"`, a floor.
    axes: NotRequired[PlanarAxes]
    # Width of the picture in scene units, above 0; its height follows from its shape. Default 1.
    size: NotRequired[float]


# A plane of object space. Seen from the positive side of the third axis, the picture is not mirrored: its right
# and up are x and y, x and -z, or -z and y.
PlanarAxes: TypeAlias = "Literal['xy', 'xz', 'yz']"


class Plane(TypedDict):
    """Infinite plane, which bounds the half-space behind it."""

    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Direction of its front, any length but 0.
    normal: list[float]
    # Any point of the plane.
    point: list[float]


class PointLight(TypedDict):
    """Point light."""

    # The area it shines from, around its position; shadows get soft edges. Default: a point.
    area: NotRequired[Area | None]
    # Its color. Default white.
    color: NotRequired[Color]
    # How it fades with distance. Default: not at all.
    falloff: NotRequired[Falloff]
    # Factor on the color, at least 0. Default 1.
    intensity: NotRequired[float]
    # Where it stands.
    position: list[float]


class Polygon(TypedDict):
    """Planar polygon, which may be concave; its front sees the vertices counter-clockwise."""

    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # The corners, in order around it; edges must not cross.
    vertices: list[list[float]]


# Floating-point format of the whole trace.
Precision: TypeAlias = "Literal['single'] | Literal['double']"


class ProblemDocument(TypedDict):
    """A problem (RFC 9457)."""

    # With 406: the formats there are.
    available: NotRequired[list[str]]
    # What is wrong, and what to do.
    detail: str
    # What is wrong, one by one, up to the limit `problems`.
    errors: NotRequired[list[ErrorEntry]]
    # The request's id, as in `X-Request-Id`.
    instance: str
    # The limit that was exceeded; `/v1/limits` has all limits.
    limit: NotRequired[LimitEntry | None]
    # Of assets that are missing: the SHA-256 of each.
    missing: NotRequired[list[str]]
    # Number of further errors. The check stops after a thousand.
    more: NotRequired[int]
    # With 403: the scope that the key lacks.
    scope: NotRequired[str | None]
    # The status that an answer with this problem has.
    status: int
    # What to do instead, as one word.
    suggest: NotRequired[str | None]
    # What kind of problem it is.
    title: str
    # Path of the page about this kind of problem, `/problems/{slug}`.
    type: str


class Proved(TypedDict):
    """Parameters of the proved mode."""

    # Largest error of each channel in 8-bit codes, 0 to 2. 0 gives the PNG of recursion without end.
    max_codes: int


class ProvedError(TypedDict):
    """Bound on the error of ending the recursion."""

    # JSON pointers of what the sentence is about.
    because: list[str]
    # The largest radiance of a ray that may go on for all of it. None where nothing bounds it.
    ceiling: list[float] | None
    # Share of pixels that are the same in an 8-bit PNG.
    identical_fraction: NotRequired[float]
    # Most 8-bit codes that any channel of any pixel is off.
    max_codes: NotRequired[int]
    # Longest chain of rays of that picture; none for recursion without end.
    max_depth: int | None
    # Most linear light that each channel of any pixel lacks; none where nothing bounds it.
    max_linear: NotRequired[list[float] | None]
    # Errors that it does not cover.
    not_covered: list[str]
    # The picture that it compares with.
    reference: str
    # Why the bound is larger than what was asked for, or than 1 code, and what to do about it.
    shortfall: NotRequired[str | None]
    # What decides that, in a sentence.
    why: str
    # Column and row of the pixel that may be off by most codes, and of those by most light; none if none is off.
    worst_pixel: NotRequired[list[int] | None]


class Quad(TypedDict):
    """Two triangles 0 1 2 and 0 2 3; planar for most uses, but it need not be."""

    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # The corners, in order around it.
    vertices: list[list[float]]


class QueueLane(TypedDict):
    """A lane of the scheduler."""

    # How many are worked on, in turn.
    running: int
    # How many wait.
    waiting: int


class QueueStatus(TypedDict):
    """Who has the renderer and waits for it."""

    # Jobs.
    jobs: QueueLane
    # Requests for pictures and answers.
    renders: QueueLane
    # Seconds until a request that comes now should have its turn, at the pace of the last ones.
    seconds_ahead: int
    # Threads of the renderer.
    threads: int
    # Requests for tiles.
    tiles: QueueLane


class RateLimitUnits(TypedDict):
    """Units of cost: one for each request, and one for each million rays."""

    # Seconds until all are there again.
    full_in_s: int
    # Units that are left.
    left: int
    # Units in a minute.
    per_minute: int


class RayAnswer(TypedDict):
    """What a ray hits."""

    # JSON pointer of the body itself, if it stands in a group or definition.
    body: NotRequired[str | None]
    # Whether the ray goes into the body's material.
    entering: NotRequired[bool]
    # Whether it hits anything; the other keys are there only if it does.
    hit: bool
    # Name of the body.
    name: NotRequired[str | None]
    # Unit geometric normal, pointing out of the body's material.
    normal: NotRequired[list[float]]
    # JSON pointer of the object in `objects`.
    object: NotRequired[str]
    # The point on the surface.
    point: NotRequired[list[float]]
    # Unpolarised Fresnel reflectance between the media at the surface, whether or not the body transmits.
    reflectance: NotRequired[float]
    # Unit mirror direction.
    reflected: NotRequired[list[float]]
    # Ray parameter, in units of the direction.
    t: NotRequired[float]
    # Whether there is total internal reflection.
    tir: NotRequired[bool]
    # Unit direction of the transmitted ray; `None` if the body is opaque or all is reflected.
    transmitted: NotRequired[list[float] | None]


class RayAnswers(TypedDict):
    """What the rays hit, in their order."""

    # One for each ray.
    answers: list[RayAnswer]


class RayCounts(TypedDict):
    """Rays by kind."""

    camera: int
    # Rays not followed because a sample reached the limit `rays_per_sample`, or a pixel the limit of its proof.
    dropped: int
    # Rays from diffuse surfaces, for color bleeding and global illumination.
    gathered: int
    reflected: int
    shadow: int
    # Shadow rays not traced, since their light could add less than the pruning rule asks for: a quarter of
    # `min_weight`, or what the proof can spare.
    shadow_skipped: int
    # Transmissions that total internal reflection turned into reflections.
    total_internal_reflections: int
    transmitted: int


# Whitted's kinds of rays that are followed.
RayKind: TypeAlias = "Literal['camera', 'reflected', 'transmitted'] | Literal['gathered']"


class RayQueries(TypedDict):
    """A scene and rays. Both are raw JSON, and each part is parsed on its own, so that errors say where they are."""

    # The rays.
    rays: list[RayQuery]
    # The scene.
    scene: Scene


class RayQuery(TypedDict):
    """A ray; `t` counts in units of `direction`, which is taken as given."""

    # Direction, any length but 0 and what is next to it: one coordinate is 1e-290 or more.
    direction: list[float]
    # Start.
    origin: list[float]
    # Hits beyond this t do not count. Default: none is too far.
    t_max: NotRequired[float | None]
    # Hits at or below this t do not count. Default 0.
    t_min: NotRequired[float]


class RayTree(TypedDict):
    """Every ray of one pixel."""

    # The 8-bit codes that the picture shows for the value, with its exposure and tone.
    codes: list[int]
    # How many codes these are off at most, for what the contributions lack; 255 if nothing bounds that.
    codes_off: int
    # R: at most so much the contributions lack, for rays that were not followed and lights that were not asked for.
    lacking: list[float]
    # Column and row of the pixel.
    pixel: list[int]
    # `single` or `double`: the format of all numbers here.
    precision: str
    # What the proved mode adds so that the pixel lies in the middle of what it may be; 0 for most pixels.
    raised: list[float]
    # The rays, each after its parent.
    rays: list[TreeRay]
    # Samples of the pixel; each has a camera ray.
    samples: int
    # Whether there were more rays than the limit `tree_rays`, or than fit into 80 MiB; then the contributions do
    # not add up.
    truncated: bool
    # The pixel's linear value: the mean of its samples in double precision, and then `raised`. A sample is the sum
    # of its rays' contributions, that of `fog` before its own, times the number of samples, added in the order of
    # `rays` in this precision together with the rounding errors of these additions.
    value: list[float]


class Rays(TypedDict):
    """Parameters of the rays mode."""

    # Rays of all kinds, 1 to 2^53. The block of pixels that reaches the number is finished, and each pixel of a
    # grid 32 pixels wide is traced in any case.
    count: int


class Readiness(TypedDict):
    """Whether the service takes work, and how much it has."""

    # Jobs.
    jobs: JobCounts
    # Requests under way.
    running: int
    # `ready`, `draining`, `stalled` (a render does not notice that it was paused or cancelled) or `unwritable` (the
    # disk does not take the records of jobs, or the folders of their files are gone).
    status: str
    # Requests that wait.
    waiting: int


class Refined(TypedDict):
    """What antialiasing added to the base samples of all pixels."""

    # Pixels that got more samples.
    pixels: int
    # The rays of those samples.
    rays: RayCounts


class Region(TypedDict):
    """A rectangle of pixels."""

    # Pixels down, at least 1.
    height: int
    # Pixels across, at least 1.
    width: int
    # Left edge.
    x: int
    # Upper edge.
    y: int


# Heights from 0 to 1.
Relief: TypeAlias = "dict[Literal['noise'], Grain] | dict[Literal['image'], ImageMap]"


class RenderProgress(TypedDict):
    """How far a picture came."""

    # Rays that make this picture again, in the rays mode.
    count: int
    # Whether nothing was left to do.
    finished: bool
    # Milliseconds that the rest would take, estimated from those before.
    ms_to_target: float
    # Pixels that were traced themselves; the others are interpolated.
    traced_pixels: int
    # Pixels that are known to need more, and have not had it: those that were not traced, as long as there are any.
    waiting_pixels: int


class RenderSettings(TypedDict):
    """How to render."""

    # What ends the recursion. Default `{"proved": {"max_codes": 1}}`, or `{"fixed": {}}` if `max_depth` or
    # `min_weight` is given.
    accuracy: NotRequired[Accuracy | None]
    # Whether pixels that differ from a neighbour get 4 to 16 samples, the more they differ. Default true.
    antialias: NotRequired[bool]
    # Whether surfaces are lit by light that other surfaces scatter once. It replaces ambient light on surfaces that
    # are seen directly, in mirrors or through glass. Default false.
    color_bleeding: NotRequired[bool]
    # How light gets from everywhere to surfaces. `"faithful"` replaces ambient light, `color_bleeding` and
    # `occlusion`, and what glows then lights other bodies. Default `"fast"`.
    fidelity: NotRequired[Fidelity]
    # Whether a checkerboard is averaged over what each ray covers of it, so that it fades to grey far away. Images
    # and noise always are. Default true.
    filter_checkers: NotRequired[bool]
    # Longest chain of rays, 1 to 100000. The camera ray counts 1. Default 10 in the mode `fixed`, and where nothing
    # bounds the light that rays bring. In other modes the default is none, and pictures are compared with recursion
    # without end; with `max_depth` they are compared with recursion to it.
    max_depth: NotRequired[int | None]
    # Only in the mode `fixed`: rays whose weight is below this in every channel are not followed, and no shadow ray
    # is traced for light that could add less than a quarter of it, 0 to 1. Default 0.001.
    min_weight: NotRequired[float | None]
    # Floating-point format. Default `"single"`.
    precision: NotRequired[Precision]
    # Samples of each pixel, 1 to 1024. Default 1. In scenes with effects that choose at random (lights with an
    # area, rough surfaces, a lens, motion, dispersion, color bleeding, global illumination) each pixel then gets 8
    # to 256, until it is likely within 1.5 codes of the mean of all.
    samples: NotRequired[int | None]
    # What casts shadows. Default `"opaque"`.
    shadows: NotRequired[Shadows]


class RepeatedTimes(TypedDict):
    """Repeated times of the same work, in milliseconds."""

    # The longest.
    max_ms: float
    # Half of the repeats are not longer; of an even number the mean of the two in the middle.
    median_ms: float
    # The shortest.
    min_ms: float
    # How many there were.
    repeats: int


class Replay(TypedDict):
    """Settings that render the same pixels again, on any machine and any number of threads."""

    # Width and height of the whole picture.
    image: list[int]
    # The part that was rendered.
    region: Region
    # The settings, after overrides.
    render: RenderSettings
    # Whether an NFF file was rendered by the SPD's counting rules.
    spd_counts: bool
    # Whether an NFF file's opaque surfaces were seen from behind, too.
    two_sided: bool
    # Version of the renderer.
    version: str


class RequestLimits(TypedDict):
    """What one request may ask for."""

    # Bytes of the answer to `POST /v1/rays`, as a multiple of those of the request.
    answer_growth: int
    # Bytes of the assets of one tenant, which scenes name by their SHA-256. If there is no room, those that it
    # needed longest ago go, but for what scenes of /v1/scenes and jobs name.
    asset_bytes: int
    # Number of the assets of one tenant.
    assets: int
    # Seconds a client may take to send a request's body.
    body_timeout_s: float
    # Tiles that one client may ask for at one time; one more is answered with 429. A client is an address of a
    # tenant, so a proxy that many use needs more.
    client_tiles: int
    # Bytes of finished pictures on disk.
    disk_cache_bytes: int | None
    # Pixels of pictures that `POST /v1/compare` compares by FLIP and CIEDE2000.
    flip_pixels: int
    # Seconds a client may take to send a request's headers. A connection without requests is closed after as long:
    # proxies that keep connections need less, or some requests meet one that closes.
    header_timeout_s: float
    # Bytes of the scenes posted to /v1/scenes.
    known_scene_bytes: int
    # Bytes of a request body.
    max_body_bytes: int
    # Pixels of one answer.
    max_pixels: int
    # Rays of one `POST /v1/rays`.
    max_rays: int
    # Samples of one answer: its pixels times the samples of each.
    max_samples_total: int
    # Seconds of one `POST /v1/tradeoff`.
    max_tradeoff_seconds: float
    # Largest zoom: a scene may be opened as 2^zoom times its size.
    max_zoom: int
    # Bytes of memory that requests, jobs and caches take together.
    memory_bytes: int
    # Pixels of a part of a job's picture.
    part_pixels: int
    # Bytes of the patch of a variation.
    patch_bytes: int
    # Bytes of finished pictures in memory. 0 keeps none.
    picture_cache_bytes: int
    # Requests that may wait for the renderer; one more is answered with 503.
    queue: int
    # Bytes of built scenes in memory: another request about the same scene skips reading and building it. 0 keeps
    # none.
    scene_cache_bytes: int
    # Tiles that may wait for the renderer, at most 25 seconds each; one more is answered with 503.
    tile_queue: int
    # Seconds after which a request is given up.
    timeout_s: float
    # Seconds a client may stop reading its answer.
    write_timeout_s: float


class Rotation(TypedDict):
    """Rotation around an axis, counter-clockwise when the axis points at the viewer."""

    # The angle in degrees.
    angle: float
    # The axis, any length but 0.
    axis: list[float]


class SamplingTarget(TypedDict):
    """Result of the mode `statistical`."""

    # Probability that the error is no larger, 0.5 to 0.999.
    confidence: float
    # Largest error of each channel in 8-bit codes, 0.25 to 64. No pixel gets more than 4096 samples.
    half_width: float
    # Samples of a pixel, on average.
    mean_samples: float
    # Most samples of a pixel.
    most_samples: int
    # Share of the pixels that reached the target. The others got the most samples allowed.
    sure_fraction: float


# Factors for each axis, written as one number when they are equal.
Scale: TypeAlias = "float | list[float]"


# A whole scene.
Scene = TypedDict('Scene', {
    '$schema': 'NotRequired[str | None]',
    'ambient': 'NotRequired[Color]',
    'background': 'NotRequired[Color]',
    'camera': 'Camera',
    'definitions': 'NotRequired[dict[str, list[Object]]]',
    'environment': 'NotRequired[Environment | None]',
    'film': 'NotRequired[Film]',
    'fog': 'NotRequired[Fog | None]',
    'image': 'NotRequired[ImageSize]',
    'import_warnings': 'NotRequired[list[ImportWarning]]',
    'lights': 'NotRequired[list[Light]]',
    'materials': 'NotRequired[dict[str, Material]]',
    'name': 'NotRequired[str | None]',
    'objects': 'list[Object]',
    'render': 'NotRequired[RenderSettings]',
    'version': 'int',
})


class SceneLinks(TypedDict):
    """Paths of a scene, its picture and its tiles."""

    # The description of the image for DZI.
    dzi: str
    # The description of the image for IIIF.
    iiif: str
    # The picture as a PNG, or where it is more than one answer may be, a small one: at most 1,024 pixels across and
    # down.
    image: str
    # The scene's canonical text.
    self: str
    # The description of the image's tiles for XYZ.
    xyz: str


class SceneProblem(TypedDict):
    """One thing that is wrong, and where."""

    # Stable short name of the kind of problem.
    code: SceneProblemCode
    # Column in the source in bytes, from 1.
    column: NotRequired[int | None]
    # One sentence that says what is wrong and what to do.
    detail: str
    # Line in the source, from 1.
    line: NotRequired[int | None]
    # Offset in a binary source, from 0.
    offset: NotRequired[int | None]
    # JSON pointer (RFC 6901) of the offending value; empty for the whole document. Files that are not JSON have
    # lines or offsets instead.
    pointer: str


# Kinds of problems.
SceneProblemCode: TypeAlias = "Literal['invalid-json', 'invalid-nff', 'wrong-type', 'missing-key', 'unknown-key', 'duplicate-name', 'out-of-range', 'unknown-reference', 'cycle', 'degenerate', 'limit', 'unsupported'] | Literal['invalid-model'] | Literal['other-format'] | Literal['out-of-bounds'] | Literal['missing-part'] | Literal['not-simulated'] | Literal['approximated'] | Literal['skipped'] | Literal['assumed'] | Literal['missing-asset'] | Literal['cancelled']"


# A scope of a key.
Scope: TypeAlias = "Literal['render'] | Literal['jobs'] | Literal['read'] | Literal['admin']"


class SeenObject(TypedDict):
    """An object that is seen."""

    # Its name.
    name: str | None
    # Its JSON pointer. Objects inside of what is placed, as instances are, have that of what places them.
    pointer: str


class SentAsset(TypedDict):
    """An asset that was sent."""

    # What scenes call it: `sha256:` and these digits.
    asset: str
    # How many bytes it has.
    bytes: int
    # Its SHA-256 in hexadecimal digits.
    sha256: str


class Sequence(TypedDict):
    """Frames of a scene, and how they are shown."""

    # Where the camera is at which time, in the order of time. Between them it takes a smooth path. Default: it
    # stays.
    camera: NotRequired[list[CameraKey]]
    # Whether the path of `camera` goes back to where it begins, so that an animation can be shown again and again.
    # Default: false.
    closed: NotRequired[bool]
    # How many, 1 to 3600. Default: as many as there are `patches`.
    count: NotRequired[int | None]
    # How often animations are shown; 0: again and again. Default 0.
    loops: NotRequired[int]
    # What is different in each frame: merge patches (RFC 7396) on the scene, one for each frame. Then the camera
    # and the bodies of the patched scene are moved. Default: nothing.
    patches: NotRequired[list[dict[str, Any]]]
    # How fast the animations of models go on, those that say `animation` or `t`: seconds of theirs in a second of
    # the frames by `rate`, above 0, at most 1000. After their end they stay as they are then. Default: they stay at
    # their `t`.
    play: NotRequired[float | None]
    # Frames a second of animations, 0.1 to 100. Default 24.
    rate: NotRequired[float]
    # For which share of the time between two frames the shutter is open, above 0, at most 1. Then the `motion` of
    # groups and instances goes on from frame to frame. Default: all frames are of the same moment.
    shutter: NotRequired[float | None]
    # Takes the camera around the scene. Default: it stays.
    turntable: NotRequired[Turntable | None]


class SequenceReport(TypedDict):
    """The whole sequence: sums, and the worst of all bounds."""

    # The largest sampling error of a frame that is likely, in codes. Null where one has no estimate.
    estimated_codes: float | None
    # Finished frames.
    frames: int
    # Milliseconds that were predicted for all frames, on a machine that does nothing else.
    predicted_ms: float
    # Rays that were predicted for all frames.
    predicted_rays: int
    # How many of 255 codes every frame is proved to be off at most. Null where one has no proof.
    proved_codes: int | None
    # All their rays.
    rays: int
    # Milliseconds of tracing.
    trace_ms: float
    # Warnings about the frames, each once.
    warnings: list[SceneProblem]


class SettingEstimate(TypedDict):
    """What a picture with some settings should take."""

    # Depth of the recursion.
    depth: Depth
    # Rays and milliseconds.
    estimate: Estimate | None
    # The id of the picture, if it has one.
    image_id: str | None
    # The settings.
    settings: dict[str, Any]


class SettingsEstimates(TypedDict):
    """The estimates of several settings."""

    # One for each of the settings, in their order.
    estimates: list[SettingEstimate]
    # The plan of the scene as it is.
    plan: Plan


# How shadow rays treat bodies.
Shadows: TypeAlias = "Literal['opaque'] | Literal['transmissive'] | Literal['none']"


class Sky(TypedDict):
    """A sky: its color changes from the horizon to the zenith. Below the horizon is ground of one color."""

    # Radiance below the horizon. Default `"#8c8780"`.
    ground: NotRequired[Color]
    # Radiance at the horizon. Default `"#dce9f5"`.
    horizon: NotRequired[Color]
    # Radiance straight above. Default `"#3f7fbf"`.
    zenith: NotRequired[Color]


class SnellAngles(TypedDict):
    """Angles of Snell's law."""

    # Index of refraction on the side the ray comes from.
    n1: float
    # Index of refraction on the other side.
    n2: float
    # Unpolarised Fresnel reflectance, for information: materials without `fresnel` have constants instead.
    reflectance: float
    # Angle of incidence in degrees.
    theta1_deg: float
    # Angle of refraction in degrees; none under total internal reflection.
    theta2_deg: float | None
    # Total internal reflection.
    tir: bool


class Sphere(TypedDict):
    """Ball around `center`."""

    # Centre.
    center: list[float]
    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # Radius, above 0.
    radius: float


class Spherical(TypedDict):
    """A picture as a globe: longitude across, latitude up. Its middle faces +z, or -y where the axis is z."""

    # Direction of the north pole, any length but 0. Default [0, 1, 0].
    axis: NotRequired[list[float]]
    # Centre of the globe. Default: the origin of object space.
    center: NotRequired[list[float]]


class SpotLight(TypedDict):
    """Spot light."""

    # The area it shines from, around its position; shadows get soft edges. Default: a point.
    area: NotRequired[Area | None]
    # Its color. Default white.
    color: NotRequired[Color]
    # The direction of its axis.
    direction: list[float]
    # How it fades with distance. Default: not at all.
    falloff: NotRequired[Falloff]
    # Angle between axis and the edge of the fully lit cone in degrees, 0 to 90. Default 0.
    inner_deg: NotRequired[float]
    # Factor on the color, at least 0. Default 1.
    intensity: NotRequired[float]
    # Angle between axis and the edge of the light in degrees, above 0, at most 90 and at least `inner_deg`. Default
    # 45.
    outer_deg: NotRequired[float]
    # Where it stands.
    position: list[float]


class Statistical(TypedDict):
    """Parameters of the statistical mode."""

    # Probability that the error is no larger, 0.5 to 0.999.
    confidence: NotRequired[float]
    # Largest error of each channel in 8-bit codes, 0.25 to 64. No pixel gets more than 4096 samples.
    half_width: float


class StoreRequest(TypedDict):
    """Where the picture of a job goes in the store."""

    # Its name below `results/TENANT/`: parts of A-Z a-z 0-9 . _ - between slashes, with {job}, {scene}, {image},
    # {width}, {height}, {date} and {ext}, and {frame} in jobs of frames. By default {job}.{ext}, or
    # {job}/{frame}.{ext}.
    key: NotRequired[str | None]


class StoredView(TypedDict):
    """The picture of a job in the store."""

    # Attempts so far.
    attempts: int
    # When it arrived or was given up (RFC 3339).
    ended_at: NotRequired[str | None]
    # Why the last attempt failed.
    error: NotRequired[str | None]
    # The picture's name in the store.
    key: str
    # When it is tried next, after an attempt that failed (RFC 3339).
    next_attempt_at: NotRequired[str | None]
    # The name of its cost report.
    report_key: str
    # How far it is.
    state: DeliveryState
    # Where it goes.
    url: str


# A studio, the same for all: its front is in direction +z, its key light comes from the upper left there.
Studio: TypeAlias = "dict[str, Any]"


# What is varied while the rest stays.
Sweep: TypeAlias = "Literal['as_asked'] | Literal['depth'] | Literal['weight'] | Literal['proved'] | Literal['samples'] | Literal['antialias']"


class TenantLimits(TypedDict):
    """Limits of the caller's tenant."""

    # Waiting and running jobs.
    jobs: int
    # Open event streams.
    streams: int
    # Units of cost in a minute: one for each request, and one for each million rays.
    units_per_minute: int | None


# A channel of a picture.
TexelChannel: TypeAlias = "Literal['r', 'g', 'b', 'a']"


class TileJson(TypedDict):
    """The description of an image's tiles: TileJSON, with pixels for coordinates."""

    # `simple`.
    crs: str
    # Pixels down.
    height: int
    # The largest zoom.
    maxzoom: int
    # 0: the whole image in one tile.
    minzoom: int
    # The zoom at which the image has its own size.
    nativezoom: int
    # Edge of a tile in pixels.
    tileSize: int
    # `3.0.0`.
    tilejson: str
    # Addresses with `{z}`, `{x}` and `{y}`.
    tiles: list[str]
    # Pixels across.
    width: int


class Time(TypedDict):
    """Parameters of the time mode."""

    # Milliseconds of wall time, from the scene's bytes to the picture's, 1 to 3600000.
    ms: float


# How bright light is compressed.
ToneMapping: TypeAlias = "Literal['none'] | Literal['khronos_pbr_neutral'] | Literal['agx']"


class Torus(TypedDict):
    """Ring: all points at `minor_radius` from a circle of `major_radius`."""

    # Axis of rotation, any length but 0. Default +y.
    axis: NotRequired[list[float]]
    # Centre.
    center: list[float]
    # Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
    hollow: NotRequired[bool]
    # Radius of the circle, above 0.
    major_radius: float
    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # Radius of the tube, above 0 and below `major_radius`.
    minor_radius: float
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]


class Tradeoff(TypedDict):
    """What was found out about one scene."""

    # Advice on settings.
    advice: list[str]
    # Which setting to take, from about ten that somebody would choose from.
    choices: TradeoffChoices
    # On what, when and how it was measured.
    circumstances: Circumstances
    # The best compromises, for each kind of error and of cost.
    fronts: list[TradeoffFront]
    # Many settings, the cheap ones first; those that the time did not suffice for have no `time`.
    points: list[TradeoffPoint]
    # What the errors of `points` were measured against; none if there was no time for it.
    reference: TradeoffReference | None
    # The scene's name.
    scene: str | None


class TradeoffChoice(TypedDict):
    """One setting, with the samples that the scene asks for."""

    # From the reference. None if there was no time for one.
    difference: Difference | None
    # Its name; `proved:1` is what requests get that ask for nothing, of scenes that ask for nothing.
    name: str
    # The bound proved for the end of the recursion, in 8-bit codes, if there is one: where the settings have
    # `max_codes`, compared with recursion to their `max_depth`, elsewhere with recursion without end.
    proved_codes: int | None
    # Rays by kind, of the picture compared.
    rays: RayCounts | None
    # Milliseconds of a whole request: loading the scene, tracing (the shortest of repeats) and encoding the
    # picture. None if it was not measured in the time there was.
    request_ms: float | None
    # The settings.
    settings: TradeoffSettings


class TradeoffChoices(TypedDict):
    """Which setting to take: an answer in a sentence, and what it rests on."""

    # The settings, those that take least first; at the end those that the time did not suffice for.
    all: list[TradeoffChoice]
    # Which setting to take, what it costs and what is lost, and what less and more would cost.
    answer: str
    # Milliseconds that a request spends on encoding the picture as PNG.
    encode_ms: float
    # The quickest that is the reference's picture in every pixel.
    exact: int | None
    # Milliseconds that a request spends on loading the scene.
    load_ms: float
    # The best one that takes clearly less time.
    quicker: int | None
    # The one to take: the quickest of those that look as good as the best, and of those that take as long the best.
    recommended: int | None
    # The picture that differences are from; none if there was no time for one.
    reference: TradeoffReference | None
    # What the answer and the numbers leave open, in a sentence each: which mode of the scene and which choice of
    # samples is not compared, against what is proved, and why nothing is or less than was measured.
    remarks: list[str]
    # Width and height of the pictures that were compared. Times are those of the picture asked for; where that is
    # larger, they are scaled up.
    size: list[int]


# What a picture costs.
TradeoffCost: TypeAlias = "Literal['time'] | Literal['rays']"


class TradeoffFront(TypedDict):
    """The points that no other beats."""

    # Which cost.
    cost: TradeoffCost
    # Which error: its root mean square in codes.
    error: ErrorSource
    # The one of them after which more cost buys ever less.
    knee: int | None
    # Indices of points by growing cost.
    points: list[int]


class TradeoffPoint(TypedDict):
    """Settings and what they were found to cost and to miss."""

    # Errors found against references.
    measured: MeasuredErrors
    # The bound proved for truncation, in 8-bit codes, if there is one: where the settings have `max_codes`,
    # compared with recursion to their `max_depth`, elsewhere with recursion without end.
    proved_codes: int | None
    # Rays by kind.
    rays: RayCounts | None
    # The settings.
    settings: TradeoffSettings
    # Which sweeps it belongs to.
    sweeps: list[Sweep]
    # Milliseconds of tracing; none if it was not measured in the time there was.
    time: RepeatedTimes | None


class TradeoffReference(TypedDict):
    """The pictures that errors are measured against; they are traced in double precision."""

    # Rays of its pictures that were dropped at the limit for one sample.
    dropped: int
    # What following still lighter rays changes; none if all are followed, or if there was no time to see.
    finer: FinerReference | None
    # In place of `min_weight`, where there was no time to follow all rays as far: the codes that the reference is
    # proved to be off at most.
    max_codes: NotRequired[int | None]
    # Longest chain of rays; none for recursion without end.
    max_depth: int | None
    # Weight below which a ray is not followed; 0 follows all.
    min_weight: float


class TradeoffSettings(TypedDict):
    """Settings that trade accuracy for time."""

    # Whether pixels that differ from a neighbour get 4 to 16 samples.
    antialias: bool
    # In place of `min_weight`: each pixel's rays are followed until it is proved to be at most this many codes off
    # the picture of `max_depth`.
    max_codes: NotRequired[int | None]
    # Longest chain of rays; the primary ray counts 1. None: without end, which is what requests get that ask for a
    # proof and name no `max_depth`.
    max_depth: int | None
    # Weight below which a ray is not followed.
    min_weight: float
    # Floating-point format.
    precision: Precision
    # Rays for each pixel.
    samples: int


class Transform(TypedDict):
    """Either `matrix`, or any of `scale`, `rotate_deg` and `translate`, applied in this order."""

    # 4 x 4, column-major, last row 0 0 0 1.
    matrix: NotRequired[list[float] | None]
    # Rotated around an axis through the origin.
    rotate_deg: NotRequired[Rotation | None]
    # Scaled around the origin: one factor, or one for each axis. Not 0. Negative factors mirror.
    scale: NotRequired[Scale | None]
    # Moved by.
    translate: NotRequired[list[float] | None]


class TreeHit(TypedDict):
    """What a ray hits."""

    # JSON pointer of the body itself, if it stands in a group or definition.
    body: NotRequired[str | None]
    # Whether the ray goes into the body's material.
    entering: bool
    # JSON pointer of its material; `default` for bodies that name none.
    material: str
    # Name of the body.
    name: NotRequired[str | None]
    # Unit geometric normal, pointing out of the body's material.
    normal: list[float]
    # JSON pointer of the object in `objects`.
    object: str
    # The point on the surface.
    point: list[float]
    # Distance.
    t: float


class TreeMedium(TypedDict):
    """A medium a ray is in."""

    # Index of refraction.
    ior: float
    # JSON pointer of the body.
    object: str


class TreeRay(TypedDict):
    """One ray."""

    # What it adds to the pixel itself, its children left out: ambient light, emission or background, and for shadow
    # rays the light they let through.
    contribution: list[float]
    # Rays in the chain so far, this one included.
    depth: int
    # Unit direction; for shadow rays towards the light.
    direction: list[float]
    # What fog on its way adds in front of a surface that is only partly there. Elsewhere that is part of
    # `contribution`.
    fog: NotRequired[list[float]]
    # What it hits.
    hit: NotRequired[TreeHit | None]
    # Its number: its place in the list.
    id: int
    # Its kind.
    kind: TreeRayKind
    # For shadow rays: the number of the light in `lights` of the scene, from 0.
    light: NotRequired[int | None]
    # The media it is in, the one that decides first; empty space around all is not listed.
    media: list[TreeMedium]
    # Rays that would have left from here but were not followed.
    not_followed: NotRequired[list[EndedRay]]
    # Start.
    origin: list[float]
    # The ray it comes from; none for camera rays.
    parent: int | None
    # Snell's law where it hits a surface that transmits.
    snell: NotRequired[SnellAngles | None]
    # For shadow rays: how much of each channel passes.
    transmittance: NotRequired[list[float] | None]
    # What its radiance is multiplied with on the way to the pixel.
    weight: list[float]


# Kinds of rays.
TreeRayKind: TypeAlias = "Literal['camera', 'reflected', 'transmitted', 'gathered', 'shadow']"


class Triangle(TypedDict):
    """Triangle; its front sees the vertices counter-clockwise."""

    # Name of a material in `materials`. Default: 0.8 grey diffuse.
    material: NotRequired[str | None]
    # A name, for people; answers and ray trees repeat it. At most 256 bytes.
    name: NotRequired[str | None]
    # The corners.
    vertices: list[list[float]]


class Turntable(TypedDict):
    """The camera goes around an axis, in equal steps from frame to frame. The frame after the last one would be at
    the whole angle, so 360 degrees can be shown again and again. Lights stay with the scene."""

    # Direction of the axis. Default: the camera's `up`.
    axis: NotRequired[list[float] | None]
    # A point of the axis. Default: the camera's `look_at`.
    center: NotRequired[list[float] | None]
    # The whole angle, -36000 to 36000; above 0 counter-clockwise when the axis points at the viewer. Default 360.
    degrees: NotRequired[float]


# An axis that is up.
UpAxis: TypeAlias = "Literal['y', 'z']"


class UvTransform(TypedDict):
    """A transform of texture coordinates as in KHR_texture_transform: from the upper left corner of the picture, v
    down; scaled, then rotated, then moved."""

    # Moved by. Default [0, 0].
    offset: NotRequired[list[float]]
    # Rotated by, in degrees, from -360 to 360; the picture turns clockwise. Default 0.
    rotate_deg: NotRequired[float]
    # Scaled by. Default [1, 1].
    scale: NotRequired[list[float]]


class ValidationResult(TypedDict):
    """The answer about a valid scene."""

    # True. The answer about an invalid scene is a problem.
    valid: bool
    # Warnings about the scene.
    warnings: list[SceneProblem]


class Variation(TypedDict):
    """A variation of a known scene."""

    # The id of a scene that you have posted to `/v1/scenes`.
    base: str
    # What is different: a merge patch (RFC 7396) on the canonical text of that scene, with at most 4 MiB. Null
    # removes a key, and lists are replaced as a whole.
    patch: dict[str, Any]


class Version(TypedDict):
    """The program and its renderer."""

    # `strahl`.
    name: str
    # Changes whenever a version renders other pixels.
    render_epoch: int
    # The program's version.
    version: str


class WebhookRequest(TypedDict):
    """A receiver that hears how a job ends."""

    # Where the message is posted, an address of the public network.
    url: str


class WindowedFalloff(TypedDict):
    """Parameters of the windowed falloff."""

    # Distance at which the light is gone, above 0.
    range: float


# The texture beyond the edges of a picture.
Wrap: TypeAlias = "Literal['repeat'] | Literal['clamp'] | Literal['mirror']"


# What lies beyond the edges of a picture.
Wraps: TypeAlias = "Wrap | list[Wrap]"
