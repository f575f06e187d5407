// A material bred by brood, as a node of MaterialX. Program @PROGRAM@,
// @OPERATIONS@ operations.
#include "libraries/pbrlib/genglsl/lib/mx_closure_type.glsl"

// Every product and sum must be rounded separately. @NAME@_brood_zero is 0: because
// compilers do not know its value, they cannot fuse operations across brood_hold.
@CODE@

void @NAME@_bsdf(ClosureData closureData, float weight, vec3 normal, vec3 tangent,@BITANGENT@ vec2 texcoord, int zero, inout BSDF bsdf)
{
  @NAME@_brood_zero = uint(zero);
  bsdf.response = vec3(0.0);
  bsdf.throughput = vec3(0.0);
  if (closureData.closureType == CLOSURE_TYPE_REFLECTION) {
    vec3 n = dot(normal, closureData.V) < 0.0 ? -normal : normal;
    float cosine = dot(n, closureData.L);
    if (cosine > 0.0) {
      // The eye is at least 1e-4 above the surface.
      vec3 eye = normalize(closureData.V + n * max(1e-4 - dot(n, closureData.V), 0.0));
      vec3 x = normalize(tangent - n * dot(n, tangent));
      vec3 y = @ACROSS@;
      vec3 f = @NAME@_evolved(closureData.L, eye, n, x, y, texcoord);
      bsdf.response = f * (cosine * closureData.occlusion * weight);
    }
  }
}
