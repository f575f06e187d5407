//! The flux of a profile: its bilinear interpolation, integrated over the sphere in closed form.

use std::f64::consts::PI;

use super::profile::{Fold, IesProfile, Photometry};
use crate::angle::sin_cos_deg;

/// The integral of intensity over all directions.
pub(super) fn lumens(profile: &IesProfile) -> f64 {
    let IesProfile { photometry, fold, vertical, horizontal, candela, .. } = profile;
    let columns = candela.chunks(vertical.len());
    let along: fn(&[f64], &[f64]) -> f64 = match photometry {
        Photometry::C => weighted_by_sine,
        Photometry::A => weighted_by_cosine,
        Photometry::B => plain,
    };
    let columns: Vec<f64> = columns.map(|column| along(vertical, column)).collect();
    // Of types A and B a half stands for the other one too.
    let halves = match photometry {
        Photometry::C => 1.0,
        Photometry::A | Photometry::B if vertical[0] >= 0.0 => 2.0,
        Photometry::A | Photometry::B => 1.0,
    };
    let across = match photometry {
        Photometry::B => weighted_by_cosine(horizontal, &columns),
        Photometry::A | Photometry::C => plain(horizontal, &columns),
    };
    let last = columns.len() - 1;
    halves
        * match fold {
            Fold::Axial => 2.0 * PI * columns[0],
            Fold::Quarters => 4.0 * across,
            Fold::Halves | Fold::Sides | Fold::Mirrored => 2.0 * across,
            Fold::Whole | Fold::Both => across,
            Fold::Open => {
                let gap = radians(360.0 - horizontal[last]);
                across + 0.5 * gap * (columns[last] + columns[0])
            }
        }
}

fn radians(degrees: f64) -> f64 {
    degrees * (PI / 180.0)
}

/// The pieces between neighbours: both angles in degrees, both values.
fn pieces<'a>(
    angles: &'a [f64],
    values: &'a [f64],
) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + 'a {
    let angles = angles.windows(2).map(|pair| [pair[0], pair[1]]);
    angles.zip(values.windows(2).map(|pair| [pair[0], pair[1]]))
}

/// The integral of the values, linear in the angle.
fn plain(angles: &[f64], values: &[f64]) -> f64 {
    pieces(angles, values).map(|([from, to], [a, b])| 0.5 * radians(to - from) * (a + b)).sum()
}

/// The same times the sine of the angle.
fn weighted_by_sine(angles: &[f64], values: &[f64]) -> f64 {
    let piece = |([from, to], [a, b]): ([f64; 2], [f64; 2])| {
        let slope = (b - a) / radians(to - from);
        let ((sin, cos), (sin_to, cos_to)) = (sin_cos_deg(from), sin_cos_deg(to));
        a * cos - b * cos_to + slope * (sin_to - sin)
    };
    pieces(angles, values).map(piece).sum()
}

/// The same times the cosine of the angle.
fn weighted_by_cosine(angles: &[f64], values: &[f64]) -> f64 {
    let piece = |([from, to], [a, b]): ([f64; 2], [f64; 2])| {
        let slope = (b - a) / radians(to - from);
        let ((sin, cos), (sin_to, cos_to)) = (sin_cos_deg(from), sin_cos_deg(to));
        b * sin_to - a * sin + slope * (cos_to - cos)
    };
    pieces(angles, values).map(piece).sum()
}
