//! `brood preset`: lists the preset materials, or prints one.

use anyhow::{Context, Result};
use brood_bench::output;
use brood_genome::preset::{PRESETS, Preset};
use clap::Args;
use serde_json::json;

/// Options of `brood preset`.
#[derive(Debug, Args)]
pub struct PresetArgs {
    /// Name of the preset to print; without it all presets are listed
    name: Option<String>,
}

/// Runs the command.
pub fn run(args: &PresetArgs, json: bool) -> Result<()> {
    if let Some(name) = &args.name {
        let preset = Preset::find(name);
        let preset = preset.with_context(|| {
            format!("no preset is named {name}; run `brood preset` for all names")
        })?;
        return match json {
            true => output::print_json(&preset_json(preset)),
            false => output::print(preset.text),
        };
    }
    if json {
        return output::print_json(&PRESETS.iter().map(preset_json).collect::<Vec<_>>());
    }
    let width = PRESETS.iter().map(|preset| preset.name.len()).max().unwrap_or(0);
    let line = |preset: &Preset| format!("{:width$}  {}\n", preset.name, preset.words);
    output::print(&PRESETS.iter().map(line).collect::<String>())
}

fn preset_json(preset: &Preset) -> serde_json::Value {
    let Preset { name, title, words, text, .. } = preset;
    json!({ "name": name, "title": title, "words": words, "text": text })
}
