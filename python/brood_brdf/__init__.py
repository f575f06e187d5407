"""Materials whose BRDFs are evolved programs: evaluation, breeding and fits on numpy arrays.

    import numpy as np
    from brood_brdf import Material, breed

    gold = Material.preset("gold")
    f = gold.eval([[0.6, 0.0, 0.8]], [[-0.6, 0.0, 0.8]])    # 1/sr, shape (1, 3)
    children = breed(gold, seed=1)                           # twenty variations

`brood_brdf.client` is a client of the HTTP API of a brood server.
"""

from .brood import Brood, breed, cross, mutate
from .catalogue import ExportFormat, Preset, export_formats, presets, simd_level
from .error import GenomeError
from .evolution import Evaluated, Evolution, EvolutionResult
from .fitting import Fit, FitProgress, Found, Target, fit
from .material import Material
from .sampling import Sampled, SamplingQuality

__all__ = [
    "Brood",
    "Evaluated",
    "Evolution",
    "EvolutionResult",
    "ExportFormat",
    "Fit",
    "FitProgress",
    "Found",
    "GenomeError",
    "Material",
    "Preset",
    "Sampled",
    "SamplingQuality",
    "Target",
    "breed",
    "cross",
    "export_formats",
    "fit",
    "mutate",
    "presets",
    "simd_level",
]
