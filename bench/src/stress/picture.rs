//! Largest byte difference between f32 and f64 pictures of random genomes, at one exposure.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Evaluator, ReferenceEvaluator, develop, shade};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{Exposure, Scene};
use rayon::prelude::*;
use serde::Serialize;

use crate::chart::{Axis, Plot, Point, Quartiles, ResultTable, Series, cells};
use crate::measure::programs;
use crate::output;
use crate::picture::Mode;

/// Number of seeds that the genomes come from.
const SEEDS: u32 = 20;
/// Side of the pictures in pixels.
const PICTURE_PX: u32 = 128;

/// Counts and differences over all pictures.
#[derive(Debug, Default, Serialize)]
pub struct PictureDifferences {
    pub pictures: u32,
    pub pictures_off_by_more_than_1_255: u32,
    /// Largest difference of a developed byte, for each genome, seed by seed.
    #[serde(skip)]
    largest: Vec<u8>,
}

/// Renders and compares `pictures` random genomes of [`SEEDS`] seeds.
pub fn run(seed: u64, pictures: u32) -> Result<PictureDifferences> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = Mode::default().set(&mesh, &Scene::default(), PICTURE_PX);
    let bar = output::bar(pictures.into(), "pictures");
    let of_seed = |index: u32| {
        let count = pictures / SEEDS + u32::from(index < pictures % SEEDS);
        programs(seed.wrapping_add(index.into()), count)
    };
    let programs: Vec<Program> = (0..SEEDS).flat_map(of_seed).collect();
    let largest: Result<Vec<u8>> = programs
        .par_iter()
        .map(|program| {
            let (mut canonical, mut reference) = (Vec::new(), Vec::new());
            CanonicalEvaluator::default().eval(&[program], &set, &mut canonical)?;
            ReferenceEvaluator.eval(&[program], &set, &mut reference)?;
            let canonical = develop(&shade(&set, &canonical), Exposure::Auto);
            let exposure = Exposure::Ev(canonical.exposure_ev);
            let reference = develop(&shade(&set, &reference), exposure);
            let bytes = canonical.rgba.iter().zip(&reference.rgba);
            bar.inc(1);
            Ok(bytes.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0))
        })
        .collect();
    bar.finish_and_clear();
    let largest = largest?;
    let visible = largest.iter().filter(|difference| **difference > 1).count();
    Ok(PictureDifferences {
        pictures,
        pictures_off_by_more_than_1_255: u32::try_from(visible)
            .expect("at most the number of pictures"),
        largest,
    })
}

impl PictureDifferences {
    /// Number and percentage of pictures that differ visibly.
    pub fn share(&self) -> String {
        let visible = self.pictures_off_by_more_than_1_255;
        format!("{visible} ({:.1} %)", 100.0 * f64::from(visible) / f64::from(self.pictures.max(1)))
    }

    /// Number of genomes for each largest difference.
    pub fn table(&self) -> ResultTable {
        let mut table = ResultTable::default();
        for difference in 0..=u8::MAX {
            let genomes = self.largest.iter().filter(|largest| **largest == difference).count();
            if genomes > 0 {
                table.push(cells! {
                    largest_difference_of_255: u32::from(difference),
                    genomes: genomes,
                });
            }
        }
        table
    }

    /// Chart of the share of genomes by least largest difference.
    pub fn chart(&self) -> Plot {
        let share = |all: &[u8], least: u8| {
            let count = all.iter().filter(|largest| **largest >= least).count();
            100.0 * count as f64 / all.len().max(1) as f64
        };
        let of_seeds: Vec<&[u8]> =
            self.largest.chunks(self.largest.len().div_ceil(SEEDS as usize).max(1)).collect();
        let marked = [1, 2, 5, 20, 100];
        let point = |least: u8| {
            let y = share(&self.largest, least);
            let of_seeds: Vec<f64> = of_seeds.iter().map(|all| share(all, least)).collect();
            let label = if marked.contains(&least) { format!("{y:.1} %") } else { String::new() };
            let y_spread = Quartiles::of(&of_seeds).spread();
            Point { x: f64::from(least), y, label, y_spread, ..Point::default() }
        };
        Plot {
            title: "f32 against f64: developed pictures".to_owned(),
            subtitle: format!(
                "{} random genomes of {SEEDS} seeds, with quartiles, on the sphere, {PICTURE_PX} x {PICTURE_PX} pixels, same samples and exposure",
                self.pictures
            ),
            x: Axis::log("largest difference of a byte, of 255"),
            y: Axis::log("share of genomes with at least this difference, %"),
            series: vec![Series {
                name: "genomes".to_owned(),
                points: (1..=u8::MAX).map(point).collect(),
                dots: false,
            }],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_counts_every_genome_once() {
        let pictures = PictureDifferences {
            pictures: 3,
            largest: vec![0, 2, 2],
            ..PictureDifferences::default()
        };
        assert_eq!(pictures.table().csv(), "largest_difference_of_255,genomes\n0,1\n2,2\n");
        assert!(pictures.chart().svg().contains(">66.7 %<"));
    }
}
