//! The program: scalar operations in single-assignment form, in a canonical order, and the models that lie over it.

use brood_genome::{Input, InputMask, Model, Output};

/// A scalar operation. Signs are part of the operation, never of an operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Operation {
    /// a + b.
    Add,
    /// a - b.
    Sub,
    /// a b.
    Mul,
    /// sin a.
    Sin,
    /// cos a.
    Cos,
    /// 2^a.
    Ex2,
    /// 2^-a.
    Ex2Neg,
    /// log2(a^2 + 2^-24).
    Lg2,
    /// a / (a^2 + 2^-24).
    Rcp,
    /// 1 / sqrt(a^2 + 2^-24).
    Rsq,
    /// log2(1 + 2^a).
    Spl,
    /// log2(1 + 2^-a).
    SplNeg,
}

impl Operation {
    /// All operations in the order of their numbers, which packed words and shaders carry.
    pub const ALL: [Self; 12] = [
        Self::Add,
        Self::Sub,
        Self::Mul,
        Self::Sin,
        Self::Cos,
        Self::Ex2,
        Self::Ex2Neg,
        Self::Lg2,
        Self::Rcp,
        Self::Rsq,
        Self::Spl,
        Self::SplNeg,
    ];

    /// Position in [`Operation::ALL`].
    #[must_use]
    pub fn number(self) -> u8 {
        self as u8
    }

    /// Whether it takes a second operand.
    #[must_use]
    pub fn is_binary(self) -> bool {
        match self {
            Self::Add | Self::Sub | Self::Mul => true,
            Self::Sin | Self::Cos | Self::Ex2 | Self::Ex2Neg => false,
            Self::Lg2 | Self::Rcp | Self::Rsq | Self::Spl | Self::SplNeg => false,
        }
    }

    /// The name in listings and shaders.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Add => "add",
            Self::Sub => "sub",
            Self::Mul => "mul",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Ex2 => "ex2",
            Self::Ex2Neg => "ex2_neg",
            Self::Lg2 => "lg2",
            Self::Rcp => "rcp",
            Self::Rsq => "rsq",
            Self::Spl => "spl",
            Self::SplNeg => "spl_neg",
        }
    }
}

/// A folded constant with the value it has in either arithmetic.
#[derive(Debug, Clone, Copy)]
pub struct Constant {
    /// In canonical f32.
    pub canonical: f32,
    /// In the f64 reference.
    pub reference: f64,
}

impl PartialEq for Constant {
    fn eq(&self, other: &Self) -> bool {
        self.canonical.to_bits() == other.canonical.to_bits()
            && self.reference.to_bits() == other.reference.to_bits()
    }
}

/// Where an operation reads a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operand {
    /// The result of an earlier step.
    Step(u16),
    /// An input of the sample.
    Input(Input),
    /// A constant of the program.
    Constant(u16),
}

/// One operation and its operands; `b` repeats `a` where the operation takes one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// What is done.
    pub operation: Operation,
    /// First operand.
    pub a: Operand,
    /// Second operand.
    pub b: Operand,
}

/// Live scalar code: steps that read only earlier steps, three results, layers of models, and the output stage.
///
/// # Invariants
/// Every step is reachable from a result; steps are in post-order from the red, the green, the blue result, so that
/// equal programs have equal words whatever genome they came from. Results are g up to sign: f squares them, and adds what
/// the layers reflect before the output stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    pub(crate) steps: Vec<Step>,
    pub(crate) constants: Vec<Constant>,
    pub(crate) results: [Operand; 3],
    pub(crate) output: Output,
    pub(crate) layers: Vec<Model>,
}

impl Program {
    /// The operations in the order of execution.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The constants that operands name.
    #[must_use]
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Where g of red, green and blue is found, up to sign.
    #[must_use]
    pub fn results(&self) -> &[Operand; 3] {
        &self.results
    }

    /// The output stage.
    #[must_use]
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// Models whose reflectance is added to g^2; they read directions, not inputs.
    #[must_use]
    pub fn layers(&self) -> &[Model] {
        &self.layers
    }

    /// The same code without its layers and with no output stage: g^2 alone.
    #[must_use]
    pub fn bare(&self) -> Self {
        Self { output: Output::IDENTITY, layers: Vec::new(), ..self.clone() }
    }

    /// Scalar operations per sample, the squares and the output stage not counted.
    #[must_use]
    pub fn operations(&self) -> usize {
        self.steps.len()
    }

    /// The program whose reflectance is this one's divided by a number; see [`Output::divided`].
    #[must_use]
    pub fn divided(self, divisor: f64) -> Self {
        Self { output: self.output.divided(divisor), ..self }
    }

    /// The inputs it reads; nothing else need be computed for it.
    #[must_use]
    pub fn inputs(&self) -> InputMask {
        let mut mask = InputMask::EMPTY;
        let mut note = |operand| {
            if let Operand::Input(input) = operand {
                mask.insert(input);
            }
        };
        for step in &self.steps {
            note(step.a);
            note(step.b);
        }
        self.results.into_iter().for_each(note);
        mask
    }
}
