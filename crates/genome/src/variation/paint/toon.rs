//! Effects that paint what a BRDF reflects, from effects that paint light.

use crate::{Genome, effect};

/// Reflected light at which the first and the last colour are reached. The thresholds of the
/// painted parent are amounts of incident light and do not apply.
const LEVELS: [(&str, f64); 2] = [("from", 0.0), ("to", 0.4)];

/// Returns a BRDF with the effects of a painted material. The light effect becomes `by brdf`; its
/// palette and its images stay.
///
/// # Panics
/// If `brdf` is painted or `paint` is not.
pub(in super::super) fn painted_by(brdf: &Genome, paint: &Genome) -> Genome {
    let mut effects = paint.effects().to_vec();
    if !paint.is_by_brdf() {
        let light = &effects[0];
        let mut values = light.values().clone();
        values.set_text(effect::BY, effect::BRDF).expect("light is painted by a BRDF");
        for (name, level) in LEVELS {
            values.set(name, &[level]).expect("levels are in their ranges");
        }
        effects[0] = light
            .with_parts(values, light.palette().cloned())
            .expect("levels keep to the rules of effects");
    }
    assert!(!brdf.is_painted(), "only a BRDF can be painted");
    // A painted material has no bumps.
    brdf.clone().with_bump(None).with_effects(effects).expect("a BRDF has effects by brdf")
}

/// True if exactly one of two genomes is painted.
pub(in super::super) fn are_mixed(first: &Genome, second: &Genome) -> bool {
    first.is_painted() != second.is_painted()
}

/// Returns both parents. If exactly one is painted, the other gets its effects.
pub(in super::super) fn matched(first: &Genome, second: &Genome) -> [Genome; 2] {
    match (first.is_painted(), second.is_painted()) {
        (false, true) => [painted_by(first, second), second.clone()],
        (true, false) => [first.clone(), painted_by(second, first)],
        _ => [first.clone(), second.clone()],
    }
}
