//! Languages of exports, and the translation of the source form to them.
//!
//! The source form is WGSL with types on local declarations; WGSL is that without the types. GLSL
//! is a translation line by line. It knows the constructs that this crate prints and no others:
//! functions, structures, constants, tables, declarations and expressions; comments have lines of
//! their own.

/// Shading language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Language {
    Glsl,
    Wgsl,
}

/// Words of the source form in GLSL, replaced in this order. `quarter` is an integer; all other
/// arguments of that bitcast are numbers.
const WORDS: [(&str, &str); 11] = [
    ("bitcast<u32>(quarter)", "uint(quarter)"),
    ("bitcast<u32>", "floatBitsToUint"),
    ("bitcast<f32>", "uintBitsToFloat"),
    ("bitcast<i32>", "int"),
    ("dpdx", "dFdx"),
    ("dpdy", "dFdy"),
    ("vec2f", "vec2"),
    ("vec3f", "vec3"),
    ("f32", "float"),
    ("i32", "int"),
    ("u32", "uint"),
];

impl Language {
    /// Translates code of the source form.
    pub(crate) fn translate(self, source: &str) -> String {
        let mut text = String::with_capacity(source.len());
        let mut is_structure = false;
        for line in source.lines() {
            is_structure |= line.starts_with("struct ");
            match self {
                _ if line.trim_start().starts_with("//") => text.push_str(line),
                Self::Wgsl => wgsl(line, &mut text),
                Self::Glsl if is_structure => text.push_str(&glsl_of_structure(line)),
                Self::Glsl => text.push_str(&glsl(line)),
            }
            text.push('\n');
            is_structure &= line != "}";
        }
        text
    }

    /// Declaration of `brood_zero`, which every module has.
    pub(crate) fn zero(self) -> &'static str {
        match self {
            Self::Glsl => {
                "// Every product and sum must be rounded separately. brood_zero must be set to 0: \
                 because compilers\n\
                 // do not know its value, they cannot fuse operations across brood_hold.\n\
                 uniform highp uint brood_zero;\n\n"
            }
            Self::Wgsl => {
                "// Every product and sum must be rounded separately. brood_zero must be set to 0: \
                 because compilers\n\
                 // do not know its value, they cannot fuse operations across brood_hold. Any \
                 binding will do.\n\
                 @group(0) @binding(0) var<uniform> brood_zero: u32;\n\n"
            }
        }
    }
}

/// Appends a line without the type of a local declaration.
fn wgsl(line: &str, text: &mut String) {
    let is_local = line.starts_with("  let ") || line.starts_with("  var ");
    match line.split_once(": ").filter(|_| is_local) {
        Some((start, rest)) => {
            let (_, value) = rest.split_once(" = ").expect("local declarations have a value");
            text.extend([start, " = ", value]);
        }
        None => text.push_str(line),
    }
}

fn glsl(line: &str) -> String {
    if let Some(head) = line.strip_prefix("fn ") {
        return glsl_of_head(head);
    }
    if let Some(table) = line.strip_prefix("var<private> ") {
        return glsl_of_table(table);
    }
    let code = line.trim_start();
    let indentation = &line[..line.len() - code.len()];
    for (keyword, qualifier) in [("let ", ""), ("var ", ""), ("const ", "const ")] {
        if let Some(declaration) = code.strip_prefix(keyword) {
            let (name, value) = declaration.split_once(" = ").expect("declarations have a value");
            let (name, value) = (glsl_of_name(name), glsl_of_expression(value));
            return format!("{indentation}{qualifier}{name} = {value}");
        }
    }
    format!("{indentation}{}", glsl_of_expression(code))
}

/// `name(a: T, b: U) -> R {` as `R name(T a, U b) {`.
fn glsl_of_head(head: &str) -> String {
    let (name, rest) = head.split_once('(').expect("functions have parameters");
    let (parameters, result) = rest.split_once(") -> ").expect("functions have a result");
    let parameters: Vec<String> = match parameters {
        "" => Vec::new(),
        some => some.split(", ").map(glsl_of_name).collect(),
    };
    format!("{} {name}({}) {{", glsl_of_words(result.trim_end_matches(" {")), parameters.join(", "))
}

/// `name: array<T, N> = array<T, N>(` as `const T name[N] = T[N](`.
fn glsl_of_table(table: &str) -> String {
    let (name, rest) = table.split_once(": array<").expect("only tables are private variables");
    let (of, rest) = rest.split_once(", ").expect("tables have a type");
    let (length, _) = rest.split_once('>').expect("tables have a length");
    let of = glsl_of_words(of);
    format!("const {of} {name}[{length}] = {of}[{length}](")
}

fn glsl_of_structure(line: &str) -> String {
    match line.strip_suffix(',') {
        Some(field) => format!("  {};", glsl_of_name(field.trim_start())),
        None if line == "}" => "};".to_owned(),
        None => line.to_owned(),
    }
}

/// `name: T` as `T name`, and `name: array<T,N>` as `T[N] name`.
fn glsl_of_name(declaration: &str) -> String {
    let (name, of) = declaration.split_once(": ").expect("declarations have a type");
    let array = of.strip_prefix("array<").and_then(|rest| rest.strip_suffix('>')?.split_once(','));
    if let Some((of, length)) = array {
        return format!("{}[{length}] {name}", glsl_of_words(of));
    }
    format!("{} {name}", glsl_of_words(of))
}

fn glsl_of_words(code: &str) -> String {
    let is_used = |(word, _): &&(&str, &str)| code.contains(word);
    let used = WORDS.iter().filter(is_used);
    used.fold(code.to_owned(), |text, (word, of)| text.replace(word, of))
}

/// Expression with conditionals, words, and signed shifts, which are unsigned in WGSL.
fn glsl_of_expression(code: &str) -> String {
    let code = glsl_of_words(&glsl_of_conditionals(code));
    let mut is_shift = false;
    let words = code.split_inclusive(' ').map(|word| {
        let text = if is_shift { word.replacen('u', "", 1) } else { word.to_owned() };
        is_shift = matches!(word, "<< " | ">> ");
        text
    });
    words.collect()
}

/// `select(b, a, c)` as `c ? a : b`, in parentheses unless it is a whole argument or value.
fn glsl_of_conditionals(code: &str) -> String {
    let Some((before, rest)) = code.split_once("select(") else { return code.to_owned() };
    let mut depth = 0;
    let mut ends = Vec::new();
    for (at, c) in rest.char_indices() {
        match c {
            ',' | ')' if depth == 0 => ends.push(at),
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        if ends.len() == 3 {
            break;
        }
    }
    let [first, second, end] = ends[..] else { unreachable!("select has three arguments") };
    let (otherwise, value) = (&rest[..first], &rest[first + 2..second]);
    let (condition, after) = (&rest[second + 2..end], &rest[end + 1..]);
    let starts = ["(", ", ", "= ", "return "];
    let is_start = before.is_empty() || starts.iter().any(|start| before.ends_with(start));
    let is_whole = is_start && after.starts_with([')', ',', ';']);
    let text = match is_whole {
        true => format!("{before}{condition} ? {value} : {otherwise}{after}"),
        false => format!("{before}({condition} ? {value} : {otherwise}){after}"),
    };
    glsl_of_conditionals(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn source_form_is_translated() {
        let cases = [
            ("// f32 stays.", "// f32 stays.", "// f32 stays."),
            ("const A: f32 = 1.0;", "const float A = 1.0;", "const A: f32 = 1.0;"),
            (
                "fn f(p: BroodPair, a: vec2f, k: i32) -> vec3f {",
                "vec3 f(BroodPair p, vec2 a, int k) {",
                "fn f(p: BroodPair, a: vec2f, k: i32) -> vec3f {",
            ),
            (
                "fn f(a: S, b: array<S,2>) -> f32 {",
                "float f(S a, S[2] b) {",
                "fn f(a: S, b: array<S,2>) -> f32 {",
            ),
            ("  return dpdx(a);", "  return dFdx(a);", "  return dpdx(a);"),
            ("struct S {\n  a: f32,\n}", "struct S {\n  float a;\n};", "struct S {\n  a: f32,\n}"),
            (
                "var<private> t: array<f32, 64> = array<f32, 64>(",
                "const float t[64] = float[64](",
                "var<private> t: array<f32, 64> = array<f32, 64>(",
            ),
            ("  let x: bool = a > 0.5;", "  bool x = a > 0.5;", "  let x = a > 0.5;"),
            ("  var y: vec3f = vec3f(x);", "  vec3 y = vec3(x);", "  var y = vec3f(x);"),
            ("  return f32(i >> 23u);", "  return float(i >> 23);", "  return f32(i >> 23u);"),
            (
                "  y = select(g(b, 1.0), a, c > 0.0);",
                "  y = c > 0.0 ? a : g(b, 1.0);",
                "  y = select(g(b, 1.0), a, c > 0.0);",
            ),
            (
                "  return f(select(0.0, a, a > 0.0) + b);",
                "  return f((a > 0.0 ? a : 0.0) + b);",
                "  return f(select(0.0, a, a > 0.0) + b);",
            ),
            (
                "  return bitcast<f32>(bitcast<u32>(m) << 23u);",
                "  return uintBitsToFloat(floatBitsToUint(m) << 23);",
                "  return bitcast<f32>(bitcast<u32>(m) << 23u);",
            ),
        ];
        for (source, glsl, wgsl) in cases {
            assert_eq!(Language::Glsl.translate(source), format!("{glsl}\n"));
            assert_eq!(Language::Wgsl.translate(source), format!("{wgsl}\n"));
        }
    }
}
