//! Radiometric and photometric units: conversion factors and formulas for flux, intensity,
//! irradiance and radiance.
//!
//! Independent of scenes: every function is one line of arithmetic and works on any colour channel.
//!
//! Quantities come in pairs, each related by one factor: W and lm, W/sr and cd, W/m2 and lx,
//! W/(m2 sr) and nit (cd/m2). The factor depends on the spectrum. Colours have three channels, each
//! in the unit of white light of that strength: a white lamp of 60 W has 60 in every channel, and a
//! photometric channel is the radiometric one times [`EFFICACY_WHITE`].

use std::f64::consts::PI;

/// Luminous efficacy at 555 nm, where the eye is most sensitive.
///
/// # Units
/// lm/W.
///
/// # Source
/// The SI defines the candela by 683 lm/W at 540 THz (BIPM 2019, The International System of Units,
/// 2.3.1).
pub const EFFICACY_555_NM: f64 = 683.0;

/// Luminous efficacy of white light: a spectrum of equal energy over the visible range and none
/// outside.
///
/// # Units
/// lm/W.
///
/// # Error
/// This is a convention. 683 lm/W times the integral of V(lambda), 106.86 nm, is 182.5 lm/W for a
/// range of 400 nm. Lamps that also radiate outside the visible range have less in total: a white
/// LED about 300 of its visible light, a filament about 15 of all its power.
///
/// # Source
/// Ward Larson and Shakespeare 1998, *Rendering with Radiance*: 179 lm/W for uniform white light.
pub const EFFICACY_WHITE: f64 = 179.0;

/// Weights of linear red, green and blue in luminance.
///
/// # Source
/// ITU-R BT.709-6, 3.2, whose primaries are those of sRGB.
pub const LUMINANCE_WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Converts a radiometric to the photometric quantity: W to lm, W/sr to cd, W/m2 to lx, W/(m2 sr)
/// to nit.
///
/// # Units
/// `efficacy` in lm/W: [`EFFICACY_555_NM`], [`EFFICACY_WHITE`], or that of another spectrum.
#[must_use]
pub fn photometric(radiometric: f64, efficacy: f64) -> f64 {
    radiometric * efficacy
}

/// Converts a photometric to the radiometric quantity: lm to W, cd to W/sr, lx to W/m2, nit to
/// W/(m2 sr).
///
/// # Units
/// `efficacy` in lm/W, above 0.
#[must_use]
pub fn radiometric(photometric: f64, efficacy: f64) -> f64 {
    photometric / efficacy
}

/// Weighted mean of the channels: luminance of a radiance, total flux of a flux, and so on.
#[must_use]
pub fn luminance(channels: [f64; 3]) -> f64 {
    channels.iter().zip(LUMINANCE_WEIGHTS).map(|(channel, weight)| channel * weight).sum()
}

/// Intensity of a point source that emits equally in all directions.
///
/// # Units
/// W to W/sr, or lm to cd.
#[must_use]
pub fn isotropic_intensity(flux: f64) -> f64 {
    flux / (4.0 * PI)
}

/// On-axis intensity of a spot light of the given flux: full within the hotspot, then linear in the
/// cosine down to 0 at the fall-off.
///
/// # Units
/// W to W/sr, or lm to cd.
///
/// # Domain
/// 1 >= `cos_hotspot` >= `cos_falloff` >= -1, not both 1 (such a cone has no solid angle and the
/// intensity would be infinite).
///
/// # Source
/// Integral of the profile over the sphere: 2 pi (1 - (cos H + cos F) / 2).
#[must_use]
pub fn spot_intensity(flux: f64, cos_hotspot: f64, cos_falloff: f64) -> f64 {
    flux / (2.0 * PI * (1.0 - 0.5 * (cos_hotspot + cos_falloff)))
}

/// Radiance of a one-sided Lambertian surface of uniform exitance.
///
/// # Units
/// W and m2 to W/(m2 sr), or lm and m2 to nit.
///
/// # Domain
/// An area above 0.
#[must_use]
pub fn lambertian_radiance(flux: f64, area: f64) -> f64 {
    flux / (PI * area)
}

/// Irradiance at normal incidence at a distance from a point source (inverse square law).
///
/// # Units
/// W/sr and m to W/m2, or cd and m to lx.
///
/// # Domain
/// A distance above 0.
#[must_use]
pub fn irradiance_at(intensity: f64, distance: f64) -> f64 {
    intensity / (distance * distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs()
    }

    #[test]
    fn photometric_conversion_round_trips() {
        assert!(close(photometric(1.0, EFFICACY_555_NM), 683.0));
        assert!(close(photometric(60.0, EFFICACY_WHITE), 10_740.0));
        for value in [0.0, 1e-9, 3.0, 1e12] {
            for efficacy in [EFFICACY_555_NM, EFFICACY_WHITE, 15.0] {
                let back = radiometric(photometric(value, efficacy), efficacy);
                assert!(close(back, value), "{value} {efficacy}");
            }
        }
    }

    #[test]
    fn luminance_of_white_equals_its_channels() {
        assert!(close(luminance([5.0; 3]), 5.0));
        assert!(luminance([0.0, 1.0, 0.0]) > luminance([1.0, 0.0, 0.0]));
    }

    #[test]
    fn point_of_one_candela_emits_4_pi_lumens_and_gives_one_lux_at_one_metre() {
        let candela = isotropic_intensity(4.0 * PI);
        assert!(close(candela, 1.0));
        assert!(close(irradiance_at(candela, 1.0), 1.0));
        assert!(close(irradiance_at(candela, 2.0), 0.25));
    }

    #[test]
    fn spot_equals_point_light_over_the_sphere_and_integrates_to_its_flux() {
        assert!(close(spot_intensity(7.0, -1.0, -1.0), isotropic_intensity(7.0)));
        for (hotspot, falloff) in [(0.9, 0.8), (0.5, 0.5), (1.0, 0.0), (0.2, -0.7)] {
            let peak = spot_intensity(100.0, hotspot, falloff);
            let steps = 100_000;
            let sum: f64 = (0..steps)
                .map(|k| {
                    let cos = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(steps);
                    let inside = cos >= hotspot;
                    if inside { 1.0 } else { ((cos - falloff) / (hotspot - falloff)).max(0.0) }
                })
                .sum();
            let flux = peak * sum * 4.0 * PI / f64::from(steps);
            assert!((flux - 100.0).abs() < 2e-2, "{hotspot} {falloff}: {flux}");
        }
    }

    #[test]
    fn square_metre_of_one_nit_emits_pi_lumens() {
        assert!(close(lambertian_radiance(PI, 1.0), 1.0));
        assert!(close(lambertian_radiance(PI, 0.25), 4.0));
    }
}
