//! How the interpreter is laid out on a device: where registers are, and how many samples an invocation has in hand.

/// Where the interpreter keeps the registers of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RegisterFile {
    /// An array of each invocation's own. It is indexed by what programs say, so most drivers put it into memory that
    /// is cached like any other.
    Private,
    /// The memory that a workgroup shares, one row a register, one column an invocation: near, but not much of it, and
    /// what one workgroup takes is not there for others.
    Workgroup,
}

/// A layout of the interpreter. All give the same bits; which is fastest is the device's business.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    file: RegisterFile,
    lanes: u32,
}

impl Default for Shape {
    /// What runs everywhere, and fastest on a processor.
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl Shape {
    /// The layouts there are.
    pub const ALL: [Self; 4] = [
        Self { file: RegisterFile::Private, lanes: 4 },
        Self { file: RegisterFile::Private, lanes: 1 },
        Self { file: RegisterFile::Workgroup, lanes: 1 },
        Self { file: RegisterFile::Workgroup, lanes: 4 },
    ];

    /// Where registers are.
    #[must_use]
    pub fn file(self) -> RegisterFile {
        self.file
    }

    /// Samples that one invocation evaluates together: decoding is shared by them, registers are not.
    #[must_use]
    pub fn lanes(self) -> u32 {
        self.lanes
    }

    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.file, self.lanes) {
            (RegisterFile::Private, 1) => "private registers, 1 sample an invocation",
            (RegisterFile::Private, _) => "private registers, 4 samples an invocation",
            (RegisterFile::Workgroup, 1) => "workgroup registers, 1 sample an invocation",
            (RegisterFile::Workgroup, _) => "workgroup registers, 4 samples an invocation",
        }
    }

    /// This layout, or the private one where `registers` of `samples` in a workgroup do not fit into `bytes`.
    pub(crate) fn fitting(self, registers: u32, samples: u32, bytes: u32) -> Self {
        match self.file {
            RegisterFile::Workgroup if registers * samples * 4 > bytes => {
                Self { file: RegisterFile::Private, lanes: self.lanes }
            }
            RegisterFile::Workgroup | RegisterFile::Private => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workgroup_registers_give_way_when_they_do_not_fit() {
        let wide = Shape::ALL[3];
        assert_eq!(wide.fitting(16, 256, 16_384), wide);
        let private = wide.fitting(32, 256, 16_384);
        assert_eq!((private.file(), private.lanes()), (RegisterFile::Private, 4));
        assert_eq!(Shape::default().fitting(128, 256, 0), Shape::default());
    }

    #[test]
    fn layouts_have_names_of_their_own() {
        for shape in Shape::ALL {
            assert_eq!(Shape::ALL.iter().filter(|other| other.name() == shape.name()).count(), 1);
        }
    }
}
