//! Ward's anisotropic Gaussian in its three normalisations.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use super::constants::{ModelConstants, WardForm};
use super::formula::{Formula, colors};
use super::microfacet::{gaussian_over_cos4, square};
use super::parameter::{Parameter, Values};
use super::reflect::Reflect;
use crate::block::Half;
use crate::{Block, Claims, Elementary, Machine};

/// Words of the parameter `form`.
const FORMS: &[&str] = &["bounded", "ward", "duer"];
const ALPHA: (f64, f64) = (1e-3, 1.0);

pub(super) const WARD: &[Parameter] = &[
    Parameter::color(
        "diffuse",
        "rho_d: share of light that is scattered back",
        [0.3; 3],
        (0.0, 1.0),
    ),
    Parameter::color("specular", "rho_s: share of light in the highlight", [0.2; 3], (0.0, 1.0)),
    Parameter::scalar("alpha_x", "width of the highlight along u", 0.15, ALPHA).logarithmic(),
    Parameter::scalar("alpha_y", "width of the highlight along v", 0.15, ALPHA).logarithmic(),
    Parameter::choice("form", "how the highlight is normalised", FORMS),
];

/// f = rho_d / pi + rho_s exp(-t^2) / (4 pi alpha_x alpha_y x), t^2 = ((h_x / alpha_x)^2 +
/// (h_y / alpha_y)^2) / h_z^2. The forms differ in x: cos_d^2 h_z^4 (bounded), sqrt(cos_i cos_o)
/// (ward) or cos_i cos_o (duer).
///
/// # Source
/// Ward 1992 and the publications of each [`WardForm`].
#[derive(Debug, Clone)]
pub(super) struct Ward {
    lobe: Lobe,
    form: WardForm,
    /// True if diffuse and specular albedo add up to at most 1.
    is_conserving: bool,
}

pub(super) fn ward(values: Values<'_>) -> Ward {
    let form = match values.choice("form") {
        "bounded" => WardForm::Bounded,
        "ward" => WardForm::Ward,
        "duer" => WardForm::Duer,
        word => panic!("unknown form {word}"),
    };
    let (diffuse, specular) = (values.color("diffuse"), values.color("specular"));
    let alpha = DVec2::new(values.scalar("alpha_x"), values.scalar("alpha_y"));
    let lobe = Lobe {
        diffuse: diffuse * FRAC_1_PI,
        specular: specular / (4.0 * PI * alpha.x * alpha.y),
        inverse: 1.0 / alpha,
    };
    let is_conserving = (diffuse + specular).max_element() <= 1.0;
    Ward { lobe, form, is_conserving }
}

/// Coefficients with the constant part of the normalisation.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    diffuse: DVec3,
    specular: DVec3,
    /// 1 / alpha along u and along v.
    inverse: DVec2,
}

/// Formula of [`WardForm::Bounded`].
struct Bounded(Lobe);
/// Formula of [`WardForm::Ward`].
struct Classic(Lobe);
/// Formula of [`WardForm::Duer`].
struct Duer(Lobe);

impl Lobe {
    /// exp(-t^2)
    #[inline(always)]
    fn gaussian<F: Elementary>(&self, half: &Half) -> f64 {
        let h = half.h;
        F::exp(-(square(h.x * self.inverse.x) + square(h.y * self.inverse.y)) / (h.z * h.z))
    }
}

impl Formula for Bounded {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let Self(lobe) = self;
        // The source divides by (h . n)^4 / (h . h) of wi + wo, which is 4 cos_d^2 h_z^4.
        let high = gaussian_over_cos4::<F>(half, lobe.inverse) / (half.cos_d * half.cos_d);
        lobe.diffuse + lobe.specular * high
    }
}

impl Formula for Classic {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let Self(lobe) = self;
        let high = lobe.gaussian::<F>(half) / (half.cos_i() * half.cos_o()).sqrt();
        lobe.diffuse + lobe.specular * high
    }
}

impl Formula for Duer {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let Self(lobe) = self;
        lobe.diffuse + lobe.specular * (lobe.gaussian::<F>(half) / (half.cos_i() * half.cos_o()))
    }
}

impl Reflect for Ward {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        match self.form {
            WardForm::Bounded => colors(machine, block, Bounded(self.lobe)),
            WardForm::Ward => colors(machine, block, Classic(self.lobe)),
            WardForm::Duer => colors(machine, block, Duer(self.lobe)),
        }
    }

    fn claims(&self) -> Claims {
        Claims {
            reciprocal: true,
            conserving: self.is_conserving && matches!(self.form, WardForm::Bounded),
        }
    }

    fn constants(&self) -> ModelConstants {
        let Lobe { diffuse, specular, inverse } = self.lobe;
        ModelConstants::Ward { form: self.form, diffuse, specular, inverse }
    }
}
