//! `brood diff`: difference of two pictures in a named metric.

mod flip;
mod picture;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use brood_bench::{logging, output};
use clap::{Args, ValueEnum};
use flip::Flip;
use picture::ComparedPicture;
use serde_json::json;

/// Options of `brood diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// Reference picture, PNG or EXR
    pub a: PathBuf,
    /// Picture to compare, PNG or EXR
    pub b: PathBuf,
    /// Metric of the difference
    #[arg(long, default_value = "rmse")]
    pub metric: Metric,
    /// Luminance of linear 1 in cd/m2; only for itp
    #[arg(long, value_name = "L", default_value_t = 100.0, value_parser = luminance)]
    pub white: f64,
}

/// Metrics of picture differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Root mean square error of linear RGB
    Rmse,
    /// Structural similarity of 8-bit sRGB; 1 for equal pictures
    Ssim,
    /// Mean FLIP error: HDR-FLIP of two EXRs, otherwise LDR-FLIP
    Flip,
    /// Mean colour difference of BT.2124
    Itp,
}

fn luminance(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (1e-3..=10_000.0).contains(value));
    value.ok_or_else(|| "must be a number from 0.001 to 10000".to_owned())
}

/// Runs the command.
pub fn run(args: &DiffArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let (a, b) = (ComparedPicture::read(&args.a)?, ComparedPicture::read(&args.b)?);
    ensure!(
        a.image.size() == b.image.size(),
        "the pictures must have the same size, got {:?} and {:?}",
        a.image.size(),
        b.image.size()
    );
    let name = args.metric.to_possible_value().expect("no metric is hidden").get_name().to_owned();
    let value = match args.metric {
        Metric::Rmse => a.image.rmse(&b.image),
        Metric::Ssim => {
            a.image.ssim(&b.image).context("ssim needs pictures of at least 11 x 11 pixels")?
        }
        Metric::Flip => {
            let flip = Flip::of(&a, &b)?;
            if json {
                let of = json!({ "metric": name, "value": flip.mean, "flip": flip.json() });
                return output::print_json(&of);
            }
            return output::print(&format!("{}\n{}\n", flip.mean, flip.text()));
        }
        Metric::Itp => a.image.itp(&b.image, args.white),
    };
    if json {
        return output::print_json(&json!({ "metric": name, "value": value }));
    }
    output::print(&format!("{value}\n"))
}
