//! `cargo xtask bench live`: frame rate of the page in a browser with each available graphics
//! driver, and exactness of exported programs there.
//!
//! Owns the choice of drivers and the tables; the script `tests/browser/rate.mjs` measures.

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use super::environment::{Environment, json_lines};
use super::{Options, Task, paragraphs, require_all, write_report};
use crate::{prerequisite, shell};

/// Name of the browser's own software renderer on the command line.
const BUILT_IN: &str = "software";
/// ANGLE backend for the system's driver: OpenGL without a screen.
const SYSTEM_DRIVER: &str = "gl-egl";
const OBJECTS: &str = "sphere,knob";
const SEEDS: &str = "7,8,9";
const PROGRAMS: &str = "200";
/// Least share of the display's frames that counts as full rate.
const FULL_RATE_SHARE: f64 = 0.95;

/// Runs the benchmark.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Live, words)?;
    let environment = Environment::prepare(&options, &[])?;
    prerequisite::install_browser_driver()?;
    let found = prerequisite::Prerequisites::find();
    if found.chromium.is_none() {
        bail!("no browser found: install chromium, or set $CHROMIUM to its path");
    }
    let default =
        if options.hardware { vec![SYSTEM_DRIVER] } else { vec![BUILT_IN, SYSTEM_DRIVER] };
    let drivers = match &options.angle {
        Some(names) => names.split(',').collect(),
        None => default,
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
    // With --hardware a driver that cannot draw is a failure.
    require_all(options.require || options.hardware, &missing)
}

fn markdown(tried: &[Value], machine: &Value, missing: &[String]) -> Result<String> {
    let mut text = String::from(
        "# The live page\n\n\
         21 random materials of 100 instructions under the circling light, drawing buffer 640 x 640, headless Chromium. *Display*: frames a second \
         while nothing is drawn; *whole*: in the whole buffer; *chosen*: in the buffer size chosen by the page (column buffer).\n",
    );
    for driver in tried {
        let lines = driver["found"].as_array().context("a driver must have results")?;
        let renderer = lines.first().and_then(|line| line["renderer"].as_str());
        write!(text, "\n## {}\n\n", renderer.unwrap_or("unknown renderer"))?;
        text.push_str(
            "| object | seed | display | whole | at the display's rate | 95th percentile | chosen | buffer | all drawn after |\n\
             |---|---|---|---|---|---|---|---|---|\n",
        );
        for line in lines.iter().filter(|line| line["object"].is_string()) {
            let number = |pointer: &str| line.pointer(pointer).and_then(Value::as_f64);
            let number = |pointer: &str| number(pointer).with_context(|| format!("find {pointer}"));
            let (display, whole) = (number("/display_fps")?, number("/whole/fps")?);
            let is_full_rate = whole >= FULL_RATE_SHARE * display;
            writeln!(
                text,
                "| {} | {} | {display:.1} | {whole:.1} | {} | {:.1} ms | {:.1} | {} x {} | {:.1} s |",
                line["object"].as_str().unwrap_or_default(),
                line["seed"].as_str().unwrap_or_default(),
                if is_full_rate { "yes" } else { "no" },
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
                "\nExported programs with exact bits: {} of {} ({} of {} values differ), {} of {} in the shorter export that the page \
                 draws with; {} rejected by the compiler. Kinds of model within their bounds: {} of {}.",
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
    write!(text, "{}\nMachine: {machine}\n", paragraphs(missing))?;
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
    fn frame_rates_below_the_displays_are_marked() {
        let exports = json!({ "renderer": "R", "exports": { "programs": 200, "exact": 199 } });
        let tried = [json!({ "driver": "gl", "found": [line(59.5), line(41.0), exports] })];
        let text = markdown(&tried, &json!("m"), &["metal: no WebGL 2".to_owned()]).unwrap();
        assert!(text.contains("| knob | 7 | 60.0 | 59.5 | yes |"), "{text}");
        assert!(text.contains("| knob | 7 | 60.0 | 41.0 | no |"), "{text}");
        assert!(text.contains("199 of 200") && text.contains("Missing: metal"), "{text}");
    }
}
