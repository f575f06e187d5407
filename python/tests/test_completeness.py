"""All public names of the package have docstrings and annotations, and docs/python.md runs."""

from __future__ import annotations

import ast
import inspect
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brood_brdf as package
from brood_brdf import Material, _native
from test_material import directions

ROOT = Path(__file__).resolve().parents[2]


def public() -> list[tuple[str, Any]]:
    """Returns the public classes and functions, and the public members of the classes."""
    found: list[tuple[str, Any]] = []
    for name in package.__all__:
        value = getattr(package, name)
        found.append((name, value))
        if not inspect.isclass(value):
            continue
        for member, each in vars(value).items():
            each = each.fget if isinstance(each, property) else each
            each = each.__func__ if isinstance(each, classmethod) else each
            is_own = inspect.isfunction(each) and each.__module__.startswith("brood_brdf")
            if is_own and (not member.startswith("_") or member == "__init__"):
                found.append((f"{name}.{member}", each))
    return found


@pytest.mark.parametrize(("name", "value"), public())
def test_public_name_has_a_docstring_and_annotations(name: str, value: Any) -> None:
    text = value.__doc__
    assert text and text[0].isupper(), "a sentence"
    assert all(len(line) <= 100 for line in text.splitlines())
    if inspect.isclass(value):
        fields = list(getattr(value, "_fields", ()))
        fields += [each for each in getattr(value, "__annotations__", {}) if each[0] != "_"]
        assert [each for each in fields if f"\n        {each}: " not in text] == []
        return
    signature = inspect.signature(value)
    is_init = name.endswith(".__init__")
    assert is_init or signature.return_annotation is not signature.empty
    parameters = [
        each for each in signature.parameters.values() if each.name not in ("self", "cls")
    ]
    assert all(each.annotation is not each.empty for each in parameters)
    if "arguments are those of" not in text:
        words = inspect.cleandoc(text)
        missing = [each.name for each in parameters if f"\n    {each.name}: " not in words]
        assert missing == []


def test_stub_has_the_names_of_the_native_module() -> None:
    stub = ast.parse((Path(package.__file__).parent / "_native.pyi").read_text("utf-8"))
    declared = {each.name for each in stub.body if isinstance(each, ast.ClassDef | ast.FunctionDef)}
    assert set(_native.__all__) == declared - {"PictureOptions", "FitOptions"}
    for each in stub.body:
        if isinstance(each, ast.ClassDef) and hasattr(_native, each.name):
            members = {it.name for it in each.body if isinstance(it, ast.FunctionDef)}
            native = {it for it in vars(getattr(_native, each.name)) if it[0] != "_"}
            assert members - {"__init__"} == native, each.name


def blocks() -> list[str]:
    """Returns the Python examples of docs/python.md and of the package's page on PyPI."""
    texts = [(ROOT / name).read_text("utf-8") for name in ("docs/python.md", "python/README.md")]
    return [
        block for text in texts for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    ]


@pytest.mark.parametrize("block", blocks())
def test_example_of_the_documentation_runs(
    block: str, server_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BROOD_URL", server_url)
    wi, wo = directions(300, 1), directions(300, 2)
    table = np.hstack([wi, wo, Material.preset("gold").eval(wi, wo)])
    head = "wix,wiy,wiz,wox,woy,woz,r,g,b"
    np.savetxt("glossy.csv", table, delimiter=",", header=head, comments="")
    Material.preset("gold").save("gold.brood")
    # The examples name the default address, and files of 35 MB.
    block = block.replace("http://127.0.0.1:7320", server_url).replace("gold.binary", "glossy.csv")
    block = block.replace("seconds=20", "seconds=2")
    block = re.sub(r"\b(Client|AsyncClient)\((?=\))", rf'\1("{server_url}"', block)
    block = re.sub(r"\bClient\(retry", f'Client("{server_url}", retry', block)
    exec(compile(block, "docs/python.md", "exec"), {"__name__": "__main__"})


def test_notebook_runs(server_url: str, tmp_path: Path) -> None:
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(ROOT / "docs/python.ipynb", as_version=4)
    os.environ["BROOD_URL"] = server_url
    client = NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    shown = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(shown) >= 4, "materials, broods and records of the client are shown as pictures"
