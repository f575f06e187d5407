"""Results of sampling."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Sampled", "SamplingQuality"]


class Sampled(NamedTuple):
    """Directions that were drawn in proportion to what a material reflects.

    Attributes:
        wi: Directions to the light, float64 of shape (N, 3).
        pdf: Density per solid angle in 1/sr, float64 of shape (N,); 0 below the surface.
        weight: f cos_i / pdf, float32 of shape (N, 3): its mean is the reflected share of an even
            sky. 0 where pdf is 0.
    """

    wi: npt.NDArray[np.float64]
    pdf: npt.NDArray[np.float64]
    weight: npt.NDArray[np.float32]


class SamplingQuality(NamedTuple):
    """Quality of `Material.sample`.

    Attributes:
        table_share: Share of the samples that a table chooses; the cosine chooses the others.
        variance: Variance of one sample in an even sky, relative to the square of the mean.
        cosine_variance: The same if the cosine chose all samples.
    """

    table_share: float
    variance: float
    cosine_variance: float
