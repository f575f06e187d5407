//! Shader of the engine Godot 3, for its GLES3 renderer: f under each light of a scene.
//!
//! Godot's shading language is GLSL without structures, tables outside of functions, hexadecimal
//! numbers and the suffix `u`. Godot parses a shader and prints numbers with 6 digits, so numbers
//! that need more are given by their bits. The colour of a light is pi times its energy, such that
//! a white diffuse surface, f = 1 / pi, has the brightness 1: f cos times that colour is Godot's
//! own unit of light.

use std::collections::HashMap;
use std::fmt::Write;

use brood_program::Program;

use crate::language::Language;
use crate::model::Layers;
use crate::module;
use crate::source::{is_of_word, with_words};

/// Components of a column of a matrix, which holds fields of a structure.
const COMPONENTS: [char; 4] = ['x', 'y', 'z', 'w'];
/// Columns of a matrix.
const COLUMNS: usize = 4;

/// Returns the file. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn shader(program: &Program, uv: f32) -> String {
    let (constants, functions) = module::with_library(&module::functions(program, uv));
    let (functions, structures) = without_structures(&without_tables(&functions));
    let functions = structures.iter().fold(functions, |text, structure| structure.replaced(&text));
    let code = Language::Glsl.translate(&without_constants(&constants, &functions));
    // Uniforms with a value are signed.
    let code = code.replace("brood_zero", "uint(brood_zero)");
    let layers = Layers::of(program.layers());
    // Where the texture is mirrored, v grows against n cross x.
    let across = match program.bumps() {
        Some(_) => "brood_sign * cross(n, x)",
        None => "cross(n, x)",
    };
    include_str!("godot/module.shader")
        .replace("@PROPERTIES@", module::properties(program, &layers))
        .replace("@PROGRAM@", &program.hash().to_string())
        .replace("@OPERATIONS@", &program.operations().to_string())
        .replace("@ACROSS@", across)
        .replace("@CODE@", numbers(&code).trim())
}

/// Replaces constants by their values, because those of Godot cannot be given by bits.
fn without_constants(constants: &str, source: &str) -> String {
    let values: HashMap<&str, &str> = constants
        .lines()
        .filter_map(|line| {
            let (name, rest) = line.strip_prefix("const ")?.split_once(": ")?;
            Some((name, rest.split_once(" = ")?.1.trim_end_matches(';')))
        })
        .collect();
    with_words(source, |word| values.get(word).map(|value| format!("({value})")))
}

/// Replaces tables by functions with a local table.
fn without_tables(source: &str) -> String {
    let mut text = String::with_capacity(source.len());
    let mut names: Vec<&str> = Vec::new();
    let mut is_table = false;
    for line in source.lines() {
        if let Some(table) = line.strip_prefix("var<private> ") {
            let (name, rest) = table.split_once(": array<f32, ").expect("tables have numbers");
            let (length, _) = rest.split_once('>').expect("tables have a length");
            names.push(name);
            is_table = true;
            writeln!(text, "fn {name}(k: i32) -> f32 {{\n  float t[{length}] = float[{length}](")
        } else if is_table && line.ends_with(");") {
            is_table = false;
            writeln!(text, "{line}\n  return t[k];\n}}")
        } else {
            writeln!(
                text,
                "{}",
                names.iter().fold(line.to_owned(), |line, name| called(&line, name))
            )
        }
        .expect("a string takes everything");
    }
    text
}

/// `name[k]` as `name(k)`.
fn called(line: &str, name: &str) -> String {
    let read = format!("{name}[");
    let mut parts = line.split(&read);
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| format!("{text}{name}({}", part.replacen(']', ")", 1)))
}

/// A structure as a matrix.
struct Structure {
    name: String,
    /// Names of the fields with the expressions that read them.
    fields: Vec<(String, String)>,
}

impl Structure {
    /// Text with the matrix instead of the structure.
    fn replaced(&self, text: &str) -> String {
        let name = &self.name;
        let text =
            text.replace(&format!(": {name}"), ": mat4").replace(&format!("-> {name}"), "-> mat4");
        let text = with_words(&text, |word| (word == name).then(|| format!("make_{name}")));
        let mut done = String::with_capacity(text.len());
        let mut rest = text.as_str();
        while let Some((before, after)) = rest.split_once('.') {
            let end = after.find(|c: char| !is_of_word(c)).unwrap_or(after.len());
            let read = self.fields.iter().find(|(field, _)| *field == after[..end]);
            done += before;
            match read {
                Some((_, read)) if before.ends_with(is_of_word) => done += read,
                _ => done.extend([".", &after[..end]]),
            }
            rest = &after[end..];
        }
        done + rest
    }
}

/// Text in which a function makes a matrix instead of each structure, and the structures.
fn without_structures(source: &str) -> (String, Vec<Structure>) {
    let mut text = String::with_capacity(source.len());
    let mut structures = Vec::new();
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        let Some(name) = line.strip_prefix("struct ") else {
            writeln!(text, "{line}").expect("a string takes everything");
            continue;
        };
        let name = name.trim_end_matches(" {");
        let fields: Vec<(&str, &str)> = lines
            .by_ref()
            .take_while(|line| *line != "}")
            .filter_map(|field| field.trim().trim_end_matches(',').split_once(": "))
            .collect();
        let (made, read) = packed(&fields);
        let parameters: Vec<String> =
            fields.iter().map(|(field, of)| format!("{field}: {of}")).collect();
        writeln!(
            text,
            "fn make_{name}({}) -> mat4 {{\n  return {made};\n}}",
            parameters.join(", ")
        )
        .expect("a string takes everything");
        structures.push(Structure { name: name.to_owned(), fields: read });
    }
    (text, structures)
}

/// Matrix of fields, and the expressions that read them. Each vector has a column; numbers have the
/// places that are left.
fn packed(fields: &[(&str, &str)]) -> (String, Vec<(String, String)>) {
    let mut columns: Vec<Vec<&str>> = Vec::new();
    let mut read = Vec::new();
    for (field, _) in fields.iter().filter(|(_, of)| *of == "vec3f") {
        read.push(((*field).to_owned(), format!("[{}].xyz", columns.len())));
        columns.push(vec![*field]);
    }
    let vectors = columns.len();
    let taken = |place: usize, columns: &[Vec<&str>]| {
        columns[place].len() + if place < vectors { 2 } else { 0 }
    };
    for (field, _) in fields.iter().filter(|(_, of)| *of == "f32") {
        let free = (0..columns.len()).find(|place| taken(*place, &columns) < COMPONENTS.len());
        let place = free.unwrap_or_else(|| {
            columns.push(Vec::new());
            columns.len() - 1
        });
        let component = COMPONENTS[taken(place, &columns)];
        read.push(((*field).to_owned(), format!("[{place}].{component}")));
        columns[place].push(field);
    }
    assert!(columns.len() <= COLUMNS && read.len() == fields.len(), "structures fit in a matrix");
    columns.resize(COLUMNS, Vec::new());
    let columns: Vec<String> = (0..COLUMNS)
        .map(|place| {
            let missing = COMPONENTS.len() - taken(place, &columns);
            let rest = vec!["0.0"; if place < vectors { missing } else { missing.min(4) }];
            format!("vec4({})", [columns[place].clone(), rest].concat().join(", "))
        })
        .collect();
    (format!("mat4({})", columns.join(", ")), read)
}

/// GLSL with the numbers of Godot.
fn numbers(code: &str) -> String {
    let mut text = String::with_capacity(code.len());
    for line in code.lines() {
        if line.trim_start().starts_with("//") {
            text += line;
        } else {
            text += &numbers_of_line(line);
        }
        text.push('\n');
    }
    text
}

fn numbers_of_line(line: &str) -> String {
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, number) = rest.split_at(start);
        text += before;
        let mut end = number.find(|c: char| !is_of_word(c) && c != '.').unwrap_or(number.len());
        // The sign of an exponent.
        if number[..end].ends_with('e') && !number.starts_with("0x") {
            let exponent = &number[end + 1..];
            end += 1 + exponent.find(|c: char| !c.is_ascii_digit()).unwrap_or(exponent.len());
        }
        let (number, after) = number.split_at(end);
        text += &match shifted(&text) {
            _ if text.ends_with(is_of_word) => number.to_owned(),
            // The sides of a shift have one type.
            Some(shifted) if !is_signed(shifted) => format!("uint({number})"),
            _ => literal(number),
        };
        rest = after;
    }
    text + rest
}

/// Code before the operator if the code ends with a shift.
fn shifted(code: &str) -> Option<&str> {
    code.strip_suffix(" << ").or_else(|| code.strip_suffix(" >> "))
}

/// True if the code ends with a conversion to a signed integer.
fn is_signed(code: &str) -> bool {
    let mut depth = 0;
    let open = code.char_indices().rev().find(|(_, c)| {
        depth += match c {
            ')' => 1,
            '(' => -1,
            _ => 0,
        };
        depth == 0
    });
    open.is_some_and(|(open, _)| code[..open].rsplit(|c| !is_of_word(c)).next() == Some("int"))
}

/// A number as Godot prints it without a loss.
fn literal(number: &str) -> String {
    if let Some(unsigned) = number.strip_suffix('u') {
        let value = match unsigned.strip_prefix("0x") {
            Some(digits) => u32::from_str_radix(digits, 16),
            None => unsigned.parse(),
        };
        let value = value.expect("unsigned numbers have 32 bits");
        // Numbers are read as signed ones.
        return match i32::try_from(value) {
            Ok(value) => format!("uint({value})"),
            Err(_) => format!("(~uint({}))", !value),
        };
    }
    let is_integer = number.bytes().all(|digit| digit.is_ascii_digit());
    match number.parse::<f32>() {
        Ok(value) if !is_integer => {
            let printed: f32 = format!("{value:.5e}").parse().expect("it is a number");
            match printed.to_bits() == value.to_bits() {
                true => number.to_owned(),
                false => format!("intBitsToFloat({})", value.to_bits()),
            }
        }
        _ => number.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;

    #[test]
    fn numbers_survive_six_digits() {
        for (number, of_godot) in [
            ("0u", "uint(0)"),
            ("0x3f800000u", "uint(1065353216)"),
            ("0xff800000u", "(~uint(8388607))"),
            ("23", "23"),
            ("0.5", "0.5"),
            ("1e-9", "1e-9"),
            ("12582912.0", "intBitsToFloat(1262485504)"),
            ("0.6931472", "intBitsToFloat(1060205080)"),
        ] {
            assert_eq!(literal(number), of_godot);
        }
        assert_eq!(
            numbers("e = float(int(offset) >> 23) + f((q & 2u) << 30)"),
            "e = float(int(offset) >> 23) + f((q & uint(2)) << uint(30))\n"
        );
        assert_eq!(
            numbers("float p2 = s1 * -9.094947e-13 + vec2(0.25).x; // 1"),
            "float p2 = s1 * -intBitsToFloat(729808896) + vec2(0.25).x; // 1\n"
        );
    }

    #[test]
    fn structures_are_matrices_and_tables_are_functions() {
        let structure = "struct S {\n  a: vec3f,\n  b: f32,\n  c: f32,\n}\n\
                         fn f(p: S) -> f32 {\n  return p.a.x + 1.5 * p.c + dot(p.a.xy, x.xy);\n}\n";
        let (text, structures) = without_structures(structure);
        assert_eq!(
            structures[0].replaced(&text),
            "fn make_S(a: vec3f, b: f32, c: f32) -> mat4 {\n  return mat4(vec4(a, b), \
             vec4(c, 0.0, 0.0, 0.0), vec4(0.0, 0.0, 0.0, 0.0), vec4(0.0, 0.0, 0.0, 0.0));\n}\n\
             fn f(p: mat4) -> f32 {\n  return p[0].xyz.x + 1.5 * p[1].x + dot(p[0].xyz.xy, x.xy);\n}\n"
        );
        let table = "var<private> t_table: array<f32, 2> = array<f32, 2>(\n  1.0,\n  2.0);\n\
                     x = t_table[k] + t_table[k + 1];";
        assert_eq!(
            without_tables(table),
            "fn t_table(k: i32) -> f32 {\n  float t[2] = float[2](\n  1.0,\n  2.0);\n  return t[k];\n}\n\
             x = t_table(k) + t_table(k + 1);\n"
        );
    }

    #[test]
    fn shaders_have_what_godot_parses() {
        for text in [
            "brood 1\n.model cook-torrance\n",
            "brood 1\n.model rough-plastic\n",
            "brood 1\n.model sgd\n",
            "brood 1\n.dialect paper smooth registers 7\nSIN R0.xy, R0.x\n",
        ] {
            let shader = shader(&Program::lower(&text.parse::<Genome>().unwrap()), 1.0);
            assert!(shader.starts_with("shader_type spatial;\n"), "{shader}");
            let code = shader.lines().filter(|line| !line.trim_start().starts_with("//"));
            for line in code {
                let is_known = !line.contains("struct ") && !line.contains("0x");
                assert!(is_known && !line.contains('@'), "{line}");
            }
            assert!(
                shader.contains("vec3 evolved(") && shader.contains("void light()"),
                "{shader}"
            );
        }
    }
}
