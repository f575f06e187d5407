//! Tests of purging lineages.

use std::sync::Arc;

use brood_protocol::{GenerationId, LineageId, ParentRef};

use super::{
    child, generation, genome, hash, key, lineage, new_generation, open, picture, read_back, saved,
    scene,
};
use crate::StorageError;

#[tokio::test]
async fn purge_removes_everything_when_nothing_is_shared() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let first = generation(&store, lineage, &[], "a").await;
    let mother = first.individuals[0].id;
    let mut second = new_generation(lineage, &[ParentRef::Individual(mother)], "b");
    second.centre = Some(mother);
    second.pictures = vec![picture("p", "b 0", scene(&store).await)];
    store.create_generation(second).await.unwrap();
    store.purge_lineage(lineage).await.unwrap();
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.lineages, counts.generations, counts.individuals), (0, 0, 0));
    assert_eq!((counts.genomes, counts.pictures), (0, 0));
    let again = store.purge_lineage(lineage).await;
    assert!(matches!(again, Err(StorageError::NotFound)), "{again:?}");
}

#[tokio::test]
async fn purge_keeps_parent_hashes_of_children_in_other_lineages() {
    let (_dir, store) = open().await;
    let (old, young) = (lineage(&store).await, lineage(&store).await);
    let mother = generation(&store, old, &[], "a").await.individuals.remove(1);
    let mut new = new_generation(young, &[ParentRef::Individual(mother.id)], "b");
    new.centre = Some(mother.id);
    let id = new.id;
    store.create_generation(new).await.unwrap();
    store.purge_lineage(old).await.unwrap();
    let left = store.generation(id).await.unwrap();
    assert_eq!(left.centre, None);
    assert_eq!(left.parents, [ParentRef::Genome(genome("a 1"))]);
    assert_eq!(left.individuals[0].parents, left.parents);
    assert_eq!(store.genome(genome("a 1")).await.unwrap(), read_back("a 1"));
    assert_eq!(store.counts().await.unwrap().genomes, 4);
    assert!(store.ancestry(left.individuals[0].id, 9).await.unwrap().is_empty());
}

#[tokio::test]
async fn purge_keeps_genomes_when_shared_or_saved() {
    let (_dir, store) = open().await;
    let (old, young) = (lineage(&store).await, lineage(&store).await);
    let scene = scene(&store).await;
    generation(&store, old, &[], "a").await;
    // `a 0` is saved by hand, `a 1` was born elsewhere as well, `twin` has the program of `a 2`.
    store.put_genome(saved("a 0", "program of a 0")).await.unwrap();
    let mut new = new_generation(young, &[], "b");
    new.individuals = vec![child(0, "a 1"), child(1, "twin")];
    Arc::make_mut(&mut new.individuals[1].genome).program_hash = hash("program of a 2");
    store.create_generation(new).await.unwrap();
    let pictures = vec![picture("of a 2", "a 2", scene), picture("of a 1", "a 1", scene)];
    store.put_pictures(pictures).await.unwrap();

    store.purge_lineage(old).await.unwrap();
    let kept = store.genomes(&["a 0", "a 1", "a 2", "twin"].map(genome)).await.unwrap();
    assert_eq!(kept.len(), 3);
    assert!(!kept.contains_key(&genome("a 2")));
    assert_eq!(kept[&genome("a 0")], read_back("a 0"));
    assert_eq!(store.picture(key("of a 2")).await.unwrap().genome_hash, genome("twin"));
    assert_eq!(store.picture(key("of a 1")).await.unwrap().genome_hash, genome("a 1"));
}

#[tokio::test]
async fn hidden_lineage_can_still_be_purged() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    store.hide_lineage(lineage).await.unwrap();
    store.hide_lineage(lineage).await.unwrap();
    let new = new_generation(lineage, &[], "a");
    let id: GenerationId = store.create_generation(new).await.unwrap().id;
    store.purge_lineage(lineage).await.unwrap();
    assert!(matches!(store.generation(id).await, Err(StorageError::NotFound)));
    let missing = store.hide_lineage(LineageId::fresh()).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
}
