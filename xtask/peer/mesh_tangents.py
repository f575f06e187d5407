"""Directions along a mesh's surface, one for each vertex, as brood makes them. Knows of no renderer.

Renderers do not agree on them, and anisotropic materials show it: Mitsuba has one for each triangle. Given the same, it is
the materials that are compared. The rule is that of `crates/scene/src/mesh/tangent.rs`, written anew; both bounds are its own.
"""

import numpy

COLLINEAR = 1e-9
CANCELLED = 1e-9


def tangents(places, normals, textures, triangles):
    """Directions of growing u by least squares over the edges of a vertex; fixed ones where they do not tell."""
    here, there = edges(triangles)
    apart = places[there] - places[here]
    normal = normals[here]
    level = apart - normal * dot(apart, normal)[:, None]
    u, v = (textures[there] - textures[here]).T

    def summed(values):
        sums = numpy.zeros((len(places), *values.shape[1:]))
        numpy.add.at(sums, here, values)
        return sums

    spread_u, spread_v = numpy.sqrt(summed(u * u)), numpy.sqrt(summed(v * v))
    # Where something vanishes the quotients are not numbers, and the fixed direction is taken.
    with numpy.errstate(divide="ignore", invalid="ignore"):
        correlation = summed(u * v) / spread_u / spread_v
        along = summed(level * u[:, None]) / spread_u[:, None]
        along -= summed(level * v[:, None]) * (correlation / spread_v)[:, None]
        length = numpy.sqrt(dot(along, along))
        found = along / length[:, None]
        found = unit(found - normals * dot(found, normals)[:, None])
        tells = 1 - correlation * correlation > COLLINEAR
        tells &= length > CANCELLED * numpy.sqrt(summed(dot(apart, apart)))
    return numpy.where(tells[:, None], found, fixed(normals))


def edges(triangles):
    """Both directions of each edge, once."""
    a, b, c = triangles.T
    both = numpy.stack([numpy.concatenate(ends) for ends in ((a, b, b, c, c, a), (b, a, c, b, a, c))], axis=1)
    return numpy.unique(both, axis=0).T


def fixed(normals):
    """Level, to the right seen from outside; across a pole that of growing x."""
    x, _, z = normals.T
    level = numpy.stack([z, 0 * z, -x], axis=1)
    pole = dot(level, level) <= 1e-12
    level[pole] = [1, 0, 0] - normals[pole] * x[pole, None]
    return unit(level)


def dot(a, b):
    return (a * b).sum(axis=1)


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=1)[:, None]
