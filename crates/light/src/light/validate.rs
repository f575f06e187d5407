//! Validation of lights.

use super::{
    AmbientLight, DirectionalLight, DiskLight, IesLight, Light, PointLight, Quantity,
    RectangleLight, SphereLight, SpotLight, Strength,
};
use crate::field::{FieldError, finite, positive, require};

/// Smallest outer cone; below, the solid angle loses digits.
const FALLOFF_MIN_DEG: f64 = 0.1;

/// Largest number of samples of a light per shading point.
const SAMPLES_MAX: u32 = 1024;
/// Longest asset name, in bytes.
const ASSET_NAME_BYTES_MAX: usize = 255;

impl Light {
    /// Checks every field; `pointer` is the JSON pointer of the light.
    ///
    /// # Errors
    /// Returns the first field out of its range, in the order of the description.
    pub fn validate(&self, pointer: &str) -> Result<(), FieldError> {
        let at = At(pointer);
        match self {
            Self::Point(light) => {
                at.place(light.position)?;
                at.strength(light.strength, PointLight::QUANTITIES)
            }
            Self::Directional(light) => {
                at.direction(light.direction, "direction")?;
                at.strength(light.strength, DirectionalLight::QUANTITIES)
            }
            Self::Spot(light) => {
                at.place(light.position)?;
                at.direction(light.axis, "axis")?;
                let falloff = (FALLOFF_MIN_DEG..=180.0).contains(&light.falloff_deg);
                at.require(falloff, "falloff_deg", "must be from 0.1 to 180 degrees")?;
                let hotspot = light.hotspot_deg >= 0.0 && light.hotspot_deg <= light.falloff_deg;
                at.require(hotspot, "hotspot_deg", "must be from 0 to the fall-off's angle")?;
                at.strength(light.strength, SpotLight::QUANTITIES)
            }
            Self::Ies(light) => {
                at.place(light.position)?;
                at.direction(light.axis, "axis")?;
                at.direction(light.up, "up")?;
                at.name(&light.profile, "profile")?;
                at.strength(light.strength, IesLight::QUANTITIES)
            }
            Self::Sphere(light) => {
                at.place(light.position)?;
                at.length(light.radius, "radius")?;
                at.strength(light.strength, SphereLight::QUANTITIES)?;
                at.samples(light.samples)
            }
            Self::Disk(light) => {
                at.place(light.position)?;
                at.direction(light.axis, "axis")?;
                at.length(light.radius, "radius")?;
                at.strength(light.strength, DiskLight::QUANTITIES)?;
                at.samples(light.samples)
            }
            Self::Rectangle(light) => {
                at.place(light.position)?;
                at.direction(light.axis, "axis")?;
                at.direction(light.up, "up")?;
                at.length(light.width, "width")?;
                at.length(light.height, "height")?;
                at.strength(light.strength, RectangleLight::QUANTITIES)?;
                at.samples(light.samples)
            }
            Self::Environment(light) => {
                at.name(&light.image, "image")?;
                finite(&[light.rotation_deg], &at.field("rotation_deg"))?;
                at.channels(light.scale, "scale")?;
                at.samples(light.samples)
            }
            Self::Ambient(light) => {
                at.strength(light.strength, AmbientLight::QUANTITIES)?;
                at.samples(light.samples)
            }
        }
    }
}

/// JSON pointer of the light.
struct At<'a>(&'a str);

impl At<'_> {
    fn field(&self, name: &str) -> String {
        format!("{}/{name}", self.0)
    }

    fn require(&self, holds: bool, name: &str, reason: &str) -> Result<(), FieldError> {
        require(holds, &self.field(name), reason)
    }

    fn place(&self, position: Option<[f64; 3]>) -> Result<(), FieldError> {
        finite(&position.unwrap_or_default(), &self.field("position"))
    }

    fn direction(&self, direction: Option<[f64; 3]>, name: &str) -> Result<(), FieldError> {
        let Some(direction) = direction else { return Ok(()) };
        finite(&direction, &self.field(name))?;
        let length = glam::DVec3::from(direction).length();
        self.require(length >= f64::from(f32::MIN_POSITIVE), name, "must not be zero")
    }

    fn name(&self, asset: &str, name: &str) -> Result<(), FieldError> {
        let holds = (1..=ASSET_NAME_BYTES_MAX).contains(&asset.len());
        self.require(holds, name, "must be a name of 1 to 255 bytes")
    }

    fn strength(&self, strength: Option<Strength>, allowed: &[Quantity]) -> Result<(), FieldError> {
        let Some(Strength { quantity, channels }) = strength else { return Ok(()) };
        let known = allowed.contains(&quantity);
        self.require(known, quantity.name(), "is no measure of a light of this kind")?;
        self.channels(channels, quantity.name())
    }

    fn channels(&self, channels: [f64; 3], name: &str) -> Result<(), FieldError> {
        finite(&channels, &self.field(name))?;
        let lit = channels.iter().all(|channel| *channel >= 0.0);
        self.require(lit, name, "must not be negative")
    }

    fn length(&self, length: Option<f64>, name: &str) -> Result<(), FieldError> {
        length.map_or(Ok(()), |length| positive(length, &self.field(name)))
    }

    fn samples(&self, samples: u32) -> Result<(), FieldError> {
        let holds = (1..=SAMPLES_MAX).contains(&samples);
        self.require(holds, "samples", "must be from 1 to 1024")
    }
}
