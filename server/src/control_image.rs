//! Control images of painted materials: checked when a genome is stored.

use brood_genome::{EffectImage, Genome, ImageHash};
use brood_protocol::LightAssetKind;
use brood_storage::{StorageError, Store};

use crate::problem::{ApiError, quote};

/// Checks that the images of a genome were uploaded.
///
/// # Errors
/// 404 or 422 with a pointer to the image in the genome's JSON.
pub async fn check(store: &Store, genome: &Genome) -> Result<(), ApiError> {
    for (at, effect) in genome.effects().iter().enumerate() {
        for EffectImage { place, image, .. } in effect.images() {
            check_one(store, *image)
                .await
                .map_err(|error| error.at(format!("/effects/{at}/parameters/{place}/image")))?;
        }
    }
    Ok(())
}

/// Checks that an image was uploaded.
///
/// # Errors
/// 404 if it does not exist, 422 if it is a file of another kind.
pub async fn check_one(store: &Store, image: ImageHash) -> Result<(), ApiError> {
    match store.light_asset_kind(*image.as_bytes()).await {
        Ok(LightAssetKind::Image) => Ok(()),
        Ok(kind) => {
            let words = format!("the id belongs to a file of kind {}", kind.name());
            Err(ApiError::refused(words))
        }
        Err(StorageError::NotFound) => {
            let words = format!("there is no image {image}; upload it with `POST /v1/images`");
            Err(ApiError::not_found(words))
        }
        Err(error) => Err(error.into()),
    }
}

/// Returns an image as it was uploaded.
///
/// # Errors
/// 404 if there is none of this id.
pub async fn file(store: &Store, id: &str) -> Result<Vec<u8>, ApiError> {
    let unknown = || ApiError::not_found(format!("there is no image {}", quote(id)));
    let hash: ImageHash = id.parse().map_err(|_| unknown())?;
    match store.light_asset(*hash.as_bytes()).await {
        Ok((LightAssetKind::Image, bytes)) => Ok(bytes),
        Ok(_) | Err(StorageError::NotFound) => Err(unknown()),
        Err(error) => Err(error.into()),
    }
}
