"""The files that are written by `generate.py` are up to date, and the answers of the service have the types of the contract."""

import runpy
import typing

import pytest
from conftest import ROOT, SCENE

from strahl import Client, contract

generate = runpy.run_path(str(ROOT / "clients/python/generate.py"))


@pytest.mark.parametrize("name", generate["GENERATED"])
def test_generated_files_are_up_to_date(name):
    assert (generate["PACKAGE"] / name).read_text() == generate["GENERATED"][name](), "python3 clients/python/generate.py"


def keys_of(of):
    """All keys of a type, and those that are always there."""
    hints = typing.get_type_hints(of, include_extras=True)
    return set(hints), {name for name, hint in hints.items() if typing.get_origin(hint) is not typing.NotRequired}


def test_answers_have_the_keys_of_their_types(service):
    client = Client(service.url)
    job = client.jobs.submit(SCENE)
    job.wait(timeout=120)
    plan = client.analyze(SCENE)
    for answer, of in [
        (job.view, contract.JobView), (job.view["progress"], contract.JobProgress), (job.view["report"], contract.CostReport),
        (plan, contract.Analyzed), (client.explain(SCENE), contract.Plan), (client.tree(SCENE, 20, 16), contract.RayTree),
        (client.add_scene(SCENE), contract.KnownScene), (client.limits(), contract.AllLimits), (client.version(), contract.Version),
        (client.compare(SCENE, SCENE), contract.PictureDifference), (client.me(), contract.KeyInfo), (client.queue(), contract.QueueStatus),
        (client.tradeoff(SCENE, seconds=1), contract.Tradeoff),
    ]:
        known, required = keys_of(of)
        assert required <= set(answer) <= known, of


def test_the_settings_are_those_of_the_contract():
    import json

    from strahl.calls import Output, PictureOptions, RenderOptions, Settings

    schemas = json.loads((ROOT / "api/openapi.json").read_text())["components"]["schemas"]
    assert set(Settings.__annotations__) == set(schemas["Overrides"]["properties"])
    assert set(Output.__annotations__) == set(schemas["PictureOutput"]["properties"])
    assert set(RenderOptions.__annotations__) - set(PictureOptions.__annotations__) == {"layers"}
