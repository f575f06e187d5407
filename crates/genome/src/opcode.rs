//! Opcodes of the machine: names, numbers, operand counts. Their results are defined in `expand`
//! and `arithmetic`.

brood_brdf::named_enum! {
    numbered
    /// An operation on four-component registers.
    ///
    /// # Source
    /// Meyer-Spradow and Loviscach, *Evolutionary Design of BRDFs*, table 1; the last four belong
    /// to the extended dialect.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    #[repr(u8)]
    pub enum Opcode {
        /// a + b.
        Add => "ADD",
        /// a - b.
        Sub => "SUB",
        /// a b.
        Mul => "MUL",
        /// a.
        Mov => "MOV",
        /// a b + c.
        Mad => "MAD",
        /// a (b - c) + c.
        Lrp => "LRP",
        /// Dot product of x, y, z, to all components.
        Dp3 => "DP3",
        /// Dot product of all four components, to all components.
        Dp4 => "DP4",
        /// (1, a.y b.y, a.z, b.w).
        Dst => "DST",
        /// Linear transform of b.xy by the rows c.xy and c.zw, added to a.xy: (x, y, x, y) with
        /// x = a.x + b.x c.x + b.y c.y and y = a.y + b.x c.z + b.y c.w.
        X2d => "X2D",
        /// Sine of one component, to all.
        Sin => "SIN",
        /// Cosine of one component, to all.
        Cos => "COS",
        /// Two to the power of one component, to all.
        Ex2 => "EX2",
        /// log2(a^2 + 2^-24) of one component, to all.
        Lg2 => "LG2",
        /// a / (a^2 + 2^-24) of one component, to all.
        Rcp => "RCP",
        /// 1 / sqrt(a^2 + 2^-24) of one component, to all.
        Rsq => "RSQ",
        /// log2(1 + 2^a) of one component, to all.
        Spl => "SPL",
    }
}

impl Opcode {
    /// Number of opcodes in the paper's set, which come first.
    pub const PAPER: usize = 13;

    /// Number of operands.
    #[inline]
    #[must_use]
    pub fn operands(self) -> usize {
        match self {
            Self::Mov | Self::Sin | Self::Cos | Self::Ex2 => 1,
            Self::Lg2 | Self::Rcp | Self::Rsq | Self::Spl => 1,
            Self::Add | Self::Sub | Self::Mul | Self::Dp3 | Self::Dp4 | Self::Dst => 2,
            Self::Mad | Self::Lrp | Self::X2d => 3,
        }
    }

    /// True if the operand is a single component, written with exactly one swizzle letter.
    #[inline]
    #[must_use]
    pub fn is_scalar(self) -> bool {
        match self {
            Self::Sin | Self::Cos | Self::Ex2 => true,
            Self::Lg2 | Self::Rcp | Self::Rsq | Self::Spl => true,
            Self::Add | Self::Sub | Self::Mul | Self::Mov | Self::Mad | Self::Lrp => false,
            Self::Dp3 | Self::Dp4 | Self::Dst | Self::X2d => false,
        }
    }

    /// Returns the components of operand `index`, after swizzling, that the components `written` of
    /// the result depend on; both are masks.
    #[inline]
    #[must_use]
    pub fn reads(self, index: usize, written: u8) -> u8 {
        const X: u8 = 1;
        const Y: u8 = 2;
        const Z: u8 = 4;
        const W: u8 = 8;
        if written == 0 {
            return 0;
        }
        match self {
            Self::Add | Self::Sub | Self::Mul | Self::Mov | Self::Mad | Self::Lrp => written,
            Self::Dp3 => X | Y | Z,
            Self::Dp4 => X | Y | Z | W,
            Self::Dst if index == 0 => written & (Y | Z),
            Self::Dst => written & (Y | W),
            Self::X2d => {
                let (upper, lower) = (written & (X | Z) != 0, written & (Y | W) != 0);
                match index {
                    0 => (u8::from(upper) * X) | (u8::from(lower) * Y),
                    1 => X | Y,
                    _ => (u8::from(upper) * (X | Y)) | (u8::from(lower) * (Z | W)),
                }
            }
            Self::Sin | Self::Cos | Self::Ex2 => X,
            Self::Lg2 | Self::Rcp | Self::Rsq | Self::Spl => X,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_and_name_round_trip() {
        for (number, opcode) in Opcode::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(opcode.number()), number);
            assert_eq!(Opcode::from_name(opcode.name()), Some(opcode));
        }
        assert_eq!(Opcode::ALL[Opcode::PAPER], Opcode::Lg2);
    }
}
