//! Inputs of a program from world directions, in f32: twins of `brood_brdf::Input::evaluate` with
//! the same operations, so that swapping the directions changes no bit here either. Inputs of a
//! point, its lights and clear bodies are fields of structures.

use brood_brdf::{Input, InputMask, LightInput};
use brood_genome::RANGE;

use crate::source::let_line;

/// Common subexpressions of the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    CosI,
    CosO,
    TangentI,
    TangentO,
    P2,
    SmoothP4,
    PaperI,
    PaperO,
    PaperP4,
    Sum,
    SinSquaredHalf,
    HalfDotLight,
}

impl Part {
    /// All parts; each uses only earlier ones.
    const ALL: [Self; 12] = [
        Self::CosI,
        Self::CosO,
        Self::TangentI,
        Self::TangentO,
        Self::P2,
        Self::SmoothP4,
        Self::PaperI,
        Self::PaperO,
        Self::PaperP4,
        Self::Sum,
        Self::SinSquaredHalf,
        Self::HalfDotLight,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::CosI => "cos_i",
            Self::CosO => "cos_o",
            Self::TangentI => "l",
            Self::TangentO => "v",
            Self::P2 => "p2",
            Self::SmoothP4 => "p4",
            Self::PaperI => "l_unit",
            Self::PaperO => "v_unit",
            Self::PaperP4 => "p4_unit",
            Self::Sum => "s",
            Self::SinSquaredHalf => "sin2_h",
            Self::HalfDotLight => "h_dot_wi",
        }
    }

    /// Type, expression, and the parts that the expression uses. 9.1e-13 is 2^-40, which avoids
    /// division by 0 at poles.
    fn definition(self) -> (&'static str, &'static str, &'static [Self]) {
        match self {
            Self::CosI => ("f32", "dot(wi, n)", &[]),
            Self::CosO => ("f32", "dot(wo, n)", &[]),
            Self::TangentI => ("vec2f", "vec2f(dot(wi, x), dot(wi, y))", &[]),
            Self::TangentO => ("vec2f", "vec2f(dot(wo, x), dot(wo, y))", &[]),
            Self::P2 => ("f32", "cos_o - cos_i", &[Self::CosI, Self::CosO]),
            Self::SmoothP4 => ("f32", "v.y * l.x - v.x * l.y", &[Self::TangentI, Self::TangentO]),
            Self::PaperI => ("vec2f", "l / sqrt(max(dot(l, l), 9.094947e-13))", &[Self::TangentI]),
            Self::PaperO => ("vec2f", "v / sqrt(max(dot(v, v), 9.094947e-13))", &[Self::TangentO]),
            Self::PaperP4 => {
                ("f32", "v_unit.y * l_unit.x - v_unit.x * l_unit.y", &[Self::PaperI, Self::PaperO])
            }
            Self::Sum => (
                "vec3f",
                "vec3f(l + v, cos_i + cos_o)",
                &[Self::CosI, Self::CosO, Self::TangentI, Self::TangentO],
            ),
            Self::SinSquaredHalf => {
                ("f32", "dot(s.xy, s.xy) / max(dot(s, s), 9.094947e-13)", &[Self::Sum])
            }
            // Half the length of the sum of both: 1 + dot(wi, wo) would cancel where they are
            // nearly opposite.
            Self::HalfDotLight => ("f32", "clamp(0.5 * sqrt(dot(s, s)), 0.0, 1.0)", &[Self::Sum]),
        }
    }
}

/// Reason why other inputs do not occur.
const OF_LIGHTS: &str = "inputs of lights are treated before";

/// Name of an input in printed code.
pub(crate) fn name(input: Input) -> String {
    if let Some((light, quantity)) = input.light() {
        return format!("{}_{light}", name_of_light_input(quantity));
    }
    let name = match input {
        Input::P1 => "p1",
        Input::U => "tex_u",
        Input::V => "tex_v",
        Input::SmoothP3 => "p3",
        Input::SmoothP5 => "p5",
        Input::SmoothP6 => "p6",
        Input::SmoothQ1 => "q1",
        Input::SmoothQ2 => "q2",
        Input::PaperP3 => "p3_unit",
        Input::PaperP5 => "p5_unit",
        Input::PaperP6 => "p6_unit",
        Input::PaperQ1 => "q1_unit",
        Input::PaperQ2 => "q2_unit",
        Input::LogTanHalf => "ln_tan_h",
        Input::HalfDotLight => "half_dot_light",
        Input::CosineDifference => "cosine_difference",
        Input::MirrorAsymmetry => "mirror_asymmetry",
        Input::CosineProduct => "cosine_product",
        Input::LogHalfDotLight => "ln_half_dot_light",
        Input::LogHalfAngle => "ln_half_angle",
        Input::LogCosineProduct => "ln_cosine_product",
        Input::LogCosineSum => "ln_cosine_sum",
        Input::NormalDotHalf => "normal_dot_half",
        Input::NormalDotEye => "facing",
        Input::Depth => "depth",
        Input::NormalDotEyeStep => "facing_step",
        Input::DepthStep => "depth_step",
        Input::P2 => "p2_first",
        Input::SmoothP4 => "p4_first",
        Input::MirroredRed => "mirrored_red",
        Input::MirroredGreen => "mirrored_green",
        Input::MirroredBlue => "mirrored_blue",
        Input::MirroredLength => "mirrored_length",
        Input::Way0Red => "way_0_red",
        Input::Way0Green => "way_0_green",
        Input::Way0Blue => "way_0_blue",
        Input::Way0Length => "way_0_length",
        Input::Way0Share => "way_0_share",
        Input::Way1Red => "way_1_red",
        Input::Way1Green => "way_1_green",
        Input::Way1Blue => "way_1_blue",
        Input::Way1Length => "way_1_length",
        Input::ReflectedLevel => "reflected_level",
        Input::ReflectedRed => "reflected_red",
        Input::ReflectedGreen => "reflected_green",
        Input::ReflectedBlue => "reflected_blue",
        Input::ReflectedStep => "reflected_step",
        Input::Image0Red => "image_0_red",
        Input::Image0Green => "image_0_green",
        Input::Image0Blue => "image_0_blue",
        Input::Image0Opacity => "image_0_opacity",
        Input::Image1Red => "image_1_red",
        Input::Image1Green => "image_1_green",
        Input::Image1Blue => "image_1_blue",
        Input::Image1Opacity => "image_1_opacity",
        Input::Image2Red => "image_2_red",
        Input::Image2Green => "image_2_green",
        Input::Image2Blue => "image_2_blue",
        Input::Image2Opacity => "image_2_opacity",
        Input::Image3Red => "image_3_red",
        Input::Image3Green => "image_3_green",
        Input::Image3Blue => "image_3_blue",
        Input::Image3Opacity => "image_3_opacity",
        _ => unreachable!("{OF_LIGHTS}"),
    };
    name.to_owned()
}

fn name_of_light_input(quantity: LightInput) -> &'static str {
    match quantity {
        LightInput::Cos => "cosine",
        LightInput::Mirror => "mirror",
        LightInput::Visibility => "visibility",
        LightInput::Level => "level",
        LightInput::Red => "red",
        LightInput::Green => "green",
        LightInput::Blue => "blue",
        LightInput::CosStep => "cosine_step",
        LightInput::MirrorStep => "mirror_step",
    }
}

/// Expression of an input of directions, and the parts that it uses. 9.5e-7 is 2^-20, the lower
/// bound of arguments of logarithms.
///
/// # Panics
/// For inputs of [`field`].
fn definition(input: Input) -> (&'static str, &'static [Part]) {
    use Part::{
        CosI, CosO, HalfDotLight, P2, PaperI, PaperO, PaperP4, SinSquaredHalf, SmoothP4, Sum,
        TangentI, TangentO,
    };
    match input {
        Input::P1 => ("cos_o + cos_i", &[CosI, CosO]),
        Input::U => ("clamp(uv.x, -BROOD_RANGE, BROOD_RANGE)", &[]),
        Input::V => ("clamp(uv.y, -BROOD_RANGE, BROOD_RANGE)", &[]),
        Input::SmoothP3 => ("v.x * l.x + v.y * l.y", &[TangentI, TangentO]),
        Input::SmoothP5 => ("v.x * l.x - v.y * l.y", &[TangentI, TangentO]),
        Input::SmoothP6 => ("v.x * l.y + v.y * l.x", &[TangentI, TangentO]),
        Input::SmoothQ1 => ("p2 * p2 - p4 * p4", &[P2, SmoothP4]),
        Input::SmoothQ2 => ("2.0 * (p2 * p4)", &[P2, SmoothP4]),
        Input::PaperP3 => ("v_unit.x * l_unit.x + v_unit.y * l_unit.y", &[PaperI, PaperO]),
        Input::PaperP5 => ("v_unit.x * l_unit.x - v_unit.y * l_unit.y", &[PaperI, PaperO]),
        Input::PaperP6 => ("v_unit.x * l_unit.y + v_unit.y * l_unit.x", &[PaperI, PaperO]),
        Input::PaperQ1 => ("p2 * p2 - p4_unit * p4_unit", &[P2, PaperP4]),
        Input::PaperQ2 => ("2.0 * (p2 * p4_unit)", &[P2, PaperP4]),
        Input::LogTanHalf => {
            ("0.5 * log(dot(s.xy, s.xy) / max(s.z * s.z, 9.094947e-13) + 1e-7)", &[Sum])
        }
        Input::HalfDotLight => ("h_dot_wi", &[HalfDotLight]),
        Input::CosineDifference => ("p2 * p2 / (4.0 * sin2_h + 1e-3)", &[P2, SinSquaredHalf]),
        Input::MirrorAsymmetry => {
            ("2.0 * (p2 * p4) / (sin2_h + 1e-3)", &[P2, SmoothP4, SinSquaredHalf])
        }
        Input::CosineProduct => ("cos_i * cos_o", &[CosI, CosO]),
        Input::LogHalfDotLight => ("log(max(h_dot_wi, 9.536743e-7))", &[HalfDotLight]),
        Input::LogHalfAngle => ("0.5 * log(max(1.0 - h_dot_wi, 0.0) + 0.002)", &[HalfDotLight]),
        Input::LogCosineProduct => ("log(max(cos_i * cos_o, 9.536743e-7))", &[CosI, CosO]),
        Input::LogCosineSum => ("log(max(cos_i + cos_o, 9.536743e-7))", &[CosI, CosO]),
        Input::NormalDotHalf => ("s.z / sqrt(max(dot(s, s), 9.094947e-13))", &[Sum]),
        Input::P2 => ("p2", &[P2]),
        Input::SmoothP4 => ("p4", &[SmoothP4]),
        _ => unreachable!("fields are not computed"),
    }
}

/// Expression of an input of a point `at`, of one of its `lights` or of its `glass`; `None` for one
/// of directions.
fn field(input: Input) -> Option<String> {
    if let Some((light, quantity)) = input.light() {
        let color = |channel: &str| format!("lights[{light}].color.{channel}");
        return Some(match quantity {
            LightInput::Level => {
                format!("max(max({}, {}), {})", color("x"), color("y"), color("z"))
            }
            LightInput::Red => color("x"),
            LightInput::Green => color("y"),
            LightInput::Blue => color("z"),
            _ => format!("lights[{light}].{}", name_of_light_input(quantity)),
        });
    }
    match input {
        Input::NormalDotEye | Input::NormalDotEyeStep | Input::DepthStep => {
            Some(format!("at.{}", name(input)))
        }
        Input::Depth => Some(within_range("at.depth")),
        Input::MirroredRed => Some("glass.mirrored.x".to_owned()),
        Input::MirroredGreen => Some("glass.mirrored.y".to_owned()),
        Input::MirroredBlue => Some("glass.mirrored.z".to_owned()),
        Input::Way0Red => Some("glass.way_0.x".to_owned()),
        Input::Way0Green => Some("glass.way_0.y".to_owned()),
        Input::Way0Blue => Some("glass.way_0.z".to_owned()),
        Input::Way1Red => Some("glass.way_1.x".to_owned()),
        Input::Way1Green => Some("glass.way_1.y".to_owned()),
        Input::Way1Blue => Some("glass.way_1.z".to_owned()),
        Input::Way0Share => Some(format!("glass.{}", name(input))),
        Input::MirroredLength | Input::Way0Length | Input::Way1Length => {
            Some(within_range(&format!("glass.{}", name(input))))
        }
        _ => None,
    }
}

/// Expression of a field whose values may be beyond the range of the machine.
fn within_range(field: &str) -> String {
    format!("clamp({field}, -BROOD_RANGE, BROOD_RANGE)")
}

/// True if an input is one of directions or texture coordinates, not a field of a structure.
pub(crate) fn is_of_directions(input: Input) -> bool {
    field(input).is_none()
}

/// Lines that compute these inputs from `wi`, `wo`, `n`, `x`, `y` and `uv`, or read them from the
/// point `at`, its `lights` and its `glass`.
pub(crate) fn lines(inputs: InputMask) -> String {
    let of_directions = || inputs.iter().filter(|input| is_of_directions(*input));
    let mut needed: Vec<Part> =
        of_directions().flat_map(|input| definition(input).1).copied().collect();
    // Adds the parts that the needed parts use, until nothing new is found.
    let mut seen = 0;
    while seen < needed.len() {
        needed.extend(needed[seen].definition().2);
        seen += 1;
    }
    let mut text = String::new();
    for part in Part::ALL.into_iter().filter(|part| needed.contains(part)) {
        let (of, expression, _) = part.definition();
        text += &let_line(of, part.name(), expression);
    }
    for input in inputs.iter() {
        let value = field(input).unwrap_or_else(|| definition(input).0.to_owned());
        text += &let_line("f32", &name(input), &value);
    }
    text
}

/// Bound of the magnitude of an input: 1.5 times its largest value, for f32 rounding and directions
/// that are not exactly unit, or the bound that it is clamped to. `uv` is the bound of texture
/// coordinates.
pub(crate) fn bound(input: Input, uv: f32) -> f32 {
    if input.light().is_some() {
        return 1.6;
    }
    match input {
        Input::Depth | Input::MirroredLength | Input::Way0Length | Input::Way1Length => RANGE,
        _ if Input::of_glass().any(|glass| glass == input) || input.is_of_image() => 1.6,
        Input::NormalDotEye | Input::NormalDotEyeStep | Input::DepthStep => 1.6,
        Input::ReflectedLevel | Input::ReflectedStep => 1.6,
        Input::ReflectedRed | Input::ReflectedGreen | Input::ReflectedBlue => 1.6,
        Input::P2 => 3.2,
        Input::SmoothP4 => 1.6,
        Input::U | Input::V => uv.min(RANGE),
        Input::SmoothP3 | Input::SmoothP5 | Input::SmoothP6 => 1.6,
        Input::PaperP3 | Input::PaperP5 | Input::PaperP6 => 1.6,
        Input::HalfDotLight | Input::CosineProduct | Input::NormalDotHalf => 1.6,
        // Holds for any two directions, also below the surface: p2 is at most 2, p4 at most 1.
        Input::P1 => 3.2,
        Input::SmoothQ1 | Input::SmoothQ2 | Input::PaperQ1 | Input::PaperQ2 => 6.4,
        // Logarithms of values between 2^-40 and 4e12.
        Input::LogTanHalf | Input::LogHalfDotLight | Input::LogHalfAngle => 40.0,
        Input::LogCosineProduct | Input::LogCosineSum => 40.0,
        // At most 4 / 1e-3.
        Input::CosineDifference | Input::MirrorAsymmetry => 8192.0,
        _ => unreachable!("{OF_LIGHTS}"),
    }
}

#[cfg(test)]
mod tests {
    use brood_brdf::DirectionPair;
    use glam::{DVec2, DVec3};

    use super::*;

    #[test]
    fn parts_use_only_earlier_parts_and_names_are_unique() {
        for (place, part) in Part::ALL.into_iter().enumerate() {
            assert!(part.definition().2.iter().all(|used| Part::ALL[..place].contains(used)));
        }
        let mut names: Vec<String> = Input::ALL.into_iter().map(name).collect();
        names.extend(Part::ALL.map(Part::name).map(str::to_owned));
        let others = ["wi", "wo", "n", "x", "y", "uv", "models", "at", "lights", "glass"];
        names.extend(others.map(str::to_owned));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{names:?}");
    }

    #[test]
    fn inputs_stay_within_their_bounds_with_a_margin() {
        let angles = [0.0, 1e-9, 1e-4, 0.3, 1.0, 1.57, 2.0, std::f64::consts::PI];
        let direction = |theta: f64, phi: f64| {
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        for wi in angles {
            for wo in angles {
                for phi in angles {
                    let pair = DirectionPair::new(direction(wi, 0.0), direction(wo, phi)).unwrap();
                    for input in Input::ALL {
                        let value = input.evaluate(&pair, DVec2::new(0.25, 0.75));
                        let bound = f64::from(bound(input, 1.2));
                        let is_clamped = bound == f64::from(RANGE);
                        let is_within = 1.5 * value.abs() < bound;
                        assert!(is_within || is_clamped, "{input:?} is {value}");
                    }
                }
            }
        }
    }

    #[test]
    fn lengths_of_clear_bodies_are_clamped_to_their_bound() {
        for input in Input::of_glass() {
            let (is_length, field) = (name(input).ends_with("length"), field(input).unwrap());
            assert_eq!(field.starts_with("clamp(glass."), is_length, "{field}");
            assert_eq!(bound(input, 1.0) > 2.0, is_length, "{field}");
        }
    }

    #[test]
    fn only_inputs_that_are_read_are_computed() {
        let text = lines([Input::P1].into_iter().collect());
        let needed = "  let cos_i: f32 = dot(wi, n);\n  let cos_o: f32 = dot(wo, n);\n  let p1: f32 = cos_o + cos_i;\n";
        assert_eq!(text, needed);
        assert_eq!(lines(InputMask::EMPTY), "");
    }
}
