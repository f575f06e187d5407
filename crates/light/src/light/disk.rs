//! Disk that emits from its front.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Kind};
use super::strength::{FromArea, Group, Strength};
use super::surface::{FlatSource, area_samples};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::placement::LightPlacement;

/// Disk that emits from its front. At most one of `radiance_w_m2_sr`, `luminance_nit`, `flux_w` and
/// `flux_lm`; by default the irradiance on the axis at the distance of the mesh's centre is pi, in
/// the small-source limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DiskLight {
    /// World position of the centre. Default: that of a point light.
    pub position: Option<[f64; 3]>,
    /// Emission axis, of any length. Default: towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Radius. Default: half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux.
    #[serde(flatten, with = "FromArea")]
    #[schema(schema_with = FromArea::schema)]
    pub strength: Option<Strength>,
    /// Samples per shading point.
    #[serde(default = "area_samples")]
    #[schema(minimum = 1, maximum = 1024, default = area_samples)]
    pub samples: u32,
}

impl Kind for DiskLight {
    type Source = FlatSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.position(self.position)?;
        at.direction(self.axis, "axis")?;
        at.length(self.radius, "radius")?;
        at.strength(self.strength, FromArea::QUANTITIES)?;
        at.samples(self.samples)
    }

    fn samples(&self) -> u32 {
        self.samples
    }

    fn source(&self, placement: &LightPlacement<'_>, _: &LightAssets) -> Option<FlatSource> {
        let centre = placement.position(self.position);
        let axes = placement.axes(placement.axis(self.axis, centre), None);
        let radius = placement.length(self.radius, 0.5);
        Some(FlatSource::new(true, centre, axes, [radius; 2], (self.strength, placement)))
    }
}
