//! Models made to fit measured materials: ABC and SGD, with the conventions of their published tables.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::fresnel;
use super::half::Half;
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

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
struct Abc {
    diffuse: DVec3,
    a: DVec3,
    b: f64,
    c: f64,
    ior: f64,
}

pub(super) fn abc(values: Values<'_>) -> Box<dyn Brdf> {
    Box::new(Abc {
        diffuse: values.color("diffuse"),
        a: values.color("a"),
        b: values.scalar("b"),
        c: values.scalar("c"),
        ior: values.scalar("ior"),
    })
}

impl Brdf for Abc {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let h = half.h;
        // 1 - cos_h without cancellation: sin^2 / (1 + cos).
        let off = (h.x * h.x + h.y * h.y) / (1.0 + h.z);
        let d = libm::pow(1.0 + self.b * off, -self.c);
        // G / (cos_i cos_o), finite at the horizon.
        let most = half.cos_i.max(half.cos_o);
        let flat = 1.0 / (half.cos_i * half.cos_o);
        let visible = flat.min(2.0 * h.z / (half.cos_d * most));
        let facets = FRAC_1_PI * fresnel::dielectric(self.ior, half.cos_d) * d * visible;
        self.diffuse * FRAC_1_PI + self.a * facets
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
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

/// f = (rho_D + rho_S F D G(i) G(o) / (cos_i cos_o)) / pi, in each channel by itself.
///
/// # Domain
/// With the parameters of the published tables some values are negative or not finite; what is not finite is 0 here.
///
/// # Source
/// Bagher, Soler and Holzschuch 2012, equations 8 to 13.
struct Sgd {
    channels: [Channel; 3],
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    rho_d: f64,
    rho_s: f64,
    alpha: f64,
    p: f64,
    f0: f64,
    f1: f64,
    normal: f64,
    lambda: f64,
    c: f64,
    k: f64,
    theta0: f64,
}

pub(super) fn sgd(values: Values<'_>) -> Box<dyn Brdf> {
    let of = |channel: usize| {
        let value = |name| values.color(name)[channel];
        Channel {
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
    Box::new(Sgd { channels: [of(0), of(1), of(2)] })
}

impl Channel {
    fn f(&self, half: &Half) -> f64 {
        let c = half.cos_d;
        let reflectance = self.f0 - c * self.f1 + (1.0 - c).powi(5) * (1.0 - self.f0);
        let tan2 = half.tan2();
        let a = self.alpha + tan2 / self.alpha;
        let cos4 = half.h.z.powi(4);
        let d = self.normal * libm::exp(-a) / (PI * libm::pow(a, self.p) * cos4);
        let shadow = |cos: f64| {
            let theta = libm::acos(cos.min(1.0));
            let past = (theta - self.theta0).max(0.0);
            let hidden = 1.0 - libm::exp(self.c * libm::pow(past, self.k));
            (1.0 + self.lambda * hidden).clamp(0.0, 1.0)
        };
        let seen = shadow(half.cos_i) * shadow(half.cos_o) / (half.cos_i * half.cos_o);
        let f = FRAC_1_PI * (self.rho_d + self.rho_s * reflectance * d * seen);
        if f.is_finite() { f } else { 0.0 }
    }
}

impl Brdf for Sgd {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        DVec3::from_array(self.channels.map(|channel| channel.f(&half)))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}
