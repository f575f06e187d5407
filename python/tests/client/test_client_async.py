"""The asynchronous client against a real server: what the synchronous one does, awaited."""

from __future__ import annotations

import asyncio
import io
import zipfile
from typing import Any

import pytest

from brood_brdf.client import AsyncClient, BadGenome
from client_harness import PNG, SIZE_PX, BroodServer, glossy_csv


def test_script_breeds_towards_detail(server: BroodServer) -> None:
    async def evolve() -> None:
        async with AsyncClient(server.url) as client:
            lineage = await client.create_lineage("detail", thumbnail_px=SIZE_PX)
            brood = await client.breed(lineage, count=4, seed=1)
            for seed in (2, 3):
                pictures = await asyncio.gather(*map(client.thumbnail, brood))
                best = brood[max(range(4), key=lambda slot: len(pictures[slot]))]
                brood = await client.breed(lineage, [best], count=4, mutation=0.3, seed=seed)
            assert (await client.sheet(brood)).startswith(PNG)
            assert [each.index async for each in client.generations(lineage, page_size=2)] == [
                0,
                1,
                2,
            ]
            assert brood._repr_png_() is None, "a notebook cannot wait for its pictures"
            kept = await client.mark(brood[0], favourite=True)
            assert [each.id async for each in client.favourites(lineage)] == [kept.id]
            archive = await client.export_zip([kept], ["brood", "wgsl"])
            assert len(zipfile.ZipFile(io.BytesIO(archive)).namelist()) == 3
            job = client.export_archive([kept], ["samples-csv"], poll_s=0.1)
            assert len(zipfile.ZipFile(io.BytesIO(await job)).namelist()) == 2
            text = await client.genome_text(kept)
            assert (await client.render(text, SIZE_PX)).startswith(PNG)
            assert len(await client.adopt(lineage, texts=[text], presets=["gold"])) == 2

    asyncio.run(evolve())


def test_search_is_waited_for(server: BroodServer) -> None:
    async def search() -> None:
        async with AsyncClient(server.url) as client:
            target = await client.upload_target("samples", glossy_csv(100))
            options: dict[str, Any] = {"strategy": "analytic", "generations": 1, "threads": 1}
            search = await client.start_search(target, **options)
            async with client.search_events(search) as events:
                names = [event.name async for event in events]
            assert names[-1] == "state"
            done = await client.wait(search, poll_s=0.1, timeout_s=100)
            assert done.state == "succeeded" and len(await client.front(done)) > 0

    asyncio.run(search())


def test_errors_are_raised(server: BroodServer) -> None:
    async def fail() -> None:
        async with AsyncClient(server.url) as client:
            with pytest.raises(BadGenome) as caught:
                await client.store_genome("brood 1\nnonsense\n")
            assert caught.value.line == 2
            answer = await client.request("GET", "/v1/system")
            assert answer.json()["version"] == (await client.system()).version
        assert client.is_closed

    asyncio.run(fail())
