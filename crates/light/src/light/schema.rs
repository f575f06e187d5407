//! OpenAPI schemas of the kinds of light.

#![expect(dead_code, reason = "the types here are only described, never made")]
#![expect(unused_qualifications, reason = "the derive macro writes paths in full")]

use std::borrow::Cow;

use utoipa::openapi::schema::{Object, SchemaType, Type};
use utoipa::openapi::{ArrayBuilder, ObjectBuilder, OneOfBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::Light;

/// One number per channel, or one for all.
struct Channels;

impl PartialSchema for Channels {
    fn schema() -> RefOr<Schema> {
        let number = || {
            let object = ObjectBuilder::new().schema_type(SchemaType::new(Type::Number));
            object.minimum(Some(0)).build()
        };
        let object: Object = number();
        let three = ArrayBuilder::new().items(number()).min_items(Some(3)).max_items(Some(3));
        let items = OneOfBuilder::new()
            .description(Some("For red, green and blue, or one number for all."))
            .item(object)
            .item(three);
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Channels {}

/// Defines the `kind` of a light.
macro_rules! word {
    ($kind:ident, $variant:ident) => {
        #[derive(ToSchema)]
        #[serde(rename_all = "lowercase")]
        enum $kind {
            $variant,
        }
    };
}

word!(PointKind, Point);
word!(DirectionalKind, Directional);
word!(SpotKind, Spot);
word!(IesKind, Ies);
word!(SphereKind, Sphere);
word!(DiskKind, Disk);
word!(RectangleKind, Rectangle);
word!(EnvironmentKind, Environment);
word!(AmbientKind, Ambient);

/// Isotropic point light. At most one of `intensity`, `intensity_cd`, `flux_w` and `flux_lm`.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct PointLight {
    #[schema(inline, required = false)]
    kind: PointKind,
    /// Position; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Radiant intensity, W/sr; null gives irradiance pi at the centre of the mesh.
    #[schema(inline)]
    intensity: Option<Channels>,
    /// Luminous intensity, cd.
    #[schema(inline)]
    intensity_cd: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
}

/// Parallel light.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct DirectionalLight {
    #[schema(inline)]
    kind: DirectionalKind,
    /// Direction of travel; null comes from the default position of a point light.
    direction: Option<[f64; 3]>,
    /// Irradiance at normal incidence, W/m2; null is pi.
    #[schema(inline)]
    irradiance_w_m2: Option<Channels>,
    /// Illuminance at normal incidence, lx.
    #[schema(inline)]
    illuminance_lx: Option<Channels>,
}

/// Point light restricted to a cone.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct SpotLight {
    #[schema(inline)]
    kind: SpotKind,
    /// Position; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Axis of the cone; null points at the centre of the mesh.
    axis: Option<[f64; 3]>,
    /// Half angle of the cone of full intensity, degrees.
    #[schema(default = 10)]
    hotspot_deg: Option<f64>,
    /// Half angle of the outer cone, degrees; the intensity falls linearly in the cosine.
    #[schema(default = 15)]
    falloff_deg: Option<f64>,
    /// Radiant intensity on the axis, W/sr; null gives irradiance pi at the distance of the mesh's
    /// centre.
    #[schema(inline)]
    intensity: Option<Channels>,
    /// Luminous intensity on the axis, cd.
    #[schema(inline)]
    intensity_cd: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
}

/// Point light with the distribution of an IES file.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct IesLight {
    #[schema(inline)]
    kind: IesKind,
    /// Position; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Direction of the profile's nadir or aim; null points at the centre of the mesh.
    axis: Option<[f64; 3]>,
    /// Direction of the profile's 90 degrees (type C) or up (types A and B).
    up: Option<[f64; 3]>,
    /// Id of the uploaded profile.
    #[schema(min_length = 1, max_length = 255)]
    profile: String,
    /// Peak radiant intensity, W/sr; null uses the file's values.
    #[schema(inline)]
    intensity: Option<Channels>,
    /// Peak luminous intensity, cd.
    #[schema(inline)]
    intensity_cd: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
}

/// Emitting ball.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct SphereLight {
    #[schema(inline)]
    kind: SphereKind,
    /// Centre; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Radius; null is half the radius of the mesh.
    radius: Option<f64>,
    /// Radiance, W/(m2 sr); null gives irradiance pi at the centre of the mesh.
    #[schema(inline)]
    radiance_w_m2_sr: Option<Channels>,
    /// Luminance, cd/m2.
    #[schema(inline)]
    luminance_nit: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
    /// Samples per shading point.
    #[schema(minimum = 1, maximum = 1024, default = 16)]
    samples: Option<u32>,
}

/// Disk that emits from its front.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct DiskLight {
    #[schema(inline)]
    kind: DiskKind,
    /// Centre; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Emission axis; null points at the centre of the mesh.
    axis: Option<[f64; 3]>,
    /// Radius; null is half the radius of the mesh.
    radius: Option<f64>,
    /// Radiance, W/(m2 sr); null gives irradiance pi on the axis at the distance of the mesh's
    /// centre.
    #[schema(inline)]
    radiance_w_m2_sr: Option<Channels>,
    /// Luminance, cd/m2.
    #[schema(inline)]
    luminance_nit: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
    /// Samples per shading point.
    #[schema(minimum = 1, maximum = 1024, default = 16)]
    samples: Option<u32>,
}

/// Rectangle that emits from its front.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct RectangleLight {
    #[schema(inline)]
    kind: RectangleKind,
    /// Centre; null places it relative to the mesh.
    position: Option<[f64; 3]>,
    /// Emission axis; null points at the centre of the mesh.
    axis: Option<[f64; 3]>,
    /// Direction of the height.
    up: Option<[f64; 3]>,
    /// Width; null is the radius of the mesh.
    width: Option<f64>,
    /// Height; null is the radius of the mesh.
    height: Option<f64>,
    /// Radiance, W/(m2 sr); null gives irradiance pi on the axis at the distance of the mesh's
    /// centre.
    #[schema(inline)]
    radiance_w_m2_sr: Option<Channels>,
    /// Luminance, cd/m2.
    #[schema(inline)]
    luminance_nit: Option<Channels>,
    /// Radiant flux, W.
    #[schema(inline)]
    flux_w: Option<Channels>,
    /// Luminous flux, lm.
    #[schema(inline)]
    flux_lm: Option<Channels>,
    /// Samples per shading point.
    #[schema(minimum = 1, maximum = 1024, default = 16)]
    samples: Option<u32>,
}

/// Equirectangular environment.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct EnvironmentLight {
    #[schema(inline)]
    kind: EnvironmentKind,
    /// Id of the uploaded picture: equirectangular, its middle towards -z.
    #[schema(min_length = 1, max_length = 255)]
    image: String,
    /// Rotation about the vertical axis, from +z towards +x, degrees.
    #[schema(default = 0)]
    rotation_deg: Option<f64>,
    /// Factor from pixel values to radiance, W/(m2 sr); default 1.
    #[schema(inline)]
    scale: Option<Channels>,
    /// Samples per shading point.
    #[schema(minimum = 1, maximum = 1024, default = 64)]
    samples: Option<u32>,
}

/// Uniform radiance from every direction.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct AmbientLight {
    #[schema(inline)]
    kind: AmbientKind,
    /// Radiance, W/(m2 sr); null is 1.
    #[schema(inline)]
    radiance_w_m2_sr: Option<Channels>,
    /// Luminance, cd/m2.
    #[schema(inline)]
    luminance_nit: Option<Channels>,
    /// Samples per shading point.
    #[schema(minimum = 1, maximum = 1024, default = 64)]
    samples: Option<u32>,
}

impl PartialSchema for Light {
    fn schema() -> RefOr<Schema> {
        let items = OneOfBuilder::new()
            .description(Some("A light; the kind tells which fields it has. Lengths are metres."))
            .item(PointLight::schema())
            .item(DirectionalLight::schema())
            .item(SpotLight::schema())
            .item(IesLight::schema())
            .item(SphereLight::schema())
            .item(DiskLight::schema())
            .item(RectangleLight::schema())
            .item(EnvironmentLight::schema())
            .item(AmbientLight::schema());
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Light {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Light")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::tests::LIGHTS;

    #[test]
    fn schema_has_every_field_of_a_serialised_light() {
        let schema = serde_json::to_value(Light::schema()).unwrap();
        let forms = schema["oneOf"].as_array().unwrap();
        for form in forms {
            assert_eq!(form["additionalProperties"], false, "{form}");
        }
        assert!(forms[0]["required"].is_null(), "{schema}");
        for json in LIGHTS {
            let written: serde_json::Value = serde_json::from_str(json).unwrap();
            let of_kind = |form: &&serde_json::Value| {
                form["properties"]["kind"]["enum"][0] == written["kind"]
            };
            let form = forms.iter().find(of_kind).unwrap();
            for field in written.as_object().unwrap().keys() {
                assert!(form["properties"][field].is_object(), "{field}: {form}");
            }
        }
    }
}
