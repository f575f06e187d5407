"""Scene in which each pixel shows one pair of directions, for renderers that draw meshes.

The eye is at the origin and looks along -z, with a parallel projection of the square from -1 to 1.
Each pair has a place whose direction to the eye has, to the light of its picture, the angle of the
pair; a normal and a tangent there turn the pair into these directions. The depth of the place is
free, because the projection is parallel.
"""

import numpy

from cases import doubles

# Pixels of a side of a picture.
SIDE = 64
# Directions to the light, one for each picture. The second is for angles near a right one.
LIGHTS = numpy.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
# Cosine of the angle up to which the second picture has a pair.
LEVEL = 0.2


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=1, keepdims=True)


def frame(first, second):
    """Orthonormal frames whose first axis is `first`, with `second` in the first plane."""
    rest = second - first * (first * second).sum(1, keepdims=True)
    # Directions that are nearly equal have any plane.
    any_axis = numpy.eye(3)[abs(first).argmin(1)]
    rest = numpy.where((abs(rest) < 1e-6).all(1, keepdims=True), any_axis, rest)
    rest = unit(rest - first * (first * rest).sum(1, keepdims=True))
    return numpy.stack([first, rest, numpy.cross(first, rest)], axis=2)


class Pairs:
    """Pairs of directions of the reference, and the meshes that show them."""

    def __init__(self, text):
        values = doubles(text).reshape(-1, 8)
        self.wi, self.wo, self.uv = unit(values[:, 0:3]), unit(values[:, 3:6]), values[:, 6:8]
        self.cosine = values[:, 2]
        cosine = (self.wi * self.wo).sum(1)
        self.picture = numpy.select([cosine > LEVEL, cosine > -LEVEL], [0, 1], 2)
        # Pixels of the second picture whose azimuth allows these angles, on the light's side.
        rows, columns = numpy.divmod(numpy.arange(SIDE * SIDE), SIDE)
        centres = numpy.stack([2 * columns + 1, 2 * rows + 1], 1) / SIDE - 1
        across = -centres[:, 0] / numpy.linalg.norm(centres, axis=1)
        self.pixel = numpy.zeros(len(values), dtype=int)
        free = {}
        for k in range(len(values)):
            key = (self.picture[k], cosine[k] > 0)
            if key not in free:
                middle = abs(across) > 0.5 if key[0] == 1 else numpy.full(len(across), True)
                right = (across > 0) == key[1] if key[0] == 1 else middle
                free[key] = iter(numpy.flatnonzero(middle & right))
            self.pixel[k] = next(free[key])
        centre, across = centres[self.pixel], across[self.pixel]
        light = LIGHTS[self.picture]
        # Sine of the angle between the direction to the eye and the z axis.
        sine = numpy.where(self.picture == 1, cosine / across, numpy.sqrt(1 - cosine**2))
        radius = numpy.linalg.norm(centre, axis=1)
        sine = numpy.maximum(sine, 1e-6)
        depth = -radius * numpy.sqrt(1 - sine**2) / sine
        self.place = numpy.concatenate([centre, depth[:, None]], axis=1)
        eye = unit(-self.place)
        turn = frame(light, eye) @ frame(self.wi, self.wo).transpose(0, 2, 1)
        self.normal, self.tangent, self.bitangent = turn[:, :, 2], turn[:, :, 0], turn[:, :, 1]

    def error(self, found, wanted):
        """Mean abs(df cos) / mean f cos, of values of f cos."""
        wanted = wanted * self.cosine[:, None]
        total = wanted.sum()
        return float(abs(found - wanted).sum() / (total if total > 0 else 1))
