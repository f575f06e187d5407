//! Colour difference between pictures of a fit and of its material, under a light and on a shape
//! that the fit has not seen.

use std::io::Cursor;

use anyhow::{Context, Result};
use brood_brdf::{Brdf, Claims, DirectionPair};
use brood_eval::express;
use brood_genome::Genome;
use brood_inspect::{OTHER_LIGHT_DEG, Picture, Shade, Shot, Specimen};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{Exposure, MeshRef, Sampling, Scene};
use glam::DVec3;
use image::{ImageFormat, RgbImage, imageops};

const SIZE_PX: u32 = 128;
/// Luminance of linear 1, in cd/m2.
const WHITE: f64 = 100.0;

/// Mean of f and of f with light and eye exchanged; the reciprocal part, which fits are given.
struct Symmetrised<'a>(&'a dyn Brdf);

impl Brdf for Symmetrised<'_> {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        (0.5 * (self.0.f(pair) + self.0.f(&pair.swapped()))).max(DVec3::ZERO)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, ..self.0.claims() }
    }
}

/// Mean differences over the pixels covered by the object, averaged over both lights.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ViewDifference {
    pub itp: f64,
    pub flip: f64,
}

impl ViewDifference {
    /// Value for materials without pictures.
    pub const UNKNOWN: Self = Self { itp: f64::NAN, flip: f64::NAN };
}

/// Scene of the comparison: a knob under the default light and under one elsewhere.
pub struct Studio {
    mesh: Mesh,
    assets: LightAssets,
}

impl Studio {
    /// Creates the mesh of the scene.
    pub fn new() -> Self {
        Self { mesh: Mesh::builtin(BuiltinMesh::Knob), assets: LightAssets::default() }
    }

    /// Compares a genome with a material at the material's exposure. Also returns a PNG: one column
    /// per light, with the material in the upper row and the genome in the lower.
    pub fn compare(&self, target: &dyn Brdf, genome: &Genome) -> Result<(ViewDifference, Vec<u8>)> {
        let target = &Symmetrised(target) as &dyn Brdf;
        let program = express(genome);
        let found = Specimen::Bred(genome, &program);
        let default = Scene { mesh: MeshRef::Builtin(BuiltinMesh::Knob), ..Scene::default() };
        let other = default.with_light_deg(default.light_deg + OTHER_LIGHT_DEG);
        let (mut sum, mut sheet) =
            (ViewDifference::default(), RgbImage::new(2 * SIZE_PX, 2 * SIZE_PX));
        for (column, mut scene) in [default, other].into_iter().enumerate() {
            let first = self.take(&scene, target);
            scene.film.exposure = Exposure::Ev(first.developed.exposure_ev);
            let second = self.take(&scene, &found);
            let covered: f64 =
                first.radiance.coverage().iter().map(|share| f64::from(*share)).sum();
            let ev = first.developed.exposure_ev;
            let (a, b) = (first.linear(ev), second.linear(ev));
            // The background is the same in both, so means over the picture are divided by the
            // covered share.
            let share = covered / a.linear().len() as f64;
            sum.itp += a.itp(&b, WHITE) / share / 2.0;
            sum.flip += a.flip(&b) / share / 2.0;
            for (row, picture) in [a, b].iter().enumerate() {
                let cell = RgbImage::from_raw(SIZE_PX, SIZE_PX, picture.encoded());
                let cell = cell.context("a picture needs three bytes per pixel")?;
                let place = |index: usize| index as i64 * i64::from(SIZE_PX);
                imageops::replace(&mut sheet, &cell, place(column), place(row));
            }
        }
        let mut png = Cursor::new(Vec::new());
        sheet.write_to(&mut png, ImageFormat::Png).context("encode the PNG")?;
        Ok((sum, png.into_inner()))
    }

    fn take(&self, scene: &Scene, material: &(impl Shade + ?Sized)) -> Picture {
        let (mesh, assets, sampling) = (&self.mesh, &self.assets, Sampling::default());
        Shot { mesh, scene, assets, size_px: SIZE_PX.into(), sampling }.take(material)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_brdf::{Model, ModelKind};

    #[test]
    fn material_differs_from_another_but_not_from_itself() {
        let studio = Studio::new();
        let model = Model::new(ModelKind::Conductor);
        let genome = Genome::of_models(vec![model.clone()]).unwrap();
        let same = studio.compare(&*model.brdf(), &genome).unwrap().0;
        assert!(same.itp < 0.05 && same.flip < 0.002, "{same:?}");
        let other = studio.compare(&*Model::new(ModelKind::Lambert).brdf(), &genome).unwrap().0;
        assert!(other.itp > 5.0 && other.flip > 0.05, "{other:?}");
    }
}
