//! Round trips of genome texts, and errors.

use crate::{BirthKey, Dialect, Genome, OpcodeSet, Output, Parametrisation, Variation};

const EXAMPLE: &str = "brood 1
# comment to the end of the line
.dialect paper smooth registers 7 isotropic homogeneous     # the last two only where they hold
.const C5 0.25 -1.5 3 0.125
ADD R5.xyz, -R1.yzyy, C5.x
COS R5.xy, R4.w

X2D R4, R1, C5.yxwz, -R2
";

#[test]
fn example_of_the_format_round_trips() {
    let genome: Genome = EXAMPLE.parse().unwrap();
    assert_eq!(genome.instructions().len(), 3);
    assert_eq!(genome.constants()[5], [0.25, -1.5, 3.0, 0.125]);
    let text = genome.to_string();
    assert_eq!(text.lines().count(), 6);
    assert!(
        text.ends_with("ADD R5.xyz, -R1.yzyy, C5.x\nCOS R5.xy, R4.w\nX2D R4, R1, C5.yxwz, -R2\n")
    );
    assert_eq!(text.parse::<Genome>().unwrap(), genome);
}

#[test]
fn random_genomes_round_trip() {
    for seed in 0..200 {
        let dialect = Dialect {
            opcodes: if seed % 2 == 0 { OpcodeSet::Paper } else { OpcodeSet::Extended },
            parametrisation: [Parametrisation::Paper, Parametrisation::Smooth]
                [seed as usize / 2 % 2],
            registers: 10 + (seed % 7) as u8,
            length: 1 + (seed * 5 % 1024) as u16,
            isotropic: seed % 3 == 0,
            homogeneous: seed % 5 == 0,
        };
        let output = Output::saturation(seed as f32 / 200.0).unwrap();
        let key = BirthKey { seed, slot: 0, attempt: 0 };
        let genome = Variation::random(dialect).with_output(Some(output)).birth(key);
        let genome = genome.with_limit(seed % 4 == 0);
        let back: Genome = genome.to_string().parse().unwrap();
        assert_eq!(back, genome, "seed {seed}");
        assert_eq!(back.hash(), genome.hash());
    }
}

#[test]
fn constants_keep_their_bits() {
    for value in [-0.0f32, 1e-40, f32::MIN_POSITIVE, 0.1, -65504.0, 1.000_000_1, 3.4e-7] {
        let text = format!(
            "brood 1\n.dialect paper smooth registers 4\n.const C0 {} 1 2 3\nMOV R0, C0\n",
            crate::text::number(value)
        );
        let genome: Genome = text.parse().unwrap();
        assert_eq!(genome.constants()[0][0].to_bits(), value.to_bits(), "{value}");
        assert_eq!(genome.to_string().parse::<Genome>().unwrap(), genome);
    }
}

#[test]
fn errors_carry_line_and_column() {
    let head = "brood 1\n.dialect paper smooth registers 7\n";
    let cases = [
        ("", "line 1, column 1: expected `brood 1`, but the line ends"),
        ("brood 2\n", "line 1, column 7: unknown format version `2`; expected 1"),
        (
            "brood 1\nMOV R0, R1\n",
            "line 2, column 1: the line `.dialect ...` must come before the first instruction",
        ),
        (
            "brood 1\n.dialect paper smooth registers 17\nMOV R0, R1",
            "line 2, column 1: registers must be between 4 and 16, got 17",
        ),
    ];
    for (text, error) in cases {
        assert_eq!(text.parse::<Genome>().unwrap_err().to_string(), error, "{text}");
    }
    let lines = [
        ("FOO R0, R1", "line 3, column 1: unknown opcode `FOO`"),
        ("ADD R0, R1", "line 3, column 1: ADD takes 2 operand(s), got 1"),
        ("ADD R0 R1, R2", "line 3, column 8: expected a comma before `R1`"),
        ("ADD R7, R1, R2", "line 3, column 1: R7 does not exist in a dialect of 7 registers"),
        (
            "ADD R0.zx, R1, R2",
            "line 3, column 5: a write mask must be letters of xyzw in order, got `zx`",
        ),
        ("ADD R0., R1, R2", "line 3, column 5: a write mask must have at least one letter"),
        (
            "ADD R0, R1.xy, R2",
            "line 3, column 9: a swizzle must be one letter or four of xyzw, got `xy`",
        ),
        ("SIN R0, R1", "line 3, column 9: SIN takes an operand with exactly one swizzle letter"),
        (
            "  MUL R0, C1, C2",
            "line 3, column 3: an instruction can read one constant register, not both C1 and C2",
        ),
        ("MUL R0, C1, C128", "line 3, column 1: C128 does not exist: constants are C0 to C127"),
        ("MUL R0, C1, C999", "line 3, column 13: `C999` is not a register"),
        ("LG2 R0, R1.x", "line 3, column 1: LG2 belongs to the extended dialect"),
        (".const C0 1 2 3", "line 3, column 16: expected a number, but the line ends"),
        (".const C0 1 2 3 nan", "line 3, column 17: expected a number, got `nan`"),
        (
            ".const C0 1 2 3 1e39",
            "line 3, column 17: expected a number from -65504 to 65504, got `1e39`",
        ),
        (
            ".matrix 1 0 0 0 1 0 0 0 -1",
            "line 3, column 25: expected a number from 0 to 65504, got `-1`",
        ),
        (".limit maybe", "line 3, column 8: expected on or off, got `maybe`"),
        (".limit on\n.limit off", "line 4, column 1: .limit is given twice"),
        ("MOV R0, R1 R2", "line 3, column 12: expected a comma before `R2`"),
        (".dialect paper smooth registers 7", "line 3, column 1: .dialect is given twice"),
    ];
    for (line, error) in lines {
        let text = format!("{head}{line}\n");
        assert_eq!(text.parse::<Genome>().unwrap_err().to_string(), error, "{line}");
    }
    let none = head.parse::<Genome>().unwrap_err();
    assert_eq!(
        none.reason,
        "a genome must have at least one instruction, one `.model` or one `.effect`"
    );
}
