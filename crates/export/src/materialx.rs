//! Node of MaterialX: its definition, its implementation in GLSL, and a material that uses it.
//!
//! The targets ESSL and Vulkan take the implementation of GLSL. MaterialX reads code of more than
//! one line from a file only, so the export is an archive. All names of the code have the hash of
//! the program, so that several materials can be in one shader.

use std::collections::HashSet;
use std::io::{Cursor, Write};

use brood_program::Program;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::exported::Exported;
use crate::language::Language;
use crate::model::Layers;
use crate::module;
use crate::source::{is_of_word, with_words};

/// Returns the archive. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn archive(program: &Program, uv: f32) -> Exported {
    let name = name(program);
    let files = [("mtlx", document(program)), ("glsl", implementation(program, uv))]
        .map(|(ending, text)| (format!("{name}.{ending}"), text));
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    // A fixed time: the same program gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    for (name, text) in files {
        writer.start_file(name, options).expect("the names differ");
        writer.write_all(text.as_bytes()).expect("a vector takes everything");
    }
    let bytes = writer.finish().expect("a vector takes everything").into_inner();
    Exported { bytes, note: None }
}

/// Name of the node, which begins the names of its functions.
fn name(program: &Program) -> String {
    format!("brood_{}", &program.hash().to_string()[..8])
}

/// Node definition, implementation and material.
fn document(program: &Program) -> String {
    let bitangent = match program.bumps() {
        Some(_) => "    <input name=\"bitangent\" type=\"vector3\" defaultgeomprop=\"Bworld\" />\n",
        None => "",
    };
    include_str!("materialx/document.mtlx")
        .replace("@BITANGENT@", bitangent)
        .replace("@PROPERTIES@", module::properties(program, &Layers::of(program.layers())))
        .replace("@PROGRAM@", &program.hash().to_string())
        .replace("@NAME@", &name(program))
}

/// Code of the node.
fn implementation(program: &Program, uv: f32) -> String {
    let (constants, functions) = module::with_library(&module::functions(program, uv));
    let code = Language::Glsl.translate(&renamed(
        &(constants + "\nvar brood_zero: u32 = 0u;\n\n" + &functions),
        &name(program),
    ));
    let (bitangent, across) = match program.bumps() {
        Some(_) => {
            (" vec3 bitangent,", "(dot(cross(n, x), bitangent) < 0.0 ? -1.0 : 1.0) * cross(n, x)")
        }
        None => ("", "cross(n, x)"),
    };
    include_str!("materialx/node.glsl")
        .replace("@CODE@", code.trim())
        .replace("@BITANGENT@", bitangent)
        .replace("@ACROSS@", across)
        .replace("@PROGRAM@", &program.hash().to_string())
        .replace("@OPERATIONS@", &program.operations().to_string())
        .replace("@NAME@", &name(program))
}

/// The source form with `prefix` before the names of functions, structures, constants and tables.
fn renamed(source: &str, prefix: &str) -> String {
    let declared: HashSet<&str> = source
        .lines()
        .filter_map(|line| {
            let declarations = ["fn ", "struct ", "const ", "var<private> ", "var "];
            let rest = declarations.into_iter().find_map(|word| line.strip_prefix(word))?;
            rest.split(|c| !is_of_word(c)).next()
        })
        .collect();
    with_words(source, |word| declared.contains(word).then(|| format!("{prefix}_{word}")))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use brood_genome::Genome;
    use zip::ZipArchive;

    use super::*;

    fn lowered(text: &str) -> Program {
        Program::lower(&text.parse::<Genome>().unwrap())
    }

    #[test]
    fn all_names_are_of_the_program() {
        let source = "const A: f32 = 1.0;\nstruct S {\n  a: f32,\n}\n\nfn f(s: S) -> f32 {\n  \
                      let f0: f32 = s.a * A;\n  return f(s).f + f0;\n}\n";
        assert_eq!(
            renamed(source, "p"),
            "const p_A: f32 = 1.0;\nstruct p_S {\n  a: f32,\n}\n\nfn p_f(s: p_S) -> f32 {\n  \
             let f0: f32 = s.a * p_A;\n  return p_f(s).f + f0;\n}\n"
        );
    }

    #[test]
    fn archive_has_the_document_and_the_code_that_it_names_and_the_same_bytes_again() {
        let program = lowered("brood 1\n.model cook-torrance\n");
        let made = archive(&program, 1.0);
        assert_eq!(made, archive(&program, 1.0));
        let mut read = ZipArchive::new(Cursor::new(made.bytes)).unwrap();
        let mut file = |ending: &str| {
            let mut text = String::new();
            let name = format!("{}.{ending}", name(&program));
            read.by_name(&name).unwrap().read_to_string(&mut text).unwrap();
            text
        };
        let (document, code) = (file("mtlx"), file("glsl"));
        let name = name(&program);
        for part in [
            format!("file=\"{name}.glsl\" function=\"{name}_bsdf\""),
            format!("node=\"{name}\" bsdf=\"R\" nodegroup=\"pbr\""),
        ] {
            assert!(document.contains(&part), "{part}\n{document}");
        }
        assert!(code.contains(&format!("void {name}_bsdf(")) && !code.contains('@'), "{code}");
        assert!(!document.contains('@') && !document.contains("bitangent"), "{document}");
    }

    #[test]
    fn bumps_follow_the_bitangent() {
        let program = lowered("brood 1\n.model lambert\n.bump strength 1\n.bump SPL R0, R0.x\n");
        assert!(document(&program).contains("defaultgeomprop=\"Bworld\""));
        assert!(implementation(&program, 1.0).contains("vec3 bitangent,"));
    }
}
