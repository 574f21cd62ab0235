"""The asynchronous client; the blocking one is made of it."""

import asyncio
import gc
import warnings

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


def test_fifty_at_once_and_what_is_left_early_leave_no_connection(service):
    async def work():
        async with AsyncClient(service.url) as client:
            pictures = await asyncio.gather(*(client.render(SCENE, width=40 + number) for number in range(50)))
            async for _ in client.stream(busy_scene("early"), width=1500, height=1000, samples=8):
                break
            task = asyncio.create_task(client.render(busy_scene("cancelled"), width=1500, height=1000, samples=8))
            await asyncio.sleep(0.2)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            for _ in range(50):
                if (await client.queue())["renders"] == {"running": 0, "waiting": 0}:
                    return len(pictures)
                await asyncio.sleep(0.1)

    with warnings.catch_warnings():
        warnings.simplefilter("error", ResourceWarning)
        assert asyncio.run(work()) == 50
        gc.collect()


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
