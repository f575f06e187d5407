//! Uniform radiance from every direction.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::environment::environment_samples;
use super::kind::{At, Draw, Kind, Source};
use super::strength::{FromEverywhere, Group, Strength};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::mixture::{Mixture, by_cosine};
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver};

/// Uniform radiance from every direction. A surface shows its directional albedo towards the eye.
/// At most one of `radiance_w_m2_sr` and `luminance_nit`; by default the radiance is 1, whose
/// irradiance is pi.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AmbientLight {
    /// Radiance or luminance.
    #[serde(flatten, with = "FromEverywhere")]
    #[schema(schema_with = FromEverywhere::schema)]
    pub strength: Option<Strength>,
    /// Samples per shading point.
    #[serde(default = "environment_samples")]
    #[schema(minimum = 1, maximum = 1024, default = environment_samples)]
    pub samples: u32,
}

impl Kind for AmbientLight {
    type Source = AmbientSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.strength(self.strength, FromEverywhere::QUANTITIES)?;
        at.samples(self.samples)
    }

    fn samples(&self) -> u32 {
        self.samples
    }

    fn source(&self, _: &LightPlacement<'_>, _: &LightAssets) -> Option<AmbientSource> {
        let radiance = self.strength.map_or([1.0; 3], |strength| strength.radiometric());
        Some(AmbientSource { radiance })
    }
}

/// Equal radiance from all directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AmbientSource {
    radiance: [f64; 3],
}

impl Source for AmbientSource {
    const IS_SOFT: bool = true;

    /// Samples directions from the material lobes of [`Mixture`]. Weights are normalised to the
    /// exact sum of irradiance times cosine, pi times radiance, so diffuse materials have no noise.
    /// If all directions are below the horizon, one cosine-distributed direction replaces them.
    fn for_each_sample(
        &self,
        receiver: &Receiver,
        draw: &Draw,
        mut put: impl FnMut(u32, LightSample),
    ) {
        let (points, samples) = (draw.points(receiver), draw.samples);
        let mixture = Mixture::new(receiver.wo);
        let mut drawn: Vec<(u32, DVec3, f64)> = (0..samples)
            .map(|sample| (sample, mixture.draw(points.at(sample))))
            .filter(|(_, local)| local.z > 0.0)
            .map(|(sample, local)| (sample, local, 1.0 / mixture.density(local)))
            .collect();
        if drawn.is_empty() {
            drawn.push((0, by_cosine(points.at(0)), 1.0));
        }
        let sum: f64 = drawn.iter().map(|(_, local, weight)| local.z * weight).sum();
        for (sample, local, weight) in drawn {
            let towards = receiver.frame.global(local).normalize();
            let irradiance = self.radiance.map(|channel| channel * (PI * weight / sum));
            put(
                sample,
                LightSample { towards, irradiance, distance: f64::INFINITY, fading: false },
            );
        }
    }

    fn central(&self, _: DVec3, _: Option<DVec3>) -> Option<CentralLight> {
        Some(CentralLight { towards: None, irradiance: self.radiance.map(|channel| PI * channel) })
    }

    fn reference_irradiance(&self, _: DVec3) -> Option<[f64; 3]> {
        Some(self.radiance.map(|channel| PI * channel))
    }
}
