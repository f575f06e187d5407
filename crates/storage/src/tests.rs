//! Tests of the store through its public methods, on real files. This module has the shared
//! fixtures.

mod access;
mod blob;
mod content;
mod durability;
mod export_file;
mod family;
mod history;
mod lost_link;
mod migration;
mod migration_rules;
mod packing;
mod removal;
mod rolling_upgrade;
mod search;
mod several_writers;
mod tls;

use std::sync::Arc;
use std::time::Duration;

use brood_genome::{
    Dialect, GenomeHash, Locks, ModelKind, PaintingPalette, PaintingRegion, Start, Steer,
};
use brood_protocol::{
    Backend, BreedOptions, Curation, DialectConstraints, GenerationId, IndividualId, JobId,
    Lineage, LineageId, ParentRef, PictureFormat, PictureKey, Sampling, SceneId, Seed,
};
use sqlx::Connection as _;
use tempfile::TempDir;

use crate::sql::query;
use crate::{
    DatabaseAddress, Idempotency, NewGeneration, NewGenome, NewIndividual, NewPicture,
    StorageError, Store, StoredGeneration, StoredGenome,
};

/// Place of a store: a data directory, or one beside a schema of the PostgreSQL database that
/// `BROOD_TEST_DATABASE` names.
enum Place {
    Directory(TempDir),
    Schema(DatabaseAddress, TempDir),
}

impl Place {
    async fn new() -> Self {
        let Ok(address) = std::env::var("BROOD_TEST_DATABASE") else {
            return Self::Directory(tempfile::tempdir().unwrap());
        };
        let schema = format!("test_{}", JobId::fresh().to_string().replace('-', "_"));
        let mut conn = sqlx::PgConnection::connect(&address).await.unwrap();
        let create = sqlx::AssertSqlSafe(format!("CREATE SCHEMA {schema}"));
        sqlx::query(create).execute(&mut conn).await.unwrap();
        conn.close().await.unwrap();
        let sign = if address.contains('?') { '&' } else { '?' };
        let address = format!("{address}{sign}options[search_path]={schema}");
        Self::Schema(address.into(), tempfile::tempdir().unwrap())
    }

    async fn open(&self) -> Store {
        match self {
            Self::Directory(dir) => Store::open(dir.path()).await.unwrap(),
            Self::Schema(address, data) => Store::connect(address, data.path()).await.unwrap(),
        }
    }
}

/// Opens an empty store of the engine that is tested.
async fn open() -> (Place, Store) {
    let place = Place::new().await;
    let store = place.open().await;
    (place, store)
}

/// Opens an empty data directory.
async fn open_directory() -> (TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(dir.path()).await.unwrap();
    (dir, store)
}

fn hash(text: &str) -> [u8; 32] {
    *blake3::hash(text.as_bytes()).as_bytes()
}

/// Bytes of the genome with a name.
fn content(name: &str) -> Vec<u8> {
    format!("genome {name}").into_bytes()
}

fn genome(name: &str) -> GenomeHash {
    GenomeHash::of(&content(name))
}

/// Genome to be saved by hand, with the hashes of the given names.
fn saved(name: &str, program: &str) -> NewGenome {
    NewGenome {
        hash: genome(name),
        bytes: content(name),
        program_hash: hash(program),
        live_instructions: 41,
        layers: Vec::new(),
    }
}

/// Genome with a name, as it is read back.
fn read_back(name: &str) -> StoredGenome {
    StoredGenome::Bytes(content(name))
}

/// Stores genomes as earlier versions did: neither packed nor with their layers in a column.
async fn age(store: &Store, genomes: &[GenomeHash]) {
    for (hash, found) in store.genomes(genomes).await.unwrap() {
        let StoredGenome::Bytes(bytes) = found else { panic!("{hash} is text") };
        let change = store.write(move |conn| {
            Box::pin(async move {
                let sql = "UPDATE genome SET bytes = ?, bases = NULL, layers = NULL WHERE hash = ?";
                let hash = hash.as_bytes().to_vec();
                query(sql).bind(bytes).bind(hash).execute(conn).await?;
                Ok(())
            })
        });
        change.await.unwrap();
    }
}

/// Runs a statement on the write connection.
async fn execute(store: &Store, sql: &'static str) {
    let change = store.write(move |conn| {
        Box::pin(async move {
            query(sql).execute(conn).await?;
            Ok(())
        })
    });
    change.await.unwrap();
}

fn key(name: &str) -> PictureKey {
    PictureKey(hash(name))
}

async fn scene(store: &Store) -> SceneId {
    store.put_scene("{}", hash("{}"), &[], 1).await.unwrap()
}

fn new_lineage(name: &str, scene: SceneId, created_ms: i64) -> Lineage {
    Lineage {
        id: LineageId::fresh(),
        name: name.to_owned(),
        notes: "seen at dusk".to_owned(),
        tags: vec!["Évora".to_owned()],
        hidden: false,
        cover_individual: None,
        scene,
        thumbnail_px: 256,
        start: Start::Wild,
        dialect: Dialect { isotropic: true, ..Dialect::default() },
        saturation: 0.1,
        energy_limit: true,
        generations: 0,
        favourites: 0,
        created_ms,
        version: 1,
    }
}

async fn lineage(store: &Store) -> LineageId {
    let new = new_lineage("first", scene(store).await, 5);
    store.create_lineage(new, None).await.unwrap().id
}

/// Child with genome and program hashes derived from a name.
fn child(slot: u32, genome_name: &str) -> NewIndividual {
    NewIndividual {
        id: IndividualId::fresh(),
        slot,
        genome: Arc::new(NewGenome {
            hash: genome(genome_name),
            bytes: content(genome_name),
            program_hash: hash(&format!("program of {genome_name}")),
            live_instructions: 41,
            layers: vec![ModelKind::Lambert],
        }),
        operator: "mutate",
        attempts: 2,
        twin: false,
    }
}

fn painting() -> PaintingPalette {
    let [dark, middle, bright] = [[0x10, 0x20, 0x50], [0x30, 0x50, 0xa0], [0xa0, 0xc0, 0xf0]];
    let region = |share| PaintingRegion { dark, middle, bright, share };
    PaintingPalette::new(vec![region(0.6127), region(0.1)]).unwrap()
}

/// Generation of three children; their genomes are named after `name`.
fn new_generation(lineage: LineageId, parents: &[ParentRef], name: &str) -> NewGeneration {
    NewGeneration {
        id: GenerationId::fresh(),
        lineage,
        seed: Seed(u64::MAX - 7),
        parents: parents.to_vec(),
        centre: None,
        options: BreedOptions {
            mutation: 0.3,
            recombination: 0.7,
            curation: Curation::Distinct,
            constraints: DialectConstraints {
                isotropic: Some(true),
                homogeneous: None,
                bumps: Some(true),
            },
            saturation: Some(0.1),
            energy_limit: Some(true),
            locks: Some(Locks { constants: vec![3, 127], ..Locks::default() }),
            steer: vec![Steer::Warmer, Steer::Rougher],
            painting: Some(painting()),
        },
        created_ms: 1_700_000_000_123,
        individuals: (0..3).map(|slot| child(slot, &format!("{name} {slot}"))).collect(),
        pictures: Vec::new(),
        search: None,
        idempotency: None,
    }
}

impl Store {
    async fn create_generation(
        &self,
        new: NewGeneration,
    ) -> Result<StoredGeneration, StorageError> {
        Ok(self.create_generation_timed(new).await?.0)
    }
}

async fn generation(
    store: &Store,
    lineage: LineageId,
    parents: &[ParentRef],
    name: &str,
) -> StoredGeneration {
    store.create_generation(new_generation(lineage, parents, name)).await.unwrap()
}

fn picture(name: &str, genome_name: &str, scene: SceneId) -> NewPicture {
    NewPicture {
        key: key(name),
        genome_hash: genome(genome_name),
        scene,
        light_deg: 22.5,
        size_px: 256.into(),
        sampling: Sampling::Adaptive,
        area: "1,2,3,4".parse().ok(),
        format: PictureFormat::Png,
        backend: Backend::Auto,
        renderer_version: 1,
    }
}

fn idempotency(key: &str) -> Idempotency {
    Idempotency {
        key: key.to_owned(),
        route: "POST /v1/lineages".to_owned(),
        body_hash: hash("body"),
        status: 201,
        answer: b"made".to_vec(),
    }
}
