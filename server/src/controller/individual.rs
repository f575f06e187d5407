//! Individuals: reading, marking, ancestry and descendants.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{IndividualDetail, IndividualId, LineageId, Page, PatchIndividual};
use brood_storage::{StorageError, StoredIndividual};
use serde::Deserialize;

use super::circle::circle_ev;
use super::{check_length, versioned};
use crate::extract::{IfMatch, Json as JsonBody, PageQuery, Path, Query, page};
use crate::limit;
use crate::presenter::Presenter;
use crate::problem::ApiError;
use crate::state::App;

/// Default depth of an ancestry, in generations.
const DEPTH: u32 = 100;
const DEPTH_MAX: u32 = 10_000;

/// Filter of the individuals.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct FavouritesQuery {
    /// Must be true: only favourites can be listed.
    favourite: Option<bool>,
    /// Lineage to list, hidden or not; default: all that are not hidden.
    lineage: Option<LineageId>,
    /// `next` of the previous page.
    cursor: Option<String>,
    /// Items per page, 1 to 200; default 50.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// Lists the favourites of one lineage or all, newest first.
#[utoipa::path(get, path = "/v1/individuals", operation_id = "list_favourites", tag = "individuals",
    params(FavouritesQuery),
    responses((status = 200, description = "page of favourites", body = Page<IndividualDetail>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<FavouritesQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    if query.favourite != Some(true) {
        return Err(ApiError::bad_parameter("favourite", "must be true"));
    }
    let paging = PageQuery { cursor: query.cursor, limit: query.limit };
    let limit = paging.limit()?;
    let cursor = paging.cursor()?;
    if let Some(lineage) = query.lineage {
        app.store.lineage(lineage).await?;
    }
    let stored = app.store.favourites(cursor, limit + 1, query.lineage).await?;
    present_page(&app, stored, limit).await
}

/// Returns an individual.
#[utoipa::path(get, path = "/v1/individuals/{id}", operation_id = "get_individual", tag = "individuals",
    params(("id" = IndividualId, Path)),
    responses((status = 200, description = "individual", body = IndividualDetail)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
) -> Result<Response, ApiError> {
    let stored = app.store.individual(id).await?;
    let scene = app.store.lineage(stored.lineage).await?.scene;
    let exposure_ev = Some(circle_ev(&app, scene, &stored).await?);
    let mut presenter = Presenter::new(&app);
    let detail = IndividualDetail { exposure_ev, ..presenter.detail(stored).await? };
    presenter.finish().await?;
    Ok(versioned(detail.individual.version, &detail))
}

/// Changes an individual's favourite mark or note.
#[utoipa::path(patch, path = "/v1/individuals/{id}", operation_id = "patch_individual", tag = "individuals",
    params(("id" = IndividualId, Path), ("If-Match" = String, Header, description = "ETag of the individual as last read")),
    request_body = PatchIndividual,
    responses((status = 200, description = "individual after the change", body = IndividualDetail)))]
pub async fn patch(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    if_match: IfMatch,
    body: JsonBody<PatchIndividual>,
) -> Result<Response, ApiError> {
    if let Some(note) = &body.value.note {
        check_length(note, limit::NOTE_CHARS, "/note")?;
    }
    let version = if_match.or(async { Ok(app.store.individual(id).await?.version) }).await?;
    let stored = app.store.patch_individual(id, version, body.value).await?;
    app.events.individual(&stored);
    present(&app, stored).await
}

/// Depth of an ancestry.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct AncestryQuery {
    /// Number of generations, 1 to 10,000; default 100.
    #[param(minimum = 1, maximum = 10_000)]
    depth: Option<u32>,
}

/// Lists an individual's ancestors, nearest first.
#[utoipa::path(get, path = "/v1/individuals/{id}/ancestry", operation_id = "list_ancestors", tag = "individuals",
    params(("id" = IndividualId, Path), AncestryQuery),
    responses((status = 200, description = "page of ancestors", body = Page<IndividualDetail>)))]
pub async fn ancestry(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<AncestryQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    let depth = query.depth.unwrap_or(DEPTH);
    if !(1..=DEPTH_MAX).contains(&depth) {
        return Err(ApiError::bad_parameter(
            "depth",
            format!("must be 1 to {DEPTH_MAX}, got {depth}"),
        ));
    }
    let stored = app.store.ancestry(id, depth).await?;
    present_page(&app, stored, u32::MAX).await
}

/// Lists an individual's descendants in all lineages, oldest first.
#[utoipa::path(get, path = "/v1/individuals/{id}/descendants", operation_id = "list_descendants", tag = "individuals",
    params(("id" = IndividualId, Path), PageQuery),
    responses((status = 200, description = "page of descendants", body = Page<IndividualDetail>)))]
pub async fn descendants(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    let (limit, cursor) = (query.limit()?, query.cursor()?);
    match app.store.descendants(id, cursor, limit + 1).await {
        Err(StorageError::NotFound) if cursor.is_some() => {
            app.store.individual(id).await?;
            let words = "names no individual, or one that was removed; begin with the first page";
            Err(ApiError::bad_parameter("cursor", words))
        }
        stored => present_page(&app, stored?, limit).await,
    }
}

async fn present(app: &App, stored: StoredIndividual) -> Result<Response, ApiError> {
    let mut presenter = Presenter::new(app);
    let detail = presenter.detail(stored).await?;
    presenter.finish().await?;
    Ok(versioned(detail.individual.version, &detail))
}

async fn present_page(
    app: &App,
    stored: Vec<StoredIndividual>,
    limit: u32,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    let Page { items, next } = page(stored, limit, |last| last.id.to_string(), |one| one);
    let mut presenter = Presenter::new(app);
    let items = presenter.details(items).await?;
    presenter.finish().await?;
    Ok(Json(Page { items, next }))
}
