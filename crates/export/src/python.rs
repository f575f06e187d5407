//! Translation of the source form to Python, for arrays of the just-in-time compiler Dr.Jit.
//!
//! Functions are vectorised: each number is an array, so conditions choose between values that are
//! both computed. A guard (`if` with a `return`) becomes a choice in the final return. The names
//! that the translation calls (`vec3f`, `select`, `as_u32`, ...) are defined by the module that the
//! code is part of.

use std::fmt::Write;

/// Calls of the source form that have other names in Python. Longer ones come first.
const CALLS: [(&str, &str); 17] = [
    ("bitcast<u32>(", "as_u32("),
    ("bitcast<f32>(", "as_f32("),
    ("bitcast<i32>(", "as_i32("),
    ("f32(", "mi.Float("),
    ("i32(", "mi.Int32("),
    ("u32(", "mi.UInt32("),
    ("max(", "dr.maximum("),
    ("min(", "dr.minimum("),
    ("clamp(", "dr.clip("),
    ("abs(", "dr.abs("),
    ("sqrt(", "dr.sqrt("),
    ("floor(", "dr.floor("),
    ("log(", "dr.log("),
    ("dot(", "dr.dot("),
    ("cross(", "dr.cross("),
    ("normalize(", "dr.normalize("),
    ("length(", "dr.norm("),
];
/// Functions that compute with the bits of their argument, and so without its derivative: their
/// values get the derivative of another function.
const DERIVATIVES: [(&str, &str); 3] = [
    ("brood_sine", "dr.sin(t) if quarter == 0 else dr.cos(t)"),
    ("brood_ex2", "dr.exp2(t)"),
    ("brood_log2", "dr.log2(t)"),
];
/// Function that keeps compilers from fusing operations. Dr.Jit's compiler for processors does not
/// fuse them; that for CUDA may, which costs a few units in the last place.
const HOLD: &str = "brood_hold";

/// A function that is being translated.
#[derive(Default)]
struct Body {
    name: String,
    /// Condition and value of a guard.
    guard: Option<(String, String)>,
}

/// Translates code of the source form.
pub(crate) fn translate(source: &str) -> String {
    let mut text = String::with_capacity(source.len());
    let mut body = Body::default();
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        let code = line.trim_start();
        if let Some(comment) = code.strip_prefix("//") {
            let indentation = &line[..line.len() - code.len()];
            line_of(&mut text, &format!("{}#{comment}", indentation.repeat(2)));
        } else if let Some(name) = code.strip_prefix("struct ") {
            let fields = lines.by_ref().take_while(|line| *line != "}");
            structure(&mut text, name.trim_end_matches(" {"), fields);
        } else if let Some(table) = code.strip_prefix("var<private> ") {
            let (name, _) = table.split_once(": ").expect("tables have a type");
            let rows = statement(&mut lines, "").trim_start().replace(");", "");
            write!(text, "{name} = Table([\n{rows}])\n").expect("a string takes everything");
        } else if let Some(head) = code.strip_prefix("fn ") {
            body = Body::default();
            line_of(&mut text, &head_of(head, &mut body));
        } else if let Some(condition) = code.strip_prefix("if (") {
            let condition = condition.trim_end_matches(") {");
            let value = lines.next().and_then(|line| line.trim_start().strip_prefix("return "));
            let value = value.expect("guards return").trim_end_matches(';');
            lines.next();
            body.guard = Some((expression(condition), expression(value)));
        } else if code == "}" || code.is_empty() {
            text.push('\n');
        } else {
            let whole = statement(&mut lines, line);
            line_of(&mut text, &assignment(&whole, &body));
        }
    }
    text
}

fn line_of(text: &mut String, line: &str) {
    text.push_str(line);
    text.push('\n');
}

/// Reads on to the end of a statement that begins with a line.
fn statement<'a>(lines: &mut impl Iterator<Item = &'a str>, first: &str) -> String {
    let mut whole = first.to_owned();
    while !whole.ends_with(';') {
        whole += "\n";
        whole += lines.next().expect("statements end with a semicolon");
    }
    whole
}

fn structure<'a>(text: &mut String, name: &str, fields: impl Iterator<Item = &'a str>) {
    let fields = fields.filter_map(|field| field.trim_start().split_once(": "));
    let fields: Vec<String> = fields.map(|(field, _)| format!("\"{field}\"")).collect();
    line_of(text, &format!("{name} = collections.namedtuple(\"{name}\", [{}])", fields.join(", ")));
}

/// `name(a: T, b: U) -> R {` as `def name(a, b):`.
fn head_of(head: &str, body: &mut Body) -> String {
    let (name, rest) = head.split_once('(').expect("functions have parameters");
    let (parameters, _) = rest.split_once(") -> ").expect("functions have a result");
    name.clone_into(&mut body.name);
    let names: Vec<&str> = parameters
        .split(", ")
        .filter_map(|parameter| parameter.split_once(": "))
        .map(|(name, _)| name)
        .collect();
    format!("def {name}({}):", names.join(", "))
}

/// A declaration, assignment, constant or return, without its semicolon.
fn assignment(whole: &str, body: &Body) -> String {
    let code = whole.trim_start().trim_end_matches(';');
    let indentation = " ".repeat(2 * (whole.len() - whole.trim_start().len()));
    if let Some(value) = code.strip_prefix("return ") {
        return format!("{indentation}return {}", result(value, body));
    }
    let declaration = ["let ", "var ", "const "].iter().find_map(|word| code.strip_prefix(word));
    let (name, value) =
        declaration.unwrap_or(code).split_once(" = ").expect("statements assign or return");
    let name = name.split(": ").next().expect("split gives at least one part");
    format!("{indentation}{name} = {}", in_parentheses(expression(value)))
}

fn result(value: &str, body: &Body) -> String {
    if body.name == HOLD {
        return "a".to_owned();
    }
    let value = in_parentheses(expression(value));
    if let Some((condition, other)) = &body.guard {
        return format!("select({value}, {other}, {condition})");
    }
    match DERIVATIVES.iter().find(|(name, _)| *name == body.name) {
        Some((_, derivative)) => format!("with_derivative({value}, {derivative})"),
        None => value,
    }
}

fn in_parentheses(value: String) -> String {
    if value.contains('\n') { format!("({value})") } else { value }
}

/// An expression. Operands of `&&` and `||` must be in parentheses.
fn expression(code: &str) -> String {
    let mut text = String::with_capacity(code.len());
    let mut rest = code;
    let mut before = ' ';
    while let Some(first) = rest.chars().next() {
        let is_word_start = !(before.is_alphanumeric() || before == '_' || before == '.');
        let call = CALLS.iter().find(|(call, _)| is_word_start && rest.starts_with(call));
        let number = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let (taken, replacement) = if let Some((call, name)) = call {
            (call.len(), (*name).to_owned())
        } else if rest.starts_with("&&") || rest.starts_with("||") {
            (2, rest[..1].to_owned())
        } else if rest.starts_with("!(") {
            (1, "~".to_owned())
        } else if is_word_start && first.is_ascii_digit() && rest[..number].ends_with('u') {
            (number, rest[..number - 1].to_owned())
        } else {
            (first.len_utf8(), first.to_string())
        };
        before = rest[..taken].chars().next_back().unwrap_or(' ');
        text += &replacement;
        rest = &rest[taken..];
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn source_form_is_translated() {
        let cases = [
            ("// f32 stays.", "# f32 stays.\n"),
            ("const A: f32 = 1.0;", "A = 1.0\n"),
            ("const B: u32 = 0xff00u;", "B = 0xff00\n"),
            (
                "struct S {\n  a: f32,\n  b: vec3f,\n}",
                "S = collections.namedtuple(\"S\", [\"a\", \"b\"])\n",
            ),
            (
                "var<private> t: array<f32, 2> = array<f32, 2>(\n  1.0,\n  2.0);",
                "t = Table([\n1.0,\n  2.0])\n",
            ),
            ("fn f(p: S, k: i32) -> f32 {\n  return p.a;\n}", "def f(p, k):\n    return p.a\n\n"),
            (
                "fn brood_hold(a: f32) -> f32 {\n  return bitcast<f32>(a);\n}",
                "def brood_hold(a):\n    return a\n\n",
            ),
            (
                "fn brood_log2(t: f32) -> f32 {\n  return t + 1.0;\n}",
                "def brood_log2(t):\n    return with_derivative(t + 1.0, dr.log2(t))\n\n",
            ),
            (
                "fn f(a: f32) -> f32 {\n  if (!((a > 0.0) && (a < 1.0))) {\n    return 0.0;\n  }\n  return a\n    + a;\n}",
                "def f(a):\n    return select((a\n    + a), 0.0, ~((a > 0.0) & (a < 1.0)))\n\n",
            ),
            ("  let x: bool = a > 0.5;", "    x = a > 0.5\n"),
            (
                "  x = brood_limit(max(a.xy, vec2f(b)));",
                "    x = brood_limit(dr.maximum(a.xy, vec2f(b)))\n",
            ),
            ("  let i: f32 = f32(bitcast<i32>(k) >> 23u);", "    i = mi.Float(as_i32(k) >> 23)\n"),
        ];
        for (source, python) in cases {
            assert_eq!(translate(source), python);
        }
    }
}
