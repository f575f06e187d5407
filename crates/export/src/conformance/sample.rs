//! Pairs of directions that f32 holds, as near to unit length as it lets them be, so that lengths are hardly an error.

use std::f64::consts::TAU;

use brood_genome::{BirthKey, Operator, Stream};
use glam::DVec3;

/// Steps of the last place, in each direction, among which the one nearest to unit length is looked for.
const STEPS: i32 = 12;

/// So many pairs above the surface: among them equal ones, grazing ones, and mirrored ones as far off as highlights are wide.
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
            held(mirrored.normalize())
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
    held(DVec3::new(r * cos, r * sin, z))
}

/// The direction of f32 components near that one whose length is nearest to 1.
fn held(w: DVec3) -> DVec3 {
    let mut best = w.as_vec3();
    let (axis, other) = if w.z.abs() > 0.7 { (2, 0) } else { (0, 1) };
    let start = best;
    for a in -STEPS..=STEPS {
        for b in -STEPS..=STEPS {
            let mut near = start;
            near[axis] = moved(start[axis], a);
            near[other] = moved(start[other], b);
            if off(near.as_dvec3()) < off(best.as_dvec3()) {
                best = near;
            }
        }
    }
    best.as_dvec3()
}

fn moved(value: f32, steps: i32) -> f32 {
    if value.abs() < 1e-30 {
        value
    } else {
        f32::from_bits(value.to_bits().saturating_add_signed(steps))
    }
}

fn off(w: DVec3) -> f64 {
    (w.length_squared() - 1.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_above_the_surface_and_held_by_f32() {
        for w in pairs(500).into_iter().flatten() {
            // 2^-24: near the normal nothing but z is large enough to make up for its last place.
            assert!(off(w) < 5.97e-8 && w.z > 0.0, "{w}: {:e}", off(w));
            assert_eq!(w.as_vec3().as_dvec3(), w);
        }
    }
}
