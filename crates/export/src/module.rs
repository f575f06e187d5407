//! Complete modules: header comment, library functions, program and `evolved`.

use std::fmt::Write;

use brood_brdf::Input;
use brood_genome::RANGE;
use brood_program::{Bumps, Program};

use crate::format::Format;
use crate::language::Language;
use crate::model::Layers;
use crate::source::let_line;
use crate::{body, input, library};

/// Returns the source of a module with these functions:
///
/// - `evolved(wi, wo, n, x, y, uv)`: f in 1/sr, without the cosine of `wi`. Arguments are the
///   directions to the light and to the eye, normal, tangent along u, and n cross x, all unit and
///   in one space; and the texture coordinates.
/// - `evolved_program(...)`: f as a function of the inputs that the program reads, and of the
///   reflectance of its models if it has any.
/// - `evolved_models(wi, wo)`: reflectance of the models, for directions in the local frame; only
///   if there are models.
/// - `evolved_slopes(u, v)` and `evolved_flat(wi, wo, n, x, y, uv)`, f about the normal that bumps
///   turn; only if there are bumps. Then y must be the direction across x along which v grows.
///
/// # Error
/// `evolved_program` has the bits of the canonical evaluator if the compiler keeps to IEEE
/// rounding. `evolved` differs by the error of inputs and models in f32; the bounds for models are
/// in [`crate::conformance`].
///
/// # Panics
/// If the program is painted, which is not a BRDF, or the format is not a language: see
/// [`export_material`](crate::export_material).
#[must_use]
pub fn export(program: &Program, format: Format) -> String {
    export_within(program, format, RANGE)
}

/// As [`export`], for texture coordinates in [-`uv`, `uv`] with `uv` from 0 to 65504. Clamps that
/// cannot act in that range are left out, which removes most clamps of most programs.
///
/// # Panics
/// As [`export`].
#[must_use]
pub fn export_within(program: &Program, format: Format, uv: f32) -> String {
    let layers = Layers::of(program.layers());
    let language = format.language().expect("BRDFs are exported in a language");
    assembled(&head(program, &layers, format, uv), &functions(program, uv), language)
}

/// Functions of a BRDF in the source form, without those of the library.
pub(crate) fn functions(program: &Program, uv: f32) -> String {
    assert!(!program.is_painted(), "painted programs are not BRDFs and are not exported as such");
    let layers = Layers::of(program.layers());
    let mut text = String::new();
    if !layers.is_empty() {
        text += &layers.functions();
    }
    text += &evolved_program(program, uv);
    match program.bumps() {
        None => text += &evolved(program, ""),
        Some(bumps) => {
            text += &evolved(program, "_flat");
            text += &turned(bumps, uv);
        }
    }
    text
}

/// Puts the library functions that a text calls before it, and the constants before these.
pub(crate) fn assembled(head: &str, text: &str, language: Language) -> String {
    let (constants, functions) = with_library(text);
    [head, &language.translate(&constants), "\n", language.zero(), &language.translate(&functions)]
        .concat()
}

/// Constants that a text and the library functions that it calls name, and these functions with the
/// text.
pub(crate) fn with_library(text: &str) -> (String, String) {
    let functions = library::functions(text) + text;
    (library::constants(|name| functions.contains(name)), functions)
}

fn evolved_program(program: &Program, uv: f32) -> String {
    let has_models = !program.layers().is_empty();
    let mut parameters: Vec<String> =
        program.inputs().iter().map(|input| format!("{}: f32", input::name(input))).collect();
    let mut text = "// f as a function of the inputs that the program reads".to_owned();
    if has_models {
        parameters.push("models: vec3f".to_owned());
        text += ", and of the reflectance of the models";
    }
    let (parameters, lines) = (parameters.join(", "), body::lines(program, uv));
    text + &format!(".\nfn evolved_program({parameters}) -> vec3f {{\n{lines}}}\n\n")
}

/// Function `evolved`, or that about the normal which bumps turn if `suffix` is not empty.
fn evolved(program: &Program, suffix: &str) -> String {
    let mut text = "// f(wi, wo) in 1/sr, without the cosine of wi. wi: direction to the light; wo: direction\n\
             // to the eye (if it is below the surface, move it to a cosine of 1e-4); n: normal;\n\
             // x: tangent along u; y: n cross x; uv: texture coordinates. All directions must be\n\
             // unit and in one space.\n"
        .to_owned();
    text += &head_of_evolved(suffix);
    text += &input::lines(program.inputs());
    let mut arguments: Vec<String> = program.inputs().iter().map(input::name).collect();
    if !program.layers().is_empty() {
        let local = |w: &str| format!("vec3f(dot({w}, x), dot({w}, y), dot({w}, n))");
        let models = format!("evolved_models({}, {})", local("wi"), local("wo"));
        text += &let_line("vec3f", "models", &models);
        arguments.push("models".to_owned());
    }
    writeln!(text, "  return evolved_program({});\n}}", arguments.join(", "))
        .expect("a string takes everything");
    text
}

fn head_of_evolved(suffix: &str) -> String {
    format!(
        "fn evolved{suffix}(wi: vec3f, wo: vec3f, n: vec3f, x: vec3f, y: vec3f, uv: vec2f) -> vec3f {{\n"
    )
}

/// Function `evolved` of a material with bumps.
fn turned(bumps: &Bumps, uv: f32) -> String {
    let slopes = body::slopes(bumps, uv);
    let head = head_of_evolved("");
    format!(
        "\n// Slopes of the bumps: changes of their height by u and by v.\n\
         fn evolved_slopes(tex_u: f32, tex_v: f32) -> vec2f {{\n{slopes}}}\n\n\
         // As evolved_flat, with the normal that bumps turn, times the ratio of the cosines of\n\
         // wi. y: perpendicular to n and x, where v grows; the opposite of n cross x where the\n\
         // texture is mirrored.\n\
         {head}{TURNED}"
    )
}

/// Body of `evolved` with bumps: twin of `TurnedPair::new` in brood-eval.
const TURNED: &str = "  let slopes: vec2f = evolved_slopes(uv.x, uv.y);
  let m: vec3f = normalize(n - x * slopes.x - y * slopes.y);
  let cos_i: f32 = dot(wi, n);
  let cos_m: f32 = dot(wi, m);
  if ((cos_i <= 0.0) || (cos_m <= 0.0)) {
    return vec3f(0.0, 0.0, 0.0);
  }
  let t: vec3f = normalize(x - m * dot(m, x));
  let up: f32 = dot(wo, m);
  let level: vec3f = wo - m * up;
  let above: vec3f = level * (1.0 / max(length(level), 1e-9)) + m * 1e-4;
  let eye: vec3f = wo * step(1e-9, up) + above * (1.0 - step(1e-9, up));
  return evolved_flat(wi, eye, m, t, cross(m, t), uv) * (cos_m / cos_i);
}
";

fn head(program: &Program, layers: &Layers<'_>, format: Format, uv: f32) -> String {
    format!(
        "// A material bred by brood: {}, for any directions.\n\
         // Program {}, {} operations. {}.\n{}",
        properties(program, layers),
        program.hash(),
        program.operations(),
        format.label(),
        preamble(format, uv),
    )
}

/// True if f depends on the texture position.
pub(crate) fn reads_texture(program: &Program) -> bool {
    let inputs = program.inputs();
    program.bumps().is_some() || inputs.contains(Input::U) || inputs.contains(Input::V)
}

/// Words about the laws that f keeps.
pub(crate) fn properties(program: &Program, layers: &Layers<'_>) -> &'static str {
    match layers.are_reciprocal() {
        _ if program.bumps().is_some() => "never negative, but not reciprocal because it has bumps",
        true => "reciprocal and never negative",
        false => "never negative, but not reciprocal because one of its models is not",
    }
}

/// Last lines of the header comment, and precision statements.
pub(crate) fn preamble(format: Format, uv: f32) -> String {
    let precision = match format {
        Format::GlslEs300 => "precision highp float;\nprecision highp int;\n\n",
        _ => "",
    };
    let within = if uv < RANGE {
        format!("// Texture positions from {} to {uv} only.\n", -uv)
    } else {
        String::new()
    };
    format!("{within}\n{precision}")
}

#[cfg(test)]
mod tests {
    use brood_genome::{
        BirthKey, Dialect, DialectConstraints, Genome, ModelKind, OpcodeSet, Output, Variation,
    };

    use super::*;
    use crate::{Within, conformance, export_material};

    fn programs() -> Vec<Program> {
        let mut programs: Vec<Program> = [OpcodeSet::Paper, OpcodeSet::Extended]
            .into_iter()
            .flat_map(|opcodes| {
                let dialect = Dialect { opcodes, registers: 16, ..Dialect::default() };
                let random = Variation::random(dialect);
                (0..40).map(move |slot| {
                    Program::lower(&random.birth(BirthKey { seed: 9, slot, attempt: 0 }))
                })
            })
            .collect();
        let black = "brood 1\n.dialect paper smooth registers 7\nSUB R0, R0, R0\n";
        programs.push(Program::lower(&black.parse::<Genome>().unwrap()));
        programs.extend(models().iter().map(|case| case.program.clone()));
        programs.extend(models().chunks(7).map(over_a_program));
        programs.extend(bumped());
        programs
    }

    fn models() -> Vec<conformance::ModelCase> {
        ModelKind::ALL.into_iter().flat_map(conformance::cases).collect()
    }

    /// The first two models as layers over a program with an output stage.
    fn over_a_program(cases: &[conformance::ModelCase]) -> Program {
        let mut text =
            "brood 1\n.scale 0.5 2 0\n.dialect paper smooth registers 7\nMUL R0, R0, R1\n"
                .to_owned();
        cases.iter().take(2).for_each(|case| text += &case.model.to_string());
        Program::lower(&text.parse::<Genome>().unwrap())
    }

    fn bumped() -> Vec<Program> {
        let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
        let random = Variation::random(Dialect::default()).with_constraints(constraints);
        let birth = |slot| random.birth(BirthKey { seed: 5, slot, attempt: 0 });
        let mut programs: Vec<Program> = (0..12).map(|slot| Program::lower(&birth(slot))).collect();
        let text = "brood 1\n.model cook-torrance\n.bump strength -2\n.bump SPL R0, R0.x\n";
        programs.push(Program::lower(&text.parse::<Genome>().unwrap()));
        programs
    }

    #[test]
    fn wgsl_modules_are_valid_for_any_program() {
        let programs = programs().into_iter().map(|program| export(&program, Format::Wgsl));
        let styles = conformance::styles();
        let styles = (1..=8).cycle().zip(&styles).map(|(lights, style)| {
            let within = Within { lights, ..Within::default() };
            export_material(style, Format::Wgsl, within).unwrap().into_text()
        });
        for text in programs.chain(styles) {
            let module = naga::front::wgsl::parse_str(&text);
            let module = module.unwrap_or_else(|e| panic!("{}\n{text}", e.emit_to_string(&text)));
            let mut validator = naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            );
            assert!(validator.validate(&module).is_ok(), "{text}");
        }
    }

    #[test]
    fn layers_are_functions_added_before_the_output_stage() {
        let text = "brood 1\n.scale 0.5 2 0\n.dialect paper smooth registers 7\nMUL R0, R0, R1\n\
                    .model lambert\n.model cook-torrance\nf0 1 0.71 0.29\n";
        let program = Program::lower(&text.parse::<Genome>().unwrap());
        let text = export(&program, Format::GlslEs300);
        for part in [
            "// Layer 2, cook-torrance: diffuse 0 0 0, f0 1 0.71 0.29, roughness 0.2",
            "vec3 layer_1(BroodPair p) {\n  return vec3(0.15915494);\n}",
            "brood_schlick(vec3(1.0, 0.71, 0.29), p.off_c) * facets",
            "return min(layer_1(p) + layer_2(p), vec3(4290774000.0));",
            "+ models.x);",
            "reciprocal and never negative",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        for absent in ["brood_erf(", "brood_metal(", "brood_sgd("] {
            assert!(!text.contains(absent), "{absent}");
        }
        let phong = "brood 1\n.model phong\n".parse::<Genome>().unwrap();
        let text = export(&Program::lower(&phong), Format::Wgsl);
        assert!(
            text.contains("but not reciprocal") && text.contains("let f0 = models.x;"),
            "{text}"
        );
    }

    #[test]
    fn module_contains_the_output_stage_and_only_the_functions_it_calls() {
        let text = "brood 1\n.dialect paper smooth registers 7\nSIN R0.xy, R0.x\n";
        let genome: Genome = text.parse().unwrap();
        let plain = export(&Program::lower(&genome), Format::GlslEs300);
        assert!(plain.contains("brood_sine(") && !plain.contains("brood_ex2("));
        assert!(plain.contains("return vec3(f0, f1, f2);"));
        let grey = genome.with_output(Output::saturation(0.25).unwrap());
        let grey = export(&Program::lower(&grey), Format::GlslEs300);
        assert!(
            grey.contains("brood_product(f1, 0.5364") && grey.contains("return vec3(o0, o1, o2);")
        );
    }
}
