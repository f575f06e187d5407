//! Differences between the languages: declarations, types, number literals.

/// Shading language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Language {
    Glsl,
    Wgsl,
}

/// Type of a value in printed code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Type {
    Scalar,
    Vec2,
    Vec3,
}

impl Language {
    pub(crate) fn type_name(self, of: Type) -> &'static str {
        match (self, of) {
            (Self::Glsl, Type::Scalar) => "float",
            (Self::Glsl, Type::Vec2) => "vec2",
            (Self::Glsl, Type::Vec3) => "vec3",
            (Self::Wgsl, Type::Scalar) => "f32",
            (Self::Wgsl, Type::Vec2) => "vec2f",
            (Self::Wgsl, Type::Vec3) => "vec3f",
        }
    }

    /// Declaration of a value.
    pub(crate) fn let_line(self, of: Type, name: &str, value: &str) -> String {
        match self {
            Self::Glsl => format!("  {} {name} = {value};\n", self.type_name(of)),
            Self::Wgsl => format!("  let {name} = {value};\n"),
        }
    }

    /// Declaration of a value with a structure type.
    pub(crate) fn let_line_of(self, structure: &str, name: &str, value: &str) -> String {
        match self {
            Self::Glsl => format!("  {structure} {name} = {value};\n"),
            Self::Wgsl => format!("  let {name} = {value};\n"),
        }
    }

    /// First line of a function with one structure parameter, including the brace.
    pub(crate) fn head_of(self, name: &str, structure: &str, parameter: &str) -> String {
        match self {
            Self::Glsl => format!("vec3 {name}({structure} {parameter}) {{\n"),
            Self::Wgsl => format!("fn {name}({parameter}: {structure}) -> vec3f {{\n"),
        }
    }

    /// First line of a function, including the brace.
    pub(crate) fn head(self, name: &str, parameters: &[(Type, &str)]) -> String {
        let parameter = |(of, name): &(Type, &str)| match self {
            Self::Glsl => format!("{} {name}", self.type_name(*of)),
            Self::Wgsl => format!("{name}: {}", self.type_name(*of)),
        };
        let parameters: Vec<String> = parameters.iter().map(parameter).collect();
        let parameters = parameters.join(", ");
        match self {
            Self::Glsl => format!("vec3 {name}({parameters}) {{\n"),
            Self::Wgsl => format!("fn {name}({parameters}) -> vec3f {{\n"),
        }
    }

    /// Declaration of a constant with shortest digits, which read back to the same bits.
    pub(crate) fn constant(self, name: &str, value: f32) -> String {
        match self {
            Self::Glsl => format!("const float {name} = {value:?};\n"),
            Self::Wgsl => format!("const {name}: f32 = {value:?};\n"),
        }
    }

    /// Declaration of a constant that is a bit pattern.
    pub(crate) fn bit_constant(self, name: &str, bits: u32) -> String {
        match self {
            Self::Glsl => format!("const uint {name} = {bits:#010x}u;\n"),
            Self::Wgsl => format!("const {name}: u32 = {bits:#010x}u;\n"),
        }
    }

    /// Literal that reads back to the same bits. Negative numbers are in parentheses, so that the
    /// literal can stand in any expression.
    ///
    /// # Domain
    /// Finite numbers. Subnormal numbers are given by their bits, because compilers may read them
    /// as 0.
    pub(crate) fn number(self, value: f32) -> String {
        if value.is_subnormal() {
            let bits = value.to_bits();
            return match self {
                Self::Glsl => format!("uintBitsToFloat({bits:#010x}u)"),
                Self::Wgsl => format!("bitcast<f32>({bits:#010x}u)"),
            };
        }
        // Shortest digits that read back; always with a point or an exponent.
        let digits = format!("{value:?}");
        match value.is_sign_negative() {
            true => format!("({digits})"),
            false => digits,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let values = [0.0, -0.0, 1.0, -0.1, 65504.0, 1.5e-7, f32::MIN_POSITIVE, 16_777_216.0, 0.1];
        for value in values {
            let text = Language::Glsl.number(value);
            let bare = text.trim_matches(['(', ')']);
            assert_eq!(bare.parse::<f32>().unwrap().to_bits(), f32::to_bits(value), "{text}");
            assert!(bare.contains(['.', 'e']), "{text} is no floating point number in GLSL");
        }
        assert_eq!(Language::Wgsl.number(f32::from_bits(1)), "bitcast<f32>(0x00000001u)");
    }
}
