"""Scalar operations a second of pyoperon's evaluator on one thread, and how many random programs stay finite.

Writes one JSON object to stdout. A GP operation is one non-leaf node on one sample. Nodes are counted too, because a
variable leaf of operon carries a coefficient, which is one multiplication more that the first count leaves out.
"""

import argparse
import json
import time

import numpy
import pyoperon

KIND = pyoperon.NodeType
ARITHMETIC = [KIND.Add, KIND.Sub, KIND.Mul]
FUNCTIONS = [KIND.Sin, KIND.Exp]
LEAVES = [KIND.Constant, KIND.Variable]
# What operon can be configured with beyond the above: the set that meets poles and logarithms of negative numbers.
PARTIAL = [KIND.Div, KIND.Log, KIND.Sqrt, KIND.Pow, KIND.Tan]


class Samples:
    """A data set of uniform inputs in [-1, 1], as directions give them."""

    def __init__(self, rows, columns, seed):
        draw = numpy.random.default_rng(seed)
        values = draw.uniform(-1.0, 1.0, (rows, columns)).astype(numpy.float32)
        # A Fortran-order float32 array becomes a view, not a copy: it has to live as long as the data set.
        self.values = numpy.asfortranarray(values)
        self.data = pyoperon.Dataset(self.values)
        self.problem = pyoperon.Problem(self.data)
        self.range = pyoperon.Range(0, rows)
        self.rows = rows


def is_function(node):
    return not node.IsLeaf and node.Arity == 1


def make_trees(samples, kinds, length, count, seed, frequency=None):
    """Trees of operon's own balanced creator with normally distributed coefficients."""
    samples.problem.ConfigurePrimitiveSet(sum(int(kind) for kind in kinds + LEAVES))
    primitives = samples.problem.PrimitiveSet
    for kind, weight in (frequency or {}).items():
        primitives.SetFrequency(pyoperon.Node(kind).HashValue, weight)
    creator = pyoperon.BalancedTreeCreator(primitives, samples.data.VariableHashes, 0.0)
    coefficients = pyoperon.NormalCoefficientInitializer()
    random = pyoperon.RandomGenerator(seed)
    trees = []
    for _ in range(count):
        tree = creator(random, length, 1, 1000)
        coefficients(random, tree)
        trees.append(tree)
    return trees


def time_trees(samples, trees, passes):
    """Fastest and slowest pass over all trees, and the busy share of a core in the fastest."""
    out = numpy.zeros(samples.rows * len(trees), dtype=numpy.float32)
    pyoperon.EvaluateTrees(trees, samples.data, samples.range, out, 1)
    times = []
    for _ in range(passes):
        start, busy = time.perf_counter(), time.process_time()
        pyoperon.EvaluateTrees(trees, samples.data, samples.range, out, 1)
        seconds = time.perf_counter() - start
        times.append((seconds, (time.process_time() - busy) / seconds))
    finite = numpy.isfinite(out.reshape(len(trees), samples.rows)).all(axis=1)
    if max(cores for _, cores in times) > 1.2:
        raise SystemExit("operon used more than one core: the figures would not be those of one")
    return min(times)[0], max(times)[0], float(finite.mean())


def rate(samples, mix, kinds, length, options, frequency=None):
    trees = make_trees(samples, kinds, length, options.programs, options.seed, frequency)
    nodes = [node for tree in trees for node in tree.Nodes]
    operations = sum(not node.IsLeaf for node in nodes)
    fastest, slowest, finite = time_trees(samples, trees, options.passes)
    return {
        "mix": mix,
        "nodes_per_program": len(nodes) / len(trees),
        "operations_per_program": operations / len(trees),
        "function_share": sum(is_function(node) for node in nodes) / operations,
        "operations_per_second": operations * samples.rows / fastest,
        "slowest_operations_per_second": operations * samples.rows / slowest,
        "nodes_per_second": len(nodes) * samples.rows / fastest,
        "finite_programs_share": finite,
    }


def finite_share(samples, name, kinds, options, large):
    """Programs whose every value is finite; with `large`, coefficients are spread over all sizes up to 65504."""
    trees = make_trees(samples, kinds, 50, options.finite_programs, options.seed + 1)
    draw = numpy.random.default_rng(options.seed)
    if large:
        for tree in trees:
            count = tree.CoefficientsCount
            sizes = numpy.exp2(draw.uniform(-16.0, numpy.log2(65504.0), count))
            tree.SetCoefficients(sizes * draw.choice([-1.0, 1.0], count))
    out = numpy.zeros(samples.rows * len(trees), dtype=numpy.float32)
    pyoperon.EvaluateTrees(trees, samples.data, samples.range, out, 1)
    finite = numpy.isfinite(out.reshape(len(trees), samples.rows)).all(axis=1)
    return {
        "mix": name,
        "coefficients": "up to +-65504" if large else "normal",
        "programs": len(trees),
        "finite_programs_share": float(finite.mean()),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=4096)
    parser.add_argument("--programs", type=int, default=300)
    parser.add_argument("--finite-programs", type=int, default=1000)
    parser.add_argument("--passes", type=int, default=15)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    samples = Samples(options.samples, 9, options.seed)
    rows = []
    # Trees of 50 nodes, and of 100, which have about as many operations as the programs they are held against.
    for length in (50, 100):
        rows.append(rate(samples, "add sub mul", ARITHMETIC, length, options))
        # The share of sin and exp in the work follows from their frequency; several, to find the one that compares.
        for weight in (2, 4, 8, 10, 16):
            frequency = {kind: weight for kind in FUNCTIONS} | {kind: 16 for kind in ARITHMETIC}
            kinds = ARITHMETIC + FUNCTIONS
            rows.append(rate(samples, "add sub mul sin exp", kinds, length, options, frequency))
    mixes = [
        ("add sub mul", ARITHMETIC),
        ("add sub mul sin exp", ARITHMETIC + FUNCTIONS),
        ("add sub mul sin exp div log sqrt pow tan", ARITHMETIC + FUNCTIONS + PARTIAL),
    ]
    finite = [
        finite_share(samples, name, kinds, options, large)
        for name, kinds in mixes
        for large in (False, True)
    ]
    print(json.dumps({"samples": samples.rows, "rows": rows, "finite": finite}))


if __name__ == "__main__":
    main()
