//! Modules of painted materials: `styled`, the colour of a point in a number of lights.
//!
//! The scalar code is printed like that of BRDFs. What it reads is in two structures; helpers fill
//! them in a fragment shader.

use std::fmt::Write;

use brood_brdf::{Input, InputMask, Lighting};
use brood_program::Program;

use crate::format::Format;
use crate::language::Language;
use crate::module;
use crate::source::let_line;
use crate::{body, input};

/// Structures and helpers.
const HELPERS: &str = include_str!("style.wgsl");
/// Mark above the helpers.
const MARK: &str = "// @style\n";

/// Structures that `styled` takes.
const STRUCTURES: &str = "\
// A point, as styles read it. facing: n . e, the cosine to the eye, not negative; depth: 0 one
// radius in front of the object's centre, 1 one radius behind it; facing_step, depth_step: lengths
// of their gradients over a pixel, at most 1, or 0 for edges with stairs; eye: direction to the eye
// along tangent, n cross tangent and normal; uv: texture coordinates.
struct StyledPoint {
  facing: f32,
  depth: f32,
  facing_step: f32,
  depth_step: f32,
  eye: vec3f,
  uv: vec2f,
}

// A light at a point, as styles read it. cosine: n . l; mirror: r . l, where r is the direction to
// the eye mirrored at n; visibility: 1 where nothing occludes the light, 0 in its shadow; color:
// irradiance over the largest channel of all lights; cosine_step, mirror_step: lengths of their
// gradients over a pixel; direction: to the light, in the frame of eye.
struct StyledLight {
  cosine: f32,
  mirror: f32,
  visibility: f32,
  color: vec3f,
  cosine_step: f32,
  mirror_step: f32,
  direction: vec3f,
}

";

/// Prints the module of a style.
///
/// # Panics
/// If the program is not painted, or `lights` is not 1 to [`Input::LIGHTS`].
pub(crate) fn module(
    style: &Program,
    (format, language): (Format, Language),
    (uv, lights): (f32, usize),
) -> String {
    assert!((1..=Input::LIGHTS).contains(&lights), "styles are printed for 1 to 8 lights");
    // Users pass visibility 1 where there are no shadows.
    let program = style.painted(Lighting { lights, has_shadows: true });
    assert!(program.is_color(), "only painted programs have colours");
    let inputs = program.inputs();
    let (_, helpers) = HELPERS.split_once(MARK).expect("the helpers have a mark");
    let text =
        [STRUCTURES, helpers, &styled_program(&program, uv), &styled(inputs, lights)].concat();
    module::assembled(&head(style, &program, format, (uv, lights)), &text, language)
}

fn styled_program(program: &Program, uv: f32) -> String {
    let parameters: Vec<String> =
        program.inputs().iter().map(|input| format!("{}: f32", input::name(input))).collect();
    let (parameters, lines) = (parameters.join(", "), body::lines(program, uv));
    "// Colour as a function of the inputs that the style reads.\n".to_owned()
        + &format!("fn styled_program({parameters}) -> vec3f {{\n{lines}}}\n\n")
}

fn styled(inputs: InputMask, lights: usize) -> String {
    let mut text = format!(
        "// Red, green and blue of a point as a display shows them (sRGB), each 0 to 1.\n\
         fn styled(at: StyledPoint, lights: array<StyledLight,{lights}>) -> vec3f {{\n"
    );
    if reads_directions(inputs) {
        text += &let_line("vec3f", "wi", "lights[0].direction");
        text += &let_line("vec3f", "wo", "at.eye");
        text += &let_line("vec3f", "x", "vec3f(1.0, 0.0, 0.0)");
        text += &let_line("vec3f", "y", "vec3f(0.0, 1.0, 0.0)");
        text += &let_line("vec3f", "n", "vec3f(0.0, 0.0, 1.0)");
        text += &let_line("vec2f", "uv", "at.uv");
    }
    text += &input::lines(inputs);
    let arguments: Vec<String> = inputs.iter().map(input::name).collect();
    writeln!(text, "  return styled_program({});\n}}", arguments.join(", "))
        .expect("a string takes everything");
    text
}

fn reads_directions(inputs: InputMask) -> bool {
    inputs.iter().any(input::is_of_directions)
}

fn head(style: &Program, program: &Program, format: Format, (uv, lights): (f32, usize)) -> String {
    let unread = match reads_directions(program.inputs()) {
        true => "",
        false => "// Reads neither tangents nor texture coordinates: pass any.\n",
    };
    let numbered = if lights == 1 { "1 light".to_owned() } else { format!("{lights} lights") };
    format!(
        "// A painted material bred by brood, in {numbered}: colours of a display, not a BRDF.\n\
         // styled_point and styled_light are for fragment shaders; others fill the structures.\n\
         {unread}// Style {}, {} operations. {}.\n{}",
        style.hash(),
        program.operations(),
        format.label(),
        module::preamble(format, uv),
    )
}

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;
    use crate::{Within, print};

    fn printed(text: &str, format: Format, lights: usize) -> String {
        let style = Program::lower(&text.parse::<Genome>().unwrap());
        print(&style, format, Within { lights, ..Within::default() }).unwrap()
    }

    const TOON: &str = "brood 1\n.effect light\n.effect silhouette\n.effect highlight\n";
    const BRUSHED: &str = "brood 1\n.dialect paper smooth registers 7\nMUL R0, R3, R1\n\
                           .effect light\nbrush 1\n";

    #[test]
    fn lights_are_an_array_and_gradients_are_derivatives() {
        let text = printed(TOON, Format::GlslEs300, 2);
        for part in [
            "vec3 styled(StyledPoint at, StyledLight[2] lights) {",
            "float cosine_1 = lights[1].cosine;",
            "float level_0 = max(max(lights[0].color.x, lights[0].color.y), lights[0].color.z);",
            "return min(length(vec2(dFdx(value), dFdy(value))), 1.0);",
            "// Reads neither tangents nor texture coordinates",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(!text.contains("lights[2]") && !text.contains(" wi ="), "{text}");
        let text = printed(TOON, Format::Wgsl, 1);
        assert!(
            text.contains("fn styled(at: StyledPoint, lights: array<StyledLight,1>) -> vec3f {")
        );
        assert!(text.contains("length(vec2f(dpdx(value), dpdy(value)))"), "{text}");
    }

    #[test]
    fn programs_of_styles_read_the_directions_of_the_first_light() {
        let text = printed(BRUSHED, Format::Glsl410, 3);
        assert!(text.contains("vec3 wi = lights[0].direction;"), "{text}");
        assert!(!text.contains("Reads neither"), "{text}");
    }

    #[test]
    fn numbers_of_lights_are_checked() {
        let style = Program::lower(&TOON.parse::<Genome>().unwrap());
        for lights in [0, 9] {
            let within = Within { lights, ..Within::default() };
            let error = print(&style, Format::Wgsl, within).unwrap_err();
            assert_eq!(error.to_string(), format!("lights must be 1 to 8, got {lights}"));
        }
    }
}
