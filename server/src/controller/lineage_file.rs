//! Lineage files: export and import of a whole history as one JSON document.

mod form;
mod import;

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_genome::{GenomeHash, ImageHash, Start};
use brood_protocol::{BreedOptions, IndividualId, Lineage, LineageId, MeshSource, ParentRef};
use brood_storage::{StoredGeneration, StoredGenome};
use http::{Request, StatusCode, header};

pub use form::LineageFile;
use form::{FileGeneration, FileIndividual, FileLightAsset};

use super::create_once;
use crate::control_image;
use crate::extract::{Path, parse_json, read_upload};
use crate::idempotency::IdempotencyKey;
use crate::library::read_genome;
use crate::limit;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::scene_asset;
use crate::state::App;

/// Rows per read.
const CHUNK: usize = 200;
const JSON: &str = "application/json";

/// Exports a lineage as one file.
#[utoipa::path(get, path = "/v1/lineages/{id}/file", operation_id = "export_lineage", tag = "lineages",
    params(("id" = LineageId, Path)),
    responses((status = 200, description = "lineage with its generations and genomes", body = LineageFile),
        (status = 422, description = "the file would be larger than the import limit of 256 MiB")))]
pub async fn export(
    State(app): State<App>,
    Path(id): Path<LineageId>,
) -> Result<Response, ApiError> {
    let lineage = app.store.lineage(id).await?;
    let known = app.library.scene(lineage.scene).await?;
    let mesh = match known.mesh {
        MeshSource::Builtin | MeshSource::Target => None,
        MeshSource::Uploaded(hash) => {
            Some(BASE64_STANDARD.encode(app.store.mesh_data(hash).await?))
        }
    };
    let stored = generations(&app, id).await?;
    let own: HashSet<IndividualId> =
        stored.iter().flat_map(|one| &one.individuals).map(|one| one.id).collect();
    let foreign = foreign_parents(&app, &stored, &own).await?;
    let hashes = stored.iter().flat_map(|one| {
        let parents = one.parents.iter().filter_map(|parent| match parent {
            ParentRef::Genome(hash) => Some(*hash),
            ParentRef::Individual(id) => foreign.get(id).copied(),
        });
        one.individuals.iter().map(|child| child.hash).chain(parents)
    });
    let hashes: BTreeSet<GenomeHash> =
        hashes.chain(super::scene::materials(&known.scene)).collect();
    let mut object_meshes = BTreeMap::new();
    for (object, source) in known.scene.objects.iter().zip(&known.objects) {
        if let MeshSource::Uploaded(hash) = source.mesh {
            let data = app.store.mesh_data(hash).await?;
            object_meshes.insert(object.mesh.to_string(), BASE64_STANDARD.encode(data));
        }
    }
    let (genomes, images) = texts(&app, &hashes).await?;
    let mut files: BTreeSet<[u8; 32]> = images.iter().map(|hash| *hash.as_bytes()).collect();
    files.extend(scene_asset::files(&known.scene));
    let mut light_assets = Vec::new();
    for hash in files {
        let (kind, bytes) = app.store.light_asset(hash).await?;
        light_assets.push(FileLightAsset { kind, bytes: BASE64_STANDARD.encode(bytes) });
    }
    let file = LineageFile {
        brood_lineage: form::VERSION,
        name: lineage.name,
        notes: lineage.notes,
        tags: lineage.tags,
        cover_individual: lineage.cover_individual.filter(|id| own.contains(id)),
        start: (lineage.start != Start::of(&lineage.dialect)).then_some(lineage.start),
        dialect: lineage.dialect,
        thumbnail_px: lineage.thumbnail_px,
        saturation: lineage.saturation,
        energy_limit: lineage.energy_limit,
        scene: known.scene.clone(),
        mesh,
        object_meshes,
        light_assets,
        genomes,
        generations: stored.into_iter().map(|one| present(one, &own, &foreign)).collect(),
    };
    let disposition = format!("attachment; filename=\"lineage-{id}.json\"");
    let headers =
        [(header::CONTENT_DISPOSITION, disposition), (header::CONTENT_TYPE, JSON.to_owned())];
    Ok((headers, written(file).await?).into_response())
}

/// Imports a lineage file of at most 256 MiB.
///
/// Individuals get new ids; the genome hashes stay the same.
#[utoipa::path(post, path = "/v1/lineages/import", operation_id = "import_lineage", tag = "lineages",
    request_body = LineageFile,
    responses((status = 201, description = "imported lineage", body = Lineage)))]
pub async fn import(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (_, bytes) = read_upload(request, &[JSON], limit::LINEAGE_FILE_BYTES).await?;
    create_once(&app, key, "/v1/lineages", bytes.clone(), async |attempt| {
        let check = move || {
            let file = parse_json(&bytes)?;
            drop(bytes);
            import::check(file)
        };
        let checked = app.processors.run(check).await??;
        let import::Checked { file, genomes, images, mesh, object_meshes, light_assets } = checked;
        for (kind, bytes) in light_assets {
            app.store.put_light_asset(*blake3::hash(&bytes).as_bytes(), kind, bytes).await?;
        }
        for (hash, image) in images {
            let pointer = format!("/genomes/{hash}");
            let checked = control_image::check_one(&app.store, image).await;
            checked.map_err(|error| error.at(pointer))?;
        }
        let mut scene = file.scene.clone();
        if let Some((mesh, data)) = mesh {
            let id = app.store.put_mesh(mesh, data).await?;
            scene.mesh = brood_scene::MeshRef::Uploaded(id.to_string());
        }
        for (name, (mesh, data)) in object_meshes {
            let id = app.store.put_mesh(mesh, data).await?;
            let objects = scene.objects.iter_mut().zip(&file.scene.objects);
            for (object, _) in objects.filter(|(_, given)| given.mesh.to_string() == name) {
                object.mesh = brood_scene::MeshRef::Uploaded(id.to_string());
            }
        }
        for hash in super::scene::materials(&scene) {
            if let Some(genome) = genomes.get(&hash) {
                app.store.put_genome((**genome).clone()).await?;
            }
        }
        app.library.meshes(&scene).await.map_err(|error| error.inside("/scene"))?;
        scene_asset::check(&app.store, &scene).await.map_err(|error| error.inside("/scene"))?;
        let scene = super::scene::store(&app, &scene).await?;
        let mut new = import::assemble(file, genomes, scene)?;
        new.idempotency = attempt.record(StatusCode::CREATED, &new.lineage);
        Ok(app.store.import_lineage(new).await?)
    })
    .await
}

async fn written(file: LineageFile) -> Result<Vec<u8>, ApiError> {
    let bytes = run_blocking(move || serde_json::to_vec(&file)).await?;
    let bytes = bytes.map_err(|error| ApiError::internal(error.to_string()))?;
    check_bytes(bytes.len())?;
    Ok(bytes)
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

async fn generations(app: &App, id: LineageId) -> Result<Vec<StoredGeneration>, ApiError> {
    let mut all: Vec<StoredGeneration> = Vec::new();
    loop {
        let after = all.last().map(|one| one.index);
        let mut some = app.store.list_generations(id, after, limit::PAGE).await?;
        if some.is_empty() {
            return Ok(all);
        }
        all.append(&mut some);
    }
}

/// Returns the genome hashes of parents that belong to other lineages.
async fn foreign_parents(
    app: &App,
    generations: &[StoredGeneration],
    own: &HashSet<IndividualId>,
) -> Result<HashMap<IndividualId, GenomeHash>, ApiError> {
    let ids = generations.iter().flat_map(|one| &one.parents).filter_map(|parent| match parent {
        ParentRef::Individual(id) if !own.contains(id) => Some(*id),
        _ => None,
    });
    let ids: Vec<_> = ids.collect::<BTreeSet<_>>().into_iter().collect();
    let mut found = HashMap::new();
    for some in ids.chunks(CHUNK) {
        let individuals = app.store.individuals(some).await?;
        found.extend(individuals.into_iter().map(|one| (one.id, one.hash)));
    }
    Ok(found)
}

/// Returns the texts of genomes by their hashes, and their control images.
async fn texts(
    app: &App,
    hashes: &BTreeSet<GenomeHash>,
) -> Result<(BTreeMap<String, String>, BTreeSet<ImageHash>), ApiError> {
    let hashes: Vec<_> = hashes.iter().copied().collect();
    let (mut texts, mut images) = (BTreeMap::new(), BTreeSet::new());
    let mut bytes = 0;
    for some in hashes.chunks(CHUNK) {
        let found = app.store.genomes(some).await?;
        let write = move || -> Result<Vec<_>, ApiError> {
            let text = |(hash, stored): (&GenomeHash, &StoredGenome)| {
                let genome = read_genome(*hash, stored)?;
                Ok((hash.to_string(), genome.to_string(), genome.images()))
            };
            found.iter().map(text).collect()
        };
        let written = run_blocking(write).await??;
        bytes += written.iter().map(|(_, text, _)| text.len()).sum::<usize>();
        check_bytes(bytes)?;
        for (hash, text, own) in written {
            texts.insert(hash, text);
            images.extend(own);
        }
    }
    Ok((texts, images))
}

fn present(
    stored: StoredGeneration,
    own: &HashSet<IndividualId>,
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
        centre: stored.centre.map(|centre| centre.id).filter(|id| own.contains(id)),
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
