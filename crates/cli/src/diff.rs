//! `brood diff`: how far apart two pictures are, in a named metric.

mod itp;
mod picture;

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use serde_json::json;

pub use crate::diff::picture::Picture;
use crate::{logging, output};

/// Options of `brood diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The reference: PNG or EXR
    pub a: PathBuf,
    /// What is held against it: PNG or EXR
    pub b: PathBuf,
    /// rmse: root mean square error of linear RGB; ssim: structural similarity, 1 for equal pictures; flip: mean FLIP
    /// error; itp: mean colour difference of BT.2124
    #[arg(long, default_value = "rmse")]
    pub metric: Metric,
    /// Luminance of linear 1 in cd/m2, for itp
    #[arg(long, value_name = "L", default_value_t = 100.0, value_parser = luminance)]
    pub white: f64,
}

/// How pictures are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Root mean square error of linear RGB
    Rmse,
    /// Structural similarity of 8-bit sRGB
    Ssim,
    /// Mean error of the FLIP difference evaluator
    Flip,
    /// Mean colour difference of BT.2124
    Itp,
}

fn luminance(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (1e-3..=10_000.0).contains(value));
    value.ok_or_else(|| "a luminance is a number from 0.001 to 10000".to_owned())
}

/// Runs the command.
pub fn run(args: &DiffArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let (a, b) = (Picture::read(&args.a)?, Picture::read(&args.b)?);
    ensure!(
        a.size() == b.size(),
        "the pictures are of different sizes: {:?} and {:?}",
        a.size(),
        b.size()
    );
    let value = match args.metric {
        Metric::Rmse => rmse(&a, &b),
        Metric::Ssim => ssim(&a, &b)?,
        Metric::Flip => flip(&a, &b),
        Metric::Itp => itp::mean_difference(a.linear(), b.linear(), args.white),
    };
    if json {
        let name = args.metric.to_possible_value();
        let name = name.expect("no metric is hidden").get_name().to_owned();
        return output::print_json(&json!({ "metric": name, "value": value }));
    }
    output::print(&format!("{value}\n"))
}

/// Root mean square error of linear RGB.
pub fn rmse(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.linear().iter().zip(b.linear());
    let squares: f64 = pairs.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c]))).sum();
    (squares / (3.0 * a.linear().len().max(1) as f64)).sqrt()
}

/// The absolute difference of two pictures of one size.
pub fn absolute(a: &Picture, b: &Picture) -> Picture {
    let (width, height) = a.size();
    let apart = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|c| (a[c] - b[c]).abs());
    Picture::from_linear(width, height, a.linear().iter().zip(b.linear()).map(apart).collect())
}

fn ssim(a: &Picture, b: &Picture) -> Result<f64> {
    let algorithm = image_compare::Algorithm::MSSIMSimple;
    let (a, b) = (a.encoded(), b.encoded());
    Ok(image_compare::rgb_similarity_structure(&algorithm, &a, &b)?.score)
}

/// Mean error of the FLIP difference evaluator.
pub fn flip(a: &Picture, b: &Picture) -> f64 {
    let (width, height) = a.size();
    let image = |picture: &Picture| {
        nv_flip::FlipImageRgb8::with_data(width, height, picture.encoded().as_raw())
    };
    let map = nv_flip::flip(image(a), image(b), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    f64::from(nv_flip::FlipPool::from_image(&map).mean())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(shift: f64) -> Picture {
        let pixel = |i: u32| [f64::from(i % 32) / 32.0 + shift, f64::from(i / 32) / 32.0, 0.25];
        Picture::from_linear(32, 32, (0..1024).map(pixel).collect())
    }

    #[test]
    fn equal_pictures_have_no_difference_in_any_metric() {
        let (a, b) = (gradient(0.0), gradient(0.0));
        assert_eq!(rmse(&a, &b), 0.0);
        assert_eq!(flip(&a, &b), 0.0);
        assert_eq!(itp::mean_difference(a.linear(), b.linear(), 100.0), 0.0);
        assert!((ssim(&a, &b).unwrap() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn difference_grows_with_the_shift() {
        let (a, b, c) = (gradient(0.0), gradient(0.05), gradient(0.2));
        assert!((rmse(&a, &b) - 0.05 / 3f64.sqrt()).abs() < 1e-12);
        assert!(flip(&a, &b) > 0.0 && flip(&a, &c) > flip(&a, &b));
        let itp = |other: &Picture| itp::mean_difference(a.linear(), other.linear(), 100.0);
        assert!(itp(&b) > 0.0 && itp(&c) > itp(&b));
        assert!(ssim(&a, &c).unwrap() < ssim(&a, &b).unwrap());
    }
}
