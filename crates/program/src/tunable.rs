//! Programs whose constants can be tuned and written back into the genome.

use brood_genome::{CONSTANTS, Genome, RANGE, expand};

use crate::Program;
use crate::lower::{SCRATCH, Scratch};

/// A program that keeps each constant of its genome as a separate parameter.
#[derive(Debug, Clone)]
pub struct Tunable {
    program: Program,
    /// Register and component in the genome of each constant of the program.
    places: Vec<Option<(u8, u8)>>,
}

impl Tunable {
    /// Lowers a genome without folding its constants: more operations than [`Program::lower`]
    /// leaves, with the same result to the bit.
    #[must_use]
    pub fn lower(genome: &Genome) -> Self {
        SCRATCH.with_borrow_mut(|Scratch { liveness, builder, collected }| {
            liveness.find(genome);
            builder.clear(true);
            let results = expand(genome, liveness, builder);
            let program = collected.collect(builder, results, genome);
            let narrow =
                |part: u32| u8::try_from(part).expect("registers and components are below 256");
            let place = |index: &u32| {
                let place = builder.place_of(*index)?;
                Some((narrow(place / 4), narrow(place % 4)))
            };
            Self { places: collected.sources.iter().map(place).collect(), program }
        })
    }

    /// Returns the program.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Returns for each constant of the program its register and component in the genome; `None` if
    /// it is not a constant of the genome.
    #[must_use]
    pub fn places(&self) -> &[Option<(u8, u8)>] {
        &self.places
    }

    /// Sets a constant of the program to the nearest number within the range of the machine.
    ///
    /// # Panics
    /// If the program has no constant of that index, or it is not a constant of the genome.
    #[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
    pub fn set(&mut self, index: usize, value: f64) {
        assert!(self.places[index].is_some(), "constant {index} is not a constant of the genome");
        let canonical = (value as f32).clamp(-RANGE, RANGE);
        let constant = &mut self.program.constants[index];
        (constant.canonical, constant.reference) = (canonical, f64::from(canonical));
    }

    /// Returns the genome with these constants.
    #[must_use]
    pub fn write(&self, genome: &Genome) -> Genome {
        let mut constants: Box<[[f32; 4]; CONSTANTS]> = Box::new(*genome.constants());
        for (constant, place) in self.program.constants.iter().zip(&self.places) {
            if let Some((register, component)) = place {
                constants[usize::from(*register)][usize::from(*component)] = constant.canonical;
            }
        }
        genome.clone().with_constants(constants)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_set_within_the_range_of_the_machine() {
        let text = "brood 1\n.dialect extended smooth registers 10\n.const C0 2 3 4 0\n\
                    MUL R0.xyz, C0, C0\n";
        let genome: Genome = text.parse().unwrap();
        let mut tunable = Tunable::lower(&genome);
        let range = f64::from(RANGE);
        for (value, expected) in [(0.1, f64::from(0.1f32)), (1e9, range), (-1e9, -range)] {
            let index = tunable.places().iter().position(Option::is_some).unwrap();
            tunable.set(index, value);
            assert_eq!(tunable.program().constants()[index].reference, expected);
        }
        let written = tunable.write(&genome).constants()[0];
        assert_eq!(written.iter().filter(|number| **number == -RANGE).count(), 1, "{written:?}");
    }
}
