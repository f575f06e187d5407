What passes the coat of a rough plastic, in WGSL; CPU twin: brood-brdf's model/rough_plastic.rs; GLSL twin: plastic.glsl.
LAYER stands for the number of the layer, TABLE for its table. Unlike the other texts this one is written once for each layer.
// @table
// What passes the coat of layer LAYER at cosines from 0 to 1 in equal steps, linear between them.
var<private> passes_LAYER_table: array<f32, 64> = array<f32, 64>(
TABLE);

fn passes_LAYER(cosine: f32) -> f32 {
  let at = 63.0 * clamp(cosine, 0.0, 1.0);
  let low = i32(min(at, 62.0));
  let share = at - f32(low);
  return passes_LAYER_table[low] * (1.0 - share) + passes_LAYER_table[low + 1] * share;
}

