//! Individuals: read, marked, and their families.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{IndividualDetail, IndividualId, Page, PatchIndividual};
use brood_storage::StoredIndividual;
use serde::Deserialize;

use super::circle::circle_ev;
use super::{check_length, versioned};
use crate::extract::{IfMatch, Json as JsonBody, NoQuery, PageQuery, Path, Query, page};
use crate::limit;
use crate::presenter::Presenter;
use crate::problem::ApiError;
use crate::state::App;

/// Generations that a family tree goes up unless asked otherwise.
const DEPTH: u32 = 100;
const DEPTH_MAX: u32 = 10_000;

/// Which individuals.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ListQuery {
    /// Has to be true: favourites are the one list of individuals that there is.
    favourite: Option<bool>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// Items of a page, 1 to 200; 50 unless asked otherwise.
    limit: Option<u32>,
}

/// The favourites of all lineages, newest first.
#[utoipa::path(get, path = "/v1/individuals", tag = "individuals", params(ListQuery),
    responses((status = 200, body = Page<IndividualDetail>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<ListQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    if query.favourite != Some(true) {
        return Err(ApiError::bad_parameter("favourite", "must be true"));
    }
    let paging = PageQuery { cursor: query.cursor, limit: query.limit };
    let limit = paging.limit()?;
    let stored = app.store.favourites(paging.cursor()?, limit + 1).await?;
    present_page(&app, stored, limit).await
}

/// One individual.
#[utoipa::path(get, path = "/v1/individuals/{id}", tag = "individuals",
    params(("id" = IndividualId, Path)), responses((status = 200, body = IndividualDetail)))]
pub async fn get(
    State(app): State<App>,
    NoQuery: NoQuery,
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

/// Marks a favourite or changes a note.
#[utoipa::path(patch, path = "/v1/individuals/{id}", tag = "individuals",
    params(("id" = IndividualId, Path), ("If-Match" = String, Header, description = "ETag of the individual as it was read")),
    request_body = PatchIndividual, responses((status = 200, body = IndividualDetail)))]
pub async fn patch(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<IndividualId>,
    IfMatch(version): IfMatch,
    body: JsonBody<PatchIndividual>,
) -> Result<Response, ApiError> {
    if let Some(note) = &body.value.note {
        check_length(note, limit::NOTE_CHARS, "/note")?;
    }
    let version = match version {
        Some(version) => version,
        None => app.store.individual(id).await?.version,
    };
    let stored = app.store.patch_individual(id, version, body.value).await?;
    app.events.individual(&stored);
    present(&app, stored).await
}

/// How far up.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct AncestryQuery {
    /// Generations, 1 to 10,000; 100 unless asked otherwise.
    depth: Option<u32>,
}

/// The ancestors, nearest first.
#[utoipa::path(get, path = "/v1/individuals/{id}/ancestry", tag = "individuals",
    params(("id" = IndividualId, Path), AncestryQuery),
    responses((status = 200, body = Page<IndividualDetail>)))]
pub async fn ancestry(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<AncestryQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    let depth = query.depth.unwrap_or(DEPTH);
    if !(1..=DEPTH_MAX).contains(&depth) {
        return Err(ApiError::bad_parameter("depth", format!("1 to {DEPTH_MAX}, not {depth}")));
    }
    let stored = app.store.ancestry(id, depth).await?;
    present_page(&app, stored, u32::MAX).await
}

/// The descendants in all lineages, oldest first.
#[utoipa::path(get, path = "/v1/individuals/{id}/descendants", tag = "individuals",
    params(("id" = IndividualId, Path), PageQuery),
    responses((status = 200, body = Page<IndividualDetail>)))]
pub async fn descendants(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<IndividualDetail>>, ApiError> {
    let limit = query.limit()?;
    let stored = app.store.descendants(id, query.cursor()?, limit + 1).await?;
    present_page(&app, stored, limit).await
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
