//! Equirectangular environment.

use std::f64::consts::PI;
use std::sync::Arc;

use brood_mesh::angle::rotation_y_deg;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;
use utoipa::openapi::Schema;

use super::kind::{At, Draw, Kind, Source};
use super::strength::Channels;
use crate::assets::{AssetRef, LightAssets};
use crate::environment::{BuiltinEnvironment, EnvironmentMap, MEAN_SIDE, PrefilteredEnvironment};
use crate::field::FieldError;
use crate::sampler::mixture::Mixture;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver};

/// Default number of samples of environments and ambient light per shading point
/// (docs/maths/lights.md).
pub const ENVIRONMENT_SAMPLES: u32 = 64;
/// Largest scale of prefiltered light, so that its sums do not overflow.
const SCALE_MAX: f64 = 1e10;
/// Share of an environment's samples that are drawn in proportion to its luminance.
const BY_LIGHT: f64 = 0.5;

/// Equirectangular environment at infinity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentLight {
    /// "studio", "overcast", "low-sun", "interior", or the name of the picture among the assets,
    /// the id of the uploaded file. Equirectangular: upper edge +y, middle -z, +x a quarter of the
    /// width to the right of the middle.
    #[schema(min_length = 1, max_length = 255)]
    pub image: String,
    /// Rotation about the vertical axis, from +z towards +x, degrees.
    #[serde(default)]
    #[schema(default = 0)]
    pub rotation_deg: f64,
    /// Factor from pixel values to radiance in W/(m2 sr), for red, green and blue. Default: 1.
    #[serde(default = "unscaled", deserialize_with = "channels")]
    #[schema(schema_with = scale_schema)]
    pub scale: [f64; 3],
    /// Samples per shading point.
    #[serde(default = "environment_samples")]
    #[schema(minimum = 1, maximum = 1024, default = environment_samples)]
    pub samples: u32,
    /// True if it stays in place while `light_deg` moves the lights. Default: false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fixed: bool,
    /// False if its light passes through objects although the scene has shadows: pictures then take
    /// a fraction of the time. Default: true.
    #[serde(default = "casts", skip_serializing_if = "Clone::clone")]
    #[schema(default = true)]
    pub shadows: bool,
}

fn casts() -> bool {
    true
}

fn unscaled() -> [f64; 3] {
    [1.0; 3]
}

fn channels<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    Channels::deserialize(deserializer).map(|channels| channels.0)
}

fn scale_schema() -> Schema {
    Channels::described(
        "Factor from pixel values to radiance in W/(m2 sr): for red, green and blue, or one number \
         for all. Default: 1.",
    )
}

pub(super) fn environment_samples() -> u32 {
    ENVIRONMENT_SAMPLES
}

impl Kind for EnvironmentLight {
    type Source = EnvironmentSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.asset_name(&self.image, "image")?;
        at.finite(self.rotation_deg, "rotation_deg")?;
        at.channels(self.scale, "scale")?;
        at.samples(self.samples)
    }

    fn samples(&self) -> u32 {
        self.samples
    }

    fn casts_shadows(&self) -> bool {
        self.shadows
    }

    fn asset(&self) -> Option<AssetRef<'_>> {
        let is_uploaded = BuiltinEnvironment::from_name(&self.image).is_none();
        is_uploaded.then_some(AssetRef::Environment(&self.image))
    }

    fn source(
        &self,
        placement: &LightPlacement<'_>,
        assets: &LightAssets,
    ) -> Option<EnvironmentSource> {
        let map = match BuiltinEnvironment::from_name(&self.image) {
            Some(builtin) => builtin.map(),
            None => assets.environment(&self.image)?.clone(),
        };
        let own = rotation_y_deg(self.rotation_deg);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (own * axis).to_array());
        let [x, y, z] = axes.map(|axis| match self.fixed {
            true => placement.fixed_direction(axis),
            false => placement.direction(axis),
        });
        let rotation = DMat3::from_cols(x, y, z);
        Some(EnvironmentSource { map, rotation, scale: self.scale })
    }
}

impl EnvironmentSource {
    /// Returns the light as prefiltered radiance.
    pub(crate) fn prefiltered(&self) -> PrefilteredEnvironment {
        PrefilteredEnvironment {
            map: self.map.clone(),
            turn: self.rotation.transpose(),
            scale: self.scale.map(|channel| channel.min(SCALE_MAX) as f32),
        }
    }
}

/// Environment picture, rotated as the scene defines.
#[derive(Debug, Clone)]
pub(crate) struct EnvironmentSource {
    map: Arc<EnvironmentMap>,
    /// Rotation from the picture's directions to the unit frame.
    rotation: DMat3,
    scale: [f64; 3],
}

impl Source for EnvironmentSource {
    const IS_SOFT: bool = true;

    /// Multiple importance sampling: half of the directions are drawn in proportion to luminance,
    /// half from the material lobes of [`Mixture`]. Weights use the combined density.
    ///
    /// # Source
    /// Veach and Guibas 1995, *Optimally Combining Sampling Techniques*: the balance heuristic.
    fn for_each_sample(
        &self,
        receiver: &Receiver,
        draw: &Draw,
        mut put: impl FnMut(u32, LightSample),
    ) {
        let (points, samples) = (draw.points(receiver), draw.samples);
        let frame = &receiver.frame;
        let mixture = Mixture::new(receiver.wo);
        for sample in 0..samples {
            let [across, down] = points.at(sample);
            let (towards, radiance) = if across < BY_LIGHT {
                let Some(drawn) = self.map.draw([across / BY_LIGHT, down]) else { continue };
                ((self.rotation * drawn.0).normalize(), drawn.1)
            } else {
                let local = mixture.draw([(across - BY_LIGHT) / (1.0 - BY_LIGHT), down]);
                let towards = frame.global(local).normalize();
                (towards, self.map.radiance((self.rotation.transpose() * towards).normalize()))
            };
            let by_material = mixture.density(frame.local(towards));
            let density = BY_LIGHT * self.map.density(radiance) + (1.0 - BY_LIGHT) * by_material;
            let weight = 1.0 / (f64::from(samples) * density);
            let [r, g, b] = self.scale;
            let irradiance =
                [radiance[0] * r * weight, radiance[1] * g * weight, radiance[2] * b * weight];
            put(
                sample,
                LightSample { towards, irradiance, distance: f64::INFINITY, fading: false },
            );
        }
    }

    fn central(&self, _: DVec3, mean: Option<DVec3>) -> Option<CentralLight> {
        Some(CentralLight { towards: mean, irradiance: self.reference_irradiance(DVec3::ZERO)? })
    }

    fn mean_direction(&self) -> Option<DVec3> {
        let sum = self.map.sum_of_directions();
        (self.rotation * sum / f64::from(MEAN_SIDE * MEAN_SIDE)).try_normalize()
    }

    fn reference_irradiance(&self, _: DVec3) -> Option<[f64; 3]> {
        let [r, g, b] = self.map.mean();
        Some([PI * r * self.scale[0], PI * g * self.scale[1], PI * b * self.scale[2]])
    }
}
