//! Pictures of random genomes in f32 against f64, at one exposure: by how many bytes they are apart.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Evaluator, ReferenceEvaluator, develop, shade};
use brood_scene::{BuiltinMesh, Exposure, Mesh, Scene};
use rayon::prelude::*;
use serde::Serialize;

use crate::bench::measure::programs;
use crate::bench::picture::Mode;
use crate::chart::{Axis, Plot, Point, Scale, Series, Table};
use crate::output;

/// Side of the pictures.
const PICTURE_PX: u32 = 128;

/// What was found.
#[derive(Debug, Default, Serialize)]
pub struct Pictures {
    pub pictures: u32,
    pub pictures_off_by_more_than_1_255: u32,
    /// For each genome the largest difference of a developed byte.
    #[serde(skip)]
    largest: Vec<u8>,
}

/// Looks at that many genomes.
pub fn run(seed: u64, pictures: u32) -> Result<Pictures> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = Mode::default().set(&mesh, &Scene::default(), PICTURE_PX);
    let bar = output::bar(pictures.into(), "pictures");
    let largest: Result<Vec<u8>> = programs(seed, pictures)
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
    let off = largest.iter().filter(|apart| **apart > 1).count();
    Ok(Pictures {
        pictures,
        pictures_off_by_more_than_1_255: u32::try_from(off).expect("at most as many as pictures"),
        largest,
    })
}

impl Pictures {
    /// How many are off, in words.
    pub fn share(&self) -> String {
        let off = self.pictures_off_by_more_than_1_255;
        format!("{off} ({:.1} %)", 100.0 * f64::from(off) / f64::from(self.pictures.max(1)))
    }

    /// Genomes for each largest difference that occurs.
    pub fn table(&self) -> Table {
        let mut table = Table::new(&["largest_difference_of_255", "genomes"]);
        for apart in 0..=u8::MAX {
            let genomes = self.largest.iter().filter(|largest| **largest == apart).count();
            if genomes > 0 {
                table.push([u32::from(apart).into(), genomes.into()]);
            }
        }
        table
    }

    /// Share of genomes off by at least so much.
    pub fn chart(&self) -> Plot {
        let share = |apart: u8| {
            let off = self.largest.iter().filter(|largest| **largest >= apart).count();
            100.0 * off as f64 / self.largest.len().max(1) as f64
        };
        let marked = [1, 2, 5, 20, 100];
        let point = |apart: u8| {
            let y = share(apart);
            let label = if marked.contains(&apart) { format!("{y:.1} %") } else { String::new() };
            Point { x: f64::from(apart), y, label, ..Point::default() }
        };
        Plot {
            title: "f32 against f64: developed pictures".to_owned(),
            subtitle: format!(
                "{} random genomes on the sphere, {PICTURE_PX} x {PICTURE_PX} pixels, same samples and exposure",
                self.pictures
            ),
            x: Axis { title: "largest difference of a byte, of 255", scale: Scale::Log },
            y: Axis { title: "share of genomes off by at least that, %", scale: Scale::Log },
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
        let pictures = Pictures { pictures: 3, largest: vec![0, 2, 2], ..Pictures::default() };
        assert_eq!(pictures.table().csv(), "largest_difference_of_255,genomes\n0,1\n2,2\n");
        assert!(pictures.chart().svg().contains(">66.7 %<"));
    }
}
