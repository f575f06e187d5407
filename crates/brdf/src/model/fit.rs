//! Models made to fit measured materials: ABC and the shifted gamma distribution (SGD), with the
//! conventions of their published tables of fits.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::constants::{ModelConstants, SgdChannel};
use super::formula::{Formula, colors, scalars};
use super::fresnel;
use super::parameter::{Parameter, Values};
use super::reflect::Reflect;
use crate::block::{Half, larger, smaller};
use crate::{Block, Claims, Elementary, Machine};

pub(super) const ABC: &[Parameter] = &[
    Parameter::color("diffuse", "k_D", [0.1; 3], (0.0, 1.0)),
    Parameter::color("a", "A: height of the highlight", [20.0; 3], (0.0, 1e6)),
    Parameter::scalar("b", "B: how narrow the highlight is", 1000.0, (1.0, 1e8)).logarithmic(),
    Parameter::scalar("c", "C: how fast the highlight falls off", 1.0, (0.01, 10.0)).logarithmic(),
    Parameter::scalar("ior", "refractive index", 1.5, (1.0, 100.0)).logarithmic(),
];

/// f = k_D / pi + F D G / (pi cos_i cos_o) with D = A / (1 + B (1 - cos_h))^C.
///
/// # Source
/// Low et al. 2012, the microfacet model of section 4.
#[derive(Debug, Clone)]
pub(super) struct Abc {
    diffuse: DVec3,
    a: DVec3,
    b: f64,
    c: f64,
    ior: f64,
}

pub(super) fn abc(values: Values<'_>) -> Abc {
    Abc {
        diffuse: values.color("diffuse"),
        a: values.color("a"),
        b: values.scalar("b"),
        c: values.scalar("c"),
        ior: values.scalar("ior"),
    }
}

impl Formula for &Abc {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        // 1 - cos_h without cancellation: sin^2 / (1 + cos).
        let off = half.sin2() / (1.0 + half.h.z);
        let d = F::pow(1.0 + self.b * off, -self.c);
        // G / (cos_i cos_o), finite at the horizon.
        let flat = 1.0 / (half.cos_i() * half.cos_o());
        let visible = smaller(flat, 2.0 * half.h.z / (half.cos_d * half.cos_max()));
        let facets = FRAC_1_PI * fresnel::dielectric(self.ior, half.cos_d) * d * visible;
        self.diffuse * FRAC_1_PI + self.a * facets
    }
}

impl Reflect for Abc {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        colors(machine, block, self)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::Abc {
            diffuse: self.diffuse * FRAC_1_PI,
            a: self.a * FRAC_1_PI,
            b: self.b,
            c: self.c,
            ior: self.ior,
        }
    }
}

pub(super) const SGD: &[Parameter] = &[
    Parameter::color("rho_d", "share of light that is scattered back", [0.1; 3], (0.0, 2.0)),
    Parameter::color("rho_s", "weight of the highlight", [0.1; 3], (0.0, 10.0)),
    Parameter::color("alpha", "roughness", [0.1; 3], (1e-9, 10.0)).logarithmic(),
    Parameter::color("p", "how fast the highlight falls off", [0.7; 3], (0.0, 10.0)),
    Parameter::color("f0", "F_0 of the reflectance", [0.05; 3], (-20.0, 20.0)),
    Parameter::color("f1", "F_1 of the reflectance", [0.05; 3], (-20.0, 20.0)),
    Parameter::color("k_normal", "K: normalises the distribution", [10.0; 3], (0.0, 1e6)),
    Parameter::color("lambda", "of the shadowing", [3.0; 3], (0.0, 1e8)),
    Parameter::color("c", "of the shadowing", [1e-7; 3], (0.0, 1e38)),
    Parameter::color("k", "of the shadowing", [40.0; 3], (0.0, 1e4)),
    Parameter::color("theta0", "of the shadowing", [0.0; 3], (-2.0, 2.0)).in_unit("rad"),
];

/// f = (rho_D + rho_S F D G(i) G(o) / (cos_i cos_o)) / pi, with separate constants for each
/// channel.
///
/// # Domain
/// With the parameters of the published tables some values are negative or not finite. Values that
/// are not finite become 0.
///
/// # Source
/// Bagher, Soler and Holzschuch 2012, equations 8 to 13.
#[derive(Debug, Clone)]
pub(super) struct Sgd {
    channels: [SgdChannel; 3],
}

pub(super) fn sgd(values: Values<'_>) -> Sgd {
    let of = |channel: usize| {
        let value = |name| values.color(name)[channel];
        SgdChannel {
            rho_d: value("rho_d"),
            rho_s: value("rho_s"),
            alpha: value("alpha"),
            p: value("p"),
            f0: value("f0"),
            f1: value("f1"),
            normal: value("k_normal"),
            lambda: value("lambda"),
            c: value("c"),
            k: value("k"),
            theta0: value("theta0"),
        }
    };
    Sgd { channels: [of(0), of(1), of(2)] }
}

/// Angle between one of the directions and the normal.
struct Angle {
    is_light: bool,
}

impl Formula for Angle {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        let cosine = if self.is_light { half.cos_i() } else { half.cos_o() };
        F::acos(smaller(cosine, 1.0))
    }
}

/// Formula of one channel, given the angles of both directions.
struct ChannelFormula<'a, const N: usize> {
    channel: &'a SgdChannel,
    thetas: &'a [[f64; N]; 2],
}

impl SgdChannel {
    /// G = 1 + lambda (1 - exp(c max(theta - theta_0, 0)^k)), clamped to [0, 1].
    #[inline(always)]
    fn shadow<F: Elementary>(&self, theta: f64) -> f64 {
        // Where the power overflows, 0 times infinity would be NaN.
        if self.lambda == 0.0 || self.c == 0.0 {
            return 1.0;
        }
        let past = larger(theta - self.theta0, 0.0);
        let hidden = 1.0 - F::exp(self.c * F::pow(past, self.k));
        // `clamp` keeps NaN, for which f is 0.
        (1.0 + self.lambda * hidden).clamp(0.0, 1.0)
    }
}

impl<const N: usize> Formula for ChannelFormula<'_, N> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> f64 {
        let channel = self.channel;
        let c = half.cos_d;
        let reflectance =
            channel.f0 - c * channel.f1 + fresnel::schlick_weight(c) * (1.0 - channel.f0);
        let cos2 = half.h.z * half.h.z;
        let a = channel.alpha + half.sin2() / cos2 / channel.alpha;
        // exp(-a) / a^p
        let fall = F::exp(-a - channel.p * F::ln(a));
        let d = channel.normal * fall / (PI * (cos2 * cos2));
        let [theta_i, theta_o] = self.thetas;
        let shadows = channel.shadow::<F>(theta_i[k]) * channel.shadow::<F>(theta_o[k]);
        let seen = shadows / (half.cos_i() * half.cos_o());
        let f = FRAC_1_PI * (channel.rho_d + channel.rho_s * reflectance * d * seen);
        if f.abs() < f64::INFINITY { f } else { 0.0 }
    }
}

/// Combines three channels to colours, which are 0 in unlit lanes.
struct MergedChannels<'a, const N: usize>(&'a [[f64; N]; 3]);

impl<const N: usize> Formula for MergedChannels<'_, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, _: &Half, k: usize) -> DVec3 {
        let [red, green, blue] = self.0;
        DVec3::new(red[k], green[k], blue[k])
    }
}

impl Reflect for Sgd {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        let thetas = &[true, false].map(|is_light| scalars(machine, block, Angle { is_light }));
        let of = |channel| scalars(machine, block, ChannelFormula { channel, thetas });
        let [red, green, blue] = &self.channels;
        colors(machine, block, MergedChannels(&[of(red), of(green), of(blue)]))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::Sgd { channels: self.channels }
    }
}
