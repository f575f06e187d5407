//! Numbers, vectors and colours of f64 as constants of the printed code.

use glam::{DVec2, DVec3};

use crate::language::{Language, Type};

/// What constants are printed in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms(pub(super) Language);

impl Terms {
    /// # Domain
    /// What an f32 can be.
    pub(super) fn number(self, value: f64) -> String {
        self.0.number(nearest(value))
    }

    pub(super) fn pair(self, value: DVec2) -> String {
        self.vector(Type::Vec2, &value.to_array())
    }

    pub(super) fn color(self, value: DVec3) -> String {
        self.vector(Type::Vec3, &value.to_array())
    }

    fn vector(self, of: Type, values: &[f64]) -> String {
        let name = self.0.type_name(of);
        let numbers: Vec<String> = values.iter().map(|value| self.number(*value)).collect();
        match numbers.iter().all(|number| *number == numbers[0]) {
            true => format!("{name}({})", numbers[0]),
            false => format!("{name}({})", numbers.join(", ")),
        }
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
    fn colours_that_are_grey_are_written_once() {
        let terms = Terms(Language::Glsl);
        assert_eq!(terms.color(DVec3::splat(0.1)), "vec3(0.1)");
        assert_eq!(terms.color(DVec3::new(1.0, 0.71, 0.29)), "vec3(1.0, 0.71, 0.29)");
        assert_eq!(Terms(Language::Wgsl).pair(DVec2::new(5.0, -2.0)), "vec2f(5.0, (-2.0))");
    }
}
