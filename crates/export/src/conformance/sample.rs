//! Pairs of directions with f32 components and almost unit length, so that their length causes
//! hardly any error.

use std::f64::consts::TAU;

use brood_genome::{BirthKey, Operator, Stream};
use glam::DVec3;

/// Range of the search for the components nearest to unit length, in units in the last place of
/// each.
const STEPS: i32 = 12;

/// Returns `count` pairs above the surface. Some are equal, some grazing, some mirrored with an
/// offset as large as highlights are wide.
#[must_use]
pub fn pairs(count: usize) -> Vec<[DVec3; 2]> {
    let key = BirthKey { seed: 11, slot: 0, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomConstants);
    (0..count).map(|_| pair(&mut stream)).collect()
}

fn pair(stream: &mut Stream) -> [DVec3; 2] {
    let wi = direction(stream);
    let wo = match stream.below(8) {
        0 => wi,
        1..=3 => {
            let width = libm::exp2(-14.0 * f64::from(stream.unit()));
            let mirrored = DVec3::new(-wi.x, -wi.y, wi.z) + width * direction(stream);
            nearest_unit(mirrored.normalize())
        }
        _ => direction(stream),
    };
    [wi, wo]
}

fn direction(stream: &mut Stream) -> DVec3 {
    let share = f64::from(stream.unit());
    let z = match stream.below(10) {
        0 => 1e-9 + 1e-6 * share,
        1 => 1.0 - 1e-7 * share,
        _ => share.max(1e-9),
    };
    let (sin, cos) = libm::sincos(TAU * f64::from(stream.unit()));
    let r = (1.0 - z * z).max(0.0).sqrt();
    nearest_unit(DVec3::new(r * cos, r * sin, z))
}

/// Returns the direction with f32 components near `w` whose length is nearest to 1. Varies two
/// components and keeps the third.
fn nearest_unit(w: DVec3) -> DVec3 {
    let mut best = w.as_vec3();
    let (axis, other) = if w.z.abs() > 0.7 { (2, 0) } else { (0, 1) };
    let start = best;
    for a in -STEPS..=STEPS {
        for b in -STEPS..=STEPS {
            let mut near = start;
            near[axis] = step(start[axis], a);
            near[other] = step(start[other], b);
            if length_error(near.as_dvec3()) < length_error(best.as_dvec3()) {
                best = near;
            }
        }
    }
    best.as_dvec3()
}

/// Changes a value by units in its last place; values near 0 stay.
fn step(value: f32, steps: i32) -> f32 {
    if value.abs() < 1e-30 {
        value
    } else {
        f32::from_bits(value.to_bits().saturating_add_signed(steps))
    }
}

fn length_error(w: DVec3) -> f64 {
    (w.length_squared() - 1.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_above_the_surface_and_exact_in_f32() {
        for w in pairs(500).into_iter().flatten() {
            // 2^-24: near the normal only z is large enough to correct the length, by its own last
            // place.
            assert!(length_error(w) < 5.97e-8 && w.z > 0.0, "{w}: {:e}", length_error(w));
            assert_eq!(w.as_vec3().as_dvec3(), w);
        }
    }
}
