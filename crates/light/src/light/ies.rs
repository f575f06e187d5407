//! Point light with the distribution of an IES file.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Kind, SingleSample};
use super::strength::{FromPoint, Group, Measure, Strength};
use crate::assets::{AssetRef, LightAssets};
use crate::field::FieldError;
use crate::ies::IesProfile;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::LightSample;
use crate::units::{EFFICACY_WHITE, luminance, radiometric};

/// Point light with the distribution of an IES file. At most one of `intensity`, `intensity_cd`,
/// `flux_w` and `flux_lm`; by default the file's values are used.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct IesLight {
    /// World position. Default: that of a point light.
    pub position: Option<[f64; 3]>,
    /// Direction of the profile's nadir (types A and B: of its aim), of any length. Default:
    /// towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Direction of the profile's 90 degrees (type C) or up (types A and B), of any length. If it
    /// is omitted or along the axis: up, or away from the default camera for a vertical axis.
    /// Horizontal angles turn counterclockwise seen from above (type C) or grow to the right of the
    /// aim (types A and B).
    pub up: Option<[f64; 3]>,
    /// Name of the profile among the assets: the id of the uploaded file.
    #[schema(min_length = 1, max_length = 255)]
    pub profile: String,
    /// Peak intensity, or flux.
    #[serde(flatten, with = "FromPoint")]
    #[schema(schema_with = FromPoint::schema)]
    pub strength: Option<Strength>,
}

impl Kind for IesLight {
    type Source = IesSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.position(self.position)?;
        at.direction(self.axis, "axis")?;
        at.direction(self.up, "up")?;
        at.asset_name(&self.profile, "profile")?;
        at.strength(self.strength, FromPoint::QUANTITIES)
    }

    fn asset(&self) -> Option<AssetRef<'_>> {
        Some(AssetRef::Profile(&self.profile))
    }

    fn source(&self, placement: &LightPlacement<'_>, assets: &LightAssets) -> Option<IesSource> {
        let profile = assets.profile(&self.profile)?.clone();
        let position = placement.position(self.position);
        let axis = placement.axis(self.axis, position);
        // Seen from above, that is along z, LM-63 counts type C counterclockwise, so 0 degrees is
        // at z x y. The right of the aim of types A and B is there too.
        let [x, y, z] = placement.axes(axis, self.up);
        let tilt_cos = axis.dot(placement.down()).clamp(-1.0, 1.0);
        let tilt = profile.tilt_factor(libm::acos(tilt_cos).to_degrees());
        let unit = placement.unit();
        let channels = match self.strength {
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
        Some(IesSource { position, axes: [-x, y, z], profile, scale })
    }
}

/// Luminaire in the unit frame.
#[derive(Debug, Clone)]
pub(crate) struct IesSource {
    position: DVec3,
    /// Axes x, y and z of the luminaire, left-handed: z is straight down or the aim, y is `up`.
    axes: [DVec3; 3],
    profile: Arc<IesProfile>,
    /// Factor from candelas to irradiance times squared distance in the unit frame.
    scale: [f64; 3],
}

impl SingleSample for IesSource {
    /// `None` where the profile is 0.
    fn at(&self, position: DVec3) -> Option<LightSample> {
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

    /// As if the subject's centre were in the peak direction.
    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        let squared = (self.position - pivot).length_squared();
        let peak = self.profile.peak_candela() / squared;
        (luminance(self.scale) > 0.0 && squared > 0.0).then(|| self.scale.map(|c| c * peak))
    }
}
