//! Normal maps and bumps on surfaces: the shading normals that they make.

use std::sync::Arc;

use brood_light::{ImagePyramid, LightAssets};
use brood_mesh::trace::{Hit, Ray};
use brood_mesh::{Mesh, MeshParts};
use glam::{DVec2, DVec3};

use super::frame::ShadedPoint;
use super::size::PictureSize;
use super::view::View;
use crate::description::NormalMap;
use crate::stage::TextureBumps;

/// Smallest component of a mapped normal along the mesh's own normal. It is positive, so no normal
/// points inwards.
const HEIGHT_MIN: f64 = 1.0 / 255.0;

/// Normal map of a mesh, with the camera that decides how much of it a pixel sees.
pub(super) struct MappedNormals<'a> {
    image: Arc<ImagePyramid>,
    strength: f64,
    repeat: f64,
    mesh: &'a Mesh,
    view: View,
    size_px: PictureSize,
}

impl<'a> MappedNormals<'a> {
    /// Makes the mapping; `None` if the mesh has no map, or one whose image is missing.
    pub fn new(
        map: Option<&NormalMap>,
        (mesh, assets): (&'a Mesh, &LightAssets),
        (view, size_px): (View, PictureSize),
    ) -> Option<Self> {
        let NormalMap { image, strength, repeat } = map?;
        let image = assets.image(image)?.clone();
        Some(Self { image, strength: *strength, repeat: *repeat, mesh, view, size_px })
    }

    /// Returns the hit with the normal of the map. The hit stays as it is if the texture
    /// coordinates of its triangle span no area.
    ///
    /// # Source
    /// Cohen, Olano and Manocha 1998, *Appearance-Preserving Simplification*, section 5.
    pub fn apply(&self, shaded: ShadedPoint, hit: &Hit, ray: Ray) -> ShadedPoint {
        let Some(slopes) = TextureSlopes::new(self.mesh.parts(), hit) else { return shaded };
        let (eye, radius) = (-ray.direction, self.mesh.radius());
        let position = (shaded.position - self.mesh.centre()) / radius;
        // Of a mirrored ray, that where it starts, and the spread along the rest of its way.
        let (spread, start) = self.view.pixel_width(self.size_px, ray.origin);
        let width = (start + spread * (position - ray.origin).length()) * radius;
        let footprint = slopes.footprint(shaded.frame.n(), eye, width);
        let uv = shaded.uv * self.repeat;
        let color = self.image.color(uv, footprint.map(|side| side * self.repeat));
        let [red, green, blue, opacity] = color.map(f64::from);
        // Flat where the image is transparent.
        let [along_u, along_v] = [red, green].map(|c| self.strength * (2.0 * c - opacity));
        let height = (2.0 * blue + 1.0 - 2.0 * opacity).max(HEIGHT_MIN);
        let [outwards, u, v] = slopes.axes(&shaded);
        let n = outwards * height + u * along_u + v * along_v;
        shaded.with_outwards(n.normalize(), eye)
    }
}

/// Returns the hit with the normal of bumps. The hit stays as it is if the texture coordinates of
/// its triangle span no area.
///
/// # Source
/// Blinn 1978, *Simulation of Wrinkled Surfaces*, with slopes in units of the texture.
pub(super) fn bumped(
    bumps: &dyn TextureBumps,
    parts: &MeshParts,
    shaded: ShadedPoint,
    (hit, ray): (&Hit, Ray),
) -> ShadedPoint {
    let Some(slopes) = TextureSlopes::new(parts, hit) else { return shaded };
    let by = bumps.slopes(shaded.uv);
    let [outwards, u, v] = slopes.axes(&shaded);
    let n = outwards - u * by.x - v * by.y;
    shaded.with_outwards(n.normalize(), -ray.direction)
}

/// Derivatives between the positions of a triangle and its texture.
struct TextureSlopes {
    along_u: DVec3,
    along_v: DVec3,
}

impl TextureSlopes {
    /// Returns the derivatives of the position by u and v; `None` if the texture coordinates of the
    /// triangle span no area.
    fn new(parts: &MeshParts, hit: &Hit) -> Option<Self> {
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let [a, b, c] = corners.map(|corner| parts.positions[corner]);
        let [ta, tb, tc] = corners.map(|corner| parts.uvs[corner]);
        let (d, e) = (tb - ta, tc - ta);
        let det = d.perp_dot(e);
        let along_u = ((b - a) * e.y - (c - a) * d.y) / det;
        let along_v = ((c - a) * d.x - (b - a) * e.x) / det;
        let is_regular = along_u.is_finite() && along_v.is_finite();
        (is_regular && along_u.cross(along_v) != DVec3::ZERO).then_some(Self { along_u, along_v })
    }

    /// Returns the normal on the outside, the tangent, and the direction across both along which v
    /// grows.
    fn axes(&self, shaded: &ShadedPoint) -> [DVec3; 3] {
        let (outwards, u) = (shaded.outwards(), shaded.frame.u());
        let v = outwards.cross(u);
        [outwards, u, if v.dot(self.along_v) < 0.0 { -v } else { v }]
    }

    /// Returns the changes of the texture position over the part of the surface that a pixel of a
    /// width sees from the direction `eye`.
    fn footprint(&self, n: DVec3, eye: DVec3, width: f64) -> [DVec2; 2] {
        let across = n.cross(eye);
        let across =
            if across.length() > 1e-6 { across.normalize() } else { n.any_orthonormal_vector() };
        let cosine = n.dot(eye).abs().max(1e-3);
        [across * width, across.cross(n) * (width / cosine)].map(|side| self.in_texture(side))
    }

    /// Solves for the change of the texture position along a vector of the surface.
    fn in_texture(&self, by: DVec3) -> DVec2 {
        let normal = self.along_u.cross(self.along_v);
        let scale = 1.0 / normal.length_squared();
        let at = DVec2::new(
            by.cross(self.along_v).dot(normal) * scale,
            self.along_u.cross(by).dot(normal) * scale,
        );
        at.clamp(DVec2::NEG_ONE, DVec2::ONE)
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;
    use brood_mesh::trace::Stack;

    use super::*;
    use crate::sample_set::point::{CameraRay, SurfacePoint};
    use crate::sample_set::render::pixel_sampler;
    use crate::{PixelArea, Raster, SampleSet, Sampling, Scene, Stage};

    const SIDE: u32 = 40;

    fn assets(side: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> LightAssets {
        let rgba: Vec<u8> = (0..side * side).flat_map(|at| pixel(at % side, at / side)).collect();
        let mut assets = LightAssets::default();
        assets.insert_image("map", Arc::new(ImagePyramid::new(side, side, &rgba)));
        assets
    }

    fn scene(mesh: &str, more: &str) -> Scene {
        let json = format!(
            r#"{{"mesh": "{mesh}", "normal_map": {{"image": "map"{more}}}, "lights": [{{}}]}}"#
        );
        let scene: Scene = serde_json::from_str(&json).unwrap();
        scene.validate().unwrap();
        scene
    }

    /// Local directions to the eye at the centres of the pixels that show the mesh, with and
    /// without the map, and the frames.
    fn frames(mesh: BuiltinMesh, scene: &Scene, assets: &LightAssets) -> Vec<[ShadedPoint; 2]> {
        let mesh = Mesh::builtin(mesh);
        let sampler = pixel_sampler(&(&mesh).into(), scene, assets, SIDE.into());
        let mut stack = Stack::default();
        let pixels = (0..SIDE * SIDE).map(|at| (at % SIDE, at / SIDE));
        let shaded = pixels.filter_map(|(x, y)| {
            let ray = sampler.ray(x, y, DVec2::splat(0.5));
            let hit = sampler.visible_hit(ray, &mut stack)?;
            let plain =
                ShadedPoint::new(sampler.surface.parts, &hit, -ray.direction, scene.tangents);
            Some([plain, sampler.surface.shaded(&hit, ray)])
        });
        shaded.collect()
    }

    #[test]
    fn colours_turn_normals_along_the_texture() {
        for (color, strength, expected) in [
            ([255, 128, 128, 255], 1.0, DVec2::new(1.0, 1.0 / 255.0)),
            ([128, 255, 255, 255], 0.5, DVec2::new(0.5 / 255.0, 0.5)),
            ([128, 255, 255, 255], -2.0, DVec2::new(-2.0 / 255.0, -2.0)),
            ([255, 255, 255, 0], 1.0, DVec2::ZERO),
        ] {
            let scene = scene("torus", &format!(r#", "strength": {strength}"#));
            let height = if color[2] == 128 { 1.0 / 255.0 } else { 1.0 };
            let expected = expected.extend(height).normalize();
            let frames = frames(BuiltinMesh::Torus, &scene, &assets(4, |_, _| color));
            assert!(frames.len() > 300);
            for [plain, mapped] in frames {
                let local = plain.frame.local(mapped.frame.n());
                // On a torus seen from outside, u, v and n are right-handed or left-handed alike.
                let off = [1.0, -1.0]
                    .map(|hand| (local - expected * DVec3::new(1.0, hand, 1.0)).length());
                assert!(off[0].min(off[1]) < 1e-6, "{local} {expected}");
                assert!(mapped.frame.u().dot(mapped.frame.n()).abs() < 1e-12);
                assert!((mapped.frame.n().length() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn green_points_along_growing_v() {
        // From both hands of the texture: the poles of the sphere differ in it.
        for mesh in ["sphere", "torus", "cube", "knob"] {
            let builtin = BuiltinMesh::from_name(mesh).unwrap();
            let up = assets(4, |_, _| [128, 255, 128, 255]);
            let parts = Mesh::builtin(builtin);
            let mut found = 0;
            for [plain, mapped] in frames(builtin, &scene(mesh, ""), &up) {
                let along =
                    mapped.outwards() - plain.outwards() * plain.outwards().dot(mapped.outwards());
                // A step along the turned normal raises v on the triangles near the point.
                let raised = step_of_v(&parts, &plain, along.normalize());
                assert!(raised.is_none_or(|dv| dv > 0.0), "{mesh}: {raised:?}");
                found += usize::from(raised.is_some());
            }
            assert!(found > 200, "{mesh}: {found}");
        }
    }

    /// Change of v for a small step from a point along a direction; `None` if the triangle there is
    /// not found.
    fn step_of_v(mesh: &Mesh, at: &ShadedPoint, along: DVec3) -> Option<f64> {
        let parts = mesh.parts();
        let inside = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| parts.positions[corner as usize]);
            let n = (b - a).cross(c - a);
            let area = n.length_squared();
            let weights = |p: DVec3| {
                let [u, v] = [(c - b).cross(p - b), (a - c).cross(p - c)].map(|x| x.dot(n) / area);
                [u, v, 1.0 - u - v]
            };
            let own = weights(at.position);
            let near = ((at.position - a).dot(n) / area.sqrt()).abs() < 1e-9;
            if !near || own.iter().any(|w| *w < 0.0) {
                return None;
            }
            let v = |weights: [f64; 3]| -> f64 {
                corners.iter().zip(weights).map(|(k, w)| parts.uvs[*k as usize].y * w).sum()
            };
            Some(v(weights(at.position + along * 1e-6)) - v(own))
        };
        parts.triangles.iter().find_map(inside)
    }

    #[test]
    fn light_from_below_the_surface_does_not_arrive() {
        let raster = |side: u32| Raster {
            size_px: side.into(),
            sampling: Sampling::Fixed(1),
            area: PixelArea::whole(side),
        };
        let waves = assets(64, |x, y| {
            let slope = |at: u32| (127.5 + 90.0 * (f64::from(at) * 0.7).sin()) as u8;
            [slope(x), slope(y), 200, 255]
        });
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let mapped = scene("sphere", r#", "repeat": 3"#);
        let set = SampleSet::render_with_assets(&mesh, &mapped, &waves, raster(SIDE));
        let plain = Scene { normal_map: None, ..mapped.clone() };
        let bare = SampleSet::render_with_assets(&mesh, &plain, &waves, raster(SIDE));
        assert_eq!(set.counts().covered, bare.counts().covered);
        assert!(set.len() <= bare.len() && set.len() > bare.len() * 3 / 4);
        assert_ne!(set.irradiance()[0], bare.irradiance()[0]);
        let sampler = pixel_sampler(&(&mesh).into(), &mapped, &waves, SIDE.into());
        let (mut stack, mut point) = (Stack::default(), SurfacePoint::default());
        let (mut lit, mut turned) = (0, 0);
        for at in 0..SIDE * SIDE {
            let ray = sampler.ray(at % SIDE, at / SIDE, DVec2::splat(0.5));
            let Some(hit) = sampler.visible_hit(ray, &mut stack) else { continue };
            sampler.surface.shade(&hit, CameraRay { ray, seed: 1 }, &mut stack, &mut point);
            let shaded = sampler.surface.shaded(&hit, ray);
            for sample in &point.lit {
                assert!(shaded.mesh_normal().dot(shaded.frame.global(sample.wi)) > 0.0);
            }
            lit += point.lit.len();
            turned += usize::from(shaded.mesh_normal().dot(shaded.frame.n()) < 0.98);
        }
        assert!(lit > 500 && turned > 300, "{lit} {turned}");
        // Missing images change nothing.
        let none = LightAssets::default();
        let missing = SampleSet::render_with_assets(&mesh, &mapped, &none, raster(SIDE));
        assert_eq!(missing.irradiance(), bare.irradiance());
    }

    #[test]
    fn far_maps_are_smooth() {
        // Stripes far below a pixel average to a flat surface.
        let stripes = assets(512, |x, _| [if x % 2 == 0 { 255 } else { 0 }, 128, 200, 255]);
        let scene = scene("sphere", r#", "repeat": 40"#);
        for [plain, mapped] in frames(BuiltinMesh::Sphere, &scene, &stripes) {
            assert!(plain.frame.n().dot(mapped.frame.n()) > 0.999);
        }
    }

    /// Height that grows along u or v.
    #[derive(Debug)]
    struct Ramp(DVec2);

    impl TextureBumps for Ramp {
        fn slopes(&self, _: DVec2) -> DVec2 {
            self.0
        }
    }

    #[test]
    fn bumps_turn_normals_as_a_map_of_their_slopes() {
        // The map has the slope 1 along u in its colour: the normal (-1, 0, 1).
        for (slopes, color) in
            [(DVec2::X, [0, 128, 255, 255]), (DVec2::NEG_Y, [128, 255, 255, 255])]
        {
            for mesh in ["sphere", "torus", "knob"] {
                let builtin = BuiltinMesh::from_name(mesh).unwrap();
                let mesh_of = Mesh::builtin(builtin);
                let map = assets(4, |_, _| color);
                let scene = scene(mesh, "");
                let plain = Scene { normal_map: None, ..scene.clone() };
                let bumped = Stage::from(&mesh_of).with_bumps(Some(Arc::new(Ramp(slopes))));
                let mapped = pixel_sampler(&(&mesh_of).into(), &scene, &map, SIDE.into());
                let bumped = pixel_sampler(&bumped, &plain, &LightAssets::default(), SIDE.into());
                let mut stack = Stack::default();
                let mut found = 0;
                for at in 0..SIDE * SIDE {
                    let ray = mapped.ray(at % SIDE, at / SIDE, DVec2::splat(0.5));
                    let Some(hit) = mapped.visible_hit(ray, &mut stack) else { continue };
                    let [a, b] = [&mapped, &bumped].map(|s| s.surface.shaded(&hit, ray));
                    // Codes are off 1/2 by 1/510.
                    assert!((a.frame.n() - b.frame.n()).length() < 0.01, "{mesh} {slopes}");
                    assert_eq!(a.mesh_normal(), b.mesh_normal());
                    found += 1;
                }
                assert!(found > 200, "{mesh}: {found}");
            }
        }
    }

    #[test]
    fn both_sides_have_one_shape() {
        // A hit seen from inside has the normal of the outside, turned.
        let map = assets(4, |_, _| [220, 90, 200, 255]);
        let mesh = Mesh::builtin(BuiltinMesh::Torus);
        let sampler = pixel_sampler(&(&mesh).into(), &scene("torus", ""), &map, SIDE.into());
        let mut point = SurfacePoint::default();
        let mut stack = Stack::default();
        let ray = sampler.ray(SIDE / 2, SIDE / 4, DVec2::splat(0.5));
        assert!(sampler.trace(CameraRay { ray, seed: 1 }, &mut stack, &mut point));
        let hit = sampler.visible_hit(ray, &mut stack).unwrap();
        let back = Ray { direction: -ray.direction, ..ray };
        let [front, back] = [ray, back].map(|ray| sampler.surface.shaded(&hit, ray).outwards());
        assert!((front - back).length() < 1e-9, "{front} {back}");
    }
}
