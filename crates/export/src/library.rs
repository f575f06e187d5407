//! The functions that modules call, in each language: hand-written texts, of which a module gets those that it calls and what
//! these call in turn.

use crate::language::Language;

/// The files of both languages, each after those that it calls.
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
/// What stands above each function, before its name without `brood_`.
const MARK: &str = "// @";
/// What all others stand on; every module has it.
const BASE: &str = "base";

/// A function with what it alone needs.
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

/// All functions; each calls only those before it.
fn all(language: Language) -> Vec<Function> {
    let files = FILES.map(|(glsl, wgsl)| match language {
        Language::Glsl => glsl,
        Language::Wgsl => wgsl,
    });
    files.into_iter().flat_map(marked).collect()
}

/// What stands below each mark of a file.
fn marked(file: &'static str) -> impl Iterator<Item = Function> {
    file.split(MARK).skip(1).map(|part| {
        let (name, text) = part.split_once('\n').expect("a text stands below each mark");
        Function { name, text }
    })
}

/// The functions that a text calls, and those that these call.
pub(crate) fn functions(text: &str, language: Language) -> String {
    let mut wanted: Vec<Function> = Vec::new();
    for function in all(language).into_iter().rev() {
        let is_called =
            function.is_called_in(text) || wanted.iter().any(|it| function.is_called_in(it.text));
        if is_called || function.name == BASE {
            wanted.push(function);
        }
    }
    wanted.iter().rev().map(|function| function.text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_in_both_languages_and_call_only_what_comes_before_them() {
        let names = |language| all(language).iter().map(|it| it.name).collect::<Vec<_>>();
        assert_eq!(names(Language::Glsl), names(Language::Wgsl));
        for language in [Language::Glsl, Language::Wgsl] {
            let all = all(language);
            for (place, function) in all.iter().enumerate() {
                // A text that has the function's own head calls it, too.
                assert!(function.is_called_in(function.text) || function.name == BASE);
                for later in &all[place + 1..] {
                    let (name, later_name) = (function.name, later.name);
                    assert!(!later.is_called_in(function.text), "{name} calls {later_name}");
                }
            }
        }
    }

    #[test]
    fn what_is_called_by_what_is_called_comes_too_and_nothing_else() {
        let text = functions("brood_lg2(a)", Language::Wgsl);
        for name in ["brood_hold", "brood_log2", "brood_square", "brood_lg2"] {
            assert!(text.contains(&format!("fn {name}(")), "{name}");
        }
        for name in ["brood_sine", "brood_ex2", "brood_ln"] {
            assert!(!text.contains(&format!("{name}(")), "{name}");
        }
    }
}
