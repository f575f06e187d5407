//! Tests of records identified by content: genomes, scenes, meshes, picture keys.

use std::collections::HashMap;

use brood_protocol::{Backend, MeshId, PictureFormat};

use super::{execute, genome, hash, key, open, picture, read_back, saved, scene};
use crate::{NewPicture, StorageError, StoredGenome, StoredMesh};

#[tokio::test]
async fn genome_is_stored_once() {
    let (_dir, store) = open().await;
    for _ in 0..2 {
        store.put_genome(saved("a", "p")).await.unwrap();
    }
    store.put_genome(saved("b", "p")).await.unwrap();
    assert_eq!(store.counts().await.unwrap().genomes, 2);
    assert_eq!(store.genome(genome("a")).await.unwrap(), read_back("a"));
    let missing = store.genome(genome("c")).await;
    assert!(matches!(missing, Err(StorageError::NotFound)), "{missing:?}");
    let found = store.genomes(&[genome("b"), genome("c"), genome("a")]).await.unwrap();
    let both = [(genome("a"), read_back("a")), (genome("b"), read_back("b"))];
    assert_eq!(found, HashMap::from(both));
    assert!(store.genomes(&[]).await.unwrap().is_empty());
}

#[tokio::test]
async fn genome_is_returned_as_text_when_stored_by_first_version() {
    let (_dir, store) = open().await;
    store.put_genome(saved("a", "p")).await.unwrap();
    execute(&store, "UPDATE genome SET text = 'brood 1', bytes = NULL, bases = NULL").await;
    let old = StoredGenome::Text("brood 1".to_owned());
    assert_eq!(store.genome(genome("a")).await.unwrap(), old);
    // Storing the genome again does not change the row.
    store.put_genome(saved("a", "p")).await.unwrap();
    assert_eq!(store.genomes(&[genome("a")]).await.unwrap()[&genome("a")], old);
}

#[tokio::test]
async fn scene_keeps_its_id_when_stored_again() {
    let (_dir, store) = open().await;
    let first = store.put_scene("{\"a\":1}", hash("1"), &[], 1).await.unwrap();
    let other = store.put_scene("{\"a\":2}", hash("2"), &[], 2).await.unwrap();
    assert_eq!(store.put_scene("{\"a\":1}", hash("1"), &[], 3).await.unwrap(), first);
    assert_ne!(first, other);
    assert_eq!(store.scene(other).await.unwrap(), "{\"a\":2}");
}

#[tokio::test]
async fn mesh_keeps_its_id_when_stored_again() {
    let (_dir, store) = open().await;
    let new = StoredMesh {
        id: MeshId::fresh(),
        content_hash: hash("cow"),
        vertices: 3,
        triangles: 1,
        has_uv: true,
        warnings_json: "[]".to_owned(),
    };
    let data = vec![7; 100_000];
    let id = store.put_mesh(new.clone(), data.clone()).await.unwrap();
    assert_eq!(id, new.id);
    let again = StoredMesh { id: MeshId::fresh(), ..new.clone() };
    assert_eq!(store.put_mesh(again, data.clone()).await.unwrap(), id);
    assert_eq!(store.mesh(id).await.unwrap(), new);
    assert_eq!(store.mesh_data(hash("cow")).await.unwrap(), data);
    assert!(matches!(store.mesh(MeshId::fresh()).await, Err(StorageError::NotFound)));
    assert!(matches!(store.mesh_data(hash("pig")).await, Err(StorageError::NotFound)));
}

#[tokio::test]
async fn picture_key_is_unchanged_when_stored_again() {
    let (_dir, store) = open().await;
    let scene = scene(&store).await;
    store.put_genome(saved("a", "p")).await.unwrap();
    let mut first = picture("1", "a", scene);
    first.format = PictureFormat::Exr;
    first.backend = Backend::Reference;
    store.put_pictures(vec![first.clone()]).await.unwrap();
    let mut changed = first.clone();
    changed.size_px = 999.into();
    store.put_pictures(vec![changed, picture("2", "a", scene)]).await.unwrap();
    assert_eq!(store.picture(key("1")).await.unwrap(), first);
    assert_eq!(store.picture(key("2")).await.unwrap(), picture("2", "a", scene));
    assert!(matches!(store.picture(key("3")).await, Err(StorageError::NotFound)));
    for (name, size_px) in [("wide", "640x360"), ("tall", "360x640")] {
        let shaped = NewPicture { size_px: size_px.parse().unwrap(), ..picture(name, "a", scene) };
        store.put_pictures(vec![shaped.clone()]).await.unwrap();
        assert_eq!(store.picture(key(name)).await.unwrap(), shaped);
    }
    let unknown = store.put_pictures(vec![picture("3", "missing", scene)]).await;
    assert!(matches!(unknown, Err(StorageError::NotFound)), "{unknown:?}");
}
