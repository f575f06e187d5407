//! A material to be compared: where it is from does not matter any more.

use std::path::{Path, PathBuf};

use anyhow::Result;
use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, Evaluator, express, model_reflectance};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;

use crate::material_file::{self, Material};
use crate::model_picture::Shade;

/// A material with a name.
pub struct Subject {
    name: String,
    kind: Kind,
}

enum Kind {
    Bred(Box<Genome>, Box<Program>),
    Measured(Box<dyn Brdf>),
}

impl Subject {
    /// Reads the material that an argument names.
    pub fn read(path: &PathBuf) -> Result<Self> {
        let name = match path.file_stem() {
            Some(stem) if path != Path::new("-") => stem.to_string_lossy().into_owned(),
            _ => "stdin".to_owned(),
        };
        let kind = match material_file::read(path)? {
            Material::Bred(genome) => {
                let program = express(&genome);
                Kind::Bred(genome, Box::new(program))
            }
            Material::Measured(brdf, _) => Kind::Measured(brdf),
        };
        Ok(Self { name, kind })
    }

    /// One that was made here.
    pub fn of(genome: Genome) -> Self {
        let program = Box::new(express(&genome));
        Self { name: String::new(), kind: Kind::Bred(Box::new(genome), program) }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its genome, where it was bred.
    pub fn genome(&self) -> Option<&Genome> {
        match &self.kind {
            Kind::Bred(genome, _) => Some(genome),
            Kind::Measured(_) => None,
        }
    }

    /// Its program, or what was measured.
    pub fn either(&self) -> Result<&Program, &dyn Brdf> {
        match &self.kind {
            Kind::Bred(_, program) => Ok(program),
            Kind::Measured(brdf) => Err(&**brdf),
        }
    }

    /// f of some pairs, at texture position 0.
    pub fn f(&self, pairs: &[DirectionPair]) -> Vec<[f64; 3]> {
        let mut out = Vec::new();
        self.shade(&SampleSet::from_pairs(pairs, &[]), &mut out);
        let channel = |channel: usize, index: usize| f64::from(out[channel * pairs.len() + index]);
        (0..pairs.len()).map(|index| [0, 1, 2].map(|c| channel(c, index))).collect()
    }
}

impl Shade for Subject {
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        match &self.kind {
            Kind::Measured(brdf) => model_reflectance(&**brdf, set, out),
            Kind::Bred(_, program) => CanonicalEvaluator::default()
                .eval(&[&**program], set, out)
                .expect("the CPU runs every program"),
        }
    }
}
