//! Tests of ancestors and descendants.

use brood_protocol::{IndividualId, ParentRef};

use super::{generation, genome, lineage, open};
use crate::StorageError;

#[tokio::test]
async fn ancestors_are_returned_once_and_nearest_first() {
    let (_dir, store) = open().await;
    let (one, two) = (lineage(&store).await, lineage(&store).await);
    let root = generation(&store, one, &[], "root").await.individuals;
    let left = generation(&store, one, &[ParentRef::Individual(root[0].id)], "left").await;
    // A grandparent bred with its own child, in another lineage.
    let both = [left.individuals[1].id, root[0].id].map(ParentRef::Individual);
    let back = generation(&store, two, &both, "back").await.individuals;
    let last = generation(&store, two, &[ParentRef::Individual(back[2].id)], "last").await;
    let id = last.individuals[0].id;

    let ids = async |depth| {
        let found = store.ancestry(id, depth).await.unwrap();
        found.into_iter().map(|one| one.id).collect::<Vec<_>>()
    };
    let all = [back[2].id, left.individuals[1].id, root[0].id];
    assert_eq!(ids(99).await, all);
    assert_eq!(ids(2).await, all);
    assert_eq!(ids(1).await, all[..1]);
    assert!(ids(0).await.is_empty());
    assert!(store.ancestry(root[1].id, 9).await.unwrap().is_empty());
    let missing = store.ancestry(IndividualId::fresh(), 9).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
}

#[tokio::test]
async fn ancestors_are_complete_when_generations_are_inbred() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let mut line = vec![generation(&store, lineage, &[], "0").await.individuals[0].id];
    for n in 1..40 {
        let newest = &line[line.len().saturating_sub(2)..];
        let parents: Vec<_> = newest.iter().copied().map(ParentRef::Individual).collect();
        line.push(generation(&store, lineage, &parents, &n.to_string()).await.individuals[0].id);
    }
    let found = store.ancestry(line.pop().unwrap(), 1000).await.unwrap();
    let mut found: Vec<_> = found.into_iter().map(|one| one.id).collect();
    found.sort_unstable();
    assert_eq!(found, line);
}

#[tokio::test]
async fn descendants_are_paged_across_lineages() {
    let (_dir, store) = open().await;
    let (one, two) = (lineage(&store).await, lineage(&store).await);
    let root = generation(&store, one, &[], "root").await.individuals;
    let mother = [ParentRef::Individual(root[0].id)];
    let mut expected = generation(&store, one, &mother, "child").await.individuals;
    let both = [expected[0].id, expected[1].id].map(ParentRef::Individual);
    expected.extend(generation(&store, two, &both, "grandchild").await.individuals);
    // Children of a parent given by hash are not descendants of an individual.
    generation(&store, two, &[ParentRef::Genome(genome("root 0"))], "stranger").await;

    let first = store.descendants(root[0].id, None, 4).await.unwrap();
    let rest = store.descendants(root[0].id, Some(first[3].id), 4).await.unwrap();
    assert_eq!([first, rest].concat(), expected);
    assert!(store.descendants(root[1].id, None, 4).await.unwrap().is_empty());
    let missing = store.descendants(IndividualId::fresh(), None, 9).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
}
