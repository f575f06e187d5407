Transmittance of the coat of a rough plastic, in GLSL. CPU twin: brood-brdf's
model/rough_plastic.rs; WGSL twin: plastic.wgsl. LAYER is replaced by the number of the layer, TABLE
by its table. Unlike the other texts, this one is printed once for each layer.
// @table
// Transmittance of the coat of layer LAYER at evenly spaced cosines from 0 to 1, linear in between.
const float passes_LAYER_table[64] = float[64](
TABLE);

float passes_LAYER(float cosine) {
  float at = 63.0 * clamp(cosine, 0.0, 1.0);
  int low = int(min(at, 62.0));
  float share = at - float(low);
  return passes_LAYER_table[low] * (1.0 - share) + passes_LAYER_table[low + 1] * share;
}

