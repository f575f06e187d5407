"""A triangle mesh without normals, written in forms of which it is said what its normals are, and a fine sphere.

Renderers make normals themselves where a file has none, each in its way: across the seams of the texture or only within
them, by angles or by areas. What they have in common is how they read normals that are there. Knows of no renderer.
"""

import argparse
import math
import pathlib

import numpy

REFINEMENTS = 2
# Rows and columns.
SPHERE = 280, 560


def read(path):
    """Places, texture places, and triangles of pairs of their numbers."""
    places, textures, triangles = [], [], []
    for line in pathlib.Path(path).read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            places.append([float(word) for word in words])
        elif kind == "vt":
            textures.append([float(word) for word in words])
        elif kind == "f":
            triangles.append([[int(number) - 1 for number in corner.split("/")[:2]] for corner in words])
    return numpy.array(places), numpy.array(textures), numpy.array(triangles)


def face_normals(places, triangles):
    a, b, c = (places[triangles[:, k]] for k in range(3))
    return unit(numpy.cross(b - a, c - a))


def smooth_normals(places, triangles):
    """Of each place: those of the triangles around it, weighted by their angles there."""
    faces = face_normals(places, triangles)
    sums = numpy.zeros_like(places)
    for k in range(3):
        here, there, then = (places[triangles[:, (k + step) % 3]] for step in range(3))
        a, b = there - here, then - here
        angle = numpy.arctan2(numpy.linalg.norm(numpy.cross(a, b), axis=1), (a * b).sum(axis=1))
        numpy.add.at(sums, triangles[:, k], faces * angle[:, None])
    return unit(sums)


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=1)[:, None]


def refined(places, triangles):
    """Loop's subdivision, once; borders become curves of their own."""
    edges = numpy.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, number, count = numpy.unique(edges, axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    if (count > 2).any():
        raise SystemExit("more than two triangles of the mesh share an edge")
    across = numpy.zeros((len(edges), 3))
    numpy.add.at(across, number, places[triangles[:, [2, 0, 1]].reshape(-1)])
    middles = 3 / 8 * places[edges].sum(axis=1) + across / 8
    border = edges[count == 1]
    middles[count == 1] = places[border].mean(axis=1)
    degree = numpy.bincount(edges.ravel(), minlength=len(places))
    around = numpy.zeros_like(places)
    numpy.add.at(around, edges[:, 0], places[edges[:, 1]])
    numpy.add.at(around, edges[:, 1], places[edges[:, 0]])
    share = (5 / 8 - (3 / 8 + numpy.cos(2 * math.pi / degree) / 4) ** 2) / degree
    moved = places * (1 - degree * share)[:, None] + around * share[:, None]
    beside = numpy.zeros_like(places)
    numpy.add.at(beside, border[:, 0], places[border[:, 1]])
    numpy.add.at(beside, border[:, 1], places[border[:, 0]])
    on_border = numpy.unique(border)
    moved[on_border] = 3 / 4 * places[on_border] + beside[on_border] / 8
    (a, b, c), (ab, bc, ca) = triangles.T, (number + len(places)).reshape(-1, 3).T
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return numpy.concatenate([moved, middles]), numpy.concatenate([numpy.stack(q, axis=1) for q in quarters])


def sphere(rows, columns):
    """Places, which are normals too, and triangles; poles above and below."""
    polar = numpy.pi * numpy.arange(1, rows) / rows
    azimuth = 2 * numpy.pi * numpy.arange(columns) / columns
    across = [numpy.outer(numpy.sin(polar), f(azimuth)).ravel() for f in (numpy.sin, numpy.cos)]
    ring = numpy.stack([across[0], numpy.repeat(numpy.cos(polar), columns), across[1]], axis=1)
    row, column = (grid.ravel() for grid in numpy.indices((rows - 2, columns)))
    a, b = row * columns + column, row * columns + (column + 1) % columns
    c, d = a + columns, b + columns
    top, below, last = len(ring), len(ring) + 1, (rows - 2) * columns
    first, then = numpy.arange(columns), (numpy.arange(columns) + 1) % columns
    triangles = [
        (a, c, d), (a, d, b),
        (numpy.full(columns, top), first, then), (last + then, last + first, numpy.full(columns, below)),
    ]
    places = numpy.concatenate([ring, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    return places, numpy.concatenate([numpy.stack(part, axis=1) for part in triangles])


def write(path, places, textures, normals, corners):
    """Corners are numbers of place, texture place (none where there are no such) and normal."""
    def lines():
        for kind, rows in (("v", places), ("vt", textures), ("vn", normals)):
            for row in rows:
                yield " ".join([kind, *(f"{value:.9g}" for value in row)])
        texture = len(textures) > 0
        for corner in corners + 1:
            yield " ".join(["f", *(f"{v}/{t if texture else ''}/{n}" for v, t, n in corner)])

    path.write_text("\n".join(lines()) + "\n")


def welded(places, triangles):
    """The same surface in which each place has one number, within the cube of -1..1."""
    low, high = places.min(axis=0), places.max(axis=0)
    places = (places - (low + high) / 2) / ((high - low).max() / 2)
    places, number = numpy.unique(places.round(5), axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles]
    first, second, third = triangles.T
    return places, triangles[(first != second) & (second != third) & (third != first)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", help="an OBJ file of triangles with texture coordinates")
    parser.add_argument("folder", type=pathlib.Path, help="where the forms are written")
    parser.add_argument("--other", help="an OBJ file of triangles, of which other.obj is made: smooth, refined, of this size")
    options = parser.parse_args()
    places, textures, triangles = read(options.mesh)
    v, t = triangles[:, :, 0], triangles[:, :, 1]

    def form(name, places, textures, normals, *corners):
        write(options.folder / f"{name}.obj", places, textures, normals, numpy.stack(corners, axis=2))

    form("smooth", places, textures, smooth_normals(places, v), v, t, v)
    each = numpy.repeat(numpy.arange(len(v))[:, None], 3, axis=1)
    form("facets", places, textures, face_normals(places, v), v, t, each)
    # Creases where one place has several texture places, as renderers have them that take those for several vertices.
    pairs, number = numpy.unique(triangles.reshape(-1, 2), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    form("seams", places, textures, smooth_normals(places[pairs[:, 0]], number), v, t, number)
    for _ in range(REFINEMENTS):
        places, v = refined(places, v)
    form("refined", places, [], smooth_normals(places, v), v, v, v)
    places, v = sphere(*SPHERE)
    form("sphere", places, [], places, v, v, v)
    if options.other:
        places, _, triangles = read(options.other)
        places, v = welded(places, triangles[:, :, 0])
        for _ in range(REFINEMENTS):
            places, v = refined(places, v)
        form("other", places, [], smooth_normals(places, v), v, v, v)


if __name__ == "__main__":
    main()
