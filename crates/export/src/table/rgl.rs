//! Writer of RGL's `.bsdf`: f cos_i over half vectors, as the BSDF `measured` of Mitsuba 3 reads
//! it.
//!
//! The format's tables of microfacets are constant, so that the table of colours is over half
//! vectors: x = sqrt(2 theta_h / pi), y = (phi + pi) / (2 pi), where phi is the azimuth of the half
//! vector, minus that of the measured incidence if the material is isotropic. That incidence is the
//! direction to the eye, as in Mitsuba. The table `luminance` serves sampling alone: it is in
//! proportion to what is reflected from an area of the square.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use brood_brdf::{DirectionPair, Rgl, Swapped};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::deviation::Deviation;
use super::source::{Source, Symmetry};
use super::tensor::{self, Data, Field};
use crate::exported::Exported;
use crate::reflectance::direction;

/// Sizes of tables of isotropic materials: the first is taken if its error is at most
/// [`ISOTROPIC_ERROR`].
const ISOTROPIC: [Size; 2] = [
    Size { azimuths: 1, inclinations: 16, side: 64 },
    Size { azimuths: 1, inclinations: 32, side: 128 },
];
const ISOTROPIC_ERROR: f64 = 2e-3;
/// Sizes of tables of anisotropic materials, with azimuths over half a turn.
const ANISOTROPIC: [Size; 2] = [
    Size { azimuths: 17, inclinations: 16, side: 64 },
    Size { azimuths: 33, inclinations: 24, side: 64 },
];
const ANISOTROPIC_ERROR: f64 = 7e-3;
/// Largest inclination, in radians: at 90 degrees nothing is seen.
const STEEPEST: f64 = 1.56;
/// Added to the table of sampling, so that everything is sampled at times.
const LEAST_LUMINANCE: f64 = 1e-5;
/// Shares of red, green and blue in luminance.
const LUMA: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);
/// Least cosine of the light's direction.
const HORIZON: f64 = 1e-6;

/// Makes the file.
pub(super) fn file(source: &Source<'_>) -> Exported {
    let ([coarse, fine], error) = match source.symmetry() {
        Symmetry::Isotropic => (ISOTROPIC, ISOTROPIC_ERROR),
        Symmetry::Half | Symmetry::None => (ANISOTROPIC, ANISOTROPIC_ERROR),
    };
    let coarse = Table::of(source, coarse);
    let is_fine_enough = coarse.deviation.mean <= error;
    let table = if is_fine_enough { coarse } else { Table::of(source, fine) };
    let note = table.words(source);
    Exported { bytes: table.bytes(&format!("Made by brood: {note}")), note: Some(note) }
}

/// Directions to the eye, and entries along each side of the square.
#[derive(Clone, Copy)]
struct Size {
    azimuths: usize,
    inclinations: usize,
    side: usize,
}

struct Table {
    azimuths: Vec<f32>,
    inclinations: Vec<f32>,
    /// Entries along each side of the square.
    side: usize,
    /// f cos_i by azimuth, inclination, channel, row and column.
    rgb: Vec<f32>,
    /// Densities of sampling by azimuth, inclination, row and column.
    luminance: Vec<f32>,
    deviation: Deviation,
}

impl Table {
    fn of(source: &Source<'_>, size: Size) -> Self {
        let Size { side, .. } = size;
        let line = |to: f64, count: usize| -> Vec<f32> {
            let at = |k: usize| -PI + (to + PI) * k as f64 / (count - 1) as f64;
            (0..count).map(|k| nearest(at(k))).collect()
        };
        let azimuths = match source.symmetry() {
            Symmetry::Isotropic => vec![0.0],
            Symmetry::Half => line(0.0, size.azimuths),
            Symmetry::None => line(PI, 2 * size.azimuths - 1),
        };
        // Denser towards the horizon, where f changes most.
        let inclination = |k: usize| {
            let rest = 1.0 - k as f64 / (size.inclinations - 1) as f64;
            nearest(STEEPEST * (1.0 - rest * rest.sqrt()))
        };
        let inclinations: Vec<f32> = (0..size.inclinations).map(inclination).collect();
        let views: Vec<DVec2> = azimuths
            .iter()
            .flat_map(|phi| {
                inclinations.iter().map(|theta| DVec2::new((*phi).into(), (*theta).into()))
            })
            .collect();
        let slices: Vec<(Vec<f32>, Vec<f32>)> =
            views.par_iter().map(|view| slice(source, *view, side)).collect();
        let (rgb, luminance): (Vec<_>, Vec<_>) = slices.into_iter().unzip();
        let deviation = Deviation { mean: 0.0, median: 0.0 };
        let (rgb, luminance) = (rgb.concat(), luminance.concat());
        let mut table = Self { azimuths, inclinations, side, rgb, luminance, deviation };
        let read = Rgl::read(&table.bytes("")).expect("the file is valid");
        table.deviation = Deviation::of(&Swapped(&read), source);
        table
    }

    /// Words about the table, for people.
    fn words(&self, source: &Source<'_>) -> String {
        let azimuths = match self.azimuths.len() {
            1 => "isotropic".to_owned(),
            count => format!("anisotropic, {count} azimuths"),
        };
        let (inclinations, side) = (self.inclinations.len(), self.side);
        format!(
            "{}; {azimuths}, {inclinations} inclinations of the eye, {side} x {side} half vectors; \
             {}",
            source.words(),
            self.deviation,
        )
    }

    fn bytes(&self, description: &str) -> Vec<u8> {
        let (azimuths, inclinations) = (self.azimuths.len(), self.inclinations.len());
        let views = [azimuths, inclinations];
        let even = vec![1.0; 4 * azimuths * inclinations];
        let side = self.side;
        let field = |name, shape: &[usize], data| Field { name, shape: shape.to_vec(), data };
        let floats = |name, shape: &[usize], data| field(name, shape, Data::Floats(data));
        tensor::file(&[
            field("description", &[description.len()], Data::Bytes(description.as_bytes())),
            floats("phi_i", &[azimuths], &self.azimuths),
            floats("theta_i", &[inclinations], &self.inclinations),
            floats("ndf", &[2, 2], &[1.0; 4]),
            floats("sigma", &[2, 2], &[0.25; 4]),
            floats("vndf", &[&views[..], &[2, 2]].concat(), &even),
            floats("luminance", &[&views[..], &[side, side]].concat(), &self.luminance),
            floats("rgb", &[&views[..], &[3, side, side]].concat(), &self.rgb),
            field("jacobian", &[1], Data::Bytes(&[1])),
        ])
    }
}

/// Colours and densities of one direction to the eye, given by azimuth and inclination.
fn slice(source: &Source<'_>, view: DVec2, side: usize) -> (Vec<f32>, Vec<f32>) {
    let eye = direction(view.y, view.x);
    let origin = match source.symmetry() {
        Symmetry::Isotropic => view.x,
        Symmetry::Half | Symmetry::None => 0.0,
    };
    let unit = |k: usize| k as f64 / (side - 1) as f64;
    let mut lit = Vec::new();
    for k in 0..side * side {
        let (x, y) = (unit(k % side), unit(k / side));
        let inclination = x * x * FRAC_PI_2;
        let half = direction(inclination, TAU * y - PI + origin);
        let across = half.dot(eye);
        let light = 2.0 * across * half - eye;
        if across > 0.0 && light.z > HORIZON {
            let pair = DirectionPair::new(light, eye).expect("the directions have length 1");
            lit.push((k, pair, x * libm::sin(inclination) * across));
        }
    }
    let pairs: Vec<DirectionPair> = lit.iter().map(|(_, pair, _)| *pair).collect();
    let mut rgb = vec![0.0; 3 * side * side];
    let mut luminance = vec![nearest(LEAST_LUMINANCE); side * side];
    for ((k, pair, area), f) in lit.into_iter().zip(source.f(&pairs)) {
        let reflected = f * pair.cos_i();
        for (channel, value) in reflected.to_array().into_iter().enumerate() {
            rgb[channel * side * side + k] = nearest(value);
        }
        luminance[k] = nearest(reflected.dot(LUMA).max(0.0) * area + LEAST_LUMINANCE);
    }
    (rgb, luminance)
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}
