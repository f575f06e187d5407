//! Library functions: hand-written texts in the source form, of which a module gets those that it
//! calls and those that these call in turn.

use brood_genome::Functions;

/// Library files; each calls only earlier ones. `model/plastic` is not among them, because it is
/// printed once for each layer.
const FILES: [&str; 8] = [
    include_str!("functions.wgsl"),
    include_str!("model/elementary.wgsl"),
    include_str!("model/pair.wgsl"),
    include_str!("model/fresnel.wgsl"),
    include_str!("model/facet.wgsl"),
    include_str!("model/lobe.wgsl"),
    include_str!("model/principled.wgsl"),
    include_str!("model/fit.wgsl"),
];
/// Mark above each function, followed by its name without `brood_`.
const MARK: &str = "// @";
/// Function that all others use; every module has it.
const BASE: &str = "base";
/// Prefix of the names of constants.
const CONSTANT_PREFIX: &str = "BROOD_";

/// A library function and its text.
#[derive(Debug, Clone, Copy)]
struct Function {
    name: &'static str,
    text: &'static str,
}

impl Function {
    fn is_called_in(&self, text: &str) -> bool {
        text.contains(&format!("brood_{}(", self.name))
    }
}

/// Returns all functions; each calls only earlier ones.
fn all() -> Vec<Function> {
    FILES.into_iter().flat_map(marked).collect()
}

/// Splits a file at its marks.
fn marked(file: &'static str) -> impl Iterator<Item = Function> {
    file.split(MARK).skip(1).map(|part| {
        let (name, text) = part.split_once('\n').expect("a text stands below each mark");
        Function { name, text }
    })
}

/// Returns the functions that a text calls and those that these call.
pub(crate) fn functions(text: &str) -> String {
    let mut called: Vec<Function> = Vec::new();
    for function in all().into_iter().rev() {
        let is_called =
            function.is_called_in(text) || called.iter().any(|it| function.is_called_in(it.text));
        if is_called || function.name == BASE {
            called.push(function);
        }
    }
    called.iter().rev().map(|function| function.text).collect()
}

/// Returns declarations of those constants of the elementary functions that are named. Numbers have
/// shortest digits, which read back to the same bits.
pub(crate) fn constants(is_named: impl Fn(&str) -> bool) -> String {
    let numbers = Functions::constants().into_iter();
    let numbers = numbers.map(|(name, value)| (name, format!("f32 = {value:?}")));
    let bits = Functions::BIT_CONSTANTS.into_iter();
    let bits = bits.map(|(name, bits)| (name.to_owned(), format!("u32 = {bits:#010x}u")));
    let all = numbers.chain(bits).map(|(name, value)| (format!("{CONSTANT_PREFIX}{name}"), value));
    let named = all.filter(|(name, _)| is_named(name));
    named.map(|(name, value)| format!("const {name}: {value};\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number literals of code, without comments.
    fn literals(text: &str) -> impl Iterator<Item = &str> {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let is_part = |c: char| c.is_alphanumeric() || c == '.' || c == '_';
        let words = code.flat_map(move |line| line.split(move |c: char| !is_part(c)));
        words.filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
    }

    #[test]
    fn hand_written_functions_contain_no_coefficient() {
        const STRUCTURAL: &str = "0.0 0u 0.5 1.0 1.5 1u 2.0 2u 23u 30u 0xff800000u 0x3f800000u";
        for function in marked(FILES[0]) {
            for literal in literals(function.text) {
                let is_structural = STRUCTURAL.split(' ').any(|it| it == literal);
                assert!(is_structural, "{literal} in {}", function.name);
            }
        }
    }

    #[test]
    fn constants_read_back_to_the_bits_of_the_twin() {
        let text = constants(|_| true);
        let mut values = text.lines().map(|line| {
            line.split_once(" = ").and_then(|(_, value)| value.strip_suffix(';')).unwrap()
        });
        for (name, value) in Functions::constants() {
            let digits = values.next().unwrap();
            let bits = [digits.parse::<f32>().unwrap(), digits.parse::<f64>().unwrap() as f32];
            assert_eq!(bits.map(f32::to_bits), [value.to_bits(); 2], "{name} {digits}");
        }
        for (name, bits) in Functions::BIT_CONSTANTS {
            let digits = values.next().unwrap().strip_prefix("0x").unwrap();
            let digits = digits.strip_suffix('u').unwrap();
            assert_eq!(u32::from_str_radix(digits, 16), Ok(bits), "{name}");
        }
        assert_eq!(values.next(), None);
    }

    #[test]
    fn constants_have_the_bits_of_the_twin_to_a_compiler() {
        let module = naga::front::wgsl::parse_str(&constants(|_| true)).unwrap();
        let found = |name: &str| {
            let name = format!("{CONSTANT_PREFIX}{name}");
            let (_, constant) =
                module.constants.iter().find(|(_, it)| it.name.as_ref() == Some(&name)).unwrap();
            match module.global_expressions[constant.init] {
                naga::Expression::Literal(naga::Literal::F32(value)) => value.to_bits(),
                naga::Expression::Literal(naga::Literal::U32(bits)) => bits,
                ref other => panic!("{name}: {other:?}"),
            }
        };
        for (name, value) in Functions::constants() {
            assert_eq!(found(&name), value.to_bits(), "{name}");
        }
        for (name, bits) in Functions::BIT_CONSTANTS {
            assert_eq!(found(name), bits, "{name}");
        }
    }

    #[test]
    fn only_constants_that_are_named_are_declared() {
        let text = functions("brood_lg2(a)");
        let text = constants(|name| text.contains(name));
        assert!(text.contains("BROOD_LG2_9") && !text.contains("BROOD_SIN_0"), "{text}");
    }

    #[test]
    fn functions_call_only_earlier_ones() {
        let all = all();
        for (place, function) in all.iter().enumerate() {
            // The check also finds the function's own definition in its text.
            assert!(function.is_called_in(function.text) || function.name == BASE);
            for later in &all[place + 1..] {
                let (name, later_name) = (function.name, later.name);
                assert!(!later.is_called_in(function.text), "{name} calls {later_name}");
            }
        }
    }

    #[test]
    fn functions_that_are_called_indirectly_are_included_and_no_others() {
        let text = functions("brood_lg2(a)");
        for name in ["brood_hold", "brood_log2", "brood_square", "brood_lg2"] {
            assert!(text.contains(&format!("fn {name}(")), "{name}");
        }
        for name in ["brood_sine", "brood_ex2", "brood_ln"] {
            assert!(!text.contains(&format!("{name}(")), "{name}");
        }
    }
}
