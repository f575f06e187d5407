//! Description of the server: version, backend, workers and limits.

use axum::Json;
use axum::extract::State;
use brood_protocol::{RENDERER_VERSION, SystemAnswer};

use crate::limit;
use crate::state::App;

/// Returns the version, the backend in use and why, the workers, and the limits.
#[utoipa::path(get, path = "/v1/system", operation_id = "get_system", tag = "operation",
    responses((status = 200, description = "version, backend, workers and limits", body = SystemAnswer)))]
pub async fn get(State(app): State<App>) -> Json<SystemAnswer> {
    let (workers, backend) = app.workers.present();
    Json(SystemAnswer {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        renderer_version: RENDERER_VERSION,
        backend,
        workers,
        database: app.store.engine_version(),
        limits: limit::report(),
    })
}
