//! `cargo xtask bench live`: what the page draws live in a browser, by each driver of graphics there is, and how many
//! exported programs keep their bits there.
//!
//! Owns which drivers are tried and the tables; the script `tests/browser/rate.mjs` owns how it is measured.

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use super::environment::{Environment, json_lines};
use super::{Options, Task, write_report};
use crate::{prerequisite, shell};

/// What the browser's own software is called on the command line.
const BUILT_IN: &str = "software";
/// What a system has: OpenGL that needs no screen.
const OF_THE_SYSTEM: &str = "gl-egl";
const OBJECTS: &str = "sphere,knob";
const SEEDS: &str = "7,8,9";
const PROGRAMS: &str = "200";
/// Of the display's frames, so many have to be drawn.
const AT_THE_DISPLAYS_RATE: f64 = 0.95;

/// Runs it.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Live, words)?;
    let environment = Environment::prepare(&options, &[])?;
    prerequisite::install_browser_driver()?;
    let found = prerequisite::Prerequisites::look();
    if found.chromium.is_none() {
        bail!("no browser: install chromium, or name one in $CHROMIUM");
    }
    let usual = if options.hardware { vec![OF_THE_SYSTEM] } else { vec![BUILT_IN, OF_THE_SYSTEM] };
    let drivers = match &options.angle {
        Some(names) => names.split(',').collect(),
        None => usual,
    };
    let mut tried = Vec::new();
    let mut missing = Vec::new();
    for driver in drivers {
        let mut node = shell::command("node");
        node.args(["tests/browser/rate.mjs", "--objects", OBJECTS, "--seeds", SEEDS]);
        node.args(["--programs", PROGRAMS]).env("BROOD_BIN", environment.brood_file());
        if let Some(browser) = &found.chromium {
            node.env("CHROMIUM", browser);
        }
        if driver != BUILT_IN {
            node.args(["--angle", driver]);
        }
        if options.hardware {
            node.arg("--hardware");
        }
        match json_lines(&mut node) {
            Ok(lines) => tried.push(json!({ "driver": driver, "found": lines })),
            Err(error) => missing.push(format!("{driver}: {error:#}")),
        }
    }
    let machine = environment.machine();
    let text = markdown(&tried, &machine, &missing)?;
    let report = json!({ "machine": machine, "drivers": tried, "missing": missing });
    write_report(&options.out, "live", &report, &text)?;
    // Who asks for hardware asks whether it draws.
    if (options.require || options.hardware) && !missing.is_empty() {
        bail!("not everything could be measured: {}", missing.join("; "));
    }
    Ok(())
}

fn markdown(tried: &[Value], machine: &Value, missing: &[String]) -> Result<String> {
    let mut text = String::from(
        "# The live page\n\n\
         21 random materials of 100 instructions under the circling light, drawing buffer 640 x 640, headless Chromium. *Display*: frames a second \
         while nothing is drawn; *whole*: in the whole buffer; *chosen*: in the buffer that the page chooses, which the last column tells.\n",
    );
    for driver in tried {
        let lines = driver["found"].as_array().context("a driver has findings")?;
        let renderer = lines.first().and_then(|line| line["renderer"].as_str());
        write!(text, "\n## {}\n\n", renderer.unwrap_or("no renderer"))?;
        text.push_str(
            "| object | seed | display | whole | at the display's rate | 95th percentile | chosen | buffer | all drawn after |\n\
             |---|---|---|---|---|---|---|---|---|\n",
        );
        for line in lines.iter().filter(|line| line["object"].is_string()) {
            let number = |pointer: &str| line.pointer(pointer).and_then(Value::as_f64);
            let number = |pointer: &str| number(pointer).with_context(|| format!("find {pointer}"));
            let (display, whole) = (number("/display_fps")?, number("/whole/fps")?);
            let kept_up = whole >= AT_THE_DISPLAYS_RATE * display;
            writeln!(
                text,
                "| {} | {} | {display:.1} | {whole:.1} | {} | {:.1} ms | {:.1} | {} x {} | {:.1} s |",
                line["object"].as_str().unwrap_or_default(),
                line["seed"].as_str().unwrap_or_default(),
                if kept_up { "yes" } else { "no" },
                number("/whole/p95_ms")?,
                number("/paced/fps")?,
                number("/paced/buffer/0")?,
                number("/paced/buffer/1")?,
                number("/all_drawn_ms")? / 1000.0,
            )?;
        }
        for exports in lines.iter().map(|line| &line["exports"]).filter(|it| it.is_object()) {
            writeln!(
                text,
                "\nExported programs with the bits they must have: {} of {} ({} of {} values differ), {} of {} in the shorter text that the page \
                 draws with; {} refused by the compiler. Kinds of models within their bounds: {} of {}.",
                exports["exact"],
                exports["programs"],
                exports["differing"],
                exports["values"],
                exports["within_exact"],
                exports["programs"],
                exports["failures"],
                exports["kinds_kept"],
                exports["kinds"],
            )?;
        }
    }
    for reason in missing {
        writeln!(text, "\nMissing: {reason}")?;
    }
    writeln!(text, "\nMachine: {machine}")?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::markdown;

    fn line(whole: f64) -> serde_json::Value {
        let rate = |fps: f64| json!({ "fps": fps, "p95_ms": 16.7, "buffer": [640, 640] });
        json!({
            "renderer": "R", "object": "knob", "seed": "7", "display_fps": 60.0, "all_drawn_ms": 2500,
            "whole": rate(whole), "paced": rate(60.0),
        })
    }

    #[test]
    fn frames_that_the_display_waits_for_are_told() {
        let exports = json!({ "renderer": "R", "exports": { "programs": 200, "exact": 199 } });
        let tried = [json!({ "driver": "gl", "found": [line(59.5), line(41.0), exports] })];
        let text = markdown(&tried, &json!("m"), &["metal: no WebGL 2".to_owned()]).unwrap();
        assert!(text.contains("| knob | 7 | 60.0 | 59.5 | yes |"), "{text}");
        assert!(text.contains("| knob | 7 | 60.0 | 41.0 | no |"), "{text}");
        assert!(text.contains("199 of 200") && text.contains("Missing: metal"), "{text}");
    }
}
