//! A whole module: what it is, the functions that it needs, the program, and `evolved`.

use std::fmt::Write;

use brood_genome::{ModelKind, RANGE};
use brood_program::Program;

use crate::format::Format;
use crate::language::{Language, Type};
use crate::{body, input, library};

/// Why a program has no source code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// A layer of it is a model.
    #[error("the material has a layer of the model {0}, and models are not written as source code")]
    Layer(ModelKind),
}

/// The source of a module with these functions:
///
/// - `evolved(wi, wo, n, x, y, uv)`: f in 1/sr, the cosine of `wi` not included; directions to the light and to the
///   eye, normal, tangent along u, and n cross x, all unit and in one space; texture position.
/// - `evolved_program(...)`: the same of the inputs that the program reads.
///
/// # Error
/// `evolved_program` has the bits of the canonical evaluator where the compiler keeps to IEEE rounding; `evolved`
/// differs by what inputs in f32 differ from inputs in f64.
pub fn export(program: &Program, format: Format) -> Result<String, ExportError> {
    export_within(program, format, RANGE)
}

/// The same for texture positions from -`uv` to `uv`: what cannot leave the range of numbers there is not clamped, which
/// for most programs spares most of the clamps. `uv`: 0 to 65504.
pub fn export_within(program: &Program, format: Format, uv: f32) -> Result<String, ExportError> {
    if let Some(model) = program.layers().first() {
        return Err(ExportError::Layer(model.kind()));
    }
    let language = format.language();
    let inputs = program.inputs();
    let names: Vec<&str> = inputs.iter().map(input::name).collect();
    let mut text = head(program, format, uv);
    text += &library::functions(program, language);
    let parameters: Vec<(Type, &str)> = names.iter().map(|name| (Type::Scalar, *name)).collect();
    text += "// f of the inputs that the program reads.\n";
    text += &language.head("evolved_program", &parameters);
    text += &body::lines(program, language, uv);
    text += "}\n\n";
    text += "// f(wi, wo) in 1/sr, the cosine of wi not included. wi: to the light; wo: to the eye (where it is below the\n\
             // surface, move it to a cosine of 1e-4); n: normal; x: tangent along u; y: n cross x; uv: texture position.\n\
             // All directions are unit and in one space.\n";
    let vectors = ["wi", "wo", "n", "x", "y"].map(|name| (Type::Vec3, name));
    let parameters: Vec<(Type, &str)> = vectors.into_iter().chain([(Type::Vec2, "uv")]).collect();
    text += &language.head("evolved", &parameters);
    text += &input::lines(inputs, language);
    writeln!(text, "  return evolved_program({});\n}}", names.join(", "))
        .expect("a string takes everything");
    Ok(text)
}

fn head(program: &Program, format: Format, uv: f32) -> String {
    let precision = match (format, format.language()) {
        (Format::GlslEs300, _) => "precision highp float;\nprecision highp int;\n\n",
        (_, Language::Glsl | Language::Wgsl) => "",
    };
    let within = if uv < RANGE {
        format!("// Texture positions from {} to {uv} only.\n", -uv)
    } else {
        String::new()
    };
    format!(
        "// A material bred by brood: reciprocal and never negative, whatever the directions.\n\
         // Program {}, {} operations. {}.\n{within}\n{precision}",
        program.hash(),
        program.operations(),
        format.label()
    )
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Genome, OpcodeSet, Output, Variation};

    use super::*;

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
        programs
    }

    #[test]
    fn wgsl_modules_are_valid_whatever_the_program() {
        for program in programs() {
            let text = export(&program, Format::Wgsl).unwrap();
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
    fn module_carries_the_output_stage_and_only_the_functions_it_calls() {
        let text = "brood 1\n.dialect paper smooth registers 7\nSIN R0.xy, R0.x\n";
        let genome: Genome = text.parse().unwrap();
        let plain = export(&Program::lower(&genome), Format::GlslEs300).unwrap();
        assert!(plain.contains("brood_sine(") && !plain.contains("brood_ex2("));
        assert!(plain.contains("return vec3(f0, f1, f2);"));
        let grey = genome.with_output(Output::saturation(0.25).unwrap());
        let grey = export(&Program::lower(&grey), Format::GlslEs300).unwrap();
        assert!(
            grey.contains("brood_product(f1, 0.5364") && grey.contains("return vec3(o0, o1, o2);")
        );
    }
}
