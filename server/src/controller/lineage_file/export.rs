//! Lineage files are written while they are sent: a lineage may be larger than the memory that a
//! request may use.
//!
//! The lineage is read twice. The first pass collects the hashes of the genomes and measures the
//! file, so that one that could not be imported again is refused. Generations that are born
//! meanwhile are left out.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;

use async_stream::try_stream;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_genome::{GenomeHash, ImageHash, Start};
use brood_protocol::{BreedOptions, IndividualId, LineageId, MeshSource, ParentRef};
use brood_storage::{StoredGeneration, StoredGenome};
use bytes::Bytes;
use futures::stream::Stream;

use super::form::{self, FileGeneration, FileIndividual, FileLightAsset, LineageFile};
use crate::controller::scene;
use crate::library::read_genome;
use crate::limit;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::scene_asset;
use crate::state::App;

/// Generations, and genomes, per read.
const GENERATIONS: u32 = 32;
const GENOMES: usize = 200;

/// Lineage file that can be written.
pub struct Export {
    app: App,
    id: LineageId,
    /// Number of generations in the file.
    generations: u64,
    genomes: Vec<GenomeHash>,
    /// Members of the file before `genomes`, without the end of the object.
    head: String,
}

impl Export {
    /// Measures the file of a lineage.
    ///
    /// # Errors
    /// 404 if the lineage does not exist; 422 if the file could not be imported again.
    pub async fn prepare(app: &App, id: LineageId) -> Result<Self, ApiError> {
        let lineage = app.store.lineage(id).await?;
        let known = app.library.scene(lineage.scene).await?;
        let (mut genomes, mut bytes) = (BTreeSet::new(), 0);
        genomes.extend(scene::materials(&known.scene));
        let mut index = 0;
        while index < lineage.generations {
            let some = page(app, id, index, lineage.generations).await?;
            if some.is_empty() {
                break;
            }
            index += some.len() as u64;
            let foreign = foreign_parents(app, id, &some).await?;
            genomes.extend(hashes(&some, &foreign));
            bytes += run_blocking(move || written(some, id, &foreign)).await?.len();
            check_bytes(bytes)?;
        }
        let generations = index;
        let mut images = BTreeSet::new();
        let genomes: Vec<_> = genomes.into_iter().collect();
        for some in genomes.chunks(GENOMES) {
            let texts = texts(app, some).await?;
            bytes += texts.iter().map(|(_, text, _)| json_bytes(text)).sum::<usize>();
            check_bytes(bytes)?;
            images.extend(texts.into_iter().flat_map(|(_, _, images)| images));
        }
        let mesh = match known.mesh {
            MeshSource::Builtin | MeshSource::Target => None,
            MeshSource::Uploaded(hash) => {
                Some(BASE64_STANDARD.encode(app.store.mesh_data(hash).await?))
            }
        };
        let mut object_meshes = BTreeMap::new();
        for (object, source) in known.scene.objects.iter().zip(&known.objects) {
            if let MeshSource::Uploaded(hash) = source.mesh {
                let data = app.store.mesh_data(hash).await?;
                object_meshes.insert(object.mesh.to_string(), BASE64_STANDARD.encode(data));
            }
        }
        let mut files: BTreeSet<[u8; 32]> = images.iter().map(|hash| *hash.as_bytes()).collect();
        files.extend(scene_asset::files(&known.scene));
        let mut light_assets = Vec::new();
        for hash in files {
            let (kind, bytes) = app.store.light_asset(hash).await?;
            light_assets.push(FileLightAsset { kind, bytes: BASE64_STANDARD.encode(bytes) });
        }
        let cover_individual = match lineage.cover_individual {
            Some(cover) if app.store.individual(cover).await?.lineage == id => Some(cover),
            _ => None,
        };
        let head = LineageFile {
            brood_lineage: form::VERSION,
            name: lineage.name,
            notes: lineage.notes,
            tags: lineage.tags,
            cover_individual,
            start: (lineage.start != Start::of(&lineage.dialect)).then_some(lineage.start),
            dialect: lineage.dialect,
            thumbnail_px: lineage.thumbnail_px,
            saturation: lineage.saturation,
            energy_limit: lineage.energy_limit,
            scene: known.scene.clone(),
            mesh,
            object_meshes,
            light_assets,
            genomes: BTreeMap::new(),
            generations: Vec::new(),
        };
        let head = run_blocking(move || serde_json::to_string(&head)).await?;
        let head = head.map_err(|error| ApiError::internal(error.to_string()))?;
        let end = "\"genomes\":{},\"generations\":[]}";
        let head = head.strip_suffix(end).ok_or_else(|| {
            ApiError::internal("the last members of a lineage file are not its lists")
        })?;
        check_bytes(bytes + head.len())?;
        Ok(Self { app: app.clone(), id, generations, genomes, head: head.to_owned() })
    }

    /// Writes the file. An error ends the stream, so that the client sees a broken transfer.
    pub fn stream(self) -> impl Stream<Item = Result<Bytes, io::Error>> + Send {
        let Self { app, id, generations, genomes, head } = self;
        try_stream! {
            yield Bytes::from(head);
            let mut before = "\"genomes\":{";
            for some in genomes.chunks(GENOMES) {
                let texts = texts(&app, some).await.map_err(broken)?;
                let mut text = String::new();
                for (hash, genome, _) in texts {
                    text += before;
                    text += &format!("\"{hash}\":{}", serde_json::Value::String(genome));
                    before = ",";
                }
                yield Bytes::from(text);
            }
            // There may be none.
            let none = if genomes.is_empty() { before } else { "" };
            yield Bytes::from(format!("{none}}},\"generations\":["));
            let mut index = 0;
            while index < generations {
                let some = page(&app, id, index, generations).await.map_err(broken)?;
                if some.is_empty() {
                    Err(io::Error::other("the lineage was removed"))?;
                }
                let before = if index > 0 { "," } else { "" };
                index += some.len() as u64;
                let foreign = foreign_parents(&app, id, &some).await.map_err(broken)?;
                let text = run_blocking(move || written(some, id, &foreign)).await;
                yield Bytes::from(before.to_owned() + &text.map_err(broken)?);
            }
            yield Bytes::from_static(b"]}");
        }
    }
}

fn broken(error: ApiError) -> io::Error {
    tracing::warn!(reason = %error.problem().detail, "a lineage file was not finished");
    io::Error::other(error.problem().detail.clone())
}

/// Checks that a file is small enough to be imported again.
fn check_bytes(so_far: usize) -> Result<(), ApiError> {
    let most = limit::LINEAGE_FILE_BYTES;
    if so_far <= most {
        return Ok(());
    }
    let words = format!(
        "the file is too large to be imported again: at least {so_far} bytes, the limit is {most}"
    );
    Err(ApiError::refused(words))
}

/// Size of a genome in the file, with its hash.
fn json_bytes(text: &str) -> usize {
    70 + text.len() + text.matches('\n').count()
}

/// Reads generations from an index on.
async fn page(
    app: &App,
    id: LineageId,
    index: u64,
    end: u64,
) -> Result<Vec<StoredGeneration>, ApiError> {
    let count = (end - index).min(GENERATIONS.into()) as u32;
    Ok(app.store.list_generations(id, index.checked_sub(1), count).await?)
}

/// Returns the genome hashes of parents that belong to other lineages.
async fn foreign_parents(
    app: &App,
    id: LineageId,
    generations: &[StoredGeneration],
) -> Result<HashMap<IndividualId, GenomeHash>, ApiError> {
    let ids = generations.iter().flat_map(|one| &one.parents).filter_map(|parent| match parent {
        ParentRef::Individual(id) => Some(*id),
        ParentRef::Genome(_) => None,
    });
    let ids: Vec<_> = ids.collect::<BTreeSet<_>>().into_iter().collect();
    let parents = app.store.individuals(&ids).await?;
    Ok(parents.into_iter().filter(|one| one.lineage != id).map(|one| (one.id, one.hash)).collect())
}

/// Hashes of the children and of parents that are not children in the file.
fn hashes(
    generations: &[StoredGeneration],
    foreign: &HashMap<IndividualId, GenomeHash>,
) -> impl Iterator<Item = GenomeHash> {
    generations.iter().flat_map(|one| {
        let parents = one.parents.iter().filter_map(|parent| match parent {
            ParentRef::Genome(hash) => Some(*hash),
            ParentRef::Individual(id) => foreign.get(id).copied(),
        });
        one.individuals.iter().map(|child| child.hash).chain(parents)
    })
}

/// Returns genomes with their texts and control images.
async fn texts(
    app: &App,
    hashes: &[GenomeHash],
) -> Result<Vec<(GenomeHash, String, Vec<ImageHash>)>, ApiError> {
    let found = app.store.genomes(hashes).await?;
    let write = move || {
        let text = |(hash, stored): (GenomeHash, StoredGenome)| {
            let genome = read_genome(hash, &stored)?;
            Ok((hash, genome.to_string(), genome.images().into_iter().collect()))
        };
        let mut texts = found.into_iter().map(text).collect::<Result<Vec<_>, ApiError>>()?;
        texts.sort_by_key(|(hash, ..)| *hash);
        Ok(texts)
    };
    run_blocking(write).await?
}

/// Returns generations as JSON, with commas between them.
fn written(
    generations: Vec<StoredGeneration>,
    id: LineageId,
    foreign: &HashMap<IndividualId, GenomeHash>,
) -> String {
    let words = generations.into_iter().map(|one| {
        serde_json::to_string(&present(one, id, foreign))
            .expect("a generation has numbers, words and lists")
    });
    words.collect::<Vec<_>>().join(",")
}

fn present(
    stored: StoredGeneration,
    id: LineageId,
    foreign: &HashMap<IndividualId, GenomeHash>,
) -> FileGeneration {
    let parent = |parent: &ParentRef| match parent {
        ParentRef::Individual(id) => {
            foreign.get(id).map_or(*parent, |hash| ParentRef::Genome(*hash))
        }
        ParentRef::Genome(_) => *parent,
    };
    let BreedOptions {
        mutation,
        recombination,
        curation,
        constraints,
        saturation,
        energy_limit,
        locks,
        steer,
        painting,
    } = stored.options;
    FileGeneration {
        seed: stored.seed,
        parents: stored.parents.iter().map(parent).collect(),
        centre: stored.centre.filter(|centre| centre.lineage == id).map(|centre| centre.id),
        mutation,
        recombination,
        curation,
        constraints,
        saturation,
        energy_limit,
        locks,
        steer,
        painting,
        created_ms: stored.created_ms,
        individuals: stored
            .individuals
            .into_iter()
            .map(|one| FileIndividual {
                id: one.id,
                hash: one.hash.to_string(),
                slot: one.slot,
                operator: one.operator,
                attempts: one.attempts,
                twin: one.twin,
                favourite: one.favourite,
                note: one.note,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_is_refused_when_it_could_not_be_imported_again() {
        assert!(check_bytes(limit::LINEAGE_FILE_BYTES).is_ok());
        let error = check_bytes(limit::LINEAGE_FILE_BYTES + 1).unwrap_err();
        assert_eq!(error.status(), 422);
        assert!(error.problem().detail.contains("268435457 bytes"), "{error:?}");
    }
}
