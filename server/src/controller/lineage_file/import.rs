//! Lineage files checked and turned into rows: nothing in a file is believed that can be computed.

use std::collections::{BTreeMap, HashMap, HashSet};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_eval::express;
use brood_genome::{Dialect, Genome, GenomeHash, Model, live_instructions};
use brood_protocol::{
    GenerationId, IndividualId, LightAssetKind, LineageId, MeshId, ParentRef, PatchIndividual,
    SceneId, decode,
};
use brood_scene::{Mesh, MeshRef};
use brood_storage::{NewGeneration, NewGenome, NewImport, NewIndividual, NewLineage, NewMesh};

use super::form::{FileGeneration, FileIndividual, LineageFile, VERSION};
use crate::breeding::{ADOPT, FIT};
use crate::controller::lineage::{check_name, check_saturation};
use crate::controller::{check_length, light_asset};
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::now_ms;

/// A file whose genomes and mesh are sound.
pub struct Checked {
    /// The file.
    pub file: LineageFile,
    /// Its genomes by hash.
    pub genomes: BTreeMap<GenomeHash, NewGenome>,
    /// Its mesh.
    pub mesh: Option<NewMesh>,
    /// The files of its lights.
    pub light_assets: Vec<(LightAssetKind, Vec<u8>)>,
}

/// Checks what is costly to check.
pub fn check(file: LineageFile) -> Result<Checked, ApiError> {
    let refuse = |pointer: &str, words: &str| ApiError::refused(words).at(pointer);
    if file.brood_lineage != VERSION {
        return Err(refuse("/brood_lineage", "the version of the form is 1"));
    }
    check_name(&file.name)?;
    check_length(&file.notes, limit::NOTE_CHARS, "/notes")?;
    check_saturation(file.saturation)?;
    file.dialect.validate().map_err(|error| refuse("/dialect", &error.to_string()))?;
    if !(limit::PICTURE_MIN_PX..=limit::THUMBNAIL_PX).contains(&file.thumbnail_px) {
        return Err(refuse("/thumbnail_px", "too small or too large"));
    }
    file.scene.validate().map_err(|error| {
        let pointer = format!("/scene{}", error.pointer);
        ApiError::refused(error.reason).at(pointer)
    })?;
    let mesh = match (&file.mesh, &file.scene.mesh) {
        (Some(data), MeshRef::Uploaded(_)) => Some(mesh(data)?),
        (None, MeshRef::Builtin(_)) => None,
        (Some(_), MeshRef::Builtin(_)) => {
            return Err(refuse("/mesh", "the scene's mesh is a built-in one"));
        }
        (None, MeshRef::Uploaded(_)) => {
            return Err(refuse("/mesh", "the scene's mesh is an uploaded one and has to be here"));
        }
    };
    let mut light_assets = Vec::with_capacity(file.light_assets.len());
    for (index, asset) in file.light_assets.iter().enumerate() {
        let pointer = format!("/light_assets/{index}/bytes");
        let bytes = BASE64_STANDARD
            .decode(&asset.bytes)
            .map_err(|error| refuse(&pointer, &error.to_string()))?;
        light_asset::answer(asset.kind, &bytes).map_err(|error| error.at(pointer))?;
        light_assets.push((asset.kind, bytes));
    }
    let mut genomes = BTreeMap::new();
    for (hash, text) in &file.genomes {
        let pointer = format!("/genomes/{}", quote(hash));
        let genome: Genome = text.parse().map_err(|error| ApiError::from(error).at(&pointer))?;
        let found = genome.hash();
        if hash.parse() != Ok(found) {
            return Err(refuse(&pointer, "the text is of another genome"));
        }
        if !genome.dialect().is_compatible(&file.dialect) {
            return Err(refuse(&pointer, "the genome is not of the lineage's dialect"));
        }
        let live = live_instructions(&genome).into_iter().filter(|live| *live).count();
        let new = NewGenome {
            hash: found,
            bytes: genome.canonical_bytes(),
            program_hash: *express(&genome).hash().as_bytes(),
            live_instructions: u32::try_from(live).expect("at most 1024 instructions"),
            layers: genome.layers().iter().map(Model::kind).collect(),
        };
        genomes.insert(found, new);
    }
    Ok(Checked { file, genomes, mesh, light_assets })
}

fn mesh(data: &str) -> Result<NewMesh, ApiError> {
    let refuse = |words: &str| ApiError::refused(words).at("/mesh");
    let bytes = BASE64_STANDARD.decode(data).map_err(|_| refuse("this is not base64"))?;
    let mesh: Mesh = decode(&bytes).map_err(|_| refuse("this is not a mesh"))?;
    Ok(NewMesh {
        id: MeshId::fresh(),
        content_hash: mesh.content_hash(),
        vertices: mesh.vertex_count() as u64,
        triangles: mesh.triangle_count() as u64,
        has_uv: mesh.has_uv(),
        warnings_json: "[]".to_owned(),
        data: brood_protocol::encode(&mesh),
    })
}

/// Turns a checked file into rows with new ids.
pub fn assemble(
    file: LineageFile,
    genomes: BTreeMap<GenomeHash, NewGenome>,
    scene: SceneId,
) -> Result<NewImport, ApiError> {
    let lineage = NewLineage {
        id: LineageId::fresh(),
        name: file.name,
        notes: file.notes,
        scene,
        thumbnail_px: file.thumbnail_px,
        dialect: file.dialect,
        saturation: file.saturation,
        energy_limit: file.energy_limit,
        created_ms: now_ms(),
    };
    let mut assembly = Assembly {
        lineage: lineage.id,
        dialect: lineage.dialect,
        genomes: &genomes,
        ids: HashMap::new(),
        marks: Vec::new(),
    };
    let mut generations = Vec::with_capacity(file.generations.len());
    for (index, generation) in file.generations.into_iter().enumerate() {
        generations.push(assembly.generation(generation, &format!("/generations/{index}"))?);
    }
    let marks = assembly.marks;
    let genomes = genomes.into_values().collect();
    Ok(NewImport { lineage, genomes, generations, marks, idempotency: None })
}

struct Assembly<'a> {
    lineage: LineageId,
    dialect: Dialect,
    genomes: &'a BTreeMap<GenomeHash, NewGenome>,
    ids: HashMap<IndividualId, IndividualId>,
    marks: Vec<(IndividualId, PatchIndividual)>,
}

impl Assembly<'_> {
    fn generation(
        &mut self,
        from: FileGeneration,
        pointer: &str,
    ) -> Result<NewGeneration, ApiError> {
        let refuse = |field: &str, words: &str| {
            Err(ApiError::refused(words).at(format!("{pointer}/{field}")))
        };
        for (field, amount) in [
            ("mutation", Some(from.mutation)),
            ("recombination", Some(from.recombination)),
            ("saturation", from.saturation),
        ] {
            if amount.is_some_and(|amount| !(0.0..=1.0).contains(&amount)) {
                return refuse(field, "this is an amount from 0 to 1");
            }
        }
        // What breeding could not have made has no place in a history that can be replayed.
        let operator = match from.parents.len() {
            0 if from.individuals.iter().all(|one| one.operator == ADOPT) => ADOPT,
            0 | 1 if from.individuals.iter().all(|one| one.operator == FIT) => FIT,
            0 => "random",
            1 => "mutate",
            2 => "recombine",
            _ => return refuse("parents", "a brood has two parents at most"),
        };
        if let Some(locks) = &from.locks
            && let Err(error) = locks.validate(&self.dialect)
        {
            return refuse(&format!("locks{}", error.pointer()), &error.to_string());
        }
        let first = from.parents.first().copied();
        if from.centre.is_some_and(|id| first != Some(ParentRef::Individual(id))) {
            return refuse("centre", "the centre is the first parent");
        }
        if !(1..=limit::CHILDREN as usize).contains(&from.individuals.len()) {
            return refuse("individuals", "a brood has 1 to 256 children");
        }
        let slots: HashSet<u32> = from.individuals.iter().map(|one| one.slot).collect();
        if slots.len() < from.individuals.len() || slots.iter().any(|slot| *slot >= limit::CHILDREN)
        {
            return refuse("individuals", "each child has a slot of its own below 256");
        }
        let mut parents = Vec::with_capacity(from.parents.len());
        for parent in &from.parents {
            parents.push(match parent {
                ParentRef::Genome(hash) if self.genomes.contains_key(hash) => *parent,
                ParentRef::Individual(id) if self.ids.contains_key(id) => {
                    ParentRef::Individual(self.ids[id])
                }
                _ => {
                    return refuse(
                        "parents",
                        "a parent is neither born before nor among the genomes",
                    );
                }
            });
        }
        let centre = match from.centre {
            None => None,
            Some(id) => match self.ids.get(&id) {
                Some(id) => Some(*id),
                None => return refuse("centre", "the centre was not born before"),
            },
        };
        let mut individuals = Vec::with_capacity(from.individuals.len());
        let mut born = Vec::with_capacity(from.individuals.len());
        for (index, one) in from.individuals.into_iter().enumerate() {
            let at = format!("{pointer}/individuals/{index}");
            let old = one.id;
            let new = self.individual(one, operator, &at)?;
            born.push((old, new.id));
            individuals.push(new);
        }
        for (old, new) in born {
            if self.ids.insert(old, new).is_some() {
                return refuse("individuals", "an id is there twice");
            }
        }
        Ok(NewGeneration {
            id: GenerationId::fresh(),
            lineage: self.lineage,
            seed: from.seed,
            parents,
            centre,
            mutation: from.mutation,
            recombination: from.recombination,
            curation: from.curation,
            constraints: from.constraints,
            saturation: from.saturation,
            energy_limit: from.energy_limit,
            locks: from.locks,
            created_ms: from.created_ms,
            individuals,
            pictures: Vec::new(),
            job: None,
            search: None,
            idempotency: None,
        })
    }

    fn individual(
        &mut self,
        from: FileIndividual,
        operator: &'static str,
        at: &str,
    ) -> Result<NewIndividual, ApiError> {
        let refuse =
            |field: &str, words: &str| ApiError::refused(words).at(format!("{at}/{field}"));
        let hash = from.hash.parse().ok().and_then(|hash| self.genomes.get(&hash));
        let genome = hash.ok_or_else(|| refuse("hash", "this is none of the file's genomes"))?;
        if from.operator != operator {
            return Err(refuse("operator", &format!("with so many parents it is {operator}")));
        }
        if from.attempts == 0 {
            return Err(refuse("attempts", "a child is drawn at least once"));
        }
        check_length(&from.note, limit::NOTE_CHARS, &format!("{at}/note"))?;
        let id = IndividualId::fresh();
        if from.favourite || !from.note.is_empty() {
            let mark = PatchIndividual { favourite: Some(from.favourite), note: Some(from.note) };
            self.marks.push((id, mark));
        }
        Ok(NewIndividual {
            id,
            slot: from.slot,
            hash: genome.hash,
            genome_bytes: genome.bytes.clone(),
            program_hash: genome.program_hash,
            operator,
            live_instructions: genome.live_instructions,
            layers: genome.layers.clone(),
            attempts: from.attempts,
            twin: from.twin,
        })
    }
}
