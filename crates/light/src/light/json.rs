//! JSON form of lights: an object with a `kind` and the fields of that kind; others are rejected.

use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::strength::Channels;
use super::{
    AREA_SAMPLES, AmbientLight, DirectionalLight, DiskLight, ENVIRONMENT_SAMPLES, EnvironmentLight,
    IesLight, Light, PointLight, Quantity, RectangleLight, SphereLight, SpotLight, Strength,
};

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    #[default]
    Point,
    Directional,
    Spot,
    Ies,
    Sphere,
    Disk,
    Rectangle,
    Environment,
    Ambient,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Directional => "directional",
            Self::Spot => "spot",
            Self::Ies => "ies",
            Self::Sphere => "sphere",
            Self::Disk => "disk",
            Self::Rectangle => "rectangle",
            Self::Environment => "environment",
            Self::Ambient => "ambient",
        }
    }
}

/// Fields of all kinds, for reading. Each kind takes its own.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename = "Light", expecting = "a light object")]
struct Fields {
    kind: Kind,
    position: Option<[f64; 3]>,
    direction: Option<[f64; 3]>,
    axis: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    profile: Option<String>,
    image: Option<String>,
    radius: Option<f64>,
    width: Option<f64>,
    height: Option<f64>,
    rotation_deg: Option<f64>,
    scale: Option<Channels>,
    samples: Option<u32>,
    hotspot_deg: Option<f64>,
    falloff_deg: Option<f64>,
    intensity: Option<Channels>,
    intensity_cd: Option<Channels>,
    flux_w: Option<Channels>,
    flux_lm: Option<Channels>,
    irradiance_w_m2: Option<Channels>,
    illuminance_lx: Option<Channels>,
    radiance_w_m2_sr: Option<Channels>,
    luminance_nit: Option<Channels>,
}

impl Fields {
    fn quantity(&mut self, quantity: Quantity) -> &mut Option<Channels> {
        match quantity {
            Quantity::Intensity => &mut self.intensity,
            Quantity::IntensityCd => &mut self.intensity_cd,
            Quantity::FluxW => &mut self.flux_w,
            Quantity::FluxLm => &mut self.flux_lm,
            Quantity::IrradianceWM2 => &mut self.irradiance_w_m2,
            Quantity::IlluminanceLx => &mut self.illuminance_lx,
            Quantity::RadianceWM2Sr => &mut self.radiance_w_m2_sr,
            Quantity::LuminanceNit => &mut self.luminance_nit,
        }
    }

    /// Takes the strength, given as one of the allowed quantities.
    fn strength(&mut self, allowed: &[Quantity]) -> Result<Option<Strength>, String> {
        let mut found: Option<Strength> = None;
        for quantity in allowed {
            let Some(Channels(channels)) = self.quantity(*quantity).take() else { continue };
            if let Some(first) = found {
                return Err(format!(
                    "a light's strength is given once, not by both {} and {}",
                    first.quantity.name(),
                    quantity.name()
                ));
            }
            found = Some(Strength::new(*quantity, channels));
        }
        Ok(found)
    }

    /// Returns a field that no kind took.
    fn left_over(&mut self) -> Option<&'static str> {
        let plain = [
            ("position", self.position.is_some()),
            ("direction", self.direction.is_some()),
            ("axis", self.axis.is_some()),
            ("up", self.up.is_some()),
            ("profile", self.profile.is_some()),
            ("image", self.image.is_some()),
            ("radius", self.radius.is_some()),
            ("width", self.width.is_some()),
            ("height", self.height.is_some()),
            ("rotation_deg", self.rotation_deg.is_some()),
            ("scale", self.scale.is_some()),
            ("samples", self.samples.is_some()),
            ("hotspot_deg", self.hotspot_deg.is_some()),
            ("falloff_deg", self.falloff_deg.is_some()),
        ];
        let plain = plain.into_iter().find(|field| field.1).map(|field| field.0);
        let given = |quantity: &Quantity| self.quantity(*quantity).is_some();
        plain.or_else(|| Quantity::ALL.into_iter().find(given).map(Quantity::name))
    }

    fn light(&mut self) -> Result<Light, String> {
        Ok(match self.kind {
            Kind::Point => Light::Point(PointLight {
                position: self.position.take(),
                strength: self.strength(PointLight::QUANTITIES)?,
            }),
            Kind::Directional => Light::Directional(DirectionalLight {
                direction: self.direction.take(),
                strength: self.strength(DirectionalLight::QUANTITIES)?,
            }),
            Kind::Spot => {
                let usual = SpotLight::default();
                Light::Spot(SpotLight {
                    position: self.position.take(),
                    axis: self.axis.take(),
                    hotspot_deg: self.hotspot_deg.take().unwrap_or(usual.hotspot_deg),
                    falloff_deg: self.falloff_deg.take().unwrap_or(usual.falloff_deg),
                    strength: self.strength(SpotLight::QUANTITIES)?,
                })
            }
            Kind::Ies => Light::Ies(IesLight {
                position: self.position.take(),
                axis: self.axis.take(),
                up: self.up.take(),
                profile: self.profile.take().ok_or("a light of kind ies needs a profile")?,
                strength: self.strength(IesLight::QUANTITIES)?,
            }),
            Kind::Sphere => Light::Sphere(SphereLight {
                position: self.position.take(),
                radius: self.radius.take(),
                strength: self.strength(SphereLight::QUANTITIES)?,
                samples: self.samples.take().unwrap_or(AREA_SAMPLES),
            }),
            Kind::Disk => Light::Disk(DiskLight {
                position: self.position.take(),
                axis: self.axis.take(),
                radius: self.radius.take(),
                strength: self.strength(DiskLight::QUANTITIES)?,
                samples: self.samples.take().unwrap_or(AREA_SAMPLES),
            }),
            Kind::Rectangle => Light::Rectangle(RectangleLight {
                position: self.position.take(),
                axis: self.axis.take(),
                up: self.up.take(),
                width: self.width.take(),
                height: self.height.take(),
                strength: self.strength(RectangleLight::QUANTITIES)?,
                samples: self.samples.take().unwrap_or(AREA_SAMPLES),
            }),
            Kind::Environment => Light::Environment(EnvironmentLight {
                image: self.image.take().ok_or("a light of kind environment needs an image")?,
                rotation_deg: self.rotation_deg.take().unwrap_or(0.0),
                scale: self.scale.take().map_or([1.0; 3], |scale| scale.0),
                samples: self.samples.take().unwrap_or(ENVIRONMENT_SAMPLES),
            }),
            Kind::Ambient => Light::Ambient(AmbientLight {
                strength: self.strength(AmbientLight::QUANTITIES)?,
                samples: self.samples.take().unwrap_or(ENVIRONMENT_SAMPLES),
            }),
        })
    }
}

impl Serialize for Light {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return write(self, serializer);
        }
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Light {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return read(deserializer);
        }
        Self::deserialize(deserializer)
    }
}

/// Reads a light.
fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Light, D::Error> {
    let mut fields = Fields::deserialize(deserializer)?;
    let light = fields.light().map_err(D::Error::custom)?;
    match fields.left_over() {
        None => Ok(light),
        Some(field) => {
            let kind = fields.kind.name();
            Err(D::Error::custom(format!("a light of kind {kind} has no field `{field}`")))
        }
    }
}

/// Writes a light with all fields of its kind.
fn write<S: Serializer>(light: &Light, serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = Written(serializer.serialize_map(None)?);
    map.field("kind", light.kind())?;
    match light {
        Light::Point(light) => {
            map.field("position", &light.position)?;
            map.strength(light.strength, PointLight::QUANTITIES)?;
        }
        Light::Directional(light) => {
            map.field("direction", &light.direction)?;
            map.strength(light.strength, DirectionalLight::QUANTITIES)?;
        }
        Light::Spot(light) => {
            map.field("position", &light.position)?;
            map.field("axis", &light.axis)?;
            map.field("hotspot_deg", &light.hotspot_deg)?;
            map.field("falloff_deg", &light.falloff_deg)?;
            map.strength(light.strength, SpotLight::QUANTITIES)?;
        }
        Light::Ies(light) => {
            map.field("position", &light.position)?;
            map.field("axis", &light.axis)?;
            map.field("up", &light.up)?;
            map.field("profile", &light.profile)?;
            map.strength(light.strength, IesLight::QUANTITIES)?;
        }
        Light::Sphere(light) => {
            map.field("position", &light.position)?;
            map.field("radius", &light.radius)?;
            map.strength(light.strength, SphereLight::QUANTITIES)?;
            map.field("samples", &light.samples)?;
        }
        Light::Disk(light) => {
            map.field("position", &light.position)?;
            map.field("axis", &light.axis)?;
            map.field("radius", &light.radius)?;
            map.strength(light.strength, DiskLight::QUANTITIES)?;
            map.field("samples", &light.samples)?;
        }
        Light::Rectangle(light) => {
            map.field("position", &light.position)?;
            map.field("axis", &light.axis)?;
            map.field("up", &light.up)?;
            map.field("width", &light.width)?;
            map.field("height", &light.height)?;
            map.strength(light.strength, RectangleLight::QUANTITIES)?;
            map.field("samples", &light.samples)?;
        }
        Light::Environment(light) => {
            map.field("image", &light.image)?;
            map.field("rotation_deg", &light.rotation_deg)?;
            map.field("scale", &light.scale)?;
            map.field("samples", &light.samples)?;
        }
        Light::Ambient(light) => {
            map.strength(light.strength, AmbientLight::QUANTITIES)?;
            map.field("samples", &light.samples)?;
        }
    }
    map.0.end()
}

struct Written<M>(M);

impl<M: SerializeMap> Written<M> {
    fn field<T: Serialize + ?Sized>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), M::Error> {
        self.0.serialize_entry(name, value)
    }

    /// Writes the given quantity, or null for the kind's first.
    fn strength(
        &mut self,
        strength: Option<Strength>,
        allowed: &[Quantity],
    ) -> Result<(), M::Error> {
        let quantity = strength.map_or(allowed[0], |strength| strength.quantity);
        self.field(quantity.name(), &strength.map(|strength| strength.channels))
    }
}
