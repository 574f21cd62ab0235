"""The asynchronous client; the blocking one is made of it."""

import asyncio

import pytest
from conftest import SCENE, busy_scene

import strahl
from strahl import AsyncClient


def test_pictures_beside_each_other_and_a_job(service):
    async def work():
        async with AsyncClient(service.url) as client:
            depths = await asyncio.gather(*(client.render(SCENE, max_depth=depth) for depth in (1, 2, 3)))
            job = await client.jobs.submit(busy_scene("async"), width=200, height=150, samples=64, labels=["async"])
            names = [event.name async for event in job.events()]
            picture = await job.wait(timeout=120)
            listed = [one.id async for one in client.jobs.list(label="async")]
            with pytest.raises(strahl.InvalidScene):
                await client.validate("{}")
            return depths, job, names, picture, listed

    depths, job, names, picture, listed = asyncio.run(work())
    assert len({one.content for one in depths}) > 1 and names[-1] == "succeeded" and listed == [job.id]
    assert picture.numpy().shape == (150, 200, 3)


def test_what_is_given_up_is_cancelled(service):
    async def work():
        async with AsyncClient(service.url, retries=0) as client:
            job = await client.jobs.submit(busy_scene("left"), width=1500, height=1000, samples=64)
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(job.wait(), 0.5)
            async with asyncio.timeout(120):
                async for _ in job.progress():
                    break
            await job.cancel()
            with pytest.raises(strahl.JobFailed):
                await job.wait()

    asyncio.run(work())
