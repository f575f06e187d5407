//! Library functions in each language: hand-written texts, of which a module gets those that it
//! calls and those that these call in turn.

use crate::language::Language;

/// Library files of both languages; each calls only earlier ones.
const FILES: [(&str, &str); 8] = [
    (include_str!("functions.glsl"), include_str!("functions.wgsl")),
    (include_str!("model/elementary.glsl"), include_str!("model/elementary.wgsl")),
    (include_str!("model/pair.glsl"), include_str!("model/pair.wgsl")),
    (include_str!("model/fresnel.glsl"), include_str!("model/fresnel.wgsl")),
    (include_str!("model/facet.glsl"), include_str!("model/facet.wgsl")),
    (include_str!("model/lobe.glsl"), include_str!("model/lobe.wgsl")),
    (include_str!("model/principled.glsl"), include_str!("model/principled.wgsl")),
    (include_str!("model/fit.glsl"), include_str!("model/fit.wgsl")),
];
/// Mark above each function, followed by its name without `brood_`.
const MARK: &str = "// @";
/// Function that all others use; every module has it.
const BASE: &str = "base";

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
fn all(language: Language) -> Vec<Function> {
    let files = FILES.map(|(glsl, wgsl)| match language {
        Language::Glsl => glsl,
        Language::Wgsl => wgsl,
    });
    files.into_iter().flat_map(marked).collect()
}

/// Splits a file at its marks.
fn marked(file: &'static str) -> impl Iterator<Item = Function> {
    file.split(MARK).skip(1).map(|part| {
        let (name, text) = part.split_once('\n').expect("a text stands below each mark");
        Function { name, text }
    })
}

/// Returns the functions that a text calls, and those that these call.
pub(crate) fn functions(text: &str, language: Language) -> String {
    let mut called: Vec<Function> = Vec::new();
    for function in all(language).into_iter().rev() {
        let is_called =
            function.is_called_in(text) || called.iter().any(|it| function.is_called_in(it.text));
        if is_called || function.name == BASE {
            called.push(function);
        }
    }
    called.iter().rev().map(|function| function.text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_exist_in_both_languages_and_call_only_earlier_ones() {
        let names = |language| all(language).iter().map(|it| it.name).collect::<Vec<_>>();
        assert_eq!(names(Language::Glsl), names(Language::Wgsl));
        for language in [Language::Glsl, Language::Wgsl] {
            let all = all(language);
            for (place, function) in all.iter().enumerate() {
                // The check also finds the function's own definition in its text.
                assert!(function.is_called_in(function.text) || function.name == BASE);
                for later in &all[place + 1..] {
                    let (name, later_name) = (function.name, later.name);
                    assert!(!later.is_called_in(function.text), "{name} calls {later_name}");
                }
            }
        }
    }

    #[test]
    fn functions_that_are_called_indirectly_are_included_and_no_others() {
        let text = functions("brood_lg2(a)", Language::Wgsl);
        for name in ["brood_hold", "brood_log2", "brood_square", "brood_lg2"] {
            assert!(text.contains(&format!("fn {name}(")), "{name}");
        }
        for name in ["brood_sine", "brood_ex2", "brood_ln"] {
            assert!(!text.contains(&format!("{name}(")), "{name}");
        }
    }
}
