//! Languages of exports, and the translation of the source form to them.
//!
//! The source form is WGSL with types on local declarations; WGSL is that without the types. GLSL
//! and HLSL are translations line by line. They know the constructs that this crate prints and no
//! others: functions, structures, constants, tables, declarations and expressions; comments have
//! lines of their own.

/// Shading language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Language {
    Glsl,
    Wgsl,
    Hlsl,
}

/// Words of the source form in GLSL, replaced in this order. `quarter` is an integer; all other
/// arguments of that bitcast are numbers.
const GLSL_WORDS: [(&str, &str); 11] = [
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

/// Words of the source form in HLSL.
const HLSL_WORDS: [(&str, &str); 11] = [
    ("bitcast<u32>(quarter)", "uint(quarter)"),
    ("bitcast<u32>", "asuint"),
    ("bitcast<f32>", "asfloat"),
    ("bitcast<i32>", "int"),
    ("dpdx", "ddx"),
    ("dpdy", "ddy"),
    ("vec2f", "float2"),
    ("vec3f", "float3"),
    ("f32", "float"),
    ("i32", "int"),
    ("u32", "uint"),
];
/// Structures of the source form, whose constructors are functions in HLSL.
const STRUCTURES: [&str; 5] =
    ["BroodPair", "BroodSgd", "StyledPoint", "StyledLight", "StyledGlass"];

impl Language {
    /// Translates code of the source form.
    pub(crate) fn translate(self, source: &str) -> String {
        let mut text = String::with_capacity(source.len());
        let mut structure: Vec<&str> = Vec::new();
        let mut is_table = false;
        for line in source.lines() {
            if line.starts_with("struct ") || !structure.is_empty() {
                structure.push(line);
            }
            is_table |= line.starts_with("var<private> ");
            match self {
                _ if line.trim_start().starts_with("//") => text.push_str(line),
                Self::Wgsl => wgsl(line, &mut text),
                Self::Hlsl if is_table && line.ends_with(");") => {
                    text.extend([line.trim_end_matches(");"), "};"]);
                }
                Self::Glsl | Self::Hlsl if !structure.is_empty() => {
                    text.push_str(&self.field(line));
                }
                Self::Glsl | Self::Hlsl => text.push_str(&self.line(line)),
            }
            text.push('\n');
            is_table &= !line.ends_with(");");
            if line == "}" && !structure.is_empty() {
                if self == Self::Hlsl {
                    text += &self.constructor(&structure);
                }
                structure.clear();
            }
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
            Self::Hlsl => {
                "// Every product and sum must be rounded separately, which `precise` asks for. For \
                 compilers\n\
                 // that lack it, such as Slang's for processors, define BROOD_PRECISE as
                 // nothing.\n\
                 #ifndef BROOD_PRECISE\n\
                 #define BROOD_PRECISE precise\n\
                 #endif\n\
                 static const uint brood_zero = 0u;\n\n"
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

impl Language {
    /// Words of the source form in the language.
    fn words(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Glsl => &GLSL_WORDS,
            Self::Hlsl => &HLSL_WORDS,
            Self::Wgsl => &[],
        }
    }

    fn line(self, line: &str) -> String {
        if let Some(head) = line.strip_prefix("fn ") {
            return self.head(head);
        }
        if let Some(table) = line.strip_prefix("var<private> ") {
            return self.table(table);
        }
        let constant = if self == Self::Hlsl { "static const " } else { "const " };
        let local = if self == Self::Hlsl { "BROOD_PRECISE " } else { "" };
        let code = line.trim_start();
        let indentation = &line[..line.len() - code.len()];
        for (keyword, qualifier) in [("let ", local), ("var ", local), ("const ", constant)] {
            if let Some(declaration) = code.strip_prefix(keyword) {
                let (name, value) =
                    declaration.split_once(" = ").expect("declarations have a value");
                // Only numbers are rounded.
                let is_number = [": f32", ": vec2f", ": vec3f"].iter().any(|of| name.ends_with(of));
                let qualifier = if keyword == "const " || is_number { qualifier } else { "" };
                let (name, value) = (self.name(name), self.expression(value));
                return format!("{indentation}{qualifier}{name} = {value}");
            }
        }
        format!("{indentation}{}", self.expression(code))
    }

    /// `name(a: T, b: U) -> R {` as `R name(T a, U b) {`.
    fn head(self, head: &str) -> String {
        let (name, rest) = head.split_once('(').expect("functions have parameters");
        let (parameters, result) = rest.split_once(") -> ").expect("functions have a result");
        let parameters: Vec<String> = match parameters {
            "" => Vec::new(),
            some => some.split(", ").map(|parameter| self.name(parameter)).collect(),
        };
        let result = self.translated_words(result.trim_end_matches(" {"));
        format!("{result} {name}({}) {{", parameters.join(", "))
    }

    /// `name: array<T, N> = array<T, N>(` as `const T name[N] = T[N](`.
    fn table(self, table: &str) -> String {
        let (name, rest) = table.split_once(": array<").expect("only tables are private variables");
        let (of, rest) = rest.split_once(", ").expect("tables have a type");
        let (length, _) = rest.split_once('>').expect("tables have a length");
        let of = self.translated_words(of);
        match self {
            Self::Hlsl => format!("static const {of} {name}[{length}] = {{"),
            _ => format!("const {of} {name}[{length}] = {of}[{length}]("),
        }
    }

    /// A line of a structure.
    fn field(self, line: &str) -> String {
        match line.strip_suffix(',') {
            Some(field) => format!("  {};", self.name(field.trim_start())),
            None if line == "}" => "};".to_owned(),
            None => line.to_owned(),
        }
    }

    /// Function that makes a structure from its fields.
    fn constructor(self, structure: &[&str]) -> String {
        let name = structure[0].trim_start_matches("struct ").trim_end_matches(" {");
        let fields: Vec<&str> =
            structure.iter().filter_map(|line| line.trim().strip_suffix(',')).collect();
        let parameters: Vec<String> = fields.iter().map(|field| self.name(field)).collect();
        let assigned = fields.iter().map(|field| {
            let name = field.split(':').next().unwrap_or_default();
            format!("  made.{name} = {name};\n")
        });
        let assigned: String = assigned.collect();
        let parameters = parameters.join(", ");
        format!(
            "\n{name} make_{name}({parameters}) {{\n  {name} made;\n{assigned}  return made;\n}}\n"
        )
    }

    /// `name: T` as `T name`, and `name: array<T,N>` as `T[N] name` or `T name[N]`.
    fn name(self, declaration: &str) -> String {
        let (name, of) = declaration.split_once(": ").expect("declarations have a type");
        let array =
            of.strip_prefix("array<").and_then(|rest| rest.strip_suffix('>')?.split_once(','));
        let Some((of, length)) = array else {
            return format!("{} {name}", self.translated_words(of));
        };
        let of = self.translated_words(of);
        match self {
            Self::Hlsl => format!("{of} {name}[{length}]"),
            _ => format!("{of}[{length}] {name}"),
        }
    }

    fn translated_words(self, code: &str) -> String {
        let used = self.words().iter().filter(|(word, _)| code.contains(word));
        used.fold(code.to_owned(), |text, (word, of)| text.replace(word, of))
    }

    /// Expression with conditionals, words, and signed shifts, which are unsigned in WGSL.
    fn expression(self, code: &str) -> String {
        let mut code = glsl_of_conditionals(code);
        if self == Self::Hlsl {
            code = hlsl_of_constructors(&code);
        }
        let code = self.translated_words(&code);
        let mut is_shift = false;
        let words = code.split_inclusive(' ').map(|word| {
            let text = if is_shift { word.replacen('u', "", 1) } else { word.to_owned() };
            is_shift = matches!(word, "<< " | ">> ");
            text
        });
        words.collect()
    }
}

/// `vec3f(a)` as `((vec3f)(a))`, and `BroodPair(a, b)` as `make_BroodPair(a, b)`.
fn hlsl_of_constructors(code: &str) -> String {
    let mut text = code.to_owned();
    for name in STRUCTURES {
        text = text.replace(&format!("{name}("), &format!("make_{name}("));
    }
    for of in ["vec2f", "vec3f"] {
        let mut done = 0;
        while let Some(found) = text[done..].find(&format!("{of}(")) {
            let start = done + found;
            let open = start + of.len();
            done = open;
            if let Some(end) = end_of_one_argument(&text[open + 1..]) {
                text.insert(open + 1 + end, ')');
                text.replace_range(start..open, &format!("(({of})"));
                done += 3;
            }
        }
    }
    text
}

/// Place of the closing parenthesis if the arguments after an opening one are one. Arguments that
/// continue on another line are several.
fn end_of_one_argument(arguments: &str) -> Option<usize> {
    let mut depth = 0;
    for (place, c) in arguments.char_indices() {
        match c {
            ',' if depth == 0 => return None,
            ')' if depth == 0 => return Some(place),
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
    }
    None
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
    #[test]
    fn hlsl_has_casts_constructors_and_rounded_locals() {
        let cases = [
            ("const A: f32 = 1.0;", "static const float A = 1.0;\n"),
            ("  let x: f32 = vec3f(a).x;", "  BROOD_PRECISE float x = ((float3)(a)).x;\n"),
            ("  let k: i32 = i32(min(at, 62.0));", "  int k = int(min(at, 62.0));\n"),
            (
                "  return vec3f(0.0) + vec3f(a, f(b, c), d);",
                "  return ((float3)(0.0)) + float3(a, f(b, c), d);\n",
            ),
            ("  let p: BroodPair = BroodPair(a, b);", "  BroodPair p = make_BroodPair(a, b);\n"),
            ("fn f(a: S, b: array<S,2>) -> vec3f {", "float3 f(S a, S b[2]) {\n"),
            (
                "var<private> t: array<f32, 2> = array<f32, 2>(\n  1.0,\n  2.0);",
                "static const float t[2] = {\n  1.0,\n  2.0};\n",
            ),
            (
                "struct S {\n  a: f32,\n}",
                "struct S {\n  float a;\n};\n\nS make_S(float a) {\n  S made;\n  made.a = a;\n  return made;\n}\n",
            ),
            (
                "  return bitcast<f32>(bitcast<u32>(m) << 23u);",
                "  return asfloat(asuint(m) << 23);\n",
            ),
        ];
        for (source, hlsl) in cases {
            assert_eq!(Language::Hlsl.translate(source), hlsl);
        }
    }
}
