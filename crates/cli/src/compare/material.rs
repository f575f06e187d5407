//! Materials of a comparison.

use std::path::{Path, PathBuf};

use anyhow::Result;
use brood_bench::material_file::{self, MaterialFile};
use brood_brdf::Brdf;
use brood_eval::express;
use brood_genome::Genome;
use brood_inspect::{Shade, Specimen};
use brood_program::Program;
use brood_scene::SampleSet;

/// Named material.
pub struct NamedMaterial {
    name: String,
    kind: Kind,
}

enum Kind {
    Bred(Box<Genome>, Box<Program>),
    Measured(Box<dyn Brdf>),
}

impl NamedMaterial {
    /// Reads the material at `path`; `-` is standard input.
    pub fn read(path: &PathBuf) -> Result<Self> {
        let name = match path.file_stem() {
            Some(stem) if path != Path::new("-") => stem.to_string_lossy().into_owned(),
            _ => "stdin".to_owned(),
        };
        let kind = match material_file::read_brdf(path)? {
            MaterialFile::Bred(genome) => {
                let program = express(&genome);
                Kind::Bred(genome, Box::new(program))
            }
            MaterialFile::Measured(brdf, _) => Kind::Measured(brdf),
        };
        Ok(Self { name, kind })
    }

    /// Wraps a genome.
    pub fn of(name: &str, genome: Genome) -> Self {
        let program = Box::new(express(&genome));
        Self { name: name.to_owned(), kind: Kind::Bred(Box::new(genome), program) }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Specimen for rendering and measuring.
    pub fn specimen(&self) -> Specimen<'_> {
        match &self.kind {
            Kind::Bred(genome, program) => Specimen::Bred(genome, program),
            Kind::Measured(brdf) => Specimen::Measured(&**brdf),
        }
    }
}

impl Shade for NamedMaterial {
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        self.specimen().shade(set, out);
    }

    fn is_prefilterable(&self) -> bool {
        self.specimen().is_prefilterable()
    }
}
