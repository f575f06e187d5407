//! Exports for three.js: a page with a material for WebGL 2, and a module with a material of nodes.

use brood_program::Program;

use crate::format::Format;
use crate::language::Language;
use crate::model::Layers;
use crate::module;

/// Version of three.js that the files are for.
const VERSION: &str = "0.187.0";
/// Files of that version that the page loads, with the SHA-384 of each in base64. Browsers refuse
/// files with other hashes.
const FILES: [(&str, &str); 3] = [
    ("build/three.module.js", "T/E3B9AvPtLn5PKD7aTSFqizQcA4kHDfU0lub7u0fvM4w9BMGcSb3yI7r5LqMAMn"),
    ("build/three.core.js", "drH6BueSlcvoXCwAqWkNJvXwu2Ax3mnGOmZnIXaomedIw+uXSP9Bf/XIUINgLUW+"),
    (
        "examples/jsm/controls/OrbitControls.js",
        "ZVBN/wmVxgX0mUGjFJXakzzdZrAF4g4aHfKyusbjoF0WsVXSoGpeM/qRaVnXtaFo",
    ),
];
/// Digits of the program's hash in names and titles.
const SHORT: usize = 8;

/// Returns the page. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn page(program: &Program, uv: f32) -> String {
    let evolved = module::export_within(program, Format::GlslEs300, uv);
    let code = evolved + &Language::Glsl.translate(&reflected(program));
    let files = FILES.map(|(file, hash)| {
        format!(
            "    \"https://cdn.jsdelivr.net/npm/three@{VERSION}/{file}\":\n      \"sha384-{hash}\""
        )
    });
    let text = include_str!("three/page.html");
    filled(text, program, &[("@INTEGRITY@", &files.join(",\n")), ("@CODE@", code.trim())])
}

/// Returns the module. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn module(program: &Program, uv: f32) -> String {
    let text = module::functions(program, uv) + &reflected(program);
    let (constants, functions) = module::with_library(&text);
    let source = constants + "\n" + &functions;
    let [glsl, wgsl] = [Language::Glsl, Language::Wgsl].map(|language| language.translate(&source));
    let text = include_str!("three/module.js");
    filled(text, program, &[("@GLSL@", &glsl), ("@WGSL@", &wgsl)])
}

/// Replaces the marks of a text, those of every file and `others`.
fn filled(text: &str, program: &Program, others: &[(&str, &str)]) -> String {
    let hash = program.hash().to_string();
    let operations = program.operations().to_string();
    let common = [
        ("@VERSION@", VERSION),
        ("@HASH@", &hash),
        ("@SHORT@", &hash[..SHORT]),
        ("@OPERATIONS@", &operations),
        ("@PROPERTIES@", module::properties(program, &Layers::of(program.layers()))),
    ];
    let marks = common.iter().chain(others);
    marks.fold(text.to_owned(), |text, (mark, value)| text.replace(mark, value))
}

/// Function that a shader calls for each light, after `evolved`, in the source form.
fn reflected(program: &Program) -> String {
    let mirrored = if program.bumps().is_some() { " * across" } else { "" };
    REFLECTED.replace("@MIRRORED@", mirrored)
}

const REFLECTED: &str = "
// f times the cosine of wi, in 1/sr: radiance for an irradiance of 1 at normal incidence. 0 if the
// light is below the surface. An eye below it, which interpolated normals cause, is moved to a
// cosine of 1e-4. along: direction in which u grows, not necessarily unit or perpendicular to n;
// 0 if there is none. across: 1, or -1 where the texture is mirrored; only bumps read it.
fn reflected(wi: vec3f, wo: vec3f, n: vec3f, along: vec3f, across: f32, uv: vec2f) -> vec3f {
  let cos_i: f32 = dot(wi, n);
  if (cos_i <= 0.0) {
    return vec3f(0.0, 0.0, 0.0);
  }
  let cos_o: f32 = dot(wo, n);
  let eye: vec3f = normalize(wo + n * (max(cos_o, 1e-4) - cos_o));
  let tangent: vec3f = along - n * dot(n, along);
  let is_across: f32 = step(abs(n.x), 0.5);
  let other: vec3f = cross(n, vec3f(is_across, 1.0 - is_across, 0.0));
  let x: vec3f = normalize(tangent + other * step(dot(tangent, tangent), 0.0));
  let y: vec3f = cross(n, x)@MIRRORED@;
  return evolved(wi, eye, n, x, y, uv) * cos_i;
}
";

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;
    use crate::{PrintError, Within, conformance, export_material};

    fn program(text: &str) -> Program {
        Program::lower(&text.parse::<Genome>().unwrap())
    }

    fn programs() -> [Program; 3] {
        [
            "brood 1\n.model cook-torrance\n",
            "brood 1\n.dialect paper smooth registers 7\nSIN R0, R1.z\n",
            "brood 1\n.model cook-torrance\n.bump strength -2\n.bump SPL R0, R0.x\n",
        ]
        .map(program)
    }

    /// Text between two others.
    fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
        let (_, rest) = text.split_once(start).unwrap();
        rest.split_once(end).unwrap().0
    }

    /// Words that have been left between two `@`.
    fn marks(text: &str) -> Vec<&str> {
        let is_mark = |word: &&str| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c == '_')
        };
        text.split('@').filter(is_mark).collect()
    }

    #[test]
    fn page_has_the_code_in_a_script_that_it_cannot_end() {
        for program in programs() {
            let page = page(&program, 1.0);
            assert_eq!(marks(&page), Vec::<&str>::new());
            let code = between(&page, "id=\"evolved\">", "</script>");
            assert!(code.contains("vec3 evolved(") && code.contains("vec3 reflected("), "{code}");
            assert!(!code.contains("</") && !code.contains("<!--"), "{code}");
            for tag in ["script", "style", "main", "form"] {
                let count = |start: &str| page.matches(&format!("{start}{tag}")).count();
                assert_eq!(count("<"), count("</"), "{tag}");
            }
        }
    }

    #[test]
    fn page_takes_each_file_in_one_version_with_its_hash() {
        let page = page(&programs()[0], 1.0);
        let versions = page.matches("https://cdn.jsdelivr.net/npm/three@").count();
        let exact = format!("https://cdn.jsdelivr.net/npm/three@{VERSION}/");
        assert_eq!(page.matches(&exact).count(), versions);
        let map = between(&page, "<script type=\"importmap\">", "</script>");
        for (file, hash) in FILES {
            let entry = format!("\"{exact}{file}\":\n      \"sha384-{hash}\"");
            assert!(map.contains(&entry), "{map}");
        }
    }

    #[test]
    fn module_has_valid_code_that_fits_in_its_strings() {
        for program in programs() {
            let module = module(&program, 1.0);
            assert_eq!(marks(&module), Vec::<&str>::new());
            let [glsl, wgsl] = ["GLSL", "WGSL"]
                .map(|language| between(&module, &format!("const {language} = `"), "`;"));
            for code in [glsl, wgsl] {
                assert!(!code.contains("${") && !code.contains('\\'), "{code}");
            }
            assert!(glsl.contains("vec3 reflected(vec3 wi"), "{glsl}");
            let parsed = naga::front::wgsl::parse_str(wgsl);
            let parsed = parsed.unwrap_or_else(|e| panic!("{}\n{wgsl}", e.emit_to_string(wgsl)));
            naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            )
            .validate(&parsed)
            .unwrap();
        }
    }

    #[test]
    fn modules_of_different_programs_have_different_names() {
        let names = programs().map(|program| {
            let module = module(&program, 1.0);
            between(&module, "return \"BroodMaterial_", "\"").to_owned()
        });
        assert!(names[0] != names[1] && names[1] != names[2] && names[0] != names[2], "{names:?}");
    }

    #[test]
    fn mirrored_textures_turn_bumps_only() {
        let turns = programs().map(|program| page(&program, 1.0).contains("cross(n, x) * across"));
        assert_eq!(turns, [false, false, true]);
    }

    #[test]
    fn painted_materials_are_refused_with_the_reason() {
        let painted = &conformance::styles()[0];
        for format in [Format::ThreePage, Format::ThreeTsl] {
            let refused = export_material(painted, format, Within::default());
            assert_eq!(refused, Err(PrintError::Painted(format)));
        }
    }
}
