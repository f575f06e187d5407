//! Exported GLSL and HLSL must be accepted by the reference compiler. `cargo xtask test` installs
//! the compiler and sets `GLSL_COMPILER`; without that variable the test is skipped.

#![expect(
    clippy::unwrap_used,
    reason = "this is a test; clippy only knows those with an attribute"
)]

use std::io::{Cursor, Read, Write};
use std::process::{Command, Stdio};

use brood_export::{Format, Within, conformance, export, export_material};
use brood_genome::{BirthKey, Dialect, Genome, ModelKind, OpcodeSet, Output, Variation};
use brood_program::Program;
use zip::ZipArchive;

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

/// Options for HLSL whose entry point is `shade`.
const HLSL: [&str; 6] = ["-D", "-V", "-e", "shade", "-o", "/dev/null"];

/// Returns the compiler's message if it rejects a fragment shader, otherwise `None`.
fn refusal(compiler: &str, options: &[&str], source: &str) -> Option<String> {
    let mut child = Command::new(compiler)
        .args(["--stdin", "-S", "frag"])
        .args(options)
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
            let within = Within { lights, ..Within::default() };
            let code = export_material(style, format, within).unwrap().into_text();
            sources.push(source(&code, &call_of_style(style, lights)));
        }
    }
    for source in sources {
        if let Some(said) = refusal(&compiler, &[], &source) {
            panic!("{said}\n{source}");
        }
    }
    assert!(
        refusal(&compiler, &[], "#version 300 es\nnonsense\n").is_some(),
        "the compiler must reject invalid source"
    );
}

/// Text between two others.
fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(start).unwrap();
    rest.split_once(end).unwrap().0
}

#[test]
fn code_for_three_js_is_accepted_by_the_reference_compiler() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    let bumped = "brood 1\n.model cook-torrance\n.bump strength -2\n.bump SPL R0, R0.x\n";
    let bumped = Program::lower(&bumped.parse::<Genome>().unwrap());
    for program in programs().iter().chain([&bumped]) {
        let text =
            |format| export_material(program, format, Within::default()).unwrap().into_text();
        let (page, module) = (text(Format::ThreePage), text(Format::ThreeTsl));
        for code in [
            between(&page, "id=\"evolved\">", "</script>"),
            between(&module, "const GLSL = `", "`;"),
        ] {
            let source = format!(
                "#version 300 es\nprecision highp float;\n{code}\nout vec4 color;\nvoid main() {{\n  \
                 color = vec4(reflected(vec3(0.0, 0.6, 0.8), vec3(0.6, 0.0, 0.8), vec3(0.0, 0.0, 1.0), \
                 vec3(1.0, 0.0, 0.0), 1.0, gl_FragCoord.xy), 1.0);\n}}\n"
            );
            if let Some(said) = refusal(&compiler, &[], &source) {
                panic!("{said}\n{source}");
            }
        }
    }
}

#[test]
fn hlsl_is_accepted_by_the_reference_compiler() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    let source = |code: &str, statements: &str, color: &str| {
        format!(
            "{code}\nfloat4 shade(float4 at : SV_Position) : SV_Target {{\n{statements}\n  return float4({color}, 1.0);\n}}\n"
        )
    };
    let frame = "float3(0.0, 0.0, 1.0), float3(1.0, 0.0, 0.0), float3(0.0, 1.0, 0.0)";
    let call = format!("evolved(normalize(at.xyz), float3(0.6, 0.0, 0.8), {frame}, at.xy)");
    let mut sources: Vec<String> =
        programs().iter().map(|one| source(&export(one, Format::Hlsl), "", &call)).collect();
    for (lights, style) in (1..=8).cycle().zip(&conformance::styles()) {
        let within = Within { lights, ..Within::default() };
        let code = export_material(style, Format::Hlsl, within).unwrap().into_text();
        let eye = "normalize(float3(at.xy, 1.0))";
        let light =
            format!("styled_light(float3(0.0, 0.6, 0.8), (float3)(1.0), 0.5, {eye}, {frame})");
        let each: String =
            (0..lights).map(|place| format!("  lights[{place}] = {light};\n")).collect();
        let statements = format!("  StyledLight lights[{lights}];\n{each}");
        let read = format!("styled_point({eye}, {frame}, 0.5, float2(0.25, 0.5)), lights");
        let name = if style.glass().is_some() { "styled_body" } else { "styled" };
        sources.push(source(&code, &statements, &format!("{name}({read})")));
    }
    for source in sources {
        if let Some(said) = refusal(&compiler, &HLSL, &source) {
            panic!("{said}\n{source}");
        }
    }
}

#[test]
fn shaders_of_disney_materials_are_accepted_by_the_reference_compiler() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    for program in programs() {
        let file = export_material(&program, Format::DisneyBrdf, Within::default());
        let file = file.unwrap().into_text();
        let (sliders, shader) = file.split_once("::begin shader\n").unwrap();
        let sliders = sliders.lines().filter(|line| line.starts_with("float "));
        let uniforms =
            sliders.map(|line| format!("uniform float {};\n", line.split(' ').nth(1).unwrap()));
        let uniforms: String = uniforms.collect();
        let shader = shader.trim_end().trim_end_matches("::end shader");
        let source = format!(
            "#version 410 core\n{uniforms}{shader}\nout vec4 color;\nvoid main() {{\n  vec3 x = gl_FragCoord.xyz;\n  \
             color = vec4(BRDF(x, x, x, x, x), 1.0);\n}}\n"
        );
        if let Some(said) = refusal(&compiler, &[], &source) {
            panic!("{said}\n{source}");
        }
    }
}

/// Types of MaterialX's shaders and its file that the code of a node includes.
const MATERIALX: &str = "#define CLOSURE_TYPE_REFLECTION 1
struct BSDF { vec3 response; vec3 throughput; };
struct ClosureData { int closureType; vec3 L; vec3 V; vec3 N; vec3 P; float occlusion; };
";

/// Code of the node of a material, and the call of its function.
fn node(program: &Program) -> (String, String) {
    let made = export_material(program, Format::MaterialX, Within::default()).unwrap();
    let mut archive = ZipArchive::new(Cursor::new(made.bytes)).unwrap();
    let name = format!("brood_{}", &program.hash().to_string()[..8]);
    let mut code = String::new();
    archive.by_name(&format!("{name}.glsl")).unwrap().read_to_string(&mut code).unwrap();
    let code: Vec<&str> = code.lines().filter(|line| !line.starts_with("#include")).collect();
    let bitangent = if program.bumps().is_some() { " at," } else { "" };
    (code.join("\n"), format!("  {name}_bsdf(data, 1.0, at, at,{bitangent} at.xy, 0, bsdf);\n"))
}

#[test]
fn nodes_of_materialx_are_accepted_by_the_reference_compiler_two_in_a_shader() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    for pair in programs().chunks(2) {
        let (code, calls): (Vec<String>, Vec<String>) = pair.iter().map(node).unzip();
        let (code, calls) = (code.join("\n"), calls.concat());
        for version in ["400", "300 es\nprecision highp float"] {
            let semicolon = if version.contains("precision") { ";" } else { "" };
            let source = format!(
                "#version {version}{semicolon}\n{MATERIALX}{code}\nout vec4 color;\nvoid main() {{\n  \
                 vec3 at = gl_FragCoord.xyz;\n  ClosureData data = ClosureData(1, at, at, at, at, 1.0);\n  \
                 BSDF bsdf = BSDF(vec3(0.0), vec3(0.0));\n{calls}  color = vec4(bsdf.response, 1.0);\n}}\n"
            );
            if let Some(said) = refusal(&compiler, &[], &source) {
                panic!("{said}\n{source}");
            }
        }
    }
}

#[test]
fn shaders_of_godot_are_accepted_by_the_reference_compiler() {
    let Some(compiler) = std::env::var("GLSL_COMPILER").ok().filter(|name| !name.is_empty()) else {
        return;
    };
    for program in programs() {
        let file = export_material(&program, Format::Godot3, Within::default()).unwrap();
        let code = file.into_text();
        let (_, code) = code.split_once("render_mode ambient_light_disabled;\n").unwrap();
        let (functions, stages) = code.split_once("void vertex() {").unwrap();
        let (_, light) = stages.split_once("void light() {").unwrap();
        let functions = functions.replace("varying", "in");
        let source = format!(
            "#version 330 core\nin vec3 NORMAL, LIGHT, VIEW, ATTENUATION, LIGHT_COLOR;\nin vec2 UV;\n\
             vec3 SPECULAR_LIGHT = vec3(0.0);\nout vec4 color;\n{functions}void light() {{{light}\n\
             void main() {{\n  light();\n  color = vec4(SPECULAR_LIGHT, 1.0);\n}}\n"
        );
        if let Some(said) = refusal(&compiler, &[], &source) {
            panic!("{said}\n{source}");
        }
    }
}

#[test]
fn painted_materials_are_refused_with_the_reason() {
    let style = &conformance::styles()[0];
    for format in [Format::MaterialX, Format::Godot3] {
        let error = export_material(style, format, Within::default()).unwrap_err().to_string();
        assert!(error.contains("a format of BRDFs"), "{error}");
    }
}
