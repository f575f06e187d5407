//! Interpreter of genomes as written: the test oracle for lowered programs.

use crate::expand::{ScalarMachine, expand};
use crate::{Arithmetic, Function, Genome, Input, Liveness};

/// Runs a genome for one sample and returns the reflectance of the three channels.
///
/// # Shapes
/// `inputs` returns the value of an input; the result is (red, green, blue).
///
/// # Domain
/// Inputs within `[-65504, 65504]`. The result is finite and not negative. Layers are not included.
pub fn interpret<T: Arithmetic>(genome: &Genome, inputs: impl Fn(Input) -> T) -> [T; 3] {
    let g = expand(genome, &Liveness::written(genome), &mut Numbers { inputs });
    genome.output().apply(g.map(T::square))
}

/// Computes with the numbers of one sample.
pub(crate) struct Numbers<I> {
    /// Returns the value of an input.
    pub(crate) inputs: I,
}

impl<T: Arithmetic, I: Fn(Input) -> T> ScalarMachine for Numbers<I> {
    type Value = T;

    fn constant(&mut self, value: f32) -> T {
        T::from_f32(value)
    }

    fn input(&mut self, input: Input) -> T {
        (self.inputs)(input)
    }

    fn neg(&mut self, a: T) -> T {
        a.neg()
    }

    fn add(&mut self, a: T, b: T) -> T {
        a.add(b)
    }

    fn mul(&mut self, a: T, b: T) -> T {
        a.mul(b)
    }

    fn function(&mut self, function: Function, a: T) -> T {
        a.function(function)
    }
}
