//! Tests of lineages, generations and individuals.

use std::sync::Arc;

use brood_genome::ModelKind;
use brood_protocol::{
    GenerationId, IndividualId, Lineage, LineageId, ParentRef, PatchIndividual, PatchLineage,
    SceneId,
};

use super::*;
use crate::lineage::Unfinished;
use crate::write::operation;
use crate::{LineageCursor, LineageFilter, NewImport, StorageError, StoredOutline};

#[tokio::test]
async fn lineage_is_read_back_as_written() {
    let (_dir, store) = open().await;
    let new = new_lineage("'; DROP TABLE lineage; --", scene(&store).await, 5);
    let made = store.create_lineage(new.clone(), None).await.unwrap();
    assert_eq!((made.id, made.name, made.notes), (new.id, new.name.clone(), new.notes.clone()));
    assert_eq!(
        (made.scene, made.dialect, made.saturation, made.energy_limit),
        (new.scene, new.dialect, 0.1, true)
    );
    assert_eq!((made.thumbnail_px, made.created_ms), (256, 5));
    assert_eq!((made.generations, made.version), (0, 1));
    generation(&store, new.id, &[], "g").await;
    assert_eq!(store.lineage(new.id).await.unwrap().generations, 1);

    let taken = store.create_lineage(new, None).await;
    assert!(matches!(taken, Err(StorageError::Conflict { .. })), "{taken:?}");
    let nowhere = store.create_lineage(new_lineage("x", SceneId::fresh(), 5), None).await;
    assert!(matches!(nowhere, Err(StorageError::NotFound)), "{nowhere:?}");
    assert!(matches!(store.lineage(LineageId::fresh()).await, Err(StorageError::NotFound)));
}

#[tokio::test]
async fn lineage_is_unchanged_when_version_is_stale() {
    let (_dir, store) = open().await;
    let id = lineage(&store).await;
    let patch = PatchLineage { name: Some("second".to_owned()), ..PatchLineage::default() };
    let changed = store.patch_lineage(id, 1, patch.clone()).await.unwrap();
    assert_eq!((changed.name.as_str(), changed.notes.as_str()), ("second", "seen at dusk"));
    assert_eq!(changed.version, 2);
    let patch = PatchLineage { name: Some("third".to_owned()), ..patch };
    let stale = store.patch_lineage(id, 1, patch.clone()).await;
    assert!(matches!(stale, Err(StorageError::StaleVersion { current: 2 })), "{stale:?}");
    assert_eq!(store.lineage(id).await.unwrap(), changed);
    let missing = store.patch_lineage(LineageId::fresh(), 1, patch).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
    let patch = PatchLineage { scene: Some(SceneId::fresh()), ..PatchLineage::default() };
    let nowhere = store.patch_lineage(id, 2, patch).await;
    assert!(matches!(nowhere, Err(StorageError::NotFound)), "{nowhere:?}");
}

#[tokio::test]
async fn lineages_are_paged_without_gaps_when_created_in_same_millisecond() {
    let (_dir, store) = open().await;
    let scene = scene(&store).await;
    let mut ids = Vec::new();
    for created_ms in [7, 7, 7, 7, 3, 7, 9] {
        let new = new_lineage("l", scene, created_ms);
        ids.push((created_ms, new.id));
        store.create_lineage(new, None).await.unwrap();
    }
    let hidden = ids.remove(2).1;
    store.hide_lineage(hidden).await.unwrap();
    ids.sort_unstable();
    ids.reverse();
    let mut seen = Vec::new();
    let mut cursor = None;
    let visible = LineageFilter::new(Some(false), "");
    loop {
        let page = store.list_lineages(cursor, 2, &visible).await.unwrap();
        let Some(last) = page.last() else { break };
        cursor = Some(LineageCursor::of(last));
        seen.extend(page.iter().map(|one| (one.created_ms, one.id)));
    }
    assert_eq!(seen, ids);
    assert_eq!(store.list_lineages(None, 50, &LineageFilter::default()).await.unwrap().len(), 7);
    assert_eq!(store.lineage(hidden).await.unwrap().id, hidden);
}

#[tokio::test]
async fn list_continues_when_lineage_of_cursor_is_purged() {
    let (_dir, store) = open().await;
    let scene = scene(&store).await;
    let mut places = Vec::new();
    for created_ms in [1, 2, 2, 3] {
        let made = store.create_lineage(new_lineage("l", scene, created_ms), None).await.unwrap();
        places.push(LineageCursor::of(&made));
    }
    places.sort_by_key(|place| std::cmp::Reverse((place.created_ms, place.id)));
    store.purge_lineage(places[1].id).await.unwrap();
    let cursor = places[1].to_string().parse().unwrap();
    let rest = store.list_lineages(Some(cursor), 9, &LineageFilter::default()).await.unwrap();
    let rest: Vec<_> = rest.iter().map(LineageCursor::of).collect();
    assert_eq!(rest, places[2..]);
    for text in ["", "5", "5.", ".5", "x.y", &places[1].id.to_string()] {
        assert!(text.parse::<LineageCursor>().is_err(), "{text}");
    }
}

#[tokio::test]
async fn generation_is_read_back_as_written() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let first = generation(&store, lineage, &[], "a").await;
    assert_eq!((first.index, first.centre.as_ref()), (0, None));
    let parents =
        [ParentRef::Individual(first.individuals[1].id), ParentRef::Genome(genome("a 2"))];
    let mut new = new_generation(lineage, &parents, "b");
    new.centre = Some(first.individuals[1].id);
    new.individuals.reverse();
    new.pictures = vec![picture("b0", "b 0", scene(&store).await)];
    let made = store.create_generation(new.clone()).await.unwrap();
    assert_eq!((made.index, made.seed, made.parents.as_slice()), (1, new.seed, parents.as_slice()));
    assert_eq!(made.centre.as_ref(), Some(&first.individuals[1]));
    assert_eq!(made.options, new.options);
    assert_eq!(made.individuals.iter().map(|one| one.slot).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(made.individuals[0].program_hash, hash("program of b 0"));
    assert_eq!(made.individuals[0].parents, parents);
    assert_eq!(store.generation(new.id).await.unwrap(), made);
    assert_eq!(store.individual(made.individuals[2].id).await.unwrap(), made.individuals[2]);
    assert_eq!(store.picture(key("b0")).await.unwrap(), new.pictures[0]);
    assert!(matches!(store.generation(GenerationId::fresh()).await, Err(StorageError::NotFound)));
}

#[tokio::test]
async fn generation_is_rolled_back_when_part_is_rejected() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let parent = ParentRef::Individual(IndividualId::fresh());
    let mut orphans = vec![new_generation(LineageId::fresh(), &[], "x")];
    orphans.push(new_generation(lineage, &[parent], "x"));
    orphans.push(new_generation(lineage, &[], "x"));
    orphans[2].centre = Some(IndividualId::fresh());
    orphans.push(new_generation(lineage, &[], "x"));
    orphans[3].pictures = vec![picture("p", "missing", scene(&store).await)];
    for orphan in orphans {
        let refused = store.create_generation(orphan).await;
        assert!(matches!(refused, Err(StorageError::NotFound)), "{refused:?}");
    }
    let mut doubled = new_generation(lineage, &[], "x");
    doubled.individuals[1].slot = 0;
    let refused = store.create_generation(doubled).await;
    assert!(matches!(refused, Err(StorageError::Conflict { .. })), "{refused:?}");
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.generations, counts.individuals, counts.genomes), (0, 0, 0));
    assert_eq!(counts.pictures, 0);
}

#[tokio::test]
async fn generations_are_listed_oldest_first() {
    let (_dir, store) = open().await;
    let (one, two) = (lineage(&store).await, lineage(&store).await);
    let mut made = Vec::new();
    for n in 0..5 {
        made.push(generation(&store, one, &[], &format!("g{n}")).await);
    }
    generation(&store, two, &[], "other").await;
    assert_eq!(store.list_generations(one, None, 50).await.unwrap(), made);
    assert_eq!(store.list_generations(one, Some(1), 2).await.unwrap(), made[2..4]);
    assert!(store.list_generations(one, Some(4), 2).await.unwrap().is_empty());
    let missing = store.list_generations(LineageId::fresh(), None, 2).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
}

#[tokio::test]
async fn individuals_are_returned_in_requested_order() {
    let (_dir, store) = open().await;
    let made = generation(&store, lineage(&store).await, &[], "a").await.individuals;
    let ids = [made[2].id, made[0].id, made[2].id];
    let found = store.individuals(&ids).await.unwrap();
    assert_eq!(found, [made[2].clone(), made[0].clone(), made[2].clone()]);
    let unknown = store.individuals(&[made[0].id, IndividualId::fresh()]).await;
    assert!(matches!(unknown, Err(StorageError::NotFound)), "{unknown:?}");
}

#[tokio::test]
async fn favourites_are_paged_youngest_first_without_hidden_lineages() {
    let (_dir, store) = open().await;
    let (shown, hidden) = (lineage(&store).await, lineage(&store).await);
    let mark = PatchIndividual { favourite: Some(true), note: None };
    let mut marked = Vec::new();
    for (lineage, name) in [(shown, "a"), (hidden, "b"), (shown, "c")] {
        for one in generation(&store, lineage, &[], name).await.individuals {
            let one = store.patch_individual(one.id, 1, mark.clone()).await.unwrap();
            assert!(one.favourite && one.version == 2, "{one:?}");
            marked.extend((lineage == shown).then_some(one));
        }
    }
    store.hide_lineage(hidden).await.unwrap();
    let note = PatchIndividual { favourite: Some(false), note: Some("dull".to_owned()) };
    let stale = store.patch_individual(marked[0].id, 1, note.clone()).await;
    assert!(matches!(stale, Err(StorageError::StaleVersion { current: 2 })), "{stale:?}");
    let unmarked = store.patch_individual(marked[0].id, 2, note).await.unwrap();
    assert_eq!((unmarked.favourite, unmarked.note.as_str()), (false, "dull"));
    marked.remove(0);
    marked.reverse();
    let first = store.favourites(None, 3, None).await.unwrap();
    let rest = store.favourites(Some(first[2].id), 3, None).await.unwrap();
    assert_eq!([first, rest].concat(), marked);
    let of_one = store.favourites(None, 9, Some(hidden)).await.unwrap();
    assert!(of_one.len() == 3 && of_one.iter().all(|one| one.lineage == hidden), "{of_one:?}");
    assert_eq!(store.lineage(hidden).await.unwrap().favourites, 3);
}

#[tokio::test]
async fn lineages_are_found_by_words_of_name_notes_and_tags() {
    let (_dir, store) = open().await;
    let scene = scene(&store).await;
    let mut ids = Vec::new();
    for (number, name) in
        ["Étude in gold", "gold", "clay at 300 \u{212a}elvin"].into_iter().enumerate()
    {
        let new = new_lineage(name, scene, i64::try_from(number).unwrap());
        let new = Lineage { tags: vec![format!("Tag {number}")], ..new };
        ids.push(store.create_lineage(new, None).await.unwrap().id);
    }
    store.hide_lineage(ids[1]).await.unwrap();
    let rows: [(Option<bool>, &str, &[LineageId]); 8] = [
        (Some(false), "ÉTUDE", &[ids[0]]),
        (Some(false), "gold", &[ids[0]]),
        (None, " gold  étude ", &[ids[0]]),
        (Some(true), "", &[ids[1]]),
        (None, "tag 2", &[ids[2]]),
        (None, "DUSK", &[ids[2], ids[1], ids[0]]),
        (None, "gold clay", &[]),
        (None, "kelvin", &[ids[2]]),
    ];
    for (hidden, search, expected) in rows {
        let filter = LineageFilter::new(hidden, search);
        let found = store.list_lineages(None, 9, &filter).await.unwrap();
        let found: Vec<_> = found.iter().map(|one| one.id).collect();
        assert_eq!(found, expected, "{search}");
    }
    let filter = LineageFilter::new(None, "dusk");
    let first = store.list_lineages(None, 1, &filter).await.unwrap();
    let rest = store.list_lineages(Some(LineageCursor::of(&first[0])), 9, &filter).await.unwrap();
    assert_eq!(rest.len(), 2);
}

#[tokio::test]
async fn cover_is_the_chosen_individual_until_it_is_cleared() {
    let (_dir, store) = open().await;
    let id = lineage(&store).await;
    let born = generation(&store, id, &[], "a").await.individuals;
    let mark = PatchIndividual { favourite: Some(true), note: None };
    store.patch_individual(born[1].id, 1, mark).await.unwrap();
    let choose = |cover| PatchLineage { cover_individual: Some(cover), ..PatchLineage::default() };
    for (version, chosen, expected) in [(1, Some(born[2].id), 2), (2, None, 1)] {
        let changed = store.patch_lineage(id, version, choose(chosen)).await.unwrap();
        assert_eq!(changed.cover_individual, chosen);
        assert_eq!(store.covers(&[id]).await.unwrap()[&id].id, born[expected].id);
    }
    store.patch_lineage(id, 3, choose(Some(born[0].id))).await.unwrap();
    store.purge_lineage(id).await.unwrap();
}

#[tokio::test]
async fn import_is_all_or_nothing() {
    let (_dir, store) = open().await;
    let lineage = new_lineage("brought", scene(&store).await, 8);
    let first = new_generation(lineage.id, &[], "a");
    let parent = first.individuals[0].id;
    let second = new_generation(lineage.id, &[ParentRef::Individual(parent)], "b");
    let mark = PatchIndividual { favourite: Some(true), note: None };
    let mut import = NewImport {
        cover: None,
        lineage,
        genomes: std::collections::HashMap::new(),
        generations: vec![first, second],
        marks: vec![(IndividualId::fresh(), mark.clone())],
        idempotency: Some(idempotency("k")),
    };
    let refused = store.import_lineage(import.clone()).await;
    assert!(matches!(refused, Err(StorageError::NotFound)), "{refused:?}");
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.lineages, counts.genomes, counts.idempotency), (0, 0, 0));
    import.marks = vec![(parent, mark)];
    let made = store.import_lineage(import).await.unwrap();
    assert_eq!((made.generations, made.name.as_str()), (2, "brought"));
    assert_eq!(store.favourites(None, 5, None).await.unwrap()[0].id, parent);
}

#[tokio::test]
async fn layers_are_read_from_column_or_decoded_from_genome() {
    const PLASTIC: &str = "brood 1\n.model lambert\n.model cook-torrance\n";
    let (_dir, store) = open().await;
    let id = lineage(&store).await;
    let parsed: brood_genome::Genome = PLASTIC.parse().unwrap();
    let mut new = new_generation(id, &[], "g");
    let plastic = Arc::make_mut(&mut new.individuals[1].genome);
    (plastic.hash, plastic.bytes) = (parsed.hash(), parsed.canonical_bytes());
    plastic.layers = vec![ModelKind::Lambert, ModelKind::CookTorrance];
    Arc::make_mut(&mut new.individuals[2].genome).layers = Vec::new();
    let ids: Vec<_> = new.individuals.iter().map(|child| child.id).collect();
    let made = store.create_generation(new).await.unwrap();
    let layer_names = |found: &[crate::StoredIndividual]| -> Vec<String> {
        let names =
            |layers: &[ModelKind]| -> Vec<&str> { layers.iter().map(|kind| kind.name()).collect() };
        found.iter().map(|one| names(&one.layers).join(" ")).collect()
    };
    let found = store.individuals(&ids).await.unwrap();
    assert_eq!(layer_names(&found), ["lambert", "lambert cook-torrance", ""]);
    assert_eq!(made.individuals, found);

    // Rows of earlier versions have no layers: bytes, or the text of the first version.
    age(&store, &[parsed.hash()]).await;
    let text =
        "UPDATE genome SET layers = NULL, bytes = NULL, bases = NULL WHERE layers IS NOT NULL";
    execute(&store, text).await;
    let found = store.individuals(&ids).await.unwrap();
    assert_eq!(layer_names(&found), ["", "lambert cook-torrance", ""]);
}

#[tokio::test]
async fn outlines_have_the_centre_favourites_and_where_the_first_parent_was_born() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let first = generation(&store, lineage, &[], "a").await;
    let parent = ParentRef::Individual(first.individuals[1].id);
    let mut new = new_generation(lineage, &[parent], "b");
    new.centre = Some(first.individuals[1].id);
    let second = store.create_generation(new).await.unwrap();
    let third = generation(&store, lineage, &[ParentRef::Genome(genome("b 2"))], "c").await;
    let mut new = new_generation(lineage, &[], "d");
    new.individuals.iter_mut().for_each(|one| one.operator = "adopt");
    store.create_generation(new).await.unwrap();
    let other = super::lineage(&store).await;
    let foreign = generation(&store, other, &[parent], "e").await;
    let mark = PatchIndividual { favourite: Some(true), note: None };
    store.patch_individual(second.individuals[2].id, 1, mark).await.unwrap();

    let outlines = store.list_outlines(lineage, None, 9).await.unwrap();
    let kept = |one: &StoredOutline| one.individuals.iter().map(|one| one.slot).collect::<Vec<_>>();
    assert_eq!(outlines.iter().map(|one| one.index).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert_eq!(
        outlines.iter().map(kept).collect::<Vec<_>>(),
        [vec![0], vec![2], vec![0], vec![0, 1, 2]]
    );
    let from = [None, Some(first.id), Some(second.id), None];
    assert_eq!(outlines.iter().map(|one| one.from).collect::<Vec<_>>(), from);
    assert_eq!(outlines[1].centre.as_ref().unwrap().id, first.individuals[1].id);
    assert_eq!(outlines[2].individuals, third.individuals[..1]);
    assert_eq!(store.list_outlines(lineage, Some(0), 2).await.unwrap(), outlines[1..3]);
    let elsewhere = store.list_outlines(other, None, 9).await.unwrap();
    assert_eq!((elsewhere[0].id, elsewhere[0].from), (foreign.id, None));
    let missing = store.list_outlines(LineageId::fresh(), None, 2).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
}

#[tokio::test]
async fn pages_of_generations_end_before_there_are_too_many_individuals() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    for name in ["a", "b", "c", "d"] {
        generation(&store, lineage, &[], name).await;
    }
    for (after, limit, individuals, expected) in [
        (None, 9, 100, 4),
        (None, 2, 100, 2),
        (None, 9, 6, 2),
        (Some(1), 9, 100, 2),
        (None, 9, 1, 1),
    ] {
        let within = store.generations_within(lineage, after, limit, individuals).await.unwrap();
        assert_eq!(within, expected, "{after:?} {limit} {individuals}");
    }
}

/// A lineage with `count` generations of three individuals.
fn new_import(scene: SceneId, count: i64) -> NewImport {
    let lineage = new_lineage("brought", scene, 8);
    let generations = (0..count).map(|n| new_generation(lineage.id, &[], &format!("{n}")));
    let generations = generations.collect();
    let genomes = std::collections::HashMap::new();
    NewImport { lineage, genomes, generations, marks: vec![], cover: None, idempotency: None }
}

/// Returns the lineages that are being imported or removed.
async fn unfinished(store: &Store) -> Vec<LineageId> {
    let rows = query("SELECT lineage_id FROM unfinished_lineage");
    let rows = rows.fetch_all(&mut store.reader().await.unwrap()).await.unwrap();
    rows.iter().map(|row| row.column("lineage_id").unwrap()).collect()
}

#[tokio::test]
async fn other_writes_pass_an_import_that_lists_leave_out_until_it_is_finished() {
    let (_dir, store) = open().await;
    let own = lineage(&store).await;
    let import = new_import(scene(&store).await, 4000);
    let id = import.lineage.id;
    let importing = tokio::spawn({
        let store = store.clone();
        async move { store.import_lineage(import).await }
    });
    let mut born = 0;
    while !importing.is_finished() {
        generation(&store, own, &[], &format!("own {born}")).await;
        born += 1;
        let listed = store.list_lineages(None, 9, &LineageFilter::default()).await.unwrap();
        if unfinished(&store).await == [id] {
            assert_eq!(listed.iter().map(|one| one.id).collect::<Vec<_>>(), [own]);
        }
    }
    assert_eq!(importing.await.unwrap().unwrap().generations, 4000);
    assert!(born > 5, "{born} generations were born during the import");
    assert_eq!(store.list_lineages(None, 9, &LineageFilter::default()).await.unwrap().len(), 2);
    assert_eq!(unfinished(&store).await, []);
}

#[tokio::test]
async fn unfinished_lineage_of_the_last_process_is_found_and_removed() {
    let (place, store) = open().await;
    let kept = generation(&store, lineage(&store).await, &[], "kept").await;
    let made = store.import_lineage(new_import(scene(&store).await, 9)).await.unwrap();
    let insert = "INSERT INTO unfinished_lineage (lineage_id, until_ms)
        SELECT id, 9000000000000 FROM lineage WHERE name = 'brought'";
    execute(&store, insert).await;
    store.close().await.unwrap();
    let store = place.open().await;
    assert_eq!(store.take_unfinished_lineages(false).await.unwrap(), [], "a server imports it");
    if let Place::Schema(..) = place {
        assert_eq!(store.take_unfinished_lineages(true).await.unwrap(), [], "another one does");
        execute(&store, "UPDATE unfinished_lineage SET until_ms = 1").await;
    }
    assert_eq!(store.take_unfinished_lineages(true).await.unwrap(), [made.id]);
    assert_eq!(store.take_unfinished_lineages(false).await.unwrap(), [], "this one removes it");
    let id = made.id;
    let import = store.write(operation!(|conn| {
        crate::lineage::renew_unfinished(conn, id, Unfinished::Import).await
    }));
    let import = import.await;
    assert!(matches!(import, Err(StorageError::Conflict { .. })), "{import:?}");
    store.remove_lineage(made.id).await.unwrap();
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.lineages, counts.individuals, counts.genomes), (1, 3, 3));
    assert_eq!(store.generation(kept.id).await.unwrap(), kept);
    assert_eq!(unfinished(&store).await, []);
}
