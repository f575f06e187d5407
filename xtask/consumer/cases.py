"""The list of cases of `brood bench consumer`, and the results of a script that reads them."""

import base64
import json
import statistics

import numpy


def doubles(text):
    """Numbers of a list of cases."""
    return numpy.frombuffer(base64.b64decode(text))


def listed(folder):
    return json.loads((folder / "cases.json").read_text())


def compared(case, error, least, ratio):
    """Result of a material: its bound is `least`, or `ratio` times its change by rounding."""
    bound = max(least, ratio * case["rounding"])
    return {
        "name": case["name"],
        "value_error": error,
        "bound": bound,
        "passed": bool(error <= bound),
    }


def finish(consumer, cases, results, **others):
    """Prints the summary of the results, and returns the exit code."""
    errors = [result["value_error"] for result in results]
    failed = [result["name"] for result in results if not result["passed"]]
    summary = {
        "consumer": consumer,
        "materials": len(results),
        "refused": sum("refused" in case for case in cases),
        "worst_error": max(errors),
        "median_error": statistics.median(errors),
        **others,
        "failed": failed,
    }
    print(json.dumps(summary))
    return 1 if failed else 0
