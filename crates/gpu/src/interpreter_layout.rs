//! Layout of the interpreter on a device: memory of the registers, and number of samples per
//! invocation.

/// Memory in which the interpreter keeps the registers of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RegisterFile {
    /// A private array of each invocation. Programs index it dynamically, so most drivers place it
    /// in cached device memory.
    Private,
    /// Workgroup memory, one row per register and one column per invocation: fast but small, and it
    /// limits the number of concurrent workgroups.
    Workgroup,
}

/// A layout of the interpreter. All give the same bits; the fastest one depends on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InterpreterLayout {
    file: RegisterFile,
    lanes: u32,
}

impl Default for InterpreterLayout {
    /// Returns the layout that every device supports, which is the fastest one on a software
    /// adapter.
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl InterpreterLayout {
    /// All layouts.
    pub const ALL: [Self; 4] = [
        Self { file: RegisterFile::Private, lanes: 4 },
        Self { file: RegisterFile::Private, lanes: 1 },
        Self { file: RegisterFile::Workgroup, lanes: 1 },
        Self { file: RegisterFile::Workgroup, lanes: 4 },
    ];

    /// Returns the memory of the registers.
    #[must_use]
    pub fn file(self) -> RegisterFile {
        self.file
    }

    /// Returns the number of samples that one invocation evaluates together, as a vector: each step
    /// is decoded once for all of them.
    #[must_use]
    pub fn lanes(self) -> u32 {
        self.lanes
    }

    /// Returns the name used in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.file, self.lanes) {
            (RegisterFile::Private, 1) => "private registers, 1 sample an invocation",
            (RegisterFile::Private, _) => "private registers, 4 samples an invocation",
            (RegisterFile::Workgroup, 1) => "workgroup registers, 1 sample an invocation",
            (RegisterFile::Workgroup, _) => "workgroup registers, 4 samples an invocation",
        }
    }

    /// Returns this layout, or the private one if `registers` of `samples` in a workgroup do not
    /// fit into `bytes`.
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
    fn private_registers_are_used_when_workgroup_registers_do_not_fit() {
        let wide = InterpreterLayout::ALL[3];
        assert_eq!(wide.fitting(16, 256, 16_384), wide);
        let private = wide.fitting(32, 256, 16_384);
        assert_eq!((private.file(), private.lanes()), (RegisterFile::Private, 4));
        assert_eq!(InterpreterLayout::default().fitting(128, 256, 0), InterpreterLayout::default());
    }

    #[test]
    fn layouts_have_distinct_names() {
        for shape in InterpreterLayout::ALL {
            assert_eq!(
                InterpreterLayout::ALL.iter().filter(|other| other.name() == shape.name()).count(),
                1
            );
        }
    }
}
