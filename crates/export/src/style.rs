//! Modules of painted materials: `styled`, the colour of a point in a number of lights.
//!
//! The scalar code is printed like that of BRDFs. What it reads is in two structures; helpers fill
//! them in a fragment shader. What rays see in a clear body is in a third, which renderers fill.

use std::fmt::Write;

use brood_brdf::{Input, InputMask, Lighting};
use brood_genome::Effect;
use brood_program::Program;

use crate::format::Format;
use crate::module;
use crate::source::let_line;
use crate::{body, input};

/// Structures and helpers.
const HELPERS: &str = include_str!("style.wgsl");
/// Mark above the helpers.
const MARK: &str = "// @style\n";
/// Reason why writing does not fail.
const STRING: &str = "a string takes everything";

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

/// Structure that `styled` also takes if the style has glass.
const GLASS: &str = "\
// What rays see in a clear body, as styles read it: colours as a display shows them (sRGB), each 0
// to 1, and lengths inside the body in radii of the object. mirrored: along the eye ray that the
// surface mirrors, with length 0 unless it meets the body again and passes; way_0, way_1: along the
// first two ways by which the refracted eye ray leaves the body; way_0_share: share of way_0 in the
// light of both, 1 unless there are two. A ray that ends at the body sees styled_body. A way that
// sees nothing has colour 0 and length 65504. If nothing enters the body, way_0 equals mirrored.
struct StyledGlass {
  mirrored: vec3f,
  mirrored_length: f32,
  way_0: vec3f,
  way_0_length: f32,
  way_1: vec3f,
  way_1_length: f32,
  way_0_share: f32,
}

";

/// Prints the module of a style.
///
/// # Panics
/// If the program is not painted, the format is not a shading language, or `lights` is not 1 to
/// [`Input::LIGHTS`].
pub(crate) fn module(style: &Program, format: Format, (uv, lights): (f32, usize)) -> String {
    assert!((1..=Input::LIGHTS).contains(&lights), "styles are printed for 1 to 8 lights");
    // Users pass visibility 1 where there are no shadows.
    let lighting = Lighting { lights, has_shadows: true };
    let program = style.painted(lighting);
    assert!(program.is_color(), "only painted programs have colours");
    let (_, helpers) = HELPERS.split_once(MARK).expect("the helpers have a mark");
    let text = |function: Function, program: &Program| function.text(program, (uv, lights));
    let text = match style.glass() {
        None => [STRUCTURES, helpers, &text(Function::OPAQUE, &program)].concat(),
        Some(_) => {
            let body = text(Function::BODY, &style.without_glass().painted(lighting));
            [STRUCTURES, GLASS, helpers, &body, "\n", &text(Function::CLEAR, &program)].concat()
        }
    };
    let language = format.language().expect("styles are printed in shading languages");
    module::assembled(&head(style, &program, format, (uv, lights)), &text, language)
}

/// Function of a style, and that of the inputs which it reads.
struct Function {
    name: &'static str,
    about: &'static str,
    of_inputs: &'static str,
    /// Parameter after those of point and lights.
    glass: &'static str,
}

impl Function {
    const OPAQUE: Self = Self {
        name: "styled",
        about: "// Red, green and blue of a point as a display shows them (sRGB), each 0 to 1.\n",
        of_inputs: "// Colour as a function of the inputs that the style reads.\n",
        glass: "",
    };
    const CLEAR: Self = Self { glass: ", glass: StyledGlass", ..Self::OPAQUE };
    const BODY: Self = Self {
        name: "styled_body",
        about: "// As styled, for the body without its glass: what rays see that end at the body.\n",
        of_inputs: "// Colour of the body without its glass as a function of the inputs that it reads.\n",
        glass: "",
    };

    fn text(&self, program: &Program, (uv, lights): (f32, usize)) -> String {
        let Self { name, about, of_inputs, glass } = self;
        let inputs = program.inputs();
        let names: Vec<String> = inputs.iter().map(input::name).collect();
        let parameters: Vec<String> = names.iter().map(|name| format!("{name}: f32")).collect();
        let (parameters, lines) = (parameters.join(", "), body::lines(program, uv));
        let mut text =
            format!("{of_inputs}fn {name}_program({parameters}) -> vec3f {{\n{lines}}}\n\n");
        text += about;
        let of_lights = format!("lights: array<StyledLight,{lights}>");
        writeln!(text, "fn {name}(at: StyledPoint, {of_lights}{glass}) -> vec3f {{").expect(STRING);
        if reads_directions(inputs) {
            text += &let_line("vec3f", "wi", "lights[0].direction");
            text += &let_line("vec3f", "wo", "at.eye");
            text += &let_line("vec3f", "x", "vec3f(1.0, 0.0, 0.0)");
            text += &let_line("vec3f", "y", "vec3f(0.0, 1.0, 0.0)");
            text += &let_line("vec3f", "n", "vec3f(0.0, 0.0, 1.0)");
            text += &let_line("vec2f", "uv", "at.uv");
        }
        text += &input::lines(inputs);
        writeln!(text, "  return {name}_program({});\n}}", names.join(", ")).expect(STRING);
        text
    }
}

fn reads_directions(inputs: InputMask) -> bool {
    inputs.iter().any(input::is_of_directions)
}

fn head(style: &Program, program: &Program, format: Format, (uv, lights): (f32, usize)) -> String {
    let unread = match reads_directions(program.inputs()) {
        true => "",
        false => "// Reads neither tangents nor texture coordinates: pass any.\n",
    };
    let glass = style.glass();
    let rays = glass.map_or_else(String::new, |_| rays(program));
    let constants = glass.map_or_else(String::new, |glass| constants(style, glass, format));
    let numbered = if lights == 1 { "1 light".to_owned() } else { format!("{lights} lights") };
    format!(
        "// A painted material bred by brood, in {numbered}: colours of a display, not a BRDF.\n\
         // styled_point and styled_light are for fragment shaders; others fill the structures.\n\
         {unread}{rays}// Style {}, {} operations. {}.\n{}{constants}",
        style.hash(),
        program.operations(),
        format.label(),
        module::preamble(format, uv),
    )
}

/// Constants that renderers trace the rays and shadows of a clear body with.
fn constants(style: &Program, glass: &Effect, format: Format) -> String {
    let index = glass.index_of_refraction().expect("glass has an index of refraction");
    let language = format.language().expect("styles are printed in shading languages");
    let declared =
        |name: &str, value: f64| language.translate(&format!("const {name}: f32 = {value:?};\n"));
    [
        "// Index of refraction of the body, relative to its surroundings.\n",
        &declared("STYLED_INDEX", index),
        "// Share of light that passes through the body into its shadow.\n",
        &declared("STYLED_PASSED", style.clearness()),
        "\n",
    ]
    .concat()
}

/// Lines on the rays of a clear body.
fn rays(program: &Program) -> String {
    let mut text = "// A clear body. The renderer traces its rays: see StyledGlass.\n".to_owned();
    if !program.reads_mirrored() {
        text += "// Reads nothing of mirrored rays: pass any.\n";
    }
    if !program.reads_ways() {
        text += "// Reads nothing of the ways out of the body: pass any.\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;
    use crate::{Within, conformance, export_material};

    fn printed(text: &str, format: Format, lights: usize) -> String {
        let style = Program::lower(&text.parse::<Genome>().unwrap());
        let within = Within { lights, ..Within::default() };
        export_material(&style, format, within).unwrap().into_text()
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

    const GLASS: &str = "brood 1\n.effect light\n.effect glass\nindex 1.33\n.effect highlight\n";

    #[test]
    fn clear_bodies_take_what_rays_see_and_have_a_body_without_glass() {
        let text = printed(GLASS, Format::GlslEs300, 2);
        let parts = [
            "const float STYLED_INDEX = 1.33;\n",
            "const float STYLED_PASSED = 1.0;\n",
            "  vec3 way_1;\n  float way_1_length;\n  float way_0_share;\n};",
            "vec3 styled_body_program(float cosine_0",
            "vec3 styled_body(StyledPoint at, StyledLight[2] lights) {",
            "vec3 styled_program(float facing",
            "vec3 styled(StyledPoint at, StyledLight[2] lights, StyledGlass glass) {",
            "float mirrored_red = glass.mirrored.x;",
            "float way_0_length = clamp(glass.way_0_length, -BROOD_RANGE, BROOD_RANGE);",
        ];
        let places = parts.map(|part| text.find(part).unwrap_or_else(|| panic!("{part}\n{text}")));
        assert!(places.is_sorted(), "{places:?}\n{text}");
        let body = &text[places[3]..places[5]];
        assert!(!body.contains("glass.") && !body.contains("way_"), "{body}");
        let without = printed(&GLASS.replace("index", "strength 0\nindex"), Format::GlslEs300, 2);
        assert!(!without.contains("Glass") && !without.contains("styled_body"), "{without}");
    }

    #[test]
    fn heads_of_clear_bodies_list_the_rays_that_are_not_read() {
        let lines = ["nothing of mirrored rays", "nothing of the ways out"];
        for (parameter, unread) in [("mirror 0", [true, false]), ("see 0", [false, true])] {
            let text = printed(&GLASS.replace("index 1.33", parameter), Format::Wgsl, 1);
            assert_eq!(lines.map(|line| text.contains(line)), unread, "{parameter}\n{text}");
        }
    }

    #[test]
    fn heads_of_clear_bodies_hold_for_their_body_too() {
        let lighting = Lighting { lights: 2, has_shadows: true };
        for style in conformance::styles() {
            let (inputs, body) = (style.painted(lighting).inputs(), style.without_glass());
            assert!(body.painted(lighting).inputs().iter().all(|input| inputs.contains(input)));
        }
    }

    #[test]
    fn clear_bodies_are_refused_by_the_reason_of_the_format() {
        let style = Program::lower(&GLASS.parse::<Genome>().unwrap());
        let error = export_material(&style, Format::Mtoon, Within::default()).unwrap_err();
        assert_eq!(error.to_string(), "VRM's toon material has no clear bodies");
    }

    #[test]
    fn numbers_of_lights_are_checked() {
        let style = Program::lower(&TOON.parse::<Genome>().unwrap());
        for lights in [0, 9] {
            let within = Within { lights, ..Within::default() };
            let error = export_material(&style, Format::Wgsl, within).unwrap_err();
            assert_eq!(error.to_string(), format!("lights must be 1 to 8, got {lights}"));
        }
    }
}
