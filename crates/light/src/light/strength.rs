//! Strength of a light: one number per channel, in one of several units.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::units::{EFFICACY_WHITE, radiometric};

/// Quantity of a light's strength. JSON names carry the unit, except `intensity`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// `intensity`: radiant intensity, W/sr.
    Intensity,
    /// `intensity_cd`: luminous intensity, cd.
    IntensityCd,
    /// `flux_w`: radiant flux, W.
    FluxW,
    /// `flux_lm`: luminous flux, lm.
    FluxLm,
    /// `irradiance_w_m2`: irradiance at normal incidence, W/m2.
    IrradianceWM2,
    /// `illuminance_lx`: illuminance at normal incidence, lx.
    IlluminanceLx,
    /// `radiance_w_m2_sr`: radiance, W/(m2 sr).
    RadianceWM2Sr,
    /// `luminance_nit`: luminance, cd/m2.
    LuminanceNit,
}

/// Physical quantity, independent of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measure {
    Intensity,
    Flux,
    Irradiance,
    Radiance,
}

/// Strength of a light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Quantity.
    pub quantity: Quantity,
    /// Value of red, green and blue, each that of white light of this strength.
    pub channels: [f64; 3],
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 8] = [
        Self::Intensity,
        Self::IntensityCd,
        Self::FluxW,
        Self::FluxLm,
        Self::IrradianceWM2,
        Self::IlluminanceLx,
        Self::RadianceWM2Sr,
        Self::LuminanceNit,
    ];

    /// Returns the field name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Intensity => "intensity",
            Self::IntensityCd => "intensity_cd",
            Self::FluxW => "flux_w",
            Self::FluxLm => "flux_lm",
            Self::IrradianceWM2 => "irradiance_w_m2",
            Self::IlluminanceLx => "illuminance_lx",
            Self::RadianceWM2Sr => "radiance_w_m2_sr",
            Self::LuminanceNit => "luminance_nit",
        }
    }

    pub(crate) fn measure(self) -> Measure {
        match self {
            Self::Intensity | Self::IntensityCd => Measure::Intensity,
            Self::FluxW | Self::FluxLm => Measure::Flux,
            Self::IrradianceWM2 | Self::IlluminanceLx => Measure::Irradiance,
            Self::RadianceWM2Sr | Self::LuminanceNit => Measure::Radiance,
        }
    }

    fn is_photometric(self) -> bool {
        match self {
            Self::IntensityCd | Self::FluxLm | Self::IlluminanceLx | Self::LuminanceNit => true,
            Self::Intensity | Self::FluxW | Self::IrradianceWM2 | Self::RadianceWM2Sr => false,
        }
    }
}

impl Strength {
    /// Creates a strength with separate channels.
    #[must_use]
    pub fn new(quantity: Quantity, channels: [f64; 3]) -> Self {
        Self { quantity, channels }
    }

    /// Creates a white strength.
    #[must_use]
    pub fn white(quantity: Quantity, value: f64) -> Self {
        Self::new(quantity, [value; 3])
    }

    /// Returns the channels in the radiometric unit: W/sr, W, W/m2 or W/(m2 sr).
    #[must_use]
    pub fn radiometric(&self) -> [f64; 3] {
        if !self.quantity.is_photometric() {
            return self.channels;
        }
        self.channels.map(|channel| radiometric(channel, EFFICACY_WHITE))
    }
}

/// Channels in JSON: three numbers, or one for all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Channels(pub [f64; 3]);

impl<'de> Deserialize<'de> for Channels {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrThree)
    }
}

struct OneOrThree;

impl<'de> Visitor<'de> for OneOrThree {
    type Value = Channels;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or [red, green, blue]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Channels, E> {
        Ok(Channels([value; 3]))
    }

    // Integers beyond 2^53 are rounded, as in lists of numbers.
    fn visit_i64<E: Error>(self, value: i64) -> Result<Channels, E> {
        Ok(Channels([value as f64; 3]))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Channels, E> {
        Ok(Channels([value as f64; 3]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Channels, A::Error> {
        let mut channels = [0.0; 3];
        for (count, channel) in channels.iter_mut().enumerate() {
            *channel = seq.next_element()?.ok_or_else(|| Error::invalid_length(count, &self))?;
        }
        match seq.next_element::<f64>()? {
            None => Ok(Channels(channels)),
            Some(_) => Err(Error::invalid_length(4, &self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photometric_strength_is_divided_by_the_efficacy_of_white() {
        for quantity in Quantity::ALL {
            let strength = Strength::white(quantity, 179.0);
            let expected = if quantity.is_photometric() { 1.0 } else { 179.0 };
            assert_eq!(strength.radiometric(), [expected; 3], "{}", quantity.name());
        }
    }

    #[test]
    fn channels_are_one_number_or_three() {
        let read = |json| serde_json::from_str::<Channels>(json).map(|channels| channels.0);
        assert_eq!(read("2").unwrap(), [2.0; 3]);
        assert_eq!(read("-2.5").unwrap(), [-2.5; 3]);
        assert_eq!(read("[1, 2.5, 3]").unwrap(), [1.0, 2.5, 3.0]);
        for json in ["[]", "[1, 2]", "[1, 2, 3, 4]", "\"x\"", "{}"] {
            let error = read(json).unwrap_err().to_string();
            assert!(error.contains("a number or [red, green, blue]"), "{json}: {error}");
        }
    }
}
