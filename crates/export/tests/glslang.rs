//! Exported GLSL must be accepted by the reference compiler. `cargo xtask test` installs the
//! compiler and sets `GLSL_COMPILER`; without that variable the test is skipped.

#![expect(
    clippy::unwrap_used,
    reason = "this is a test; clippy only knows those with an attribute"
)]

use std::io::Write;
use std::process::{Command, Stdio};

use brood_export::{Format, Within, conformance, export, print};
use brood_genome::{BirthKey, Dialect, Genome, ModelKind, OpcodeSet, Output, Variation};
use brood_program::Program;

/// Random programs of both dialects, with and without an output stage.
fn programs() -> Vec<Program> {
    let dialects = [OpcodeSet::Paper, OpcodeSet::Extended].map(|opcodes| Dialect {
        opcodes,
        registers: 16,
        ..Dialect::default()
    });
    let outputs = [None, Some(Output::saturation(0.65).unwrap())];
    let births = dialects
        .into_iter()
        .flat_map(|dialect| outputs.map(|output| Variation::random(dialect).with_output(output)));
    births
        .flat_map(|random| {
            (0..6).map(move |slot| random.birth(BirthKey { seed: 5, slot, attempt: 0 }))
        })
        .map(|genome| Program::lower(&genome))
        .chain(models())
        .collect()
}

/// Models of every kind with every word of their choices, and some as layers over a program.
fn models() -> Vec<Program> {
    let cases: Vec<_> = ModelKind::ALL.into_iter().flat_map(conformance::cases).collect();
    let over = cases.chunks(7).map(|few| {
        let head = "brood 1\n.scale 0.5 2 0\n.dialect paper smooth registers 7\nMUL R0, R0, R1\n";
        let layers: String = few.iter().take(2).map(|case| case.model.to_string()).collect();
        Program::lower(&format!("{head}{layers}").parse::<Genome>().unwrap())
    });
    let alone = cases.iter().map(|case| case.program.clone());
    over.chain(alone).collect()
}

/// Returns the compiler's message if it rejects a fragment shader, otherwise `None`.
fn refusal(compiler: &str, source: &str) -> Option<String> {
    let mut child = Command::new(compiler)
        .args(["--stdin", "-S", "frag"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(source.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (!output.status.success()).then_some(said)
}

/// Calls of `styled` through the helpers, and of `styled_body` if the style has glass.
fn call_of_style(style: &Program, lights: usize) -> String {
    let frame = "vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)";
    let eye = "normalize(vec3(gl_FragCoord.xy, 1.0))";
    let light = format!("styled_light(vec3(0.0, 0.6, 0.8), vec3(1.0), 0.5, {eye}, {frame})");
    let lights = format!("StyledLight[{lights}]({})", vec![light; lights].join(", "));
    let read = format!("styled_point({eye}, {frame}, 0.5, vec2(0.25, 0.5)), {lights}");
    match style.glass() {
        Some(_) => {
            let glass = "StyledGlass(vec3(0.5), 0.0, vec3(0.25), 1.5, vec3(0.0), 65504.0, 1.0)";
            format!("styled({read}, {glass}) + styled_body({read})")
        }
        None => format!("styled({read})"),
    }
}

#[test]
fn exports_are_accepted_by_the_reference_compiler() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    let call = "evolved(vec3(0.0, 0.6, 0.8), vec3(0.6, 0.0, 0.8), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), \
                vec3(0.0, 1.0, 0.0), vec2(0.25, 0.5))";
    let mut sources = Vec::new();
    for (format, version) in [(Format::GlslEs300, "300 es"), (Format::Glsl410, "410 core")] {
        let source = |code: &str, color: &str| {
            format!(
                "#version {version}\n{code}\nout vec4 color;\nvoid main() {{ color = vec4({color}, 1.0); }}\n"
            )
        };
        sources.extend(programs().iter().map(|one| source(&export(one, format), call)));
        for (lights, style) in (1..=8).cycle().zip(&conformance::styles()) {
            let code = print(style, format, Within { lights, ..Within::default() }).unwrap();
            sources.push(source(&code, &call_of_style(style, lights)));
        }
    }
    for source in sources {
        if let Some(said) = refusal(&compiler, &source) {
            panic!("{said}\n{source}");
        }
    }
    assert!(
        refusal(&compiler, "#version 300 es\nnonsense\n").is_some(),
        "the compiler must reject invalid source"
    );
}
