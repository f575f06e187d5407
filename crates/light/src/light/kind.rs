//! Traits that a kind of light implements: its ranges, and its sampling.

use glam::DVec3;

use super::strength::{Quantity, Strength};
use crate::assets::{AssetRef, LightAssets};
use crate::field::{FieldError, finite, positive, require};
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver};
use crate::sequence::SamplePoints;

/// Largest number of samples of a light per shading point.
const SAMPLES_MAX: u32 = 1024;
/// Longest asset name, in bytes.
const ASSET_NAME_BYTES_MAX: usize = 255;

/// Description of a light of one kind.
pub(crate) trait Kind {
    /// The light in the unit frame.
    type Source: Source;

    /// Checks every field.
    fn check(&self, at: &At<'_>) -> Result<(), FieldError>;

    /// Largest number of samples at one shading point.
    fn samples(&self) -> u32 {
        1
    }

    /// Asset that the light refers to.
    fn asset(&self) -> Option<AssetRef<'_>> {
        None
    }

    /// False if its light passes through objects.
    fn casts_shadows(&self) -> bool {
        true
    }

    /// Prepares the light for sampling; `None` if its asset is missing.
    fn source(&self, placement: &LightPlacement<'_>, assets: &LightAssets) -> Option<Self::Source>;
}

/// Light in the unit frame, prepared for sampling.
pub(crate) trait Source {
    /// True for extended lights: their samples differ between positions, and their shadows are
    /// soft.
    const IS_SOFT: bool;

    /// Calls `put` with the index of each sample and the sample.
    fn for_each_sample(&self, receiver: &Receiver, draw: &Draw, put: impl FnMut(u32, LightSample));

    /// Returns the approximate irradiance of an extended light without occlusion, in the brightest
    /// channel; 0 for other lights.
    fn unoccluded_irradiance(&self, _position: DVec3, _n: DVec3) -> f64 {
        0.0
    }

    /// Returns the approximate maximum of the irradiance at the subject's centre, a position of the
    /// unit frame.
    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]>;

    /// Returns the light as if all of it came from its middle; `None` if it does not reach the
    /// position. `mean` is the mean direction of [`Source::mean_direction`].
    fn central(&self, position: DVec3, mean: Option<DVec3>) -> Option<CentralLight>;

    /// Returns the mean direction to a light that is the same at every position.
    fn mean_direction(&self) -> Option<DVec3> {
        None
    }
}

/// Light without extent: one sample at most, and hard shadows.
pub(crate) trait SingleSample {
    /// Returns the sample at a position in the unit frame; `None` if the light does not reach it.
    fn at(&self, position: DVec3) -> Option<LightSample>;

    /// As [`Source::reference_irradiance`].
    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]>;
}

impl<S: SingleSample> Source for S {
    const IS_SOFT: bool = false;

    #[inline]
    fn for_each_sample(
        &self,
        receiver: &Receiver,
        _: &Draw,
        mut put: impl FnMut(u32, LightSample),
    ) {
        if let Some(sample) = self.at(receiver.position) {
            put(0, sample);
        }
    }

    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        SingleSample::reference_irradiance(self, pivot)
    }

    fn central(&self, position: DVec3, _: Option<DVec3>) -> Option<CentralLight> {
        let LightSample { towards, irradiance, .. } = self.at(position)?;
        Some(CentralLight { towards: Some(towards), irradiance })
    }
}

/// Samples to draw of one light.
#[derive(Debug)]
pub(crate) struct Draw {
    /// Index of the light in the scene.
    pub light: usize,
    /// Number of samples.
    pub samples: u32,
}

impl Draw {
    /// Returns the sample points for a receiver.
    #[inline]
    pub fn points(&self, receiver: &Receiver) -> SamplePoints {
        SamplePoints::new(receiver.seed, self.light)
    }
}

/// JSON pointer of a light, and checks of its fields.
pub(crate) struct At<'a>(pub &'a str);

impl At<'_> {
    fn field(&self, name: &str) -> String {
        format!("{}/{name}", self.0)
    }

    pub fn require(&self, holds: bool, name: &str, reason: &str) -> Result<(), FieldError> {
        require(holds, &self.field(name), reason)
    }

    pub fn finite(&self, number: f64, name: &str) -> Result<(), FieldError> {
        finite(&[number], &self.field(name))
    }

    pub fn position(&self, position: Option<[f64; 3]>) -> Result<(), FieldError> {
        finite(&position.unwrap_or_default(), &self.field("position"))
    }

    pub fn direction(&self, direction: Option<[f64; 3]>, name: &str) -> Result<(), FieldError> {
        let Some(direction) = direction else { return Ok(()) };
        finite(&direction, &self.field(name))?;
        let length = DVec3::from(direction).length();
        self.require(length >= f64::from(f32::MIN_POSITIVE), name, "must not be zero")
    }

    pub fn asset_name(&self, asset: &str, name: &str) -> Result<(), FieldError> {
        let holds = (1..=ASSET_NAME_BYTES_MAX).contains(&asset.len());
        self.require(holds, name, "must be a name of 1 to 255 bytes")
    }

    pub fn strength(
        &self,
        strength: Option<Strength>,
        allowed: &[Quantity],
    ) -> Result<(), FieldError> {
        let Some(Strength { quantity, channels }) = strength else { return Ok(()) };
        let known = allowed.contains(&quantity);
        self.require(known, quantity.name(), "is no measure of a light of this kind")?;
        self.channels(channels, quantity.name())
    }

    pub fn channels(&self, channels: [f64; 3], name: &str) -> Result<(), FieldError> {
        finite(&channels, &self.field(name))?;
        let lit = channels.iter().all(|channel| *channel >= 0.0);
        self.require(lit, name, "must not be negative")
    }

    pub fn length(&self, length: Option<f64>, name: &str) -> Result<(), FieldError> {
        length.map_or(Ok(()), |length| positive(length, &self.field(name)))
    }

    pub fn samples(&self, samples: u32) -> Result<(), FieldError> {
        let holds = (1..=SAMPLES_MAX).contains(&samples);
        self.require(holds, "samples", "must be from 1 to 1024")
    }
}
