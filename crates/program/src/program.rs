//! The program: scalar operations in single-assignment form, in a canonical order, and what their
//! results stand for.

use brood_genome::{Effect, Input, InputMask, Model, Output};

use crate::Operation;

/// A folded constant with its value in each arithmetic.
#[derive(Debug, Clone, Copy)]
pub struct Constant {
    /// Value in canonical f32.
    pub canonical: f32,
    /// Value in the f64 reference.
    pub reference: f64,
}

impl PartialEq for Constant {
    fn eq(&self, other: &Self) -> bool {
        self.canonical.to_bits() == other.canonical.to_bits()
            && self.reference.to_bits() == other.reference.to_bits()
    }
}

/// Source of a value that an operation reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operand {
    /// The result of an earlier step.
    Step(u16),
    /// An input of the sample.
    Input(Input),
    /// A constant of the program.
    Constant(u16),
}

/// One operation and its operands; `b` repeats `a` for a unary operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Operation of the step.
    pub operation: Operation,
    /// First operand.
    pub a: Operand,
    /// Second operand.
    pub b: Operand,
}

/// Meaning of the results of a program.
#[derive(Debug, Clone, PartialEq)]
pub enum Meaning {
    /// g of a BRDF: f is g^2 plus the reflectance of the layers, through the output stage.
    Reflectance,
    /// Effects of a painted material. The results are those of its program, which shifts the amount
    /// of light; all 0 without one. If the light effect is `by brdf`, all but the effects is the
    /// BRDF that they paint: see [`Program::brdf`]. A style is lowered for a number of lights
    /// before it is evaluated: see [`Program::painted`].
    Style(Vec<Effect>),
    /// Colours of a display, within [0, 1].
    Color,
    /// Slopes of bumps.
    Slopes,
}

/// Live scalar code: steps that read only earlier steps, three results, layers of models, and the
/// output stage.
///
/// # Invariants
/// Every step is reachable from a result. Steps are in post-order from the red, the green and the
/// blue result, so equal programs have equal words whatever genome they came from. Results are g up
/// to sign, colours, or slopes up to sign. Only BRDFs, and styles that paint one, have layers and
/// an output stage; only BRDFs have bumps.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    pub(crate) steps: Vec<Step>,
    pub(crate) constants: Vec<Constant>,
    pub(crate) results: [Operand; 3],
    pub(crate) output: Output,
    pub(crate) layers: Vec<Model>,
    pub(crate) meaning: Meaning,
    pub(crate) bumps: Option<Box<Bumps>>,
}

/// Slopes of the bumps of a material over the texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Bumps {
    pub(crate) code: Program,
    pub(crate) is_negative: [bool; 2],
}

impl Bumps {
    /// Code whose results are the slopes along u and v, up to sign, and 0.
    #[must_use]
    pub fn code(&self) -> &Program {
        &self.code
    }

    /// True for the slopes, along u and along v, whose sign the code leaves out.
    #[must_use]
    pub fn is_negative(&self) -> [bool; 2] {
        self.is_negative
    }
}

impl Program {
    /// Returns the operations in the order of execution.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Returns the constants that operands refer to.
    #[must_use]
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Returns the operands that hold g of red, green and blue up to sign, or colours.
    #[must_use]
    pub fn results(&self) -> &[Operand; 3] {
        &self.results
    }

    /// Returns the output stage.
    #[must_use]
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// Returns the models whose reflectance is added to g^2; they read directions, not inputs.
    #[must_use]
    pub fn layers(&self) -> &[Model] {
        &self.layers
    }

    /// Returns the bumps, which turn the normal before the directions are measured from it; `None`
    /// if the surface is as the mesh.
    #[must_use]
    pub fn bumps(&self) -> Option<&Bumps> {
        self.bumps.as_deref()
    }

    /// Returns the meaning of the results.
    #[must_use]
    pub fn meaning(&self) -> &Meaning {
        &self.meaning
    }

    /// True if the program is of a painted material, not of a BRDF.
    #[must_use]
    pub fn is_painted(&self) -> bool {
        self.meaning != Meaning::Reflectance
    }

    /// True if the program is a style that paints what its BRDF reflects.
    #[must_use]
    pub fn is_by_brdf(&self) -> bool {
        matches!(&self.meaning, Meaning::Style(effects) if effects.iter().any(Effect::is_by_brdf))
    }

    /// Returns the BRDF of the program: of a style the one that it paints, of a BRDF itself. `None`
    /// if there is none.
    #[must_use]
    pub fn brdf(&self) -> Option<Self> {
        let has_brdf = !self.is_painted() || self.is_by_brdf();
        has_brdf.then(|| Self { meaning: Meaning::Reflectance, ..self.clone() })
    }

    /// True if the results are colours of a display.
    #[must_use]
    #[inline]
    pub fn is_color(&self) -> bool {
        matches!(self.meaning, Meaning::Color)
    }

    /// Returns the same code without layers, output stage and bumps: g^2 alone.
    #[must_use]
    pub fn bare(&self) -> Self {
        Self { output: Output::IDENTITY, layers: Vec::new(), bumps: None, ..self.clone() }
    }

    /// Returns the program without bumps: the BRDF about the normal that they turn.
    #[must_use]
    pub fn without_bumps(self) -> Self {
        Self { bumps: None, ..self }
    }

    /// Returns the program at one texture position: the inputs u and v become constants. The values
    /// have the same bits as those of samples at that position; the code is not in canonical order.
    #[must_use]
    pub fn at_texture_position(&self, u: f32, v: f32) -> Self {
        let mut program = self.clone();
        let first = u16::try_from(program.constants.len())
            .expect("a program has far fewer constants than operands can number");
        let constant = |value: f32| Constant { canonical: value, reference: f64::from(value) };
        program.constants.extend([constant(u), constant(v)]);
        let fixed = |operand: &mut Operand| match operand {
            Operand::Input(Input::U) => *operand = Operand::Constant(first),
            Operand::Input(Input::V) => *operand = Operand::Constant(first + 1),
            Operand::Input(_) | Operand::Step(_) | Operand::Constant(_) => {}
        };
        for step in &mut program.steps {
            fixed(&mut step.a);
            fixed(&mut step.b);
        }
        program.results.iter_mut().for_each(fixed);
        program
    }

    /// Returns the number of scalar operations per sample, without the squares and the output
    /// stage.
    #[must_use]
    pub fn operations(&self) -> usize {
        self.steps.len()
    }

    /// Returns the program whose reflectance is this program's divided by `divisor`; see
    /// [`Output::divided`]. A program without a BRDF stays as it is.
    #[must_use]
    pub fn divided(self, divisor: f64) -> Self {
        if self.is_painted() && !self.is_by_brdf() {
            return self;
        }
        Self { output: self.output.divided(divisor), ..self }
    }

    /// Returns the inputs that the program reads; no other input needs to be computed for it.
    #[must_use]
    pub fn inputs(&self) -> InputMask {
        let mut mask = InputMask::EMPTY;
        let mut read = |operand| {
            if let Operand::Input(input) = operand {
                mask.insert(input);
            }
        };
        for step in &self.steps {
            read(step.a);
            read(step.b);
        }
        self.results.into_iter().for_each(read);
        mask
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{Genome, ModelKind};

    use super::*;

    #[test]
    fn bare_program_has_neither_layers_nor_output_stage() {
        let models = vec![Model::new(ModelKind::Lambert)];
        let program = Program::lower(&Genome::of_models(models).unwrap()).divided(2.0);
        assert_eq!(program.output(), &Output::IDENTITY.divided(2.0));
        assert_eq!(program.layers().len(), 1);
        let bare = program.bare();
        assert_eq!((bare.output(), bare.layers()), (&Output::IDENTITY, &[][..]));
        assert_eq!(bare.steps(), program.steps());
    }

    #[test]
    fn constants_are_equal_when_both_values_have_the_same_bits() {
        let constant = |canonical, reference| Constant { canonical, reference };
        assert_eq!(constant(0.1, 0.1), constant(0.1, 0.1));
        assert_ne!(constant(0.1, 0.1), constant(0.1, 0.2));
        assert_ne!(constant(0.1, 0.1), constant(0.2, 0.1));
        assert_ne!(constant(0.0, 0.0), constant(-0.0, 0.0));
    }
}
