//! Tests of lowering: it preserves every bit in both arithmetics, and programs do not depend on how
//! a genome is written.

use brood_genome::{
    Arithmetic, BirthKey, Dialect, Genome, Input, Opcode, OpcodeSet, Output, RANGE, Variation,
    interpret, live_instructions,
};

use crate::{Counts, Operand, Program, Tape, Tunable, execute};

fn random(seed: u64, dialect: Dialect) -> Genome {
    let output = seed.is_multiple_of(3).then(|| Output::saturation(0.65).unwrap());
    let key = BirthKey { seed, slot: 0, attempt: 0 };
    Variation::random(dialect).with_output(output).birth(key)
}

fn dialects() -> [Dialect; 4] {
    let paper = Dialect::default();
    let extended = Dialect { opcodes: OpcodeSet::Extended, registers: 10, length: 60, ..paper };
    let isotropic = Dialect { isotropic: true, homogeneous: true, registers: 4, ..paper };
    [paper, extended, isotropic, Dialect { length: 1024, registers: 16, ..paper }]
}

/// Inputs of a synthetic sample: some ordinary, some at the ends of the range, some zero.
fn input(sample: u32, input: Input) -> f32 {
    let bits = brood_genome::philox4x32([sample, input.index() as u32, 0, 0], [1, 2])[0];
    match bits % 16 {
        0 => 0.0,
        1 => 65504.0,
        2 => -65504.0,
        3 => -0.0,
        _ => (bits >> 8) as f32 / 8_388_608.0 - 1.0,
    }
}

#[test]
fn lowering_preserves_every_bit() {
    for dialect in dialects() {
        for seed in 0..150 {
            let genome = random(seed, dialect);
            let program = Program::lower(&genome);
            for sample in 0..12 {
                let canonical = interpret(&genome, |i| input(sample, i));
                let lowered = execute(&program, |i| input(sample, i), |c| c.canonical);
                let bits = |f: [f32; 3]| f.map(f32::to_bits);
                assert_eq!(bits(canonical), bits(lowered), "seed {seed} sample {sample}\n{genome}");
                assert!(canonical.iter().all(|f| f.is_finite() && *f >= 0.0));
                let reference = interpret(&genome, |i| f64::from(input(sample, i)));
                let lowered = execute(&program, |i| f64::from(input(sample, i)), |c| c.reference);
                let bits = |f: [f64; 3]| f.map(f64::to_bits);
                assert_eq!(bits(reference), bits(lowered), "seed {seed} sample {sample}\n{genome}");
            }
        }
    }
}

/// Keys of pictures contain program hashes, so a change of lowering renders every picture again.
#[test]
fn programs_have_the_recorded_hashes() {
    let recorded = ["72d6b74c69b1ce08", "79fde6bcda8d6f21", "c4af16d30d24dcf2", "0aba484dea1e63c2"];
    let hashes = dialects().map(|dialect| {
        let mut all = blake3::Hasher::new();
        for seed in 0..100 {
            all.update(Program::lower(&random(seed, dialect)).hash().as_bytes());
        }
        all.finalize().to_hex()[..16].to_owned()
    });
    assert_eq!(hashes, recorded);
}

#[test]
fn tuned_constants_are_written_back_to_the_genome() {
    let mut tuned = 0;
    for dialect in dialects() {
        for seed in 0..60 {
            let genome = random(seed, dialect);
            let mut tunable = Tunable::lower(&genome);
            assert_eq!(tunable.write(&genome), genome);
            for other in [false, true] {
                for index in 0..tunable.places().len() {
                    if tunable.places()[index].is_some() && other {
                        let value = tunable.program().constants()[index].reference;
                        tunable.set(index, 0.25 - 1.5 * value);
                        tuned += 1;
                    }
                }
                let written = tunable.write(&genome);
                for sample in 0..6 {
                    let bits = |f: [f32; 3]| f.map(f32::to_bits);
                    let own = execute(tunable.program(), |i| input(sample, i), |c| c.canonical);
                    let canonical = interpret(&written, |i| input(sample, i));
                    assert_eq!(bits(own), bits(canonical), "seed {seed} sample {sample}\n{genome}");
                }
            }
        }
    }
    assert!(tuned > 1000, "{tuned}");
}

#[test]
fn words_round_trip_and_broken_words_are_rejected() {
    for seed in 0..100 {
        let program = Program::lower(&random(seed, dialects()[1]));
        let words = program.to_words();
        assert_eq!(Program::from_words(&words).unwrap(), program);
        assert_eq!(Program::from_words(&words).unwrap().hash(), program.hash());
        for index in 0..words.len() {
            let mut broken = words.clone();
            broken[index] ^= 0xffff_0001;
            // Broken words may be rejected or read as another valid program, which must run.
            if let Ok(program) = Program::from_words(&broken) {
                let f = execute(&program, |i| input(0, i), |c| c.canonical);
                assert!(f.iter().all(|f| f.is_finite()));
            }
        }
        assert!(Program::from_words(&words[..words.len() - 1]).is_err());
    }
    assert!(Program::from_words(&[]).is_err());
}

#[test]
fn words_are_accepted_when_constants_at_the_limits_are_folded() {
    for opcode in Opcode::ALL {
        for x in [-RANGE, -1.0, 0.0, 1.0, RANGE] {
            let operands = ["C0.x", "C0.y", "C0.z"][..opcode.operands()].join(", ");
            let text = format!(
                "brood 1\n.dialect extended smooth registers 10\n.const C0 {x} {RANGE} {x} 0\n\
                 {} R0.xyz, {operands}\n",
                opcode.name()
            );
            let program = Program::lower(&text.parse::<Genome>().unwrap());
            assert_eq!(program.operations(), 0, "{text}");
            assert_eq!(Program::from_words(&program.to_words()), Ok(program), "{text}");
        }
    }
}

#[test]
fn counts_shrink_with_every_pass() {
    let mut totals = [0u32; 5];
    for seed in 0..400 {
        let genome = random(seed, Dialect::default());
        let c = Counts::of(&genome);
        let passes = [
            c.scalar_operations,
            c.live_scalar_operations,
            c.numbered_operations,
            c.operations,
            c.live_instructions,
        ];
        assert!(passes[..4].is_sorted_by(|a, b| a >= b), "seed {seed}: {c:?}");
        assert_eq!(c.instructions, 100);
        totals.iter_mut().zip(passes).for_each(|(total, pass)| *total += pass);
    }
    let means = totals.map(|total| f64::from(total) / 400.0);
    println!("mean scalar operations: all, live, numbered, folded; live instructions: {means:?}");
    assert!((20.0..60.0).contains(&means[4]), "{means:?}");
}

#[test]
fn program_does_not_depend_on_dead_code_register_names_or_order() {
    let a = "brood 1\n.dialect paper smooth registers 7\nMUL R3.x, R0.x, R1.y\nADD R4.x, R0.y, R0.z\nADD R0.xyz, R3.x, -R4.x\nMOV R1, R2\n";
    let b = "brood 1\n.dialect paper smooth registers 7\nSIN R6, R0.x\nADD R5.x, R0.z, R0.y\nMUL R2.x, -R1.y, R0.x\nADD R0.xyz, R5.x, R2.x\n";
    let lower = |text: &str| Program::lower(&text.parse::<Genome>().unwrap());
    assert_eq!(lower(a).hash(), lower(b).hash());
    assert_eq!(lower(a).operations(), 3);
}

#[test]
fn constants_are_folded_and_dead_inputs_are_not_read() {
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 0.5 0 1 2\nMUL R0, R0, C0.y\nSIN R1, C0.x\nMAD R0.x, R1, C0.w, R0\nADD R0.y, R1, -R1\nMUL R0.z, R2, C0.z\n";
    let genome: Genome = text.parse().unwrap();
    let program = Program::lower(&genome);
    assert_eq!(program.operations(), 0);
    let [red, green, blue] = *program.results();
    assert!(matches!(red, Operand::Constant(_)) && matches!(green, Operand::Constant(_)));
    assert!(matches!(blue, Operand::Input(Input::SmoothQ2)), "{blue:?}");
    assert_eq!(program.inputs().len(), 1);
    let f = execute(&program, |_| 0.25, |c| c.canonical);
    assert_eq!(f[0], (Arithmetic::sine(0.5f32) * 2.0).powi(2));
    assert_eq!((f[1], f[2]), (0.0, 0.0625));
}

#[test]
fn tape_has_the_bits_of_its_program_in_few_registers() {
    let mut most = 0;
    for dialect in dialects() {
        for seed in 0..100 {
            let program = Program::lower(&random(seed, dialect));
            let tape = Tape::new(&program);
            most = most.max(tape.registers());
            let mut registers = vec![0.0f32; usize::from(tape.registers())];
            for (step, original) in tape.steps().iter().zip(program.steps()) {
                assert_eq!(step.operation, original.operation);
                let (a, b) = (read(&tape, &registers, step.a), read(&tape, &registers, step.b));
                registers[usize::from(step.dst)] = step.operation.apply(a, b);
            }
            let squares = tape.results().map(|operand| read(&tape, &registers, operand).square());
            let expected = execute(&program, |i| input(3, i), |c| c.canonical);
            assert_eq!(program.output().apply(squares), expected, "seed {seed}");
        }
    }
    println!("most registers: {most}");
    assert!(most <= 128, "{most} registers");
}

fn read(tape: &Tape, registers: &[f32], operand: crate::TapeOperand) -> f32 {
    match operand {
        crate::TapeOperand::Register(index) => registers[usize::from(index)],
        crate::TapeOperand::Input(i) => input(3, i),
        crate::TapeOperand::Constant(index) => tape.constants()[usize::from(index)].canonical,
    }
}

#[test]
fn padded_genome_lowers_to_the_same_program() {
    for seed in 0..40 {
        let short = random(seed, Dialect { length: 20, ..Dialect::default() });
        let long = short.clone().padded(100).unwrap();
        assert_eq!(long.instructions().len(), 100);
        assert_eq!(long.instructions()[80..], *short.instructions());
        assert_eq!(Program::lower(&long), Program::lower(&short), "{long}");
        let live = live_instructions(&long);
        assert!(live[..80].iter().all(|live| !live), "a move of a register to itself is dead");
        assert_eq!(live[80..], *live_instructions(&short));
        assert_eq!(short.clone().padded(20).unwrap(), short);
        assert!(long.padded(20).is_err());
    }
}

fn painted(text: &str, lights: usize) -> Program {
    let genome: Genome = format!("brood 1\n{text}\n").parse().unwrap();
    Program::lower(&genome).painted(brood_brdf::Lighting { lights, has_shadows: true })
}

#[test]
fn glass_reads_only_what_it_shows() {
    let reads = |parameters: &str| {
        let program = painted(&format!(".effect light\n.effect glass\n{parameters}"), 1);
        (program.reads_mirrored(), program.reads_ways())
    };
    assert_eq!(reads(""), (true, true));
    assert_eq!(reads("strength 0"), (false, false));
    assert_eq!(reads("mirror 0"), (false, true));
    assert_eq!(reads("see 0"), (true, false));
    assert_eq!(reads("from 1"), (true, false));
    assert_eq!(reads("from 0\nto 0"), (false, true));
    let plain = painted(".effect light", 2);
    assert_eq!(painted(".effect light\n.effect glass\nstrength 0", 2), plain);
    let style =
        Program::lower(&"brood 1\n.effect light\n.effect glass\nindex 1.33".parse().unwrap());
    assert_eq!(style.glass().and_then(brood_genome::Effect::index_of_refraction), Some(1.33));
    assert_eq!(style.without_glass(), Program::lower(&"brood 1\n.effect light".parse().unwrap()));
}

#[test]
fn effects_without_strength_fold_away() {
    let plain = painted(".effect light", 2);
    let off = ".effect light\n.effect silhouette\nstrength 0\n.effect highlight\nstrength 0\n\
               .effect distance\nstrength 0";
    assert_eq!(painted(off, 2), plain);
    let dark = painted(".effect light\nstrength 0", 2);
    assert!(dark.inputs().is_empty() && dark.steps().is_empty(), "{dark:?}");
    let unbrushed = ".effect light\n.dialect paper smooth registers 7\nADD R0, R1, R2";
    assert_eq!(painted(unbrushed, 2), plain);
    assert_ne!(painted(&unbrushed.replace("light", "light\nbrush 0.5"), 2), plain);
}

#[test]
fn styles_read_only_the_lights_of_the_scene() {
    for lights in 0..=Input::LIGHTS {
        let program = painted(".effect light\n.effect highlight", lights);
        let read = program.inputs();
        for light in 0..Input::LIGHTS {
            let cosine = Input::of_light(light, brood_brdf::LightInput::Cos);
            assert_eq!(read.contains(cosine), light < lights);
        }
        assert!(program.is_color() && program.is_painted());
    }
}

#[test]
fn directed_programs_read_the_first_light_and_the_eye() {
    let text = ".effect light\nbrush 1\n.dialect directed smooth registers 12\n\
                DP4 R0, R10, R10\nMAD R0, R11, R11.yxzw, R0";
    let read = painted(text, 1).inputs();
    let inputs = [Input::Light0Mirror, Input::NormalDotEye, Input::Depth, Input::P2];
    assert!(inputs.into_iter().all(|input| read.contains(input)), "{read:?}");
}

#[test]
fn words_of_styles_and_colours_round_trip() {
    let text = "brood 1\n.effect light\npalette #000000 #808080 #ffffff\nbrush 0.3\n\
                .effect distance\n.dialect paper smooth registers 7\nADD R0, R1, R2\n";
    let style = Program::lower(&text.parse::<Genome>().unwrap());
    let color = style.painted(brood_brdf::Lighting { lights: 1, has_shadows: false });
    assert_ne!(style.hash(), color.hash());
    for program in [style, color] {
        let words = program.to_words();
        assert_eq!(Program::from_words(&words).unwrap(), program);
        for end in 0..words.len() {
            assert!(Program::from_words(&words[..end]).is_err(), "{end}");
        }
        for at in 0..words.len() {
            let mut broken = words.clone();
            broken[at] ^= 1 << (at % 32);
            // Either an error, or words of another valid program.
            if let Ok(other) = Program::from_words(&broken) {
                assert_eq!(Program::from_words(&other.to_words()), Ok(other));
            }
        }
    }
}

/// Style that paints a program with two models and an output stage.
fn by_brdf(amount: &str) -> Program {
    let text = format!(
        "brood 1\n.dialect paper smooth registers 7\n.scale 0.5 1 2\n.model lambert\n\
         .model conductor\n.effect light\nby brdf\n{amount}\n.effect silhouette\n\
         ADD R0, R1, R2\n"
    );
    Program::lower(&text.parse::<Genome>().unwrap())
}

#[test]
fn style_by_brdf_has_the_program_of_its_brdf() {
    let style = by_brdf("brush 1");
    assert!(style.is_painted() && style.is_by_brdf());
    let text = "brood 1\n.dialect paper smooth registers 7\n.scale 0.5 1 2\n.model lambert\n\
                .model conductor\nADD R0, R1, R2\n";
    let brdf = Program::lower(&text.parse::<Genome>().unwrap());
    assert_eq!(style.brdf(), Some(brdf.clone()));
    assert_eq!(brdf.brdf(), Some(brdf.clone()));
    assert_ne!(style.hash(), brdf.hash());
    assert_eq!(style.divided(2.0).brdf(), Some(brdf.divided(2.0)));
    let light = Program::lower(&"brood 1\n.effect light\n".parse::<Genome>().unwrap());
    assert_eq!((light.brdf(), light.is_by_brdf()), (None, false));
}

#[test]
fn style_by_brdf_reads_levels_and_neither_lights_nor_directions() {
    for (amount, levels) in [("", 1), ("property box\nbrush 1\nshadow 0.5", 3)] {
        for lights in [0, 1, 8] {
            let lighting = brood_brdf::Lighting { lights, has_shadows: true };
            let color = by_brdf(amount).painted(lighting);
            assert!(color.layers().is_empty() && color.is_color());
            let read = color.inputs();
            let of_point = [Input::ReflectedStep, Input::NormalDotEye, Input::NormalDotEyeStep];
            assert!(of_point.into_iter().all(|input| read.contains(input)), "{read:?}");
            let of_brdf = Input::REFLECTED.into_iter().filter(|input| read.contains(*input));
            assert_eq!(of_brdf.count(), levels);
            assert_eq!(read.len(), of_point.len() + levels, "{read:?}");
        }
    }
}

#[test]
fn words_of_styles_by_brdf_round_trip() {
    let alone = "brood 1\n.dialect paper smooth registers 7\n.effect light\nby brdf\n\
                 ADD R0, R1, R2\n";
    let alone = Program::lower(&alone.parse::<Genome>().unwrap());
    for program in [by_brdf(""), alone] {
        let words = program.to_words();
        assert_eq!(Program::from_words(&words).unwrap(), program);
        for end in 0..words.len() {
            assert!(Program::from_words(&words[..end]).is_err(), "{end}");
        }
        for at in 0..words.len() {
            let mut broken = words.clone();
            broken[at] ^= 1 << (at % 32);
            if let Ok(other) = Program::from_words(&broken) {
                assert_eq!(Program::from_words(&other.to_words()), Ok(other));
            }
        }
    }
}
