//! Lineages: creating, listing, reading, changing, hiding and purging.

use axum::Json;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_genome::{Dialect, Start};
use brood_protocol::{
    CreateLineage, IndividualId, Lineage, LineageId, ListedLineage, Page, PatchLineage, SceneId,
    check_painted_defaults,
};
use brood_scene::Scene;
use brood_storage::{LineageCursor, LineageFilter, StorageError};
use http::{HeaderMap, StatusCode};
use serde::Deserialize;

use super::{check_length, create_once, is_plain, versioned};
use crate::access::Need;
use crate::bus;
use crate::clock::now_ms;
use crate::extract::{IfMatch, Json as JsonBody, PageQuery, Path, Query, page};
use crate::idempotency::IdempotencyKey;
use crate::layer::token;
use crate::library::check_painted_lights;
use crate::limit;
use crate::presenter::Presenter;
use crate::problem::{ApiError, quote};
use crate::state::App;

const COLLECTION: &str = "/v1/lineages";

/// Creates a lineage.
#[utoipa::path(post, path = "/v1/lineages", operation_id = "create_lineage", tag = "lineages",
    request_body = CreateLineage,
    params(IdempotencyKey),
    responses((status = 201, description = "new lineage", body = Lineage)))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    body: JsonBody<CreateLineage>,
) -> Result<Response, ApiError> {
    create_once(&app, key, COLLECTION, body.bytes, async |attempt| {
        let asked = body.value;
        check_name(&asked.name)?;
        check_length(&asked.notes, limit::NOTE_CHARS, "/notes")?;
        check_tags(&asked.tags)?;
        check_saturation(asked.saturation)?;
        let sides = limit::PICTURE_MIN_PX..=limit::THUMBNAIL_PX;
        if !sides.contains(&asked.thumbnail_px) {
            let words = format!(
                "must be {} to {} pixels, got {}",
                sides.start(),
                sides.end(),
                asked.thumbnail_px
            );
            return Err(ApiError::refused(words).at("/thumbnail_px"));
        }
        let (start, dialect) = start_of(asked.start, asked.dialect)?;
        if start == Start::Painted {
            check_painted_defaults(Some(asked.saturation), asked.energy_limit)?;
        }
        let scene = match asked.scene {
            Some(scene) => check_scene(&app, scene, start).await?,
            None => super::scene::store(&app, &Scene::default()).await?,
        };
        let new = Lineage {
            id: LineageId::fresh(),
            name: asked.name,
            notes: asked.notes,
            tags: asked.tags,
            hidden: false,
            cover_individual: None,
            scene,
            thumbnail_px: asked.thumbnail_px,
            start,
            dialect,
            saturation: asked.saturation,
            energy_limit: asked.energy_limit.unwrap_or(start == Start::Believable),
            generations: 0,
            favourites: 0,
            created_ms: now_ms(),
            version: 1,
        };
        let record = attempt.record(StatusCode::CREATED, &new);
        Ok(app.store.create_lineage(new, record).await?)
    })
    .await
}

/// Page of lineages.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct LineagesQuery {
    /// Words that must all occur in the name, the notes or a tag, in any order; at most 200
    /// characters. Upper and lower case are the same.
    search: Option<String>,
    /// True to list the hidden lineages instead of the others.
    #[serde(default)]
    hidden: bool,
    /// `next` of the previous page.
    cursor: Option<String>,
    /// Items per page, 1 to 200; default 50.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// Lists the lineages that are not hidden, newest first.
#[utoipa::path(get, path = "/v1/lineages", operation_id = "list_lineages", tag = "lineages",
    params(LineagesQuery),
    responses((status = 200, description = "page of lineages", body = Page<ListedLineage>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<LineagesQuery>,
) -> Result<Json<Page<ListedLineage>>, ApiError> {
    let paging = PageQuery { cursor: query.cursor, limit: query.limit };
    let limit = paging.limit()?;
    let cursor = paging.cursor::<LineageCursor>()?;
    let search = query.search.unwrap_or_default();
    let chars = search.chars().count();
    if chars > limit::SEARCH_CHARS {
        let words = format!("must have at most {} characters, got {chars}", limit::SEARCH_CHARS);
        return Err(ApiError::bad_parameter("search", words));
    }
    let filter = LineageFilter::new(Some(query.hidden), &search);
    let items = app.store.list_lineages(cursor, limit + 1, &filter).await?;
    let Page { items, next } =
        page(items, limit, |lineage| LineageCursor::of(lineage).to_string(), |lineage| lineage);
    let mut presenter = Presenter::new(&app);
    let items = presenter.lineages(items).await?;
    presenter.finish().await?;
    Ok(Json(Page { items, next }))
}

/// Returns a lineage.
#[utoipa::path(get, path = "/v1/lineages/{id}", operation_id = "get_lineage", tag = "lineages",
    params(("id" = LineageId, Path)), responses((status = 200, description = "lineage", body = Lineage)))]
pub async fn get(State(app): State<App>, Path(id): Path<LineageId>) -> Result<Response, ApiError> {
    let lineage = app.store.lineage(id).await?;
    Ok(versioned(lineage.version, &lineage))
}

/// Changes a lineage's name, notes, tags, scene, cover or defaults; hides or restores it.
#[utoipa::path(patch, path = "/v1/lineages/{id}", operation_id = "patch_lineage", tag = "lineages",
    params(("id" = LineageId, Path), ("If-Match" = String, Header, description = "ETag of the lineage as last read")),
    request_body = PatchLineage,
    responses((status = 200, description = "lineage after the change", body = Lineage)))]
pub async fn patch(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    if_match: IfMatch,
    body: JsonBody<PatchLineage>,
) -> Result<Response, ApiError> {
    let patch = body.value;
    if let Some(name) = &patch.name {
        check_name(name)?;
    }
    if let Some(notes) = &patch.notes {
        check_length(notes, limit::NOTE_CHARS, "/notes")?;
    }
    if let Some(tags) = &patch.tags {
        check_tags(tags)?;
    }
    if let Some(Some(cover)) = patch.cover_individual {
        check_cover(&app, id, cover).await?;
    }
    if let Some(saturation) = patch.saturation {
        check_saturation(saturation)?;
    }
    if let Some(scene) = patch.scene {
        check_scene(&app, scene, app.store.lineage(id).await?.start).await?;
    }
    if (patch.saturation.is_some() || patch.energy_limit.is_some())
        && app.store.lineage(id).await?.start == Start::Painted
    {
        check_painted_defaults(patch.saturation, patch.energy_limit)?;
    }
    let version = if_match.or(async { Ok(app.store.lineage(id).await?.version) }).await?;
    let lineage = app.store.patch_lineage(id, version, patch).await?;
    app.events.lineage(id, lineage.version);
    Ok(versioned(lineage.version, &lineage))
}

/// Options of a deletion.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct DeleteQuery {
    /// True to remove the lineage and its contents permanently.
    #[serde(default)]
    purge: bool,
}

/// Hides a lineage, or removes it permanently.
#[utoipa::path(delete, path = "/v1/lineages/{id}", operation_id = "delete_lineage", tag = "lineages",
    params(("id" = LineageId, Path), DeleteQuery),
    responses((status = 204, description = "lineage hidden or removed")))]
pub async fn delete(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    Query(query): Query<DeleteQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    if query.purge {
        app.access.check(&app.store, Need::Admin, token(&headers)).await?;
        let removing = app.clone();
        // Runs in a separate task: the removal does not end with its client.
        let purge = app.tasks.spawn(async move {
            let purge = removing.store.purge_lineage(id);
            // Another server, or the next start, removes the rest.
            let purged = removing.stopping.run_until_cancelled(purge).await;
            if !matches!(purged, Some(Err(StorageError::NotFound))) {
                bus::genomes_removed(&removing);
            }
            purged
        });
        let purged = purge.await.map_err(|error| ApiError::internal(error.to_string()))?;
        purged.ok_or_else(|| ApiError::stopping("the rest is removed at the next start"))??;
    } else {
        app.store.hide_lineage(id).await?;
    }
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// Checks that a name is plain text that can be seen, and short enough.
///
/// # Errors
/// 422 if it is not.
pub fn check_name(name: &str) -> Result<(), ApiError> {
    if !is_plain(name) {
        let words = "a name must have visible characters, and none that are invisible or change the order of text";
        return Err(ApiError::refused(words).at("/name"));
    }
    check_length(name, limit::NAME_CHARS, "/name")
}

/// Checks that tags are few, short, different, and plain text without commas.
///
/// # Errors
/// 422 if they are not.
pub fn check_tags(tags: &[String]) -> Result<(), ApiError> {
    let count = tags.len();
    if count > limit::TAGS {
        let words = format!("must have at most {} tags, got {count}", limit::TAGS);
        return Err(ApiError::refused(words).at("/tags"));
    }
    for (index, tag) in tags.iter().enumerate() {
        let pointer = format!("/tags/{index}");
        if tag.trim() != tag || !is_plain(tag) || tag.contains(',') {
            let words = "a tag must have visible characters without commas, none that are invisible \
                         or change the order of text, and no space around it";
            return Err(ApiError::refused(words).at(pointer));
        }
        check_length(tag, limit::TAG_CHARS, &pointer)?;
        let folded = tag.to_lowercase();
        if tags[..index].iter().any(|one| one.to_lowercase() == folded) {
            let words = format!("the tag {} is there twice", quote(tag));
            return Err(ApiError::refused(words).at(pointer));
        }
    }
    Ok(())
}

/// Checks that a cover is an individual of the lineage.
async fn check_cover(app: &App, lineage: LineageId, cover: IndividualId) -> Result<(), ApiError> {
    let pointer = "/cover_individual";
    let one = app.store.individual(cover).await;
    if one.map_err(|error| ApiError::from(error).at(pointer))?.lineage == lineage {
        return Ok(());
    }
    Err(ApiError::refused("the cover must be an individual of this lineage").at(pointer))
}

/// Checks that a saturation is between 0 and 1.
///
/// # Errors
/// 422 if it is not.
pub fn check_saturation(saturation: f32) -> Result<(), ApiError> {
    if (0.0..=1.0).contains(&saturation) {
        return Ok(());
    }
    let words = format!("`saturation` must be between 0 and 1, got {saturation}");
    Err(ApiError::refused(words).at("/saturation"))
}

/// Returns the start and the dialect of a lineage; a missing one follows from the other.
///
/// # Errors
/// 422 if the dialect is invalid or the start does not allow it.
pub fn start_of(
    start: Option<Start>,
    dialect: Option<Dialect>,
) -> Result<(Start, Dialect), ApiError> {
    let refuse = |words: String| Err(ApiError::refused(words).at("/dialect"));
    let start = start.unwrap_or_else(|| dialect.as_ref().map_or(Start::default(), Start::of));
    let dialect = dialect.unwrap_or_else(|| start.dialect());
    if let Err(error) = dialect.validate() {
        return refuse(error.to_string());
    }
    if !start.allows(&dialect) {
        let own = start.dialect();
        return refuse(format!(
            "`start` {} needs a dialect like {own}, length {}, or none; got {dialect}, length {}",
            start.name(),
            own.length,
            dialect.length
        ));
    }
    Ok((start, dialect))
}

async fn check_scene(app: &App, scene: SceneId, start: Start) -> Result<SceneId, ApiError> {
    let known = app.library.scene(scene).await.map_err(|error| error.at("/scene"))?;
    if start == Start::Painted {
        check_painted_lights(known.scene.lights.len()).map_err(|error| error.at("/scene"))?;
    }
    Ok(scene)
}
