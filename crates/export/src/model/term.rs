//! Literals of numbers, vectors and colours for printed code.

use glam::{DVec2, DVec3};

use crate::language::{Language, Type};

/// Printer of literals in a language.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms(pub(super) Language);

impl Terms {
    /// # Domain
    /// Values within the range of f32.
    pub(super) fn number(self, value: f64) -> String {
        self.0.number(nearest(value))
    }

    pub(super) fn pair(self, value: DVec2) -> String {
        self.vector(Type::Vec2, &value.to_array())
    }

    pub(super) fn color(self, value: DVec3) -> String {
        self.vector(Type::Vec3, &value.to_array())
    }

    /// Constructor of a vector; equal components are written once.
    fn vector(self, of: Type, values: &[f64]) -> String {
        let name = self.0.type_name(of);
        let literals: Vec<String> = values.iter().map(|value| self.number(*value)).collect();
        match literals.iter().all(|number| *number == literals[0]) {
            true => format!("{name}({})", literals[0]),
            false => format!("{name}({})", literals.join(", ")),
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
    fn grey_colours_are_written_once() {
        let terms = Terms(Language::Glsl);
        assert_eq!(terms.color(DVec3::splat(0.1)), "vec3(0.1)");
        assert_eq!(terms.color(DVec3::new(1.0, 0.71, 0.29)), "vec3(1.0, 0.71, 0.29)");
        assert_eq!(Terms(Language::Wgsl).pair(DVec2::new(5.0, -2.0)), "vec2f(5.0, (-2.0))");
    }
}
