//! Luminaires with a photometric profile.

use std::sync::Arc;

use glam::DVec3;

use super::Arrival;
use super::placing::Placing;
use crate::units::{EFFICACY_WHITE, luminance, radiometric};
use crate::{IesLight, IesProfile, LightAssets, Measure};

/// A luminaire.
#[derive(Debug, Clone)]
pub(super) struct IesSource {
    position: DVec3,
    /// The frame of the luminaire: x, y, z.
    axes: [DVec3; 3],
    profile: Arc<IesProfile>,
    /// From candelas to irradiance times the square of a distance in the unit frame.
    scale: [f64; 3],
}

impl IesSource {
    /// `None` where there is no such profile.
    pub fn new(light: &IesLight, placing: &Placing<'_>, assets: &LightAssets) -> Option<Self> {
        let profile = assets.profile(&light.profile)?.clone();
        let position = placing.position(light.position);
        let axis = placing.axis(light.axis, position);
        let axes = placing.axes(axis, light.up);
        let tilt_cos = axis.dot(placing.down()).clamp(-1.0, 1.0);
        let tilt = profile.tilt_factor(libm::acos(tilt_cos).to_degrees());
        let unit = placing.unit();
        let channels = match light.strength {
            None => [radiometric(1.0, EFFICACY_WHITE); 3],
            Some(strength) => {
                let whole = match strength.quantity.measure() {
                    Measure::Flux => profile.lumens(),
                    Measure::Intensity | Measure::Irradiance | Measure::Radiance => {
                        profile.peak_candela()
                    }
                };
                // Nothing cannot be made brighter.
                let share = if whole > 0.0 { 1.0 / whole } else { 0.0 };
                strength.radiometric().map(|channel| channel * share)
            }
        };
        let scale = channels.map(|channel| channel * tilt / (unit * unit));
        Some(Self { position, axes, profile, scale })
    }

    /// `None` where it does not shine.
    pub fn at(&self, place: DVec3) -> Option<Arrival> {
        let towards = self.position - place;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let towards = towards / squared.sqrt();
        let local = DVec3::from(self.axes.map(|axis| -towards.dot(axis)));
        let candela = self.profile.candela(local);
        let irradiance = self.scale.map(|channel| channel * candela / squared);
        let distance = squared.sqrt();
        (candela > 0.0).then_some(Arrival { towards, irradiance, distance, fading: false })
    }

    /// As if the brightest direction went to the centre of the mesh.
    pub fn usual(&self) -> Option<[f64; 3]> {
        let squared = self.position.length_squared();
        let peak = self.profile.peak_candela() / squared;
        (luminance(self.scale) > 0.0 && squared > 0.0).then(|| self.scale.map(|c| c * peak))
    }
}
