//! Checks lineage files and turns them into rows. Everything that can be computed is recomputed,
//! not trusted.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_eval::express;
use brood_genome::{
    Dialect, Genome, GenomeHash, ImageHash, Model, Start, Steer, live_instructions,
};
use brood_mesh::Mesh;
use brood_protocol::{
    GenerationId, IndividualId, LightAssetKind, Lineage, LineageId, ParentRef, PatchIndividual,
    SceneId, check_painted_defaults, decode_stored,
};
use brood_scene::MeshRef;
use brood_storage::{NewGeneration, NewGenome, NewImport, NewIndividual, StoredMesh};

use super::form::{FileGeneration, FileIndividual, LineageFile, VERSION};
use crate::breeding::{ADOPT, FIT};
use crate::clock::now_ms;
use crate::controller::lineage::{check_name, check_saturation, check_tags, start_of};
use crate::controller::{check_length, light_asset, mesh};
use crate::limit;
use crate::problem::{ApiError, quote};

/// Mesh with its stored bytes.
pub type ImportedMesh = (StoredMesh, Vec<u8>);

/// Lineage file whose genomes, meshes, images and light files were checked.
pub struct Checked {
    /// The file.
    pub file: LineageFile,
    /// Genomes by hash.
    pub genomes: BTreeMap<GenomeHash, Arc<NewGenome>>,
    /// Mesh of the scene, if uploaded.
    pub mesh: Option<ImportedMesh>,
    /// Uploaded meshes of the scene's other objects, by the ids in the file.
    pub object_meshes: BTreeMap<String, ImportedMesh>,
    /// Control images of the genomes, each with the hash of one that has it.
    pub images: Vec<(GenomeHash, ImageHash)>,
    /// Files of the lights.
    pub light_assets: Vec<(LightAssetKind, Vec<u8>)>,
}

/// Checks a file's values, genomes, mesh and light files. This is CPU-heavy.
///
/// # Errors
/// 422 with a pointer to the invalid value.
pub fn check(file: LineageFile) -> Result<Checked, ApiError> {
    let refuse = |pointer: &str, words: &str| ApiError::refused(words).at(pointer);
    if file.brood_lineage != VERSION {
        let words = format!("the version must be {VERSION}, got {}", file.brood_lineage);
        return Err(refuse("/brood_lineage", &words));
    }
    check_name(&file.name)?;
    check_length(&file.notes, limit::NOTE_CHARS, "/notes")?;
    check_tags(&file.tags)?;
    check_saturation(file.saturation)?;
    file.dialect.validate().map_err(|error| refuse("/dialect", &error.to_string()))?;
    if !(limit::PICTURE_MIN_PX..=limit::THUMBNAIL_PX).contains(&file.thumbnail_px) {
        let (least, most) = (limit::PICTURE_MIN_PX, limit::THUMBNAIL_PX);
        let words = format!("must be {least} to {most} pixels, got {}", file.thumbnail_px);
        return Err(refuse("/thumbnail_px", &words));
    }
    file.scene.validate().map_err(|error| {
        let pointer = format!("/scene{}", error.pointer);
        ApiError::refused(error.reason).at(pointer)
    })?;
    let mesh = match (&file.mesh, &file.scene.mesh) {
        (Some(data), MeshRef::Uploaded(_)) => Some(mesh(data, "/mesh")?),
        (None, MeshRef::Builtin(_)) => None,
        (Some(_), MeshRef::Builtin(_)) => {
            return Err(refuse(
                "/mesh",
                "the scene has a built-in mesh, so no mesh is allowed here",
            ));
        }
        (None, MeshRef::Uploaded(_)) => {
            return Err(refuse("/mesh", "the mesh is missing: the scene has an uploaded mesh"));
        }
    };
    let object_meshes = object_meshes(&file)?;
    let materials = crate::controller::scene::materials(&file.scene);
    let bred = bred(&file);
    let mut light_assets = Vec::with_capacity(file.light_assets.len());
    for (index, asset) in file.light_assets.iter().enumerate() {
        let pointer = format!("/light_assets/{index}/bytes");
        let bytes = BASE64_STANDARD
            .decode(&asset.bytes)
            .map_err(|error| refuse(&pointer, &error.to_string()))?;
        light_asset::answer(asset.kind, &bytes).map_err(|error| error.at(pointer))?;
        light_assets.push((asset.kind, bytes));
    }
    let (mut genomes, mut images) = (BTreeMap::new(), BTreeMap::new());
    for (hash, text) in &file.genomes {
        let pointer = format!("/genomes/{}", quote(hash));
        let genome: Genome = text.parse().map_err(|error| ApiError::from(error).at(&pointer))?;
        let found = genome.hash();
        if hash.parse() != Ok(found) {
            return Err(refuse(&pointer, "the text does not have this hash"));
        }
        let is_material = materials.contains(&found) && !bred.contains(&found);
        if !is_material && !genome.dialect().is_compatible(&file.dialect) {
            return Err(refuse(&pointer, "the genome does not have the lineage's dialect"));
        }
        let live = live_instructions(&genome).into_iter().filter(|live| *live).count();
        let new = NewGenome {
            hash: found,
            bytes: genome.canonical_bytes(),
            program_hash: *express(&genome).hash().as_bytes(),
            live_instructions: u32::try_from(live).expect("at most 1024 instructions"),
            layers: genome.layers().iter().map(Model::kind).collect(),
        };
        images.extend(genome.images().into_iter().map(|image| (image, found)));
        genomes.insert(found, Arc::new(new));
    }
    let images = images.into_iter().map(|(image, genome)| (genome, image)).collect();
    Ok(Checked { file, genomes, images, mesh, object_meshes, light_assets })
}

/// Returns the hashes of the file's individuals and parents.
fn bred(file: &LineageFile) -> HashSet<GenomeHash> {
    let individuals = file.generations.iter().flat_map(|one| &one.individuals);
    let parents = file.generations.iter().flat_map(|one| &one.parents);
    let parents = parents.filter_map(|parent| match parent {
        ParentRef::Genome(hash) => Some(*hash),
        ParentRef::Individual(_) => None,
    });
    individuals.filter_map(|one| one.hash.parse().ok()).chain(parents).collect()
}

/// Reads the uploaded meshes of the scene's other objects.
fn object_meshes(file: &LineageFile) -> Result<BTreeMap<String, ImportedMesh>, ApiError> {
    let mut meshes = BTreeMap::new();
    for object in &file.scene.objects {
        let MeshRef::Uploaded(id) = &object.mesh else { continue };
        let pointer = format!("/object_meshes/{}", quote(id));
        let Some(data) = file.object_meshes.get(id) else {
            let words = "the mesh is missing: an object of the scene has it";
            return Err(ApiError::refused(words).at(pointer));
        };
        if !meshes.contains_key(id) {
            meshes.insert(id.clone(), mesh(data, &pointer)?);
        }
    }
    Ok(meshes)
}

fn mesh(data: &str, pointer: &str) -> Result<ImportedMesh, ApiError> {
    let refuse = |words: &str| ApiError::refused(words).at(pointer);
    let bytes = BASE64_STANDARD.decode(data).map_err(|_| refuse("the mesh must be base64"))?;
    let mesh: Mesh = decode_stored(&bytes).map_err(|_| refuse("the mesh cannot be decoded"))?;
    Ok((mesh::row(&mesh, Vec::new()), brood_protocol::encode(&mesh)))
}

/// Turns a checked file into rows with new ids.
///
/// # Errors
/// 422 with a pointer if the generations contradict each other.
pub fn assemble(
    file: LineageFile,
    genomes: BTreeMap<GenomeHash, Arc<NewGenome>>,
    scene: SceneId,
) -> Result<NewImport, ApiError> {
    let (start, dialect) = start_of(file.start, Some(file.dialect))?;
    if start == Start::Painted {
        check_painted_defaults(Some(file.saturation), Some(file.energy_limit))?;
    }
    let lineage = Lineage {
        id: LineageId::fresh(),
        name: file.name,
        notes: file.notes,
        tags: file.tags,
        hidden: false,
        cover_individual: None,
        scene,
        thumbnail_px: file.thumbnail_px,
        start,
        dialect,
        saturation: file.saturation,
        energy_limit: file.energy_limit,
        generations: file.generations.len() as u64,
        favourites: 0,
        created_ms: now_ms(),
        version: 1,
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
    let cover = match file.cover_individual {
        Some(id) => Some(*assembly.ids.get(&id).ok_or_else(|| {
            let words = "the cover must be an individual of the file";
            ApiError::refused(words).at("/cover_individual")
        })?),
        None => None,
    };
    let marks = assembly.marks;
    let genomes = genomes.into_iter().collect();
    Ok(NewImport { lineage, genomes, generations, marks, cover, idempotency: None })
}

struct Assembly<'a> {
    lineage: LineageId,
    dialect: Dialect,
    genomes: &'a BTreeMap<GenomeHash, Arc<NewGenome>>,
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
        let options = from.options();
        if let Err(error) = options.check_amounts() {
            return refuse(error.field, &error.to_string());
        }
        if let Err(error) = Steer::check_words(&options.steer) {
            return refuse("steer", &error.to_string());
        }
        // Only broods that breeding could have made are accepted: the history must be repeatable.
        let all_by = |name| from.individuals.iter().all(|one| one.operator == name);
        let operator = match *from.parents {
            [] | [ParentRef::Individual(_)] if all_by(ADOPT) => ADOPT,
            [] | [_] if all_by(FIT) => FIT,
            [] => "random",
            [_] => "mutate",
            [_, _] => "recombine",
            _ => return refuse("parents", "a brood must have at most 2 parents"),
        };
        if let Some(locks) = &options.locks
            && let Err(error) = locks.validate(&self.dialect)
        {
            return refuse(&format!("locks{}", error.pointer()), &error.to_string());
        }
        let first = from.parents.first().copied();
        if from.centre.is_some_and(|id| first != Some(ParentRef::Individual(id))) {
            return refuse("centre", "the centre must be the first parent");
        }
        if !(1..=limit::CHILDREN as usize).contains(&from.individuals.len()) {
            return refuse("individuals", "a brood must have 1 to 256 children");
        }
        let slots: HashSet<u32> = from.individuals.iter().map(|one| one.slot).collect();
        if slots.len() < from.individuals.len() || slots.iter().any(|slot| *slot >= limit::CHILDREN)
        {
            return refuse("individuals", "each child must have its own slot below 256");
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
                        "a parent must be an individual of an earlier generation or a genome of the file",
                    );
                }
            });
        }
        let centre = match from.centre {
            None => None,
            Some(id) => match self.ids.get(&id) {
                Some(id) => Some(*id),
                None => {
                    return refuse(
                        "centre",
                        "the centre must be an individual of an earlier generation",
                    );
                }
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
                return refuse("individuals", "an id occurs twice");
            }
        }
        Ok(NewGeneration {
            id: GenerationId::fresh(),
            lineage: self.lineage,
            seed: from.seed,
            parents,
            centre,
            options,
            created_ms: from.created_ms,
            individuals,
            pictures: Vec::new(),
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
        let genome = hash.ok_or_else(|| refuse("hash", "the file has no genome with this hash"))?;
        if from.operator != operator {
            return Err(refuse(
                "operator",
                &format!("the operator must be {operator} for this number of parents"),
            ));
        }
        if from.attempts == 0 {
            return Err(refuse("attempts", "must be at least 1"));
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
            genome: genome.clone(),
            operator,
            attempts: from.attempts,
            twin: from.twin,
        })
    }
}
