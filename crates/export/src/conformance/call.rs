//! Calls of exported functions of styles, with values in the fields of their structures: those that
//! renderers write by hand, independent of the order in which the printed code reads them.

use brood_brdf::{Input, LightInput, Lighting};
use brood_program::Program;

use crate::format::Format;
use crate::input::is_of_directions;
use crate::language::Language;

/// Call of an exported function of a style.
#[derive(Debug, Clone)]
pub struct StyledCall {
    /// Style whose colour the function returns.
    pub style: Program,
    /// Expression of the call.
    pub code: String,
    /// Inputs whose values the expression reads, in the order of their numbers.
    pub inputs: Vec<Input>,
}

/// Returns calls of `styled`, and of `styled_body` if the style has glass, with values in the
/// fields of their structures; none if the style reads directions, because their fields are 0.
/// `value` returns the expression of the value with a number.
///
/// # Domain
/// The level of each light must be its largest channel.
///
/// # Panics
/// If the format is not a language.
#[must_use]
pub fn styled_calls(
    style: &Program,
    (format, lights): (Format, usize),
    value: impl Fn(usize) -> String,
) -> Vec<StyledCall> {
    let language = format.language().expect("functions are of a language");
    let lighting = Lighting { lights, has_shadows: true };
    if style.painted(lighting).inputs().iter().any(is_of_directions) {
        return Vec::new();
    }
    let call = |name: &str, style: &Program, has_glass| {
        let mut arguments = Arguments { language, value: &value, inputs: Vec::new() };
        let code = arguments.call(name, lights, has_glass);
        StyledCall { style: style.clone(), code, inputs: arguments.inputs }
    };
    match style.glass() {
        Some(_) => {
            vec![call("styled", style, true), call("styled_body", &style.without_glass(), false)]
        }
        None => vec![call("styled", style, false)],
    }
}

/// Printer of arguments, which collects their inputs.
struct Arguments<'a> {
    language: Language,
    value: &'a dyn Fn(usize) -> String,
    inputs: Vec<Input>,
}

impl Arguments<'_> {
    fn call(&mut self, name: &str, lights: usize, has_glass: bool) -> String {
        let mut arguments = vec![self.point()];
        let elements: Vec<String> = (0..lights).map(|light| self.light(light)).collect();
        let array = match self.language {
            Language::Glsl => format!("StyledLight[{lights}]"),
            Language::Wgsl => format!("array<StyledLight,{lights}>"),
            Language::Hlsl => unreachable!("HLSL has no expression for arrays"),
        };
        arguments.push(format!("{array}({})", elements.join(", ")));
        arguments.extend(has_glass.then(|| self.glass()));
        format!("{name}({})", arguments.join(", "))
    }

    fn point(&mut self) -> String {
        let numbers =
            [Input::NormalDotEye, Input::Depth, Input::NormalDotEyeStep, Input::DepthStep];
        let numbers = numbers.map(|input| self.number(input)).join(", ");
        format!("StyledPoint({numbers}, {}(0.0), {}(0.0))", self.vector(3), self.vector(2))
    }

    fn light(&mut self, light: usize) -> String {
        let mut number = |quantity| self.number(Input::of_light(light, quantity));
        let before = [LightInput::Cos, LightInput::Mirror, LightInput::Visibility].map(&mut number);
        let color = [LightInput::Red, LightInput::Green, LightInput::Blue].map(&mut number);
        let after = [LightInput::CosStep, LightInput::MirrorStep].map(number);
        let (before, color, after) = (before.join(", "), color.join(", "), after.join(", "));
        let vector = self.vector(3);
        format!("StyledLight({before}, {vector}({color}), {after}, {vector}(0.0))")
    }

    fn glass(&mut self) -> String {
        let colors = [
            [Input::MirroredRed, Input::MirroredGreen, Input::MirroredBlue],
            [Input::Way0Red, Input::Way0Green, Input::Way0Blue],
            [Input::Way1Red, Input::Way1Green, Input::Way1Blue],
        ];
        let lengths = [Input::MirroredLength, Input::Way0Length, Input::Way1Length];
        let vector = self.vector(3);
        let ways = colors.into_iter().zip(lengths).map(|(color, length)| {
            let color = color.map(|input| self.number(input)).join(", ");
            format!("{vector}({color}), {}", self.number(length))
        });
        let ways: Vec<String> = ways.collect();
        format!("StyledGlass({}, {})", ways.join(", "), self.number(Input::Way0Share))
    }

    fn number(&mut self, input: Input) -> String {
        self.inputs.push(input);
        (self.value)(self.inputs.len() - 1)
    }

    fn vector(&self, size: usize) -> String {
        match self.language {
            Language::Glsl => format!("vec{size}"),
            Language::Wgsl => format!("vec{size}f"),
            Language::Hlsl => format!("float{size}"),
        }
    }
}
