//! Literals of numbers, vectors and colours for printed code.

use glam::{DVec2, DVec3};

use crate::source;

/// # Domain
/// Values within the range of f32.
pub(super) fn number(value: f64) -> String {
    source::number(nearest(value))
}

pub(super) fn pair(value: DVec2) -> String {
    vector("vec2f", &value.to_array())
}

pub(super) fn color(value: DVec3) -> String {
    vector("vec3f", &value.to_array())
}

/// Constructor of a vector; equal components are written once.
fn vector(of: &str, values: &[f64]) -> String {
    let literals: Vec<String> = values.iter().map(|value| number(*value)).collect();
    match literals.iter().all(|number| *number == literals[0]) {
        true => format!("{of}({})", literals[0]),
        false => format!("{of}({})", literals.join(", ")),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_colours_are_written_once() {
        assert_eq!(color(DVec3::splat(0.1)), "vec3f(0.1)");
        assert_eq!(color(DVec3::new(1.0, 0.71, 0.29)), "vec3f(1.0, 0.71, 0.29)");
        assert_eq!(pair(DVec2::new(5.0, -2.0)), "vec2f(5.0, (-2.0))");
    }
}
