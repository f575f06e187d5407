//! The canonical functions in each language, of which a module gets those that it calls.

use brood_program::{Operation, Program};

use crate::language::Language;

/// A function of the library, in the order in which they are defined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Base,
    Sine,
    Ex2,
    Log2,
    Square,
    Lg2,
    Rcp,
    Rsq,
    Spl,
}

impl Function {
    const ALL: [Self; 9] = [
        Self::Base,
        Self::Sine,
        Self::Ex2,
        Self::Log2,
        Self::Square,
        Self::Lg2,
        Self::Rcp,
        Self::Rsq,
        Self::Spl,
    ];

    /// What stands above it in the files.
    fn mark(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Sine => "sine",
            Self::Ex2 => "ex2",
            Self::Log2 => "log2",
            Self::Square => "square",
            Self::Lg2 => "lg2",
            Self::Rcp => "rcp",
            Self::Rsq => "rsq",
            Self::Spl => "spl",
        }
    }

    /// Those that an operation needs, its callees included.
    fn needed_by(operation: Operation) -> &'static [Self] {
        match operation {
            Operation::Add | Operation::Sub | Operation::Mul => &[],
            Operation::Sin | Operation::Cos => &[Self::Sine],
            Operation::Ex2 | Operation::Ex2Neg => &[Self::Ex2],
            Operation::Lg2 => &[Self::Log2, Self::Square, Self::Lg2],
            Operation::Rcp => &[Self::Square, Self::Rcp],
            Operation::Rsq => &[Self::Square, Self::Rsq],
            Operation::Spl | Operation::SplNeg => &[Self::Ex2, Self::Log2, Self::Spl],
        }
    }

    fn text(self, language: Language) -> &'static str {
        let all = match language {
            Language::Glsl => include_str!("functions.glsl"),
            Language::Wgsl => include_str!("functions.wgsl"),
        };
        all.split("// @")
            .find_map(|part| part.strip_prefix(self.mark())?.strip_prefix('\n'))
            .expect("each function is in both files")
    }
}

/// The functions that a program calls.
pub(crate) fn functions(program: &Program, language: Language) -> String {
    let needs = |function: &Function| {
        let mut steps = program.steps().iter();
        *function == Function::Base
            || steps.any(|step| Function::needed_by(step.operation).contains(function))
    };
    Function::ALL.iter().filter(|function| needs(function)).map(|f| f.text(language)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_function_is_in_both_files_and_calls_only_what_comes_before_it() {
        for language in [Language::Glsl, Language::Wgsl] {
            for (place, function) in Function::ALL.into_iter().enumerate() {
                let text = function.text(language);
                assert!(text.contains("brood_"), "{function:?}");
                for later in &Function::ALL[place + 1..] {
                    let call = format!("brood_{}(", later.mark());
                    assert!(!text.contains(&call), "{function:?} calls {later:?}");
                }
            }
        }
    }
}
