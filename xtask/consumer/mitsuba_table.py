"""Tests exported RGL tables in Mitsuba: python mitsuba_table.py DIR [NAME...]

DIR holds cases.json and files of `brood bench consumer --format rgl-bsdf`. Each material is loaded
as a user would, by the BSDF `measured`, then

- f times the cosine is compared with the values of the reference,
- the variance of one sample in an even sky is measured, with samples by the table and by the cosine.

Prints one line of JSON for each material, then one with the summary. Exits with 1 if a bound is
exceeded.
"""

import json
import statistics
import sys
import time

import mitsuba as mi
from mitsuba_shared import doubles, interaction, tested, variances

# Bounds of the median over presets and models of the median over pairs of |df| / f. Random programs
# may have details that no table shows; their errors are stated in the files.
ISOTROPIC_MEDIAN = 0.008
ANISOTROPIC_MEDIAN = 0.007
RANDOM = ("random-", "layered-", "textured-", "bumped-")
# Bound of the difference of errors, mean |df cos| / mean f cos, as Mitsuba and as brood reads a file:
# the larger of this and of this share.
OWN_DIFFERENCE = 1e-4
OWN_RATIO = 1e-2


def value_errors(bsdf, pairs, wanted):
    """Mean |df cos| / mean f cos, and median over pairs of |df| / f."""
    si = interaction(pairs.to_eye, pairs.uv)
    found = bsdf.eval(mi.BSDFContext(), si, pairs.to_light)
    differences, values = [0.0] * len(pairs.cosine), [0.0] * len(pairs.cosine)
    for channel in range(3):
        columns = zip(found[channel], wanted[channel::3], pairs.cosine)
        for place, (value, f, cosine) in enumerate(columns):
            differences[place] += abs(value - f * cosine)
            values[place] += f * cosine
    ratios = [a / b for a, b in zip(differences, values) if b > 0]
    return sum(differences) / max(sum(values), 1e-30), median(ratios)


def test(case, folder, pairs):
    started = time.time()
    bsdf = mi.load_dict({"type": "measured", "filename": str(folder / case["file"])})
    error, of_pairs = value_errors(bsdf, pairs, doubles(case["f"]))
    own_error = case["own_error"]
    table, cosine = variances(bsdf)
    return {
        "name": case["name"],
        "anisotropic": case["anisotropic"],
        "value_error": error,
        "median_of_pairs": of_pairs,
        "own_error": own_error,
        "variance": table,
        "cosine_variance": cosine,
        "seconds": round(time.time() - started, 2),
        "passed": abs(error - own_error) <= max(OWN_DIFFERENCE, OWN_RATIO * own_error),
    }


def median(values):
    return statistics.median(values) if values else 0


def main():
    found, refused = tested(test)
    errors = [result["value_error"] for result in found]
    known = [r for r in found if not r["name"].startswith(RANDOM)]
    isotropic = median([r["median_of_pairs"] for r in known if not r["anisotropic"]])
    anisotropic = median([r["median_of_pairs"] for r in known if r["anisotropic"]])
    # Variances below 1e-3 are noise of the estimate.
    ratios = [(r["cosine_variance"] + 1e-3) / (r["variance"] + 1e-3) for r in found]
    failed = [result["name"] for result in found if not result["passed"]]
    if isotropic > ISOTROPIC_MEDIAN:
        failed.append("median of isotropic materials")
    if anisotropic > ANISOTROPIC_MEDIAN:
        failed.append("median of anisotropic materials")
    summary = {
        "consumer": f"mitsuba {mi.__version__}, measured",
        "materials": len(found),
        "refused": refused,
        "worst_error": max(errors),
        "median_error": median(errors),
        "median_of_pairs": median([r["median_of_pairs"] for r in found]),
        "median_of_isotropic": isotropic,
        "median_of_anisotropic": anisotropic,
        "variance_ratio": {"median": median(ratios), "worst": min(ratios)},
        "failed": failed,
    }
    print(json.dumps(summary))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
