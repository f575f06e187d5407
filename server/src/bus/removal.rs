//! Caches of genomes that may be removed.

use crate::state::AppState;

/// Drops what is cached of genomes here and at the other servers. Called after a removal, even one
/// that has failed: it may have removed some of the genomes.
pub fn genomes_removed(app: &AppState) {
    forget_removed(app);
    app.events.peers().tell_removal();
}

/// Drops what is cached of genomes: the store may have lost some of them, and the rows of their
/// pictures.
pub(super) fn forget_removed(app: &AppState) {
    app.library.clear_materials();
    app.pictures.cache.clear_rows();
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use brood_eval::express;
    use brood_genome::preset::neutral;
    use brood_protocol::{Backend, PictureFormat, PictureKey, SceneId};
    use brood_scene::{PictureSize, Sampling};
    use brood_storage::NewPicture;

    use super::*;
    use crate::config::ServerConfig;
    use crate::server::Server;

    #[tokio::test(flavor = "multi_thread")]
    async fn materials_and_picture_rows_are_read_again_when_genomes_were_removed() {
        let dir = tempfile::tempdir().unwrap();
        let config = ServerConfig::new("127.0.0.1:0".parse().unwrap(), dir.path().to_owned());
        let app = Server::bind(config).await.unwrap().app();
        let (genome, key) = (neutral(), PictureKey([1; 32]));
        let hash = genome.hash();
        app.library.insert_material(hash, genome.clone(), express(genome)).await;
        let row = NewPicture {
            key,
            genome_hash: hash,
            scene: SceneId::fresh(),
            light_deg: 0.0,
            size_px: PictureSize::from(8),
            sampling: Sampling::default(),
            area: None,
            format: PictureFormat::Png,
            backend: Backend::Cpu,
            renderer_version: 1,
        };
        app.pictures.cache.insert_row(&Arc::new(row));
        assert!(app.library.material(hash).await.is_ok() && app.pictures.row(key).await.is_ok());
        genomes_removed(&app);
        assert_eq!(app.library.material(hash).await.unwrap_err().status(), 404);
        assert_eq!(app.pictures.row(key).await.unwrap_err().status(), 404);
    }
}
