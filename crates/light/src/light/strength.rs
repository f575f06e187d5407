//! Strength of a light: one number per channel, in one of several units.

use std::fmt;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serializer};
use utoipa::openapi::schema::{SchemaType, Type};
use utoipa::openapi::{ArrayBuilder, ObjectBuilder, OneOfBuilder, RefOr, Schema};

use crate::units::{EFFICACY_WHITE, radiometric};

/// Quantity of a light's strength. JSON names carry the unit, except `intensity`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
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

    /// Field names in JSON.
    const NAMES: [&'static str; 8] = [
        "intensity",
        "intensity_cd",
        "flux_w",
        "flux_lm",
        "irradiance_w_m2",
        "illuminance_lx",
        "radiance_w_m2_sr",
        "luminance_nit",
    ];

    /// Returns the field name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        // The order of the variants is that of `NAMES`.
        Self::NAMES[self as usize]
    }

    fn description(self) -> &'static str {
        match self {
            Self::Intensity => "Radiant intensity, W/sr; of a profile or cone the largest.",
            Self::IntensityCd => "Luminous intensity, cd; of a profile or cone the largest.",
            Self::FluxW => "Radiant flux, W.",
            Self::FluxLm => "Luminous flux, lm.",
            Self::IrradianceWM2 => "Irradiance at normal incidence, W/m2.",
            Self::IlluminanceLx => "Illuminance at normal incidence, lx.",
            Self::RadianceWM2Sr => "Radiance, W/(m2 sr).",
            Self::LuminanceNit => "Luminance, cd/m2.",
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

/// Quantities that measure a kind of light, and the JSON form of its strength: at most one field of
/// the light, named after the quantity.
pub(super) trait Group {
    /// Allowed quantities. An omitted strength is written as null in the first.
    const QUANTITIES: &'static [Quantity];

    fn serialize<S: Serializer>(
        strength: &Option<Strength>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let quantity = strength.map_or(Self::QUANTITIES[0], |strength| strength.quantity);
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(quantity.name(), &strength.map(|strength| strength.channels))?;
        map.end()
    }

    fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Strength>, D::Error> {
        // A struct takes its own fields out of the object, so that others are found to be unknown.
        let reader = OneQuantity(Self::QUANTITIES);
        deserializer.deserialize_struct("Strength", &Quantity::NAMES, reader)
    }

    /// Properties of the object of a light.
    fn schema() -> RefOr<Schema> {
        let object = Self::QUANTITIES.iter().fold(ObjectBuilder::new(), |object, quantity| {
            object.property(quantity.name(), Channels::described(quantity.description()))
        });
        RefOr::T(Schema::Object(object.build()))
    }
}

/// Lights at a point.
pub(super) enum FromPoint {}
/// Lights with an area.
pub(super) enum FromArea {}
/// Parallel light.
pub(super) enum FromDirection {}
/// Light from everywhere.
pub(super) enum FromEverywhere {}

impl Group for FromPoint {
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::Intensity, Quantity::IntensityCd, Quantity::FluxW, Quantity::FluxLm];
}

impl Group for FromArea {
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::RadianceWM2Sr, Quantity::LuminanceNit, Quantity::FluxW, Quantity::FluxLm];
}

impl Group for FromDirection {
    const QUANTITIES: &'static [Quantity] = &[Quantity::IrradianceWM2, Quantity::IlluminanceLx];
}

impl Group for FromEverywhere {
    const QUANTITIES: &'static [Quantity] = &[Quantity::RadianceWM2Sr, Quantity::LuminanceNit];
}

/// Reads at most one of the quantities.
struct OneQuantity(&'static [Quantity]);

impl<'de> Visitor<'de> for OneQuantity {
    type Value = Option<Strength>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the strength of a light")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Option<Strength>, A::Error> {
        let mut found: Option<Strength> = None;
        while let Some(name) = map.next_key::<String>()? {
            let Some(quantity) = self.0.iter().find(|quantity| quantity.name() == name) else {
                return Err(Error::custom(format_args!("unknown field `{name}`")));
            };
            let value = map.next_value::<Channels>();
            let Channels(channels) =
                value.map_err(|error| Error::custom(format_args!("/{name}: {error}")))?;
            if let Some(first) = found {
                return Err(Error::custom(format_args!(
                    "a light's strength is given once, not by both {} and {name}",
                    first.quantity.name(),
                )));
            }
            found = Some(Strength::new(*quantity, channels));
        }
        Ok(found)
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

impl Channels {
    /// Schema of one number per channel, or one for all.
    pub(super) fn described(description: &str) -> Schema {
        let number = || {
            let object = ObjectBuilder::new().schema_type(SchemaType::new(Type::Number));
            object.minimum(Some(0))
        };
        let three = ArrayBuilder::new().items(number()).min_items(Some(3)).max_items(Some(3));
        let items = OneOfBuilder::new().description(Some(description)).item(number()).item(three);
        Schema::OneOf(items.build())
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
