"""Searches against a real server: targets, results, waiting, events."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import httpx
import pytest

from brood_brdf.client import Client, Conflict, RenderJob, SearchFailed, Target
from client_harness import PNG, SIZE_PX, BroodServer, glossy_csv

RED = "brood 1\n.model lambert\nalbedo 0.6 0.05 0.05\n"


@pytest.fixture(scope="module")
def target(server: BroodServer) -> Target:
    """Samples of a glossy material."""
    with Client(server.url) as client:
        return client.upload_target("samples", glossy_csv(), name="glossy")


def test_search_finds_a_measured_material(
    client: Client, target: Target, capsys: pytest.CaptureFixture[str]
) -> None:
    options: dict[str, Any] = {"strategy": "analytic", "generations": 3, "seed": 1, "threads": 1}
    search = client.start_search(target, **options, name="mine")
    assert (search.name, search.budget, search.target) == ("mine", {"generations": 3}, target.id)
    done = search.wait(poll_s=0.1, timeout_s=100, progress=True)
    assert "E_log" in capsys.readouterr().err
    assert (done.state, done.progress) == ("succeeded", 1.0)
    assert done.best is not None and done.best.e_log < 0.5
    found = done.front()
    assert found[0].hash == done.best.hash and found[0].id == done.best.individual
    assert found[0].text().startswith("brood 1") and found[0].picture(SIZE_PX).startswith(PNG)
    assert client.individual(found[0]).lineage == done.lineage
    bred = client.breed(done.lineage, [found[0]], count=2, seed=1)
    assert bred.parents == (found[0].individual,)
    log = done.log()
    assert [line.generation for line in log] == list(range(1, done.generation + 1))
    assert client.search_log(done, after=1) == log[1:]
    assert done.id in {each.id for each in client.searches(done.lineage)}
    last = list(done.events())
    assert len(last) == 1 and last[0].name == "state" and last[0].data["state"] == "succeeded"


def test_search_is_watched_paused_resumed_and_cancelled(client: Client, target: Target) -> None:
    search = client.start_search(target, strategy="gp", seconds=600, threads=1)
    with search.events() as events:
        names = set()
        for event in events:
            names.add(event.name)
            if event.name == "progress":
                break
        assert search.pause().state == "paused"
        with pytest.raises(Conflict, match="paused"):
            search.pause()
        with pytest.raises(Conflict):
            client.delete_target(target)
        with pytest.raises(TimeoutError, match="is paused"):
            search.wait(poll_s=0.01, timeout_s=0.05)
        assert search.resume().state in ("queued", "running")
        assert search.cancel().state == "cancelled"
        states = [event.data["state"] for event in events if event.name == "state"]
    assert states[-1] == "cancelled" and "paused" in states
    assert search.refresh().wait().state == "cancelled"


def test_search_matches_a_picture(client: Client, tmp_path: Path) -> None:
    scene = {"mesh": "sphere", "film": {"exposure": 0}}
    picture = tmp_path / "ball.png"
    picture.write_bytes(client.render(RED, 64, scene=client.store_scene(scene)))
    target = client.upload_target("image", str(picture), scene=scene, name="ball", samples=1)
    assert target.views[0]["pixels"]["used"] > 0
    assert target.view(0, "scene").startswith(PNG) and target._repr_png_() is not None
    search = client.start_search(target, strategy="analytic", generations=2, threads=1)
    done = client.wait(search, poll_s=0.1, timeout_s=100)
    assert done.best is not None and done.best.views is not None
    assert done.best.views[0].flip < 0.2
    assert client.picture(done.best, target=target).startswith(PNG)
    views = [{"picture": "a", "scene": scene, "gain": True}]
    several = client.upload_views(views, {"a": picture}, name="views")
    assert several.views[0]["gain_solved"]
    several.delete()
    assert several.id not in {each.id for each in client.targets(page_size=1)}


def test_failed_search_raises() -> None:
    numbers = {"progress": 0.5, "generation": 1, "evaluations": 9, "seconds": 1.0, "seed": 1}
    words = {"id": "x", "name": "n", "target": "t", "lineage": "l", "strategy": "gp"}
    rest = {"budget": {"seconds": 2}, "start": [], "mirrored": False, "created_ms": 0}
    states = iter([{"state": "running"}, {"state": "failed", "reason": "worker_lost"}])
    transport = httpx.MockTransport(
        lambda _: httpx.Response(200, json={**numbers, **words, **rest, **next(states)})
    )
    slept_s: list[float] = []
    client = Client("http://brood", transport=transport, sleep=slept_s.append)
    with client, pytest.raises(SearchFailed, match="worker_lost"):
        client.wait("x", poll_s=3.0)
    assert slept_s == [3.0]


def test_progress_without_tqdm_names_the_extra(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match=r"brood-brdf\[notebook\]"):
        client.wait("x", progress=True)


def test_render_job_is_a_job(client: Client) -> None:
    lineage = client.create_lineage("job", thumbnail_px=SIZE_PX)
    answer = client.request("POST", f"/v1/lineages/{lineage.id}/generations", json={"count": 2})
    link = answer.headers["link"]
    job = client.job(link[link.index("/v1/jobs/") + 9 : link.index(">")])
    assert isinstance(job, RenderJob) and job.state in ("queued", "running", "succeeded")
