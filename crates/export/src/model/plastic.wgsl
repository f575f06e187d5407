Transmittance of the coat of a rough plastic. CPU twin: brood-brdf's model/rough_plastic.rs. LAYER
is replaced by the number of the layer, TABLE by its table. Unlike the other texts, this one is
printed once for each layer.
// @table
// Transmittance of the coat of layer LAYER at evenly spaced cosines from 0 to 1, linear in between.
var<private> passes_LAYER_table: array<f32, 64> = array<f32, 64>(
TABLE);

fn passes_LAYER(cosine: f32) -> f32 {
  let at: f32 = 63.0 * clamp(cosine, 0.0, 1.0);
  let low: i32 = i32(min(at, 62.0));
  let share: f32 = at - f32(low);
  return passes_LAYER_table[low] * (1.0 - share) + passes_LAYER_table[low + 1] * share;
}

