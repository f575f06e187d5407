//! The pictures of a comparison: framed alike, exposed alike, rendered by workers and read back where they are held against each
//! other.

use std::sync::Arc;

use brood_inspect::{COMPARED, LinearImage};
use brood_protocol::{PictureFormat, SceneId};
use brood_scene::{Exposure, Film, Sampling, Scene};
use brood_storage::PictureRow;
use futures::stream::{self, StreamExt, TryStreamExt};

use super::{One, Wanted, specimen};
use crate::controller::scene;
use crate::library::View;
use crate::problem::ApiError;
use crate::state::App;

/// The scene with one exposure for all, and that exposure.
pub async fn exposed(app: &App, wanted: &Wanted) -> Result<(SceneId, f64), ApiError> {
    let known = app.library.scene(wanted.scene).await?;
    let film = known.scene.film;
    if let Exposure::Ev(ev) = film.exposure {
        return Ok((wanted.scene, ev));
    }
    let (circle, first) = (app.library.circle(wanted.scene).await?, wanted.first());
    let ev = app.on_processor(move || circle.ev(&specimen(&first), film)).await?;
    let film = Film { exposure: Exposure::Ev(ev), ..film };
    let id = scene::store(app, &Scene { film, ..known.scene.clone() }).await?;
    Ok((id, ev))
}

impl Wanted {
    /// How its pictures are framed in a scene.
    pub fn view(&self, app: &App, scene: SceneId, format: PictureFormat) -> View {
        View {
            scene,
            light_deg: None,
            size_px: self.size_px,
            sampling: Sampling::default(),
            area: None,
            format,
            backend: app.backend,
        }
    }
}

pub async fn row(app: &App, one: &One, view: View) -> Result<Arc<PictureRow>, ApiError> {
    let framed = app.library.frame(view).await?;
    let key = framed.key(one.material.program.hash());
    app.announce(framed.row(key, one.hash)).await
}

/// The pictures as exposed, in order.
pub async fn linear(
    app: &App,
    wanted: &Wanted,
    (scene, exposure_ev): (SceneId, f64),
) -> Result<Vec<LinearImage>, ApiError> {
    let view = wanted.view(app, scene, PictureFormat::Exr);
    let mut rows = Vec::with_capacity(wanted.materials.len());
    for one in &wanted.materials {
        rows.push(row(app, one, view).await?);
    }
    let files = rows.into_iter().map(|row| async move { app.picture(&row).await });
    let files = stream::iter(files).buffered(*COMPARED.end()).try_collect::<Vec<_>>().await?;
    let read = move || -> Result<Vec<LinearImage>, ApiError> {
        let read = |exr: &bytes::Bytes| LinearImage::from_exr(exr, exposure_ev);
        let read: Result<_, _> = files.iter().map(read).collect();
        read.map_err(|error| ApiError::internal(error.to_string()))
    };
    app.on_processor(read).await?
}
