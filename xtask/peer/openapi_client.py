"""Generates a client of brood's API with openapi-python-client, and calls routes with its functions.

Starts the given brood with an empty database on a free port. Prints one line: versions, files and routes.
"""

import argparse
import importlib
import io
import json
import math
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import uuid
from importlib.metadata import version

PEER = pathlib.Path(__file__).parent
PACKAGE = "brood_client"
# Bodies that the generator skips. Each of these routes also takes JSON or bytes, which it does not skip.
SKIPPED = {"Unsupported content type text/x-brood", "Unsupported content type text/plain"}
LISTENING = "brood is listening on "
# Pictures are rendered while the request waits.
TIMEOUT_S = 60
TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
PNG = b"\x89PNG\r\n\x1a\n"
EXR = b"\x76\x2f\x31\x01"


def generate(document, folder):
    """Writes the package; returns its number of files."""
    shutil.rmtree(folder / PACKAGE, ignore_errors=True)
    command = [sys.executable, "-m", "openapi_python_client", "generate", "--meta", "none"]
    command += ["--path", document, "--config", PEER / "openapi_client.json", "--output-path", folder / PACKAGE]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    warnings = re.findall(r"^(?:WARNING|ERROR) parsing (.*)\n\n(.*)", done.stdout, re.MULTILINE)
    unknown = [f"{where} {what}" for where, what in warnings if what not in SKIPPED]
    unnamed = "arning" in done.stdout and not warnings
    if done.returncode != 0 or unknown or unnamed:
        sys.exit("\n".join(unknown) or done.stdout)
    return sum(file.is_file() for file in (folder / PACKAGE).rglob("*"))


class Server:
    """The server, with an empty folder of data, for the duration of a `with` block."""

    def __init__(self, brood):
        self.brood = brood

    def __enter__(self):
        self.data = tempfile.TemporaryDirectory(prefix="brood-client-")
        options = ["serve", "--listen", "127.0.0.1:0", "--data", self.data.name, "--workers", "1", "--backend", "cpu"]
        self.log = open(pathlib.Path(self.data.name) / "log", "w+")
        self.process = subprocess.Popen([self.brood, *options], stdout=subprocess.PIPE, stderr=self.log, text=True)
        for line in self.process.stdout:
            if line.startswith(LISTENING):
                return line.removeprefix(LISTENING).strip()
        self.process.wait()
        self.log.seek(0)
        sys.exit(f"the server does not listen; its log:\n{self.log.read()}")

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.log.close()
        self.data.cleanup()


class Api:
    """Functions and types of the generated package; counts the functions that are called."""

    def __init__(self, url):
        client = importlib.import_module(f"{PACKAGE}.client")
        self.client = client.Client(base_url=url, timeout=TIMEOUT_S, raise_on_unexpected_status=True)
        self.models = importlib.import_module(f"{PACKAGE}.models")
        self.types = importlib.import_module(f"{PACKAGE}.types")
        self.called = set()

    def __call__(self, name, *path, status=200, **options):
        """Calls a function, `tag.operation`, and returns its parsed answer."""
        module = importlib.import_module(f"{PACKAGE}.api.{name}")
        answer = module.sync_detailed(*path, client=self.client, **options)
        check(answer.status_code == status, f"{name}: {answer.status_code} {answer.content[:200]}")
        self.called.add(name)
        return answer.parsed

    def file(self, content):
        return self.types.File(payload=io.BytesIO(content))


def check(holds, words):
    if not holds:
        raise AssertionError(words)


def samples():
    """Measurement of a grey diffuse material as CSV."""
    lines = ["wix,wiy,wiz,wox,woy,woz,r,g,b"]
    for number in range(400):
        light, eye = (math.radians(5 + number * step % 80) for step in (7, 11))
        turn = math.radians(number * 137.5)
        direction = [math.sin(light), 0, math.cos(light)]
        direction += [math.sin(eye) * math.cos(turn), math.sin(eye) * math.sin(turn), math.cos(eye)]
        lines.append(",".join(str(value) for value in [*direction, 0.1, 0.1, 0.1]))
    return "\n".join(lines).encode() + b"\n"


def breeding(api):
    models = api.models
    scene = api("scenes.create_scene", status=201, body=models.Scene.from_dict({"mesh": "torus", "scale": 0.9}))
    check(scene.mesh == "torus" and scene.scale == 0.9, scene)
    check(api("scenes.get_scene", scene.id).id == scene.id, scene)
    new = models.CreateLineage(name="generated", scene=scene.id, thumbnail_px=64)
    lineage = api("lineages.create_lineage", status=201, body=new)
    check((lineage.name, lineage.scene) == ("generated", scene.id), lineage)
    brood = api("generations.breed", lineage.id, status=201, body=models.Breed(count=4, seed=1))
    check(len(brood.individuals) == 4 and brood.seed == 1, brood)
    check(api("generations.get_generation", brood.id) == brood, "the generation differs when it is read again")
    check([it.id for it in api("generations.list_generations", lineage.id).items] == [brood.id], "list of generations")
    check([it.name for it in api("lineages.list_lineages").items] == ["generated"], "list of lineages")
    child = brood.individuals[0]
    marked = models.PatchIndividual(favourite=True)
    detail = api("individuals.patch_individual", child.id, body=marked, if_match='"1"')
    check(detail.favourite is True, detail)
    favourites = api("individuals.list_favourites", favourite=True, lineage=lineage.id)
    check([it.id for it in favourites.items] == [child.id], favourites)
    genome = api("genomes.get_genome", child.hash_)
    check(api("genomes.create_genome", status=201, body=genome).hash_ == child.hash_, "the genome's hash changes")
    return lineage, brood, child


def files(api, lineage, brood, child):
    sheet = api("pictures.get_sheet", brood.id)
    thumbnail = api("pictures.get_thumbnail", child.thumbnail.rsplit("/", 1)[1])
    picture = api("pictures.render_individual_png", child.id, size="64")
    for name, png in [("sheet", sheet), ("thumbnail", thumbnail), ("picture", picture)]:
        check(png.payload.read().startswith(PNG), f"{name} must be a PNG file")
    exr = api("pictures.render_individual_exr", child.id, size="64").payload.read()
    check(exr.startswith(EXR), exr[:20])
    source = api("exports.export_individual", child.id, "glsl-es-300")
    check("vec3 " in source, source[:200])
    archive = api("exports.get_archive", individuals=child.id, formats="brood").payload.read()
    check(archive.startswith(b"PK"), archive[:20])
    mesh = api("meshes.create_mesh", status=201, body=api.file(TRIANGLE))
    check((mesh.vertices, mesh.triangles) == (3, 1), mesh)
    glb = api("meshes.get_mesh_glb", str(mesh.id)).payload.read()
    length = int.from_bytes(glb[8:12], "little")
    check(glb.startswith(b"glTF\x02\0\0\0") and length == len(glb), glb[:20])
    document = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])
    check(document["asset"]["version"] == "2.0", document)
    spec = api.models.TargetSpec(kind="samples", name="grey")
    upload = api.models.TargetUpload(file=api.file(samples()), spec=spec)
    target = api("jobs.create_target", status=201, body=upload)
    check((target.kind, target.name) == ("samples", "grey"), target)
    check(api("jobs.get_target", target.id) == target, "the target differs when it is read again")
    check(api("lineages.delete_lineage", lineage.id, status=204) is None, "204 has no body")


def errors(api):
    problem = api("lineages.get_lineage", uuid.uuid4(), status=404)
    check(isinstance(problem, api.models.Problem) and problem.status == 404, problem)
    unnamed = api("lineages.create_lineage", status=422, body=api.models.CreateLineage(name=" "))
    check(isinstance(unnamed, api.models.Problem) and unnamed.pointer == "/name", unnamed)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--brood", required=True)
    parser.add_argument("--document", type=pathlib.Path, required=True)
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    options = parser.parse_args()
    written = generate(options.document, options.folder)
    sys.path.insert(0, str(options.folder))
    with Server(options.brood) as url:
        api = Api(url)
        check(api("operation.health") == "ok\n", "the server must be healthy")
        system = api("operation.get_system")
        presets = [preset.name for preset in api("genomes.list_presets")]
        check("gold" in presets, presets)
        lineage, brood, child = breeding(api)
        files(api, lineage, brood, child)
        errors(api)
    generator = f"openapi-python-client {version('openapi-python-client')}"
    print(f"brood {system.version}, {generator}: {written} files; {len(api.called)} routes called: ", end="")
    print(", ".join(sorted(name.split(".")[1] for name in api.called)))


if __name__ == "__main__":
    main()
