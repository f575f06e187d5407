//! Tests of tokens and idempotency records.

use brood_protocol::ParentRef;

use super::{genome, hash, idempotency, lineage, new_generation, new_lineage, open, scene};
use crate::{IdempotencyLookup, Scope, StorageError, Token};

#[tokio::test]
async fn token_is_found_by_hash_until_revoked() {
    let (_dir, store) = open().await;
    assert!(!store.any_token().await.unwrap());
    store.create_token("b", Scope::Work, hash("b"), Some(99)).await.unwrap();
    store.create_token("a", Scope::Admin, hash("a"), None).await.unwrap();
    let b = Token { name: "b".to_owned(), scope: Scope::Work, expires_ms: Some(99) };
    let a = Token { name: "a".to_owned(), scope: Scope::Admin, expires_ms: None };
    assert_eq!(store.token_by_hash(hash("b")).await.unwrap(), Some(b.clone()));
    assert_eq!(store.list_tokens().await.unwrap(), [a, b]);
    assert!(!store.revoke_token("b", 1).await.unwrap());
    assert_eq!(store.token_by_hash(hash("b")).await.unwrap(), None);
    assert!(store.any_token().await.unwrap());
    let gone = store.revoke_token("b", 1).await;
    assert!(matches!(gone, Err(StorageError::NotFound)), "{gone:?}");
}

#[tokio::test]
async fn access_stays_closed_when_the_last_token_is_revoked() {
    let (_dir, store) = open().await;
    assert!(!store.needs_token().await.unwrap());
    store.create_token("a", Scope::Admin, hash("a"), None).await.unwrap();
    assert!(store.needs_token().await.unwrap());
    let early = store.open_access().await;
    assert!(matches!(early, Err(StorageError::Conflict { .. })), "{early:?}");
    assert!(store.revoke_token("a", 1).await.unwrap());
    assert!(store.needs_token().await.unwrap() && !store.any_token().await.unwrap());
    store.open_access().await.unwrap();
    assert!(!store.needs_token().await.unwrap());
}

#[tokio::test]
async fn token_is_rejected_when_name_is_in_use() {
    let (_dir, store) = open().await;
    store.create_token("a", Scope::Read, hash("1"), None).await.unwrap();
    let second = store.create_token("a", Scope::Read, hash("2"), None).await;
    assert!(matches!(second, Err(StorageError::Conflict { .. })), "{second:?}");
}

#[test]
fn scope_allows_its_permissions_only() {
    use Scope::{Admin, Breed, Read, Work};
    let all = [Read, Breed, Work, Admin];
    let allowed =
        |scope: Scope| all.into_iter().filter(|needed| scope.allows(*needed)).collect::<Vec<_>>();
    assert_eq!(allowed(Read), [Read]);
    assert_eq!(allowed(Breed), [Read, Breed]);
    assert_eq!(allowed(Work), [Work]);
    assert_eq!(allowed(Admin), all);
    for scope in all {
        assert_eq!(scope.to_string().parse(), Ok(scope));
    }
}

#[tokio::test]
async fn response_is_replayed_when_key_route_and_body_are_equal() {
    let (_dir, store) = open().await;
    let answer = idempotency("k");
    let new = new_lineage("once", scene(&store).await, 5);
    let look = |key: &'static str, route: &'static str, body: &'static str| {
        let store = store.clone();
        async move { store.lookup_idempotent(key, route, hash(body)).await.unwrap() }
    };
    assert_eq!(look("k", "POST /v1/lineages", "body").await, IdempotencyLookup::Fresh);
    store.create_lineage(new.clone(), Some(answer.clone())).await.unwrap();
    let replay = IdempotencyLookup::Replay { status: 201, body: b"made".to_vec() };
    assert_eq!(look("k", "POST /v1/lineages", "body").await, replay);
    assert_eq!(look("k", "POST /v1/lineages", "other").await, IdempotencyLookup::OtherBody);
    assert_eq!(look("k", "POST /v1/scenes", "body").await, IdempotencyLookup::Fresh);

    // The second of two concurrent writes stores nothing.
    let again = new_lineage("twice", new.scene, 6);
    let lost = store.create_lineage(again, Some(answer)).await;
    assert!(
        matches!(
            lost,
            Err(StorageError::Conflict { what: "the idempotency key is already in use" })
        ),
        "{lost:?}"
    );
    assert_eq!(store.counts().await.unwrap().lineages, 1);

    assert_eq!(store.prune_idempotency(5).await.unwrap(), 0);
    assert_eq!(store.prune_idempotency(6).await.unwrap(), 1);
    assert_eq!(look("k", "POST /v1/lineages", "body").await, IdempotencyLookup::Fresh);
}

#[tokio::test]
async fn record_is_rolled_back_when_write_fails() {
    let (_dir, store) = open().await;
    let lineage = lineage(&store).await;
    let mut new = new_generation(lineage, &[ParentRef::Genome(genome("missing"))], "x");
    new.idempotency = Some(idempotency("k"));
    let failed = store.create_generation(new).await;
    assert!(matches!(failed, Err(StorageError::NotFound)), "{failed:?}");
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.idempotency, counts.generations, counts.genomes), (0, 0, 0));

    store.store_idempotency(idempotency("k"), 3).await.unwrap();
    assert_eq!(store.counts().await.unwrap().idempotency, 1);
}
