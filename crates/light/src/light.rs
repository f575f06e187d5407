//! Lights of a scene: the list of kinds, and what is the same for all of them.
//!
//! Each kind has a file in `light/` with its description, its ranges and its sampling. In JSON a
//! light is an object with a `kind` and the fields of that kind.

mod ambient;
mod directional;
mod disk;
mod environment;
mod ies;
mod json;
mod kind;
mod moved;
mod point;
mod rectangle;
mod schema;
mod sphere;
mod spot;
mod strength;
mod surface;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::LazyLock;

use glam::DVec3;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::openapi::{OneOfBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

pub use ambient::AmbientLight;
pub use directional::DirectionalLight;
pub use disk::DiskLight;
pub use environment::{ENVIRONMENT_SAMPLES, EnvironmentLight};
pub use ies::IesLight;
pub(crate) use kind::Draw;
pub use moved::LightMove;
pub use point::PointLight;
pub use rectangle::RectangleLight;
pub use sphere::SphereLight;
pub use spot::SpotLight;
pub use strength::{Quantity, Strength};
pub use surface::AREA_SAMPLES;

use crate::assets::{AssetRef, LightAssets};
use crate::environment::PrefilteredEnvironment;
use crate::field::FieldError;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver};
use kind::{At, Kind, Source};

/// Defines [`Light`] and [`LightSource`] by the list of kinds.
macro_rules! kinds {
    ($($kind:literal: $variant:ident($light:ident),)*) => {
        /// A light; the kind decides which fields it has. World units are metres.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(tag = "kind")]
        pub enum Light {
            $(#[doc = concat!("`", $kind, "`")] #[serde(rename = $kind)] $variant($light),)*
        }

        /// Light in the unit frame, prepared for sampling.
        #[derive(Debug)]
        pub(crate) enum LightSource {
            $($variant(<$light as Kind>::Source),)*
        }

        impl Light {
            const KINDS: &[&str] = &[$($kind),*];

            /// Returns the kind in JSON.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self { $(Self::$variant(_) => $kind,)* }
            }

            /// Returns the largest number of samples at one shading point.
            #[must_use]
            pub fn samples(&self) -> u32 {
                match self { $(Self::$variant(light) => light.samples(),)* }
            }

            /// False if its light passes through objects.
            #[must_use]
            pub fn casts_shadows(&self) -> bool {
                match self { $(Self::$variant(light) => light.casts_shadows(),)* }
            }

            /// Returns the asset that the light refers to, if its kind uses one.
            #[must_use]
            pub fn asset(&self) -> Option<AssetRef<'_>> {
                match self { $(Self::$variant(light) => light.asset(),)* }
            }

            /// Checks every field; `pointer` is the JSON pointer of the light.
            ///
            /// # Errors
            /// Returns the first field out of its range, in the order of the description.
            pub fn validate(&self, pointer: &str) -> Result<(), FieldError> {
                match self { $(Self::$variant(light) => light.check(&At(pointer)),)* }
            }

            /// Prepares the light for sampling; `None` if its asset is missing.
            pub(crate) fn source(
                &self,
                placement: &LightPlacement<'_>,
                assets: &LightAssets,
            ) -> Option<LightSource> {
                match self {
                    $(Self::$variant(light) => {
                        light.source(placement, assets).map(LightSource::$variant)
                    })*
                }
            }

            fn read(object: json::LightObject) -> Result<Self, String> {
                match object.kind.as_str() {
                    $($kind => object.fields().map(Self::$variant),)*
                    _ => Err(object.unknown_kind(Self::KINDS)),
                }
            }

            fn schemas() -> Vec<Schema> {
                vec![$(schema::light::<$light>($kind, DEFAULT_KIND),)*]
            }
        }

        impl LightSource {
            /// Calls `put` with the index of each sample and the sample.
            pub fn for_each_sample(
                &self,
                receiver: &Receiver,
                draw: &Draw,
                put: impl FnMut(u32, LightSample),
            ) {
                match self {
                    $(Self::$variant(source) => source.for_each_sample(receiver, draw, put),)*
                }
            }

            /// True for extended lights.
            pub fn is_soft(&self) -> bool {
                match self { $(Self::$variant(_) => <$light as Kind>::Source::IS_SOFT,)* }
            }

            /// Returns the approximate irradiance of an extended light without occlusion, in the
            /// brightest channel; 0 for other lights.
            pub fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
                match self {
                    $(Self::$variant(source) => source.unoccluded_irradiance(position, n),)*
                }
            }

            /// Returns the light as if all of it came from its middle.
            pub fn central(&self, position: DVec3, mean: Option<DVec3>) -> Option<CentralLight> {
                match self { $(Self::$variant(source) => source.central(position, mean),)* }
            }

            /// Returns the mean direction to a light that is the same at every position.
            pub fn mean_direction(&self) -> Option<DVec3> {
                match self { $(Self::$variant(source) => source.mean_direction(),)* }
            }

            /// Returns the approximate maximum of the irradiance at the subject's centre.
            pub fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
                match self { $(Self::$variant(source) => source.reference_irradiance(pivot),)* }
            }
        }
    };
}

kinds! {
    "point": Point(PointLight),
    "directional": Directional(DirectionalLight),
    "spot": Spot(SpotLight),
    "ies": Ies(IesLight),
    "sphere": Sphere(SphereLight),
    "disk": Disk(DiskLight),
    "rectangle": Rectangle(RectangleLight),
    "environment": Environment(EnvironmentLight),
    "ambient": Ambient(AmbientLight),
}

impl LightSource {
    /// Returns an environment as prefiltered radiance; `None` for other lights.
    pub(crate) fn prefiltered(&self) -> Option<PrefilteredEnvironment> {
        match self {
            Self::Environment(source) => Some(source.prefiltered()),
            _ => None,
        }
    }
}

/// Names of the fields of all kinds.
static FIELDS: LazyLock<HashSet<String>> = LazyLock::new(|| {
    let names = |schema| match schema {
        Schema::Object(object) => object.properties.into_keys().collect(),
        _ => Vec::new(),
    };
    Light::schemas().into_iter().flat_map(names).collect()
});

/// Kind of a light that names none.
const DEFAULT_KIND: &str = "point";

impl Light {
    /// Returns a point light at a position with irradiance pi at the centre of the mesh.
    #[must_use]
    pub fn point_at(position: [f64; 3]) -> Self {
        Self::Point(PointLight { position: Some(position), strength: None })
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::Point(PointLight::default())
    }
}

impl<'de> Deserialize<'de> for Light {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let is_field = |name: &str| FIELDS.contains(name);
        let object = json::LightObject::read(deserializer, DEFAULT_KIND, is_field)?;
        Self::read(object).map_err(D::Error::custom)
    }
}

impl PartialSchema for Light {
    fn schema() -> RefOr<Schema> {
        let text = "A light; the kind determines its fields. Lengths are metres.";
        let items = OneOfBuilder::new().description(Some(text));
        let items = Self::schemas().into_iter().fold(items, OneOfBuilder::item);
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Light {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Light")
    }
}
