//! Writer of the text form.

use std::fmt;

use crate::{Bump, Dialect, Genome, OpcodeSet, Output, Parametrisation};

impl fmt::Display for Genome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "brood 1")?;
        // Left out for models or effects alone under the default dialect, which the parser assumes
        // then.
        if *self.dialect() != (Dialect { length: 0, ..Dialect::default() }) {
            writeln!(f, ".dialect {}", self.dialect())?;
        }
        write_output(f, self.output())?;
        if self.is_limited() {
            writeln!(f, ".limit on")?;
        }
        write_constants(f, self, ".const")?;
        self.bump().into_iter().try_for_each(|bump| write!(f, "{bump}"))?;
        self.layers().iter().try_for_each(|model| write!(f, "{model}"))?;
        self.effects().iter().try_for_each(|effect| write!(f, "{effect}"))?;
        // Instructions must be the last lines: the page marks them one by one.
        self.instructions().iter().try_for_each(|instruction| writeln!(f, "{instruction}"))
    }
}

impl fmt::Display for Bump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, ".bump strength {}", number(self.strength()))?;
        write_constants(f, self.program(), ".bump const")?;
        let mut instructions = self.program().instructions().iter();
        instructions.try_for_each(|instruction| writeln!(f, ".bump {instruction}"))
    }
}

/// Writes the constants that are not 0.
fn write_constants(f: &mut fmt::Formatter<'_>, of: &Genome, directive: &str) -> fmt::Result {
    for (index, constant) in of.constants().iter().enumerate() {
        if constant.iter().any(|value| value.to_bits() != 0) {
            let [x, y, z, w] = constant.map(number);
            writeln!(f, "{directive} C{index} {x} {y} {z} {w}")?;
        }
    }
    Ok(())
}

impl fmt::Display for Dialect {
    /// Writes the words of the `.dialect` line. The length is left out: it is the number of
    /// instructions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let opcodes = match self.opcodes {
            OpcodeSet::Paper => "paper",
            OpcodeSet::Extended => "extended",
            OpcodeSet::Directed => "directed",
            OpcodeSet::Surface => "surface",
        };
        let parametrisation = match self.parametrisation {
            Parametrisation::Smooth => "smooth",
            Parametrisation::Paper => "paper",
        };
        let isotropic = if self.isotropic { " isotropic" } else { "" };
        let homogeneous = if self.homogeneous { " homogeneous" } else { "" };
        let registers = self.registers;
        write!(f, "{opcodes} {parametrisation} registers {registers}{isotropic}{homogeneous}")
    }
}

fn write_output(f: &mut fmt::Formatter<'_>, output: &Output) -> fmt::Result {
    let list = |numbers: &[f32]| numbers.iter().map(|v| format!(" {}", number(*v))).collect();
    let identity = Output::IDENTITY;
    if output.matrix() != identity.matrix() {
        let numbers: String = list(output.matrix().as_flattened());
        writeln!(f, ".matrix{numbers}")?;
    }
    if output.scale() != identity.scale() {
        let numbers: String = list(output.scale());
        writeln!(f, ".scale{numbers}")?;
    }
    if output.offset() != identity.offset() {
        let numbers: String = list(output.offset());
        writeln!(f, ".offset{numbers}")?;
    }
    Ok(())
}

/// Shortest decimal that reads back to the same bits.
pub(crate) fn number(value: f32) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-5..1e7).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}
