//! IES lights: luminaires with a photometric profile.

use std::sync::Arc;

use glam::DVec3;

use super::placement::LightPlacement;
use super::sample::LightSample;
use crate::assets::LightAssets;
use crate::ies::IesProfile;
use crate::light::{IesLight, Measure};
use crate::units::{EFFICACY_WHITE, luminance, radiometric};

/// Luminaire with a photometric profile.
#[derive(Debug, Clone)]
pub(super) struct IesSource {
    position: DVec3,
    /// Axes x, y and z of the luminaire.
    axes: [DVec3; 3],
    profile: Arc<IesProfile>,
    /// Factor from candelas to irradiance times squared distance in the unit frame.
    scale: [f64; 3],
}

impl IesSource {
    /// Returns `None` if the profile is missing.
    pub fn new(
        light: &IesLight,
        placement: &LightPlacement<'_>,
        assets: &LightAssets,
    ) -> Option<Self> {
        let profile = assets.profile(&light.profile)?.clone();
        let position = placement.position(light.position);
        let axis = placement.axis(light.axis, position);
        let axes = placement.axes(axis, light.up);
        let tilt_cos = axis.dot(placement.down()).clamp(-1.0, 1.0);
        let tilt = profile.tilt_factor(libm::acos(tilt_cos).to_degrees());
        let unit = placement.unit();
        let channels = match light.strength {
            None => [radiometric(1.0, EFFICACY_WHITE); 3],
            Some(strength) => {
                let whole = match strength.quantity.measure() {
                    Measure::Flux => profile.lumens(),
                    Measure::Intensity | Measure::Irradiance | Measure::Radiance => {
                        profile.peak_candela()
                    }
                };
                // A dark profile cannot be scaled to a strength.
                let share = if whole > 0.0 { 1.0 / whole } else { 0.0 };
                strength.radiometric().map(|channel| channel * share)
            }
        };
        let scale = channels.map(|channel| channel * tilt / (unit * unit));
        Some(Self { position, axes, profile, scale })
    }

    /// Returns the sample at a position; `None` where the profile is 0.
    pub fn at(&self, position: DVec3) -> Option<LightSample> {
        let towards = self.position - position;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let towards = towards / squared.sqrt();
        let local = DVec3::from(self.axes.map(|axis| -towards.dot(axis)));
        let candela = self.profile.candela(local);
        let irradiance = self.scale.map(|channel| channel * candela / squared);
        let distance = squared.sqrt();
        (candela > 0.0).then_some(LightSample { towards, irradiance, distance, fading: false })
    }

    /// Returns the irradiance at the centre of the mesh, as if it were in the peak direction.
    pub fn reference_irradiance(&self) -> Option<[f64; 3]> {
        let squared = self.position.length_squared();
        let peak = self.profile.peak_candela() / squared;
        (luminance(self.scale) > 0.0 && squared > 0.0).then(|| self.scale.map(|c| c * peak))
    }
}
