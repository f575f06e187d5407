"""Tests exported HLSL with Slang: python slang.py DIR

DIR holds cases.json and files of `brood bench consumer --format hlsl`. Each material is compiled by
Slang for the processor, run on all pairs of directions, and compared with the values of the
reference. Needs a C++ compiler. Prints one line of JSON for each material, then one with the
summary. Exits with 1 if a bound is exceeded.
"""

import importlib.metadata
import json
import sys
from pathlib import Path

import numpy
import slangpy

from cases import compared, doubles, finish, listed

# Bounds of the error of values, mean |df cos| / mean f cos: the larger of this, and of this times
# the change by rounding directions and texture positions to numbers of 32 bits.
VALUE_ERROR = 1e-5
ROUNDING_RATIO = 2

KERNEL = """
StructuredBuffer<float> pairs;
RWStructuredBuffer<float> found;

[shader("compute")]
[numthreads(1, 1, 1)]
void run(uint3 id : SV_DispatchThreadID) {
  uint k = 8 * id.x;
  float3 wi = float3(pairs[k], pairs[k + 1], pairs[k + 2]);
  float3 wo = float3(pairs[k + 3], pairs[k + 4], pairs[k + 5]);
  float2 uv = float2(pairs[k + 6], pairs[k + 7]);
  float3 n = float3(0.0, 0.0, 1.0);
  float3 f = evolved(wi, wo, n, float3(1.0, 0.0, 0.0), float3(0.0, 1.0, 0.0), uv);
  found[3 * id.x] = f.x;
  found[3 * id.x + 1] = f.y;
  found[3 * id.x + 2] = f.z;
}
"""


def values(device, name, source, pairs):
    """f of each pair: red, green, blue."""
    module = device.load_module_from_source(name, "#define BROOD_PRECISE\n" + source + KERNEL)
    program = device.link_program([module], [module.entry_point("run")])
    kernel = device.create_compute_kernel(program)
    usage = slangpy.BufferUsage
    count = len(pairs)
    given = device.create_buffer(data=pairs, usage=usage.shader_resource, struct_size=4)
    found = device.create_buffer(size=12 * count, usage=usage.unordered_access, struct_size=4)
    kernel.dispatch(thread_count=[count, 1, 1], vars={"pairs": given, "found": found})
    return found.to_numpy().view(numpy.float32).reshape(count, 3)


def main():
    folder = Path(sys.argv[1])
    device = slangpy.Device(type=slangpy.DeviceType.cpu)
    given = listed(folder)
    cases = given["cases"]
    exact = doubles(given["pairs"]).reshape(-1, 8)
    pairs = numpy.ascontiguousarray(exact, dtype=numpy.float32)
    cosine = exact[:, 2:3]
    results = []
    for case in cases:
        if "file" not in case or "f" not in case:
            continue
        source = (folder / case["file"]).read_text()
        found = values(device, case["file"].replace(".", "_"), source, pairs)
        wanted = doubles(case["f"]).reshape(-1, 3)
        total = (wanted * cosine).sum()
        error = (abs(found - wanted) * cosine).sum() / (total if total > 0 else 1)
        result = compared(case, error, VALUE_ERROR, ROUNDING_RATIO)
        print(json.dumps(result), flush=True)
        results.append(result)
    return finish(f"slangpy {importlib.metadata.version('slangpy')}", cases, results)


if __name__ == "__main__":
    sys.exit(main())
