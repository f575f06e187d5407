"""Methods that both clients have.

To add a route, describe it in the file of its resource, and name it here.
"""

from __future__ import annotations

from . import export as _export
from . import generation as _generation
from . import genome as _genome
from . import individual as _individual
from . import lineage as _lineage
from . import scene as _scene
from . import search as _search
from . import system as _system
from . import target as _target
from .call import Route

__all__ = ["Routes"]


class Routes:
    """Methods of `Client` and `AsyncClient`, by resource."""

    system = Route(_system.system)
    ready = Route(_system.ready)

    create_lineage = Route(_lineage.create_lineage)
    lineage = Route(_lineage.lineage)
    lineages = Route(_lineage.lineages)
    change_lineage = Route(_lineage.change_lineage)
    delete_lineage = Route(_lineage.delete_lineage)
    lineage_file = Route(_lineage.lineage_file)
    import_lineage = Route(_lineage.import_lineage)
    lineage_events = Route(_lineage.lineage_events)

    breed = Route(_lineage.breed)
    adopt = Route(_lineage.adopt)
    generations = Route(_lineage.generations)
    generation = Route(_generation.generation)
    sheet = Route(_generation.sheet)
    sheet_animation = Route(_generation.sheet_animation)
    sheet_of = Route(_individual.sheet_of)

    individual = Route(_individual.individual)
    favourites = Route(_individual.favourites)
    mark = Route(_individual.mark)
    ancestry = Route(_individual.ancestry)
    descendants = Route(_individual.descendants)
    picture = Route(_individual.picture)
    radiance = Route(_individual.radiance)
    thumbnail = Route(_individual.thumbnail)
    animation = Route(_individual.animation)
    strip = Route(_individual.strip)
    image_slice = Route(_individual.image_slice)
    lit_spheres = Route(_individual.lit_spheres)
    inspection = Route(_individual.inspection)
    export = Route(_individual.export)
    export_bytes = Route(_individual.export_bytes)
    export_zip = Route(_export.export_zip)
    export_archive = Route(_export.export_archive)
    start_export = Route(_export.start_export)
    export_job = Route(_export.export_job)
    cancel_export = Route(_export.cancel_export)
    export_file = Route(_export.export_file)

    store_genome = Route(_genome.store_genome)
    genome_text = Route(_genome.genome_text)
    genome_json = Route(_genome.genome_json)
    render = Route(_genome.render)
    lit_spheres_of = Route(_genome.lit_spheres_of)
    export_genome = Route(_genome.export_genome)
    export_formats = Route(_genome.export_formats)
    presets = Route(_genome.presets)
    models = Route(_genome.models)
    compare = Route(_genome.compare)

    store_scene = Route(_scene.store_scene)
    scene = Route(_scene.scene)
    default_scene = Route(_scene.default_scene)
    upload_mesh = Route(_scene.upload_mesh)
    mesh = Route(_scene.mesh)
    mesh_glb = Route(_scene.mesh_glb)
    upload_environment = Route(_scene.upload_environment)
    upload_image = Route(_scene.upload_image)
    upload_profile = Route(_scene.upload_profile)
    develop = Route(_scene.develop)
    palette = Route(_scene.palette)

    upload_target = Route(_target.upload_target)
    upload_views = Route(_target.upload_views)
    target = Route(_target.target)
    targets = Route(_target.targets)
    delete_target = Route(_target.delete_target)
    target_picture = Route(_target.target_picture)
    target_view = Route(_target.target_view)

    start_search = Route(_search.start_search)
    search = Route(_search.search)
    searches = Route(_search.searches)
    pause_search = Route(_search.pause_search)
    resume_search = Route(_search.resume_search)
    cancel_search = Route(_search.cancel_search)
    front = Route(_search.front)
    spread = Route(_search.spread)
    darkest = Route(_search.darkest)
    brightest = Route(_search.brightest)
    search_log = Route(_search.search_log)
    search_events = Route(_search.search_events)
    wait = Route(_search.wait)
    job = Route(_search.job)
