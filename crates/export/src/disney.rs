//! Material of Disney's BRDF Explorer: a file with sliders and a function in GLSL.
//!
//! The first line must begin with `analytic`. Everywhere in the file, lines whose first character
//! is `#` are comments. The uniform `brood_zero` is 0 because nothing sets it.

use brood_program::Program;

use crate::format::Format;
use crate::module::{export_within, reads_texture};

/// Returns the file. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn file(program: &Program, uv: f32) -> String {
    let is_textured = reads_texture(program);
    let (sliders, position) = match is_textured {
        true => (
            "float texture_u 0.0 1.0 0.5\nfloat texture_v 0.0 1.0 0.5\n",
            "vec2(texture_u, texture_v)",
        ),
        false => ("", "vec2(0.0)"),
    };
    let code = export_within(program, Format::Glsl410, uv);
    format!(
        "analytic\n\n\
         # A material bred by brood. Program {}.\n\n\
         ::begin parameters\n{sliders}::end parameters\n\n\
         ::begin shader\n\n{code}\n\
         vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {{\n  \
           return evolved(L, V, N, X, Y, {position});\n}}\n\n\
         ::end shader\n",
        program.hash(),
    )
}

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;

    /// Lines between the marks of a section, as BRDF Explorer reads them.
    fn section<'a>(file: &'a str, name: &str) -> Vec<&'a str> {
        let (begin, end) = (format!("::begin {name}"), format!("::end {name}"));
        let lines = file.lines().filter(|line| !line.trim_start().starts_with('#'));
        let within = lines.skip_while(|line| !line.starts_with(&begin)).skip(1);
        within.take_while(|line| !line.starts_with(&end)).collect()
    }

    #[test]
    fn sections_have_the_function_and_sliders_of_textured_materials() {
        let of = |text: &str| file(&Program::lower(&text.parse::<Genome>().unwrap()), 1.0);
        let plain = of("brood 1\n.model cook-torrance\n");
        assert!(plain.starts_with("analytic\n"));
        assert!(section(&plain, "parameters").is_empty());
        let shader = section(&plain, "shader").join("\n");
        assert!(shader.contains("vec3 evolved(") && shader.contains("vec3 BRDF(vec3 L, vec3 V"));
        let textured = of("brood 1\n.dialect paper smooth registers 7\nMUL R0, R1.z, R1.w\n");
        assert_eq!(section(&textured, "parameters").len(), 2, "{textured}");
    }
}
