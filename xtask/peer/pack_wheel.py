"""Packs the Python package with a native library that cargo has built already.

`cargo xtask test` uses it: maturin would compile the crates again, with other features than the
build of the whole workspace. The metadata are those of python/pyproject.toml.
"""

import argparse
import base64
import hashlib
import sysconfig
import zipfile
from pathlib import Path

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    from pip._vendor import tomli as tomllib

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--package", type=Path, required=True, help="folder of pyproject.toml")
parser.add_argument("--library", type=Path, required=True, help="built native library")
parser.add_argument("--version", required=True)
parser.add_argument("--out", type=Path, required=True, help="folder for the wheel")
options = parser.parse_args()

project = tomllib.loads((options.package / "pyproject.toml").read_text("utf-8"))["project"]
name = project["name"].replace("-", "_")
platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
tag = f"cp310-abi3-{platform}"
head = [
    "Metadata-Version: 2.1",
    f"Name: {project['name']}",
    f"Version: {options.version}",
    f"Summary: {project['description']}",
    f"Requires-Python: {project['requires-python']}",
    *(f"Requires-Dist: {each}" for each in project["dependencies"]),
]
for extra, wanted in project["optional-dependencies"].items():
    head += [f"Provides-Extra: {extra}"]
    head += [f"Requires-Dist: {each} ; extra == '{extra}'" for each in wanted]

files = {f"{name}/_native.abi3.so": options.library.read_bytes()}
for path in sorted((options.package / name).rglob("*")):
    if path.suffix in (".py", ".pyi", ".typed") or path.name == "py.typed":
        files[path.relative_to(options.package).as_posix()] = path.read_bytes()
info = f"{name}-{options.version}.dist-info"
files[f"{info}/METADATA"] = ("\n".join(head) + "\n").encode()
wheel = f"Wheel-Version: 1.0\nGenerator: brood\nRoot-Is-Purelib: false\nTag: {tag}\n"
files[f"{info}/WHEEL"] = wheel.encode()


def record(path: str, content: bytes) -> str:
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    return f"{path},sha256={digest},{len(content)}\n"


lines = "".join(record(path, content) for path, content in files.items())
files[f"{info}/RECORD"] = (lines + f"{info}/RECORD,,\n").encode()
options.out.mkdir(parents=True, exist_ok=True)
target = options.out / f"{name}-{options.version}-{tag}.whl"
with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as archive:
    for path, content in files.items():
        archive.writestr(path, content)
print(target)
