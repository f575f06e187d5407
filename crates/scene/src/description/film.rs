//! Film of a scene: exposure and tone curve.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::schema::{SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// Largest absolute exposure, in EV.
pub const EV_MAX: f64 = 64.0;

/// Exposure and tone curve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Film {
    /// "auto" or a fixed exposure in EV.
    pub exposure: Exposure,
    /// Tone curve.
    pub tone: Tone,
}

/// Exposure of a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Exposure {
    /// Automatic: the 97th percentile becomes linear 0.9.
    #[default]
    Auto,
    /// Fixed: radiance is multiplied by 2 to this power.
    Ev(f64),
}

/// Tone curve from exposed radiance to display value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Clips to 1.
    #[default]
    None,
    /// x / (1 + x) per channel (Reinhard et al. 2002).
    Reinhard,
    /// Fit of the ACES curve, per channel (Narkowicz 2015).
    Filmic,
}

impl Tone {
    /// All tone curves.
    pub const ALL: [Self; 3] = [Self::None, Self::Reinhard, Self::Filmic];

    /// Returns the name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }
}

/// Film without tone curve.
impl From<Exposure> for Film {
    fn from(exposure: Exposure) -> Self {
        Self { exposure, tone: Tone::None }
    }
}

impl Serialize for Exposure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Ev(ev) => serializer.serialize_f64(*ev),
        }
    }
}

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AutoOrEv)
    }
}

impl PartialSchema for Exposure {
    fn schema() -> RefOr<Schema> {
        let auto = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .enum_values(Some(["auto"]));
        let ev = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::Number))
            .minimum(Some(-EV_MAX))
            .maximum(Some(EV_MAX));
        let items = OneOfBuilder::new()
            .description(Some("Measured from the picture, or a fixed number of EV."))
            .item(auto)
            .item(ev);
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Exposure {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Exposure")
    }
}

struct AutoOrEv;

impl Visitor<'_> for AutoOrEv {
    type Value = Exposure;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"auto\" or a number of EV")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Exposure, E> {
        match text {
            "auto" => Ok(Exposure::Auto),
            _ => Err(E::invalid_value(Unexpected::Other("another word"), &self)),
        }
    }

    fn visit_f64<E: Error>(self, ev: f64) -> Result<Exposure, E> {
        Ok(Exposure::Ev(ev))
    }

    // Integers beyond 2^53 are rounded; validation rejects them.
    fn visit_i64<E: Error>(self, ev: i64) -> Result<Exposure, E> {
        Ok(Exposure::Ev(ev as f64))
    }

    fn visit_u64<E: Error>(self, ev: u64) -> Result<Exposure, E> {
        Ok(Exposure::Ev(ev as f64))
    }
}
