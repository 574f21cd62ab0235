"""Client of strahl, a render service: a JSON scene in, a ray-traced picture and what it cost out."""

from .aio import AsyncAssets, AsyncClient, AsyncJob, AsyncJobs
from .client import Assets, Client, Job, Jobs
from .events import Event, Progress
from .parts import Pass
from .picture import Error, Picture
from .problems import (
    Busy,
    Conflict,
    Damaged,
    Forbidden,
    Gone,
    InvalidArgument,
    InvalidRequest,
    InvalidScene,
    JobFailed,
    Mistake,
    NotFound,
    Problem,
    RateLimited,
    StrahlError,
    TooLarge,
    TooSlow,
    Unauthorized,
    Unreachable,
)

__all__ = [
    "Assets", "AsyncAssets", "AsyncClient", "AsyncJob", "AsyncJobs", "Busy", "Client", "Conflict", "Damaged", "Error", "Event", "Forbidden",
    "Gone", "InvalidArgument", "InvalidRequest", "InvalidScene", "Job", "JobFailed", "Jobs", "Mistake", "NotFound", "Pass", "Picture",
    "Problem", "Progress", "RateLimited", "StrahlError", "TooLarge", "TooSlow", "Unauthorized", "Unreachable",
]
