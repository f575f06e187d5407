//! Tests of packed genomes: which ones are packed against which, after births, purges and
//! compaction; and of damage that a check finds.

use std::sync::Arc;

use brood_genome::{BirthKey, Dialect, Genome, GenomeHash, Start, Variation};
use brood_protocol::{LineageId, ParentRef};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection};

use super::{age, child, execute, lineage, new_generation, open, open_directory};
use crate::sql::query;
use crate::{NewGenome, NewIndividual, Store, StoredGenome};

fn random(slot: u32) -> Genome {
    let variation = Variation::random(Dialect::default()).with_start(Start::Wild);
    variation.birth(BirthKey { seed: 5, slot, attempt: 0 })
}

fn mutant(parent: &Genome, slot: u32) -> Genome {
    Variation::mutate(parent, 0.3).birth(BirthKey { seed: 6, slot, attempt: 0 })
}

fn individual(slot: u32, genome: &Genome) -> NewIndividual {
    let mut new = child(slot, "replaced");
    let (hash, bytes) = (genome.hash(), genome.canonical_bytes());
    let program_hash = *hash.as_bytes();
    new.genome =
        Arc::new(NewGenome { hash, bytes, program_hash, live_instructions: 9, layers: Vec::new() });
    new
}

/// Stores a generation with these children of parents given by hash.
async fn birth(store: &Store, lineage: LineageId, parents: &[&Genome], children: &[Genome]) {
    let parents: Vec<_> = parents.iter().map(|one| ParentRef::Genome(one.hash())).collect();
    let mut new = new_generation(lineage, &parents, "unused");
    new.individuals = (0..).zip(children).map(|(slot, one)| individual(slot, one)).collect();
    store.create_generation(new).await.unwrap();
}

/// Number of bases and packed size of a genome; `None` if it is not packed.
async fn packed(store: &Store, genome: &Genome) -> Option<(usize, usize)> {
    let sql = "SELECT CAST(octet_length(bases) / 32 AS BIGINT), CAST(octet_length(bytes) AS BIGINT)
               FROM genome WHERE hash = ?";
    let hash = genome.hash().as_bytes().to_vec();
    let mut conn = store.reader().await.unwrap();
    let row = query(sql).bind(hash).fetch_one(&mut conn).await.unwrap();
    let bases: Option<u32> = row.column(0).unwrap();
    let size: u32 = row.column(1).unwrap();
    bases.map(|bases| (bases as usize, size as usize))
}

async fn assert_whole(store: &Store, genomes: &[&Genome]) {
    let hashes: Vec<GenomeHash> = genomes.iter().map(|one| one.hash()).collect();
    let found = store.genomes(&hashes).await.unwrap();
    for genome in genomes {
        assert_eq!(found[&genome.hash()], StoredGenome::Bytes(genome.canonical_bytes()));
    }
    assert_eq!(store.check(|_| {}).await.unwrap().problems, Vec::<String>::new());
}

#[tokio::test]
async fn children_are_packed_against_their_parents_and_parents_against_none() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let roots = [0, 1].map(random);
    birth(&store, lineage, &[], &roots).await;
    let children = [0, 1, 2].map(|slot| mutant(&roots[0], slot));
    birth(&store, lineage, &[&roots[0], &roots[1]], &children).await;
    for child in &children {
        let (bases, bytes) = packed(&store, child).await.unwrap();
        assert!(bases == 2 && bytes < 400, "{bases} bases, {bytes} bytes");
    }
    // Two children are not worth packing their parent anew, three are.
    let few = [0, 1].map(|slot| mutant(&children[0], slot));
    birth(&store, lineage, &[&children[0]], &few).await;
    assert_eq!(packed(&store, &children[0]).await.unwrap().0, 2);
    assert_eq!(packed(&store, &few[0]).await.unwrap().0, 0);
    let brood = [2, 3, 4].map(|slot| mutant(&children[0], slot));
    birth(&store, lineage, &[&children[0]], &brood).await;
    assert_eq!(packed(&store, &children[0]).await.unwrap().0, 0);
    assert_eq!(packed(&store, &brood[0]).await.unwrap().0, 1);
    assert_whole(&store, &[&roots[0], &children[0], &children[2], &few[1], &brood[2]]).await;
}

#[tokio::test]
async fn genomes_that_survive_a_purge_are_packed_without_the_removed_ones() {
    let (_dir, store) = open().await;
    let (old, young) = (lineage(&store).await, lineage(&store).await);
    let root = random(0);
    birth(&store, old, &[], std::slice::from_ref(&root)).await;
    let children = [0, 1, 2].map(|slot| mutant(&root, slot));
    birth(&store, old, &[&root], &children).await;
    birth(&store, young, &[], &children[..1]).await;
    assert_eq!(packed(&store, &children[0]).await.unwrap().0, 1);
    store.purge_lineage(old).await.unwrap();
    assert_eq!(store.counts().await.unwrap().genomes, 1);
    assert_eq!(packed(&store, &children[0]).await.unwrap().0, 0);
    assert_whole(&store, &[&children[0]]).await;
}

#[tokio::test]
async fn purge_of_a_long_lineage_takes_many_transactions_and_leaves_nothing() {
    let (_dir, store) = open().await;
    let (long, other) = (lineage(&store).await, lineage(&store).await);
    let mut parent = random(0);
    birth(&store, long, &[], std::slice::from_ref(&parent)).await;
    birth(&store, other, &[], &[random(1)]).await;
    for _ in 0..60 {
        let children = [0, 1, 2].map(|slot| mutant(&parent, slot));
        birth(&store, long, &[&parent], &children).await;
        let [first, ..] = children;
        parent = first;
    }
    store.purge_lineage(long).await.unwrap();
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.lineages, counts.generations, counts.genomes), (1, 1, 1));
    assert_whole(&store, &[&random(1)]).await;
}

#[tokio::test]
async fn compaction_packs_what_earlier_versions_stored() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let (root, text) = (random(0), random(1));
    birth(&store, lineage, &[], &[root.clone(), text.clone()]).await;
    let children = [0, 1, 2, 3].map(|slot| mutant(&root, slot));
    birth(&store, lineage, &[&root], &children).await;
    let grandchildren = [0, 1, 2].map(|slot| mutant(&children[3], slot));
    birth(&store, lineage, &[&children[3]], &grandchildren).await;
    let all: Vec<_> = [&root, &text].into_iter().chain(&children).chain(&grandchildren).collect();
    let hashes: Vec<_> = all.iter().map(|one| one.hash()).collect();
    age(&store, &hashes).await;
    let (words, hash) = (text.to_string(), text.hash().as_bytes().to_vec());
    let first_version = store.write(move |conn| {
        Box::pin(async move {
            let sql = "UPDATE genome SET bytes = NULL, text = ? WHERE hash = ?";
            query(sql).bind(words).bind(hash).execute(conn).await?;
            Ok(())
        })
    });
    first_version.await.unwrap();
    store.close().await.unwrap();

    let done = Store::compact(dir.path(), |_| {}).await.unwrap();
    assert_eq!(done.genomes, 9);
    assert!(done.bytes_after < done.bytes_before, "{done:?}");
    let store = Store::open(dir.path()).await.unwrap();
    assert_whole(&store, &all).await;
    for (genome, bases) in [(&root, 0), (&text, 0), (&children[0], 1), (&children[3], 0)] {
        assert_eq!(packed(&store, genome).await.unwrap().0, bases);
    }
    assert_eq!(packed(&store, &grandchildren[1]).await.unwrap().0, 1);
    let found = store.list_generations(lineage, None, 9).await.unwrap();
    assert!(found.iter().flat_map(|one| &one.individuals).all(|one| one.layers.is_empty()));
    store.close().await.unwrap();
    assert_eq!(Store::compact(dir.path(), |_| {}).await.unwrap().genomes, 0);
}

#[tokio::test]
async fn check_finds_damaged_genomes_and_missing_rows() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let root = random(0);
    birth(&store, lineage, &[], std::slice::from_ref(&root)).await;
    let children = [0, 1, 2].map(|slot| mutant(&root, slot));
    birth(&store, lineage, &[&root], &children).await;
    assert_whole(&store, &[&root, &children[1]]).await;
    execute(&store, "UPDATE genome SET bytes = x'00' WHERE length(bases) = 0").await;
    let error = store.genome(children[1].hash()).await.unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("the database is damaged: genome {} is damaged", root.hash())
    );
    let checked = store.check(|_| {}).await.unwrap();
    assert_eq!((checked.genomes, checked.problems.len()), (4, 4));
    store.close().await.unwrap();

    let file = SqliteConnectOptions::new().filename(dir.path().join("brood.db"));
    let mut conn = file.foreign_keys(false).connect().await.unwrap();
    let unknown = "UPDATE individual SET genome_hash = zeroblob(32) WHERE slot = 2";
    sqlx::query(unknown).execute(&mut conn).await.unwrap();
    conn.close().await.unwrap();
    let store = Store::open(dir.path()).await.unwrap();
    let problems = store.check(|_| {}).await.unwrap().problems;
    assert_eq!(problems[0], "1 rows of individual refer to a missing row of genome");
}
