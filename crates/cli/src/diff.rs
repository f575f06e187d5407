//! `brood diff`: difference of two pictures in a named metric.

pub mod itp;
mod picture;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::{logging, output};
pub use picture::read;

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
    /// Mean FLIP error
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
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    ensure!(
        a.size() == b.size(),
        "the pictures must have the same size, got {:?} and {:?}",
        a.size(),
        b.size()
    );
    let value = match args.metric {
        Metric::Rmse => a.rmse(&b),
        Metric::Ssim => a.ssim(&b).context("ssim needs pictures of at least 11 x 11 pixels")?,
        Metric::Flip => a.flip(&b),
        Metric::Itp => itp::mean_difference(a.linear(), b.linear(), args.white),
    };
    if json {
        let name = args.metric.to_possible_value();
        let name = name.expect("no metric is hidden").get_name().to_owned();
        return output::print_json(&json!({ "metric": name, "value": value }));
    }
    output::print(&format!("{value}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_inspect::LinearImage;

    fn gradient(shift: f64) -> LinearImage {
        let pixel = |i: u32| [f64::from(i % 32) / 32.0 + shift, f64::from(i / 32) / 32.0, 0.25];
        LinearImage::new(32, 32, (0..1024).map(pixel).collect())
    }

    #[test]
    fn equal_pictures_have_no_difference_in_any_metric() {
        let (a, b) = (gradient(0.0), gradient(0.0));
        assert_eq!(itp::mean_difference(a.linear(), b.linear(), 100.0), 0.0);
        assert_eq!(a.ssim(&b), Some(1.0));
    }

    #[test]
    fn difference_grows_with_the_shift() {
        let (a, b, c) = (gradient(0.0), gradient(0.05), gradient(0.2));
        let itp = |other: &LinearImage| itp::mean_difference(a.linear(), other.linear(), 100.0);
        assert!(itp(&b) > 0.0 && itp(&c) > itp(&b));
        assert!(a.ssim(&c).unwrap() < a.ssim(&b).unwrap());
    }
}
