"""What users do, against the real service."""

import json
import pathlib
import re
import threading
import time

import numpy
import pytest
from conftest import ROOT, SCENE, busy_scene

import strahl
from strahl import Client


@pytest.fixture
def client(service):
    with Client(service.url) as one:
        yield one


def test_a_picture_says_what_it_cost_and_how_accurate_it_is(client, tmp_path):
    picture = client.render(SCENE)
    assert (picture.media_type, picture.content[:4]) == ("image/png", b"\x89PNG")
    assert picture.error.proved is not None and 0 <= picture.error.identical <= 1
    assert picture.rays["camera"] >= 48 * 32 and "shadows" in " ".join(picture.effects)
    assert picture.etag.startswith('"i_') and client.image(picture.image_id).content == picture.content
    assert picture._repr_png_() == picture.content
    picture.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == picture.content
    assert client.render(SCENE).cached and not client.render(SCENE, max_depth=7).cached
    assert client.render(SCENE, samples=3).timing["trace"] > 0
    unproved = client.render(SCENE, accuracy="fixed", min_weight=0.5)
    assert unproved.error.proved is not None or unproved.error.why


def test_pixels_are_arrays(client):
    light, codes = client.render(SCENE, format="pfm").numpy(), client.render(SCENE).numpy()
    assert (light.shape, light.dtype, codes.shape, codes.dtype) == ((32, 48, 3), numpy.float32, (32, 48, 3), numpy.uint8)
    linear = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.clip(light, 1e-9, None) ** (1 / 2.4) - 0.055)
    assert numpy.abs(numpy.clip(linear, 0, 1) * 255 - codes).max() <= 1, "rows are from the top in both"
    assert (client.tile(SCENE, (8, 4, 16, 12)).numpy() == codes[4:16, 8:24]).all()
    assert client.render(SCENE, format="webp").numpy().shape == (32, 48, 3)
    assert client.render(SCENE, format="jpg", quality=80)._repr_jpeg_()
    with pytest.raises(ValueError, match="pfm"):
        client.render(SCENE, bits=16).numpy()
    with pytest.raises(ValueError, match="pfm"):
        client.render(SCENE, format="exr").numpy()


def test_scenes_come_as_text_bytes_and_files(client, tmp_path):
    whole = client.render(SCENE).content
    text = json.dumps(SCENE)
    (tmp_path / "scene.json").write_text(text)
    for scene in (text, text.encode(), tmp_path / "scene.json"):
        assert client.render(scene).content == whole
    nff = tmp_path / "ball.nff"
    nff.write_text("v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nl 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n")
    assert client.render(nff).numpy().shape == (16, 16, 3)
    cube = tmp_path / "tetrahedron.obj"
    cube.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    for model in (cube, cube.read_bytes()):
        assert client.render(model, width=20, height=16, view="front").numpy().shape[:2] == (16, 20)
    with pytest.raises(strahl.InvalidArgument, match="models can be rendered"):
        client.jobs.submit(cube)
    with pytest.raises(ValueError, match="NFF"):
        client.jobs.submit(nff)
    with pytest.raises(ValueError):
        client.render({**SCENE, "background": [float("nan")] * 3})


def test_turntables_sequences_and_assets(client, tmp_path):
    size = {"width": 24, "height": 16}
    around = client.turntable(SCENE, 3, format="gif", **size)
    assert (around.media_type, around.content[:6]) == ("image/gif", b"GIF89a")
    assert client.turntable(SCENE, 4, sheet=(4, 1), **size).numpy().shape[:2] == (16, 96)
    job = client.jobs.submit(SCENE, frames={"count": 2, "turntable": {}}, **size)
    assert job.wait().media_type == "image/apng"
    assert [frame["number"] for frame in job.frames()["frames"]] == [0, 1]
    assert job.frame(1).numpy().shape == (16, 24, 3)
    assert [job.animation(format).media_type for format in ("png", "webp", "gif")] == ["image/apng", "image/webp", "image/gif"]
    assert job.sheet(columns=1).numpy().shape[:2] == (32, 24)
    with pytest.raises(strahl.NotFound):
        job.frame(2)

    model = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "tetrahedron.obj").write_bytes(model)
    name = client.assets.add(tmp_path / "tetrahedron.obj")
    assert name == client.assets.add(model) and name.startswith("sha256:")
    assert client.assets.missing([name, "0" * 64]) == ["0" * 64]
    placed = {**SCENE, "objects": [*SCENE["objects"], {"model": {"asset": name}}]}
    assert client.render(placed).content != client.render(SCENE).content
    client.assets.delete(name)
    assert client.assets.missing([name]) == [name.removeprefix("sha256:")]
    with pytest.raises(strahl.InvalidRequest, match="Assets are missing"):
        client.render(placed)
    with pytest.raises(strahl.InvalidArgument):
        client.assets.add(str(tmp_path / "tetrahedron.obj"))


def test_questions_about_a_scene(client):
    assert client.validate(SCENE) == []
    plan = client.analyze(SCENE)
    assert plan["actual"]["rays"]["camera"] > 0 and plan["estimate"] is not None
    assert "actual" not in client.explain(SCENE)
    assert client.tradeoff(SCENE, seconds=1)["advice"]
    assert client.map(SCENE, "depth").numpy().shape[:2] == (32, 48)
    tree = client.tree(SCENE, 20, 16)
    assert tree["pixel"] == [20, 16] and tree["rays"]
    hits = client.rays(SCENE, [{"origin": [0, 1, 5], "direction": [0, 0, -1]}, {"origin": [0, 1, 5], "direction": [0, 1, 0]}])
    assert [hit["hit"] for hit in hits] == [True, False]
    known = client.add_scene(SCENE, zoom=2)
    assert known["zoom"] == 2 and client.image(known["image_id"]).numpy().shape == (128, 192, 3)
    assert client.limits()["request"] and client.version()["name"] == "strahl"


def test_a_picture_streams_from_coarse_to_fine(client):
    passes = list(client.stream(SCENE, width=320, height=200))
    assert [one.scale for one in passes] == sorted((one.scale for one in passes), reverse=True) and len(passes) > 1
    assert [one.final for one in passes] == [False] * (len(passes) - 1) + [True]
    last, whole = passes[-1], client.render(SCENE, width=320, height=200)
    assert last.picture.content == whole.content and last.picture.image_id == whole.image_id
    told, said = last.picture.error, whole.error
    assert (told.proved, told.depth, told.estimated, told.why) == (said.proved, said.depth, said.estimated, said.why)
    # The header is rounded.
    assert abs(told.identical - said.identical) < 0.001
    assert last.report["cost"]["rays"]["camera"] == whole.rays["camera"] and last.picture.effects == whole.effects
    first = passes[0]
    assert first.picture.numpy().shape[1] * first.scale >= 320 and first.region == (0, 0, 320, 200)
    for _ in client.stream(busy_scene("left"), width=1500, height=1000, samples=8):
        break
    with pytest.raises(strahl.InvalidScene):
        list(client.stream("{}"))


def test_variations_comparisons_and_several_settings(client):
    base = client.add_scene(SCENE)["scene_id"]
    moved = client.render({"base": base, "patch": {"camera": {"pinhole": {"eye": [2, 1, 4]}}}})
    assert moved.content == client.render({**SCENE, "camera": {"pinhole": {"eye": [2, 1, 4], "look_at": [0, 0.5, 0]}}}).content
    assert json.loads(client.source(base)) == SCENE
    assert client.compare(SCENE, SCENE)["same"]
    far = client.compare((SCENE, {"antialias": False}), client.render(SCENE).image_id)
    assert not far["same"] and far["rms_codes"] > 0
    assert client.difference((SCENE, {"antialias": False}), SCENE, format="flip").numpy().shape == (32, 48)
    several = client.explain_each(SCENE, [{"max_depth": depth} for depth in (1, 2, 3)])
    assert [one["settings"]["max_depth"] for one in several["estimates"]] == [1, 2, 3]
    assert client.me()["needs_keys"] is False and client.queue()["threads"] >= 1


def test_events_of_all_jobs(client):
    told = client.jobs.events(label="watched")
    names = []

    def follow():
        for event in told:
            names.append((event.name, event.data.get("job")))
            if event.name == "removed":
                return

    following = threading.Thread(target=follow)
    following.start()
    # Once it tells of one of these, the stream is open.
    first = []
    while not names and len(first) < 600:
        first.append(client.jobs.submit(SCENE, labels=["watched"], width=76).id)
        time.sleep(0.1)
    job = client.jobs.submit(SCENE, labels=["watched"], width=77)
    other = client.jobs.submit(SCENE, width=78)
    job.wait(timeout=120)
    job.delete()
    following.join(120)
    assert {name for name, of in names if of == job.id} >= {"created", "succeeded", "removed"}
    assert {of for _, of in names} <= {job.id, *first} and other.id not in first


def test_mistakes_have_pointers_lines_and_columns(client):
    text = json.dumps({**SCENE, "objects": [{"sphere": {"center": [0, 0, 0], "radius": -1, "material": "rde"}}]}, indent=1)
    for ask in (client.validate, client.render, client.explain, client.jobs.submit):
        with pytest.raises(strahl.InvalidScene) as caught:
            ask(text)
        mistakes = {mistake.pointer: mistake for mistake in caught.value.mistakes}
        assert set(mistakes) == {"/objects/0/sphere/radius", "/objects/0/sphere/material"}
        wrong = mistakes["/objects/0/sphere/material"]
        assert 'did you mean "red"' in wrong.detail and wrong.line and wrong.column
    with pytest.raises(strahl.InvalidScene) as caught:
        client.render('{"version": 1,')
    assert caught.value.slug == "invalid-json" and caught.value.mistakes[0].line == 1
    with pytest.raises(strahl.InvalidRequest) as caught:
        client.render(SCENE, samples=0)
    assert caught.value.mistakes[0].parameter == "samples"
    with pytest.raises(strahl.TooLarge) as caught:
        client.render(SCENE, width=4_096, height=4_096)
    assert caught.value.limit["name"] == "max_pixels"


def test_hostile_names_do_not_reach_the_terminal(client):
    hostile = "\x1b]0;owned\x07\x1b[2J\n\u202egnp<img src=x onerror=alert(1)>"
    with pytest.raises(strahl.InvalidScene) as caught:
        client.render({**SCENE, "objects": [{"sphere": {"center": [0, 0, 0], "radius": 1, "material": hostile}}]})
    assert all(c.isprintable() or c == "\n" for c in str(caught.value))
    assert all(c.isprintable() for mistake in caught.value.mistakes for c in str(mistake))


def test_a_job_from_its_submission_to_its_picture(client, tmp_path):
    job = client.jobs.submit(busy_scene("job"), width=256, height=192, samples=64, labels=["mine"], priority=70)
    assert job.view["priority"] == 70 and job.prioritize(71).view["priority"] == 71
    seen = list(job.progress())
    assert [one.fraction for one in seen] == sorted(one.fraction for one in seen) and seen[-1].fraction == 1
    assert seen[-1].state == "succeeded" and len(seen) > 3
    picture = job.wait()
    assert picture.numpy().shape == (192, 256, 3)
    assert job.view["report"]["cost"]["rays"]["camera"] > 0
    job.download(tmp_path / "job.png")
    assert (tmp_path / "job.png").read_bytes() == picture.content and not list(tmp_path.glob("*.part"))
    assert (job.tile((64, 64, 32, 16)).numpy() == picture.numpy()[64:80, 64:96]).all()
    assert job.preview().media_type == "image/png"
    assert [one.id for one in client.jobs.list(label="mine")] == [job.id] and client.jobs.get(job.id).state == "succeeded"
    with pytest.raises(strahl.Conflict):
        job.cancel()
    job.delete()
    with pytest.raises(strahl.NotFound):
        job.refresh()


def test_jobs_that_end_otherwise(client):
    job = client.jobs.submit(busy_scene("never"), width=2000, height=1500, samples=256)
    with pytest.raises(TimeoutError):
        job.wait(timeout=0.5)
    told = []
    for _ in range(40):
        if not told:
            with pytest.raises(TimeoutError):
                job.wait(timeout=1.5, on_progress=told.append)
    assert told and told[-1].state in {"queued", "running"}
    job.cancel()
    with pytest.raises(strahl.JobFailed, match="canceled"):
        job.wait(timeout=120)
    assert [event.name for event in job.events()][-1] == "canceled"
    same = [client.jobs.submit(SCENE, idempotency_key="one and the same").id for _ in range(2)]
    assert same[0] == same[1]
    with pytest.raises(strahl.InvalidRequest):
        client.jobs.submit(SCENE, idempotency_key="one and the same", width=50)
    for wrong in ("../livez", "", "a b", "%2e"):
        with pytest.raises(ValueError, match="id"):
            client.jobs.get(wrong)


def test_the_readme_does_what_it_says(service, tmp_path, monkeypatch, capsys):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "clients/python/README.md").read_text(), re.DOTALL)
    assert len(blocks) >= 6
    monkeypatch.chdir(tmp_path)
    for folder in ("scenes", "tests"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    known = {}
    for block in blocks:
        exec(compile(block.replace("http://127.0.0.1:8080", service.url), "README.md", "exec"), known)
    assert "succeeded 100%" in capsys.readouterr().out and pathlib.Path("job.png").stat().st_size > 100
    known["client"].close()


WEIRD = 'gr\u00fcn "a" \\ b'


def test_pointers_lead_to_the_values_in_the_scene(client):
    scene = {**SCENE, "materials": {WEIRD: {"ior": -1}}, "objects": [{"sphere": {"center": [0, 0, 0], "radius": 1, "material": WEIRD}}]}
    with pytest.raises(strahl.InvalidScene) as caught:
        client.validate(scene)
    assert [mistake.pointer for mistake in caught.value.mistakes] == [f"/materials/{WEIRD}/ior"]


def test_warnings_are_the_same_in_pictures_and_streams(client):
    name = 'say "so" \\ b'
    scene = {**SCENE, "materials": {name: {"diffuse": [9, 0, 0]}}, "objects": [{"sphere": {"center": [0, 1, 0], "radius": 1, "material": name}}]}
    warnings = client.render(scene).warnings
    assert warnings[0].startswith(f"/materials/{name}/diffuse: ") and '"#rrggbb"' in warnings[0]
    assert list(client.stream(scene))[-1].picture.warnings == warnings


def test_only_pictures_in_one_answer_have_layers(client):
    assert client.render(SCENE, format="exr", layers="distance").media_type == "image/x-exr"
    assert client.render(SCENE, format="exr", layers=["distance", "normal"]).media_type == "image/x-exr"
    with pytest.raises(strahl.InvalidArgument, match="layers"):
        client.jobs.submit(SCENE, format="exr", layers="distance")
    with pytest.raises(strahl.InvalidArgument, match="layers"):
        list(client.stream(SCENE, format="exr", layers="distance"))


def test_jobs_are_listed_over_pages(client):
    for number in range(60):
        client.jobs.submit(SCENE, labels=["many"], max_depth=number % 3 + 1)
    listed = [job.id for job in client.jobs.list(label="many")]
    assert len(set(listed)) == 60
