//! Readable listing of a program's scalar code.

use std::fmt::Write;

use brood_genome::Output;
use brood_program::{Operand, Program};

/// Returns one operation per line, then the expressions of the three channels.
#[must_use]
pub fn scalar_code(program: &Program) -> String {
    let mut text = String::new();
    let name = |operand: Operand| match operand {
        Operand::Step(index) => format!("t{index}"),
        Operand::Input(input) => input.name().to_owned(),
        Operand::Constant(index) => program.constants()[usize::from(index)].canonical.to_string(),
    };
    for (index, step) in program.steps().iter().enumerate() {
        let (a, b) = (name(step.a), name(step.b));
        let operands = if step.operation.is_binary() { format!("{a}, {b}") } else { a };
        line(&mut text, &format!("t{index} = {} {operands}", step.operation.name()));
    }
    let [r, g, b] = program.results().map(name);
    line(&mut text, &format!("g = ({r}, {g}, {b})"));
    let layers = program.layers().iter().map(|model| format!(" + {}", model.kind()));
    let sum = format!("g^2{}", layers.collect::<String>());
    let output = program.output();
    if *output == Output::IDENTITY {
        line(&mut text, &format!("f = {sum}"));
    } else {
        line(&mut text, &format!("f = scale (matrix ({sum})) + offset"));
        line(&mut text, &format!("matrix = {:?}", output.matrix()));
        line(&mut text, &format!("scale = {:?}", output.scale()));
        line(&mut text, &format!("offset = {:?}", output.offset()));
    }
    text
}

/// Returns the genome's text with dead instructions marked by a comment. It still parses.
#[must_use]
pub fn marked_source(source: &str, live: &[bool]) -> String {
    let lines: Vec<&str> = source.lines().collect();
    let first = lines.len() - live.len();
    let mut text = String::new();
    for (index, source) in lines.into_iter().enumerate() {
        let dead = index.checked_sub(first).is_some_and(|index| !live[index]);
        line(&mut text, &if dead { format!("{source:<40} # dead") } else { source.to_owned() });
    }
    text
}

fn line(text: &mut String, line: &str) {
    writeln!(text, "{line}").expect("a string takes everything");
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_genome::{BirthKey, Dialect, Genome, Variation, live_instructions};

    #[test]
    fn marked_source_parses_and_marks_dead_instructions() {
        let key = BirthKey { seed: 1, slot: 0, attempt: 0 };
        let genome = Variation::random(Dialect::default()).birth(key);
        let live = live_instructions(&genome);
        let text = marked_source(&genome.to_string(), &live);
        assert_eq!(text.parse::<Genome>().unwrap(), genome);
        let dead = live.iter().filter(|live| !**live).count();
        assert_eq!(text.matches("# dead").count(), dead);
    }

    #[test]
    fn scalar_code_has_a_line_per_operation() {
        let text =
            "brood 1\n.dialect paper smooth registers 7\nMUL R0.xy, R1.x, R1.y\nSIN R0.z, R0.x\n";
        let program = Program::lower(&text.parse().unwrap());
        let listing = scalar_code(&program);
        assert_eq!(listing, "t0 = mul q2, q1\nt1 = sin t0\ng = (t0, t0, t1)\nf = g^2\n");
    }
}
