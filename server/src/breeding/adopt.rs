//! Adoption: adds existing genomes and presets to a lineage, unchanged, as individuals without
//! parents, or as children of the individual that they are edits of.

use brood_eval::express;
use brood_genome::preset::Preset;
use brood_genome::{Dialect, Genome, GenomeHash, live_instructions};
use brood_program::Child;
use brood_protocol::{Adopt, BreedOptions, IndividualId, Lineage, ParentRef, Seed};

use super::{Breeding, Brood, Newborn, Parent};
use crate::library::Framing;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::server_timing::ServerTiming;

/// Operator of an adopted individual.
pub const OPERATOR: &str = "adopt";

impl Breeding {
    /// Makes a generation of `adopt.genomes`, then `adopt.presets`, in this order.
    ///
    /// # Errors
    /// [`ApiError`] if there are too many, one is unknown, or one does not fit the lineage's
    /// dialect; if the parent is unknown or of another lineage.
    pub(super) async fn adopt(
        &self,
        lineage: &Lineage,
        adopt: Adopt,
        timing: &mut ServerTiming,
    ) -> Result<Brood, ApiError> {
        let count = adopt.genomes.len() + adopt.presets.len();
        if !(1..=limit::CHILDREN as usize).contains(&count) {
            let words = format!(
                "`genomes` and `presets` must have 1 to {} items together, got {count}",
                limit::CHILDREN
            );
            return Err(ApiError::refused(words).at("/genomes"));
        }
        let centre = match adopt.parent {
            Some(id) => self.adopting_parent(lineage, id).await?.centre(),
            None => None,
        };
        let framed = self.library.frame(Framing::thumbnail(self.backend, lineage)).await?;
        let mut genomes = Vec::with_capacity(count);
        for (index, hash) in adopt.genomes.iter().enumerate() {
            let pointer = format!("/genomes/{index}");
            let known = match hash.parse::<GenomeHash>() {
                Ok(hash) => self.library.material(hash).await,
                Err(_) => Err(ApiError::refused("a genome hash must be 64 hexadecimal digits")),
            };
            let known = known.map_err(|error| error.at(pointer.clone()))?;
            genomes.push(fitted(known.genome.clone(), &lineage.dialect, pointer)?);
        }
        for (index, name) in adopt.presets.iter().enumerate() {
            let pointer = format!("/presets/{index}");
            let preset = Preset::find(name).ok_or_else(|| {
                let words =
                    format!("there is no preset {}; `GET /v1/presets` lists them", quote(name));
                ApiError::not_found(words).at(pointer.clone())
            })?;
            genomes.push(fitted(preset.genome().clone(), &lineage.dialect, pointer)?);
        }
        timing.end("read");
        let children = self.processors.run(move || newborns(genomes)).await?;
        timing.end("make");
        Ok(Brood {
            framed,
            seed: Seed(0),
            parents: adopt.parent.into_iter().map(ParentRef::Individual).collect(),
            centre,
            operator: OPERATOR,
            options: BreedOptions::default(),
            children,
            step: None,
        })
    }

    /// Reads the parent of adopted genomes, which must be an individual of the lineage.
    async fn adopting_parent(
        &self,
        lineage: &Lineage,
        id: IndividualId,
    ) -> Result<Parent, ApiError> {
        let pointer = "/parent";
        let individual = self.individual(id, pointer).await?;
        if individual.lineage != lineage.id {
            let words = "the parent must be an individual of this lineage";
            return Err(ApiError::refused(words).at(pointer));
        }
        let material = self.library.material(individual.hash).await;
        let material = material.map_err(|error| error.at(pointer))?;
        Ok(Parent { individual: Some(individual), material })
    }
}

/// Pads a genome with no-ops to the lineage's length.
///
/// Models have no length, and a lineage of models takes programs of any length.
pub(super) fn fitted(
    genome: Genome,
    dialect: &Dialect,
    pointer: String,
) -> Result<Genome, ApiError> {
    let own = *genome.dialect();
    if own.length == 0 || dialect.length == 0 {
        return Ok(genome);
    }
    let as_long = Dialect { length: dialect.length, ..own };
    if own.length > dialect.length || !as_long.is_compatible(dialect) {
        let words = format!(
            "the genome has dialect {own}, length {}; the lineage has {dialect}, length {}",
            own.length, dialect.length
        );
        return Err(ApiError::refused(words).at(pointer));
    }
    genome.padded(dialect.length).map_err(|error| ApiError::refused(error.to_string()).at(pointer))
}

/// Wraps genomes as the children of a brood, by slot.
pub(super) fn newborns(genomes: Vec<Genome>) -> Vec<Newborn> {
    let newborn = |(slot, genome): (u32, Genome)| {
        let program = express(&genome);
        let live = live_instructions(&genome).into_iter().filter(|live| *live).count();
        Newborn::from(Child {
            slot,
            hash: genome.hash(),
            program_hash: program.hash(),
            live_instructions: u32::try_from(live).expect("at most 1024 instructions"),
            attempts: 1,
            twin: false,
            genome,
            program,
        })
    };
    (0..).zip(genomes).map(newborn).collect()
}
