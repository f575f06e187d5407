//! Answers that need nothing but the stored row.

use brood_protocol::{Individual, PictureKey};
use brood_storage::StoredIndividual;

use crate::picture::thumbnail_url;

/// Converts an individual whose thumbnail has this key.
pub fn individual(stored: StoredIndividual, key: PictureKey) -> Individual {
    Individual {
        id: stored.id,
        hash: stored.hash,
        slot: stored.slot,
        parents: stored.parents,
        operator: stored.operator,
        live_instructions: stored.live_instructions,
        layers: stored.layers.iter().map(|kind| kind.name().to_owned()).collect(),
        thumbnail: thumbnail_url(key),
        favourite: stored.favourite,
        note: stored.note,
        twin: stored.twin,
        version: stored.version,
    }
}
