//! Scene description: mesh, camera, lights and film, with a default for every field.
//!
//! Owns the JSON form, the only serialised form, and validation. Does not trace rays; the sample
//! set does.

mod backdrop;
mod camera;
mod film;
mod mesh_ref;
mod normal_map;
mod normals;
mod object;
mod tangents;
#[cfg(test)]
mod tests;
mod validate;

use brood_light::{AssetRef, DirectionalLight, EnvironmentLight, Light, PointLight, SpotLight};
use brood_mesh::BuiltinMesh;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use backdrop::Backdrop;
pub use camera::{Camera, LookAtCamera, OrbitCamera, OrthographicCamera};
pub use film::{EV_MAX, Exposure, Film, Tone};
pub use mesh_ref::MeshRef;
pub use normal_map::NormalMap;
pub use normals::Normals;
pub use object::{Ground, OBJECTS_MAX, SceneObject};
pub use tangents::{SpherePole, Tangents};
pub use validate::{LIGHT_SAMPLES_MAX, LIGHTS_MAX};

/// Mesh, camera, lights and film of a picture. The world is right-handed with y up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Mesh: "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh.
    pub mesh: MeshRef,
    /// Rotation of the mesh about its centre: about x, then y, then z, in degrees.
    pub rotation_deg: [f64; 3],
    /// Scale of the mesh about its centre. The default camera frames scale 1.
    pub scale: f64,
    /// Camera.
    pub camera: Camera,
    /// Lights, at most 16.
    pub lights: Vec<Light>,
    /// Exposure and tone curve.
    pub film: Film,
    /// Position on the light orbit, in degrees: all lights but fixed environments are rotated by
    /// this angle about the vertical axis through the centre of the mesh, from +z towards +x.
    pub light_deg: f64,
    // Picture keys hash the JSON, so fields added later are written only if they differ from their
    // default.
    /// True if the mesh casts shadows.
    #[serde(skip_serializing_if = "is_default")]
    pub shadows: bool,
    /// Meaning of the vertex normals.
    #[serde(skip_serializing_if = "is_default")]
    pub normals: Normals,
    /// Tangent of the shading frame.
    #[serde(skip_serializing_if = "is_default")]
    pub tangents: Tangents,
    /// Axis through the poles of the texture of the mesh "sphere"; "z" needs that mesh.
    #[serde(skip_serializing_if = "is_default")]
    pub sphere_pole: SpherePole,
    /// Backdrop behind the object; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backdrop: Option<Backdrop>,
    /// Other objects, at most 8. They hide each other and, if the scene has shadows, shade each
    /// other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<SceneObject>,
    /// Ground below the object; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<Ground>,
    /// Normal map of the mesh; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            mesh: MeshRef::default(),
            rotation_deg: [0.0; 3],
            scale: 1.0,
            camera: Camera::default(),
            lights: vec![Light::default()],
            film: Film::default(),
            light_deg: 0.0,
            shadows: false,
            normals: Normals::default(),
            tangents: Tangents::default(),
            sphere_pole: SpherePole::default(),
            backdrop: None,
            objects: Vec::new(),
            ground: None,
            normal_map: None,
        }
    }
}

impl Scene {
    /// Returns the scene with another position on the light orbit.
    ///
    /// # Units
    /// Degrees, from +z towards +x. Replaces [`Scene::light_deg`].
    #[must_use]
    pub fn with_light_deg(&self, degrees: f64) -> Self {
        Self { light_deg: degrees, ..self.clone() }
    }
}

impl Scene {
    /// Returns the built-in mesh with the texture that the scene selects; `None` if the mesh is
    /// uploaded.
    #[must_use]
    pub fn builtin(&self) -> Option<BuiltinMesh> {
        match (&self.mesh, self.sphere_pole) {
            (MeshRef::Builtin(BuiltinMesh::Sphere), SpherePole::Z) => Some(BuiltinMesh::SphereZ),
            (MeshRef::Builtin(mesh), _) => Some(*mesh),
            (MeshRef::Uploaded(_), _) => None,
        }
    }

    /// True if prefiltered light can replace the samples of environments: there is one, and none
    /// casts shadows.
    #[must_use]
    pub fn is_prefilterable(&self) -> bool {
        let casts = |light: &Light| matches!(light, Light::Environment(own) if own.shadows);
        self.has_environment() && !(self.shadows && self.lights.iter().any(casts))
    }

    /// Returns the scene with one light at the eye instead of its own, which shows where pixels see
    /// the surface evenly.
    #[must_use]
    pub fn lit_from_eye(&self) -> Self {
        let direction = Some(self.camera.direction());
        let light = Light::Directional(DirectionalLight { direction, strength: None });
        Self { lights: vec![light], light_deg: 0.0, shadows: false, ..self.clone() }
    }

    /// True if there are other objects or a ground.
    #[must_use]
    pub fn has_surroundings(&self) -> bool {
        !self.objects.is_empty() || self.ground.is_some()
    }

    /// Returns the materials of the other objects, then that of the ground; `None` stands for
    /// neutral grey. With each comes its JSON pointer.
    pub fn materials(&self) -> impl Iterator<Item = (Option<&str>, String)> {
        let objects = self.objects.iter().enumerate();
        let objects =
            objects.map(|(k, own)| (own.material.as_deref(), format!("/objects/{k}/material")));
        let ground = self.ground.iter();
        objects.chain(ground.map(|own| (own.material.as_deref(), "/ground/material".to_owned())))
    }

    /// Returns the normal maps of the subject, the other objects and the ground, with their JSON
    /// pointers.
    pub fn normal_maps(&self) -> impl Iterator<Item = (&NormalMap, String)> {
        let own = self.normal_map.iter().map(|map| (map, "/normal_map".to_owned()));
        let objects = self.objects.iter().enumerate().filter_map(|(k, object)| {
            Some((object.normal_map.as_ref()?, format!("/objects/{k}/normal_map")))
        });
        let ground = self.ground.iter().filter_map(|ground| ground.normal_map.as_ref());
        own.chain(objects).chain(ground.map(|map| (map, "/ground/normal_map".to_owned())))
    }

    /// Returns the normal map of a part: of the subject for 0, then of the other objects, then of
    /// the ground.
    #[must_use]
    pub fn normal_map_of(&self, part: usize) -> Option<&NormalMap> {
        match part.checked_sub(1) {
            None => self.normal_map.as_ref(),
            Some(at) => match self.objects.get(at) {
                Some(object) => object.normal_map.as_ref(),
                None => self.ground.as_ref()?.normal_map.as_ref(),
            },
        }
    }

    /// Returns the files that the scene names, with the JSON pointers of the names.
    pub fn assets(&self) -> impl Iterator<Item = (AssetRef<'_>, String)> {
        let lights = self.lights.iter().enumerate();
        let lights = lights.filter_map(|(k, light)| {
            let asset = light.asset()?;
            let field = match asset {
                AssetRef::Profile(_) => "profile",
                AssetRef::Environment(_) | AssetRef::Image(_) => "image",
            };
            Some((asset, format!("/lights/{k}/{field}")))
        });
        let backdrop = match &self.backdrop {
            Some(Backdrop::Image { image }) => Some(image),
            _ => None,
        };
        let backdrop = backdrop.map(|image| (AssetRef::Image(image), "/backdrop/image".to_owned()));
        let maps = self.normal_maps();
        let maps = maps.map(|(map, at)| (AssetRef::Image(&map.image), format!("{at}/image")));
        lights.chain(backdrop).chain(maps)
    }

    /// True if a light is an environment.
    #[must_use]
    pub fn has_environment(&self) -> bool {
        self.lights.iter().any(|light| matches!(light, Light::Environment(_)))
    }

    /// Returns the scene without its environments.
    #[must_use]
    pub fn without_environments(&self) -> Self {
        let mut scene = self.clone();
        scene.lights.retain(|light| !matches!(light, Light::Environment(_)));
        scene
    }

    /// Returns the scene of lit spheres (see [`crate::PrefilteredLight::on_spheres`]): the same
    /// camera, environments, and backdrop of them, and defaults for everything else.
    ///
    /// Spheres of several turns have no backdrop, and the first environment is rotated by 0: they
    /// serve all rotations of the environments as a whole.
    #[must_use]
    pub fn for_spheres(&self, turns: u32) -> Self {
        let mut first = 0.0;
        let lights = self.lights.iter().filter_map(|light| {
            let Light::Environment(own) = light else { return None };
            let turned = if own.fixed { 0.0 } else { self.light_deg };
            let rotation_deg = own.rotation_deg + turned;
            Some(EnvironmentLight { rotation_deg, shadows: true, ..own.clone() })
        });
        let lights: Vec<EnvironmentLight> = lights.collect();
        if turns > 1 {
            first = lights.first().map_or(0.0, |light| light.rotation_deg);
        }
        let lights = lights.into_iter().map(|light| {
            let rotation_deg = (light.rotation_deg - first).rem_euclid(360.0);
            Light::Environment(EnvironmentLight { rotation_deg, fixed: true, ..light })
        });
        let film = Film { exposure: Exposure::Ev(0.0), tone: Tone::default() };
        let is_lit = |backdrop: &Backdrop| matches!(backdrop, Backdrop::Environment { .. });
        let backdrop = self.backdrop.clone().filter(|backdrop| turns == 1 && is_lit(backdrop));
        let (camera, lights) = (self.camera.clone(), lights.collect());
        Self { camera, lights, film, backdrop, ..Self::default() }
    }

    /// Returns the scene of lit angles (see [`crate::LitAngles`]): the same objects, camera, and
    /// places of lights, and defaults for everything else; `None` if there is none: without
    /// shadows, or with other lights than point, spot and directional lights. Spot lights become
    /// point lights, which cast the same shadows within the cone.
    #[must_use]
    pub fn for_angles(&self) -> Option<Self> {
        let place = |light: &Light| match light {
            Light::Point(PointLight { position, .. }) | Light::Spot(SpotLight { position, .. }) => {
                Some(Light::Point(PointLight { position: *position, strength: None }))
            }
            Light::Directional(DirectionalLight { direction, .. }) => {
                let direction = *direction;
                Some(Light::Directional(DirectionalLight { direction, strength: None }))
            }
            _ => None,
        };
        let lights: Option<Vec<Light>> = self.lights.iter().map(place).collect();
        let scene = Self { lights: lights?, ..self.clone() };
        (self.shadows && !self.lights.is_empty()).then(|| scene.without_looks())
    }

    /// Returns the scene of ray ends (see [`crate::RayEnds`]): that of lit angles if there is one,
    /// else the same objects and camera without shadows; `None` if a normal map turns normals.
    #[must_use]
    pub fn for_ray_ends(&self) -> Option<Self> {
        let has_map = self.normal_map.is_some()
            || self.objects.iter().any(|object| object.normal_map.is_some())
            || self.ground.as_ref().is_some_and(|ground| ground.normal_map.is_some());
        let unlit = || Self { lights: vec![Light::default()], shadows: false, ..self.clone() };
        (!has_map).then(|| self.for_angles().unwrap_or_else(|| unlit().without_looks()))
    }

    /// Returns the scene with the same objects, camera and lights, and defaults for materials, film
    /// and backdrop.
    fn without_looks(self) -> Self {
        let plain =
            |object: SceneObject| SceneObject { material: None, normal_map: None, ..object };
        let ground = self.ground.map(|own| Ground { material: None, normal_map: None, ..own });
        Self {
            light_deg: 0.0,
            film: Film { exposure: Exposure::Ev(0.0), tone: Tone::default() },
            backdrop: None,
            objects: self.objects.into_iter().map(plain).collect(),
            ground,
            normal_map: None,
            ..self
        }
    }

    /// Returns the largest number of samples of all lights at one shading point: the cost of a
    /// picture relative to one point light.
    #[must_use]
    pub fn light_samples(&self) -> u32 {
        self.lights.iter().map(Light::samples).sum()
    }
}
