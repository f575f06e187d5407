"""E_log of pyoperon's symbolic regression on samples that `brood bench fit --out` wrote.

One model for each channel, each with the whole time. Regressed is ln(1 + f cos_i), so that the mean squared error is the
square of E_log. Writes one JSON object a line to stdout: material, e_log over all channels, and each channel's own.
"""

import argparse
import json
import pathlib
import time

import numpy
from pyoperon.sklearn import SymbolicRegressor

SYMBOLS = "add,sub,mul,div,exp,log,sqrt,square,constant,variable"


def read(path):
    rows = numpy.loadtxt(path, delimiter=",", skiprows=1)
    wi, wo, f = rows[:, 0:3], rows[:, 3:6], rows[:, 6:9]
    half = wi + wo
    half /= numpy.linalg.norm(half, axis=1, keepdims=True)
    cos_h, cos_d = half[:, 2], numpy.sum(half * wi, axis=1)
    cos_i, cos_o = wi[:, 2], wo[:, 2]
    tan_h = numpy.sqrt(numpy.maximum(1.0 - cos_h**2, 0.0)) / numpy.maximum(cos_h, 1e-6)
    features = numpy.stack([cos_h, cos_d, cos_i, cos_o, cos_i * cos_o, tan_h], axis=1)
    return features, numpy.log1p(f * cos_i[:, None])


def fit(features, wanted, options):
    regressor = SymbolicRegressor(
        allowed_symbols=SYMBOLS,
        max_length=60,
        population_size=1000,
        optimizer_iterations=5,
        max_time=options.seconds,
        generations=1_000_000,
        max_evaluations=2**31 - 1,
        model_selection_criterion="mean_squared_error",
        n_threads=options.threads,
        random_state=options.seed,
    )
    start = time.perf_counter()
    regressor.fit(features, wanted)
    return regressor, time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("samples", type=pathlib.Path)
    parser.add_argument("--seconds", type=int, default=25)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for path in sorted(options.samples.glob("*-fitted.csv")):
        name = path.name.removesuffix("-fitted.csv")
        features, wanted = read(path)
        held, held_wanted = read(path.with_name(f"{name}-held.csv"))
        squares, seconds = [], []
        for channel in range(3):
            regressor, took = fit(features, wanted[:, channel], options)
            found = regressor.predict(held)
            squares.append(float(numpy.mean((found - held_wanted[:, channel]) ** 2)))
            seconds.append(took)
        channels = [value**0.5 for value in squares]
        e_log = (sum(squares) / 3) ** 0.5
        print(json.dumps({"material": name, "e_log": e_log, "channels": channels, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
