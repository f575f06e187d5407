//! Checks the request for a search and turns it into rows.

use brood_genome::Dialect;
use brood_protocol::{
    Budget, CreateSearch, IndividualId, JobId, Lineage, LineageId, SearchOptions, SearchState,
    Seed, Target, encode,
};
use brood_scene::Scene;
use brood_storage::{NewSearch, StorageError, StoredSearch};
use brood_target::{Objective, Strategy, TargetKind};

use crate::clock::now_ms;
use crate::controller::check_length;
use crate::controller::lineage::check_name;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

const THUMBNAIL_PX: u32 = 256;

/// Checks a request and returns the search to store.
///
/// # Errors
/// 422 with a pointer to the invalid value, or 404 if a target, lineage or individual is missing.
pub async fn read(app: &App, asked: CreateSearch) -> Result<NewSearch, ApiError> {
    let refuse = |pointer: &str, words: String| ApiError::refused(words).at(pointer);
    if asked.kind != "fit" {
        let words = format!("`kind` must be fit, got {}", quote(&asked.kind));
        return Err(refuse("/kind", words));
    }
    let budget = budget(&asked)?;
    let requested = strategy(asked.strategy.as_deref().unwrap_or("auto"))?;
    let objective = asked.objective.as_deref().map(str::parse::<Objective>).transpose();
    let objective = objective.map_err(|error| refuse("/objective", error.to_string()))?;
    let threads = match asked.threads {
        Some(threads) if !(1..=limit::SEARCH_THREADS).contains(&threads) => {
            let words = format!("`threads` must be 1 to {}", limit::SEARCH_THREADS);
            return Err(refuse("/threads", words));
        }
        threads => threads.and_then(|threads| u32::try_from(threads).ok()),
    };
    if asked.target_error.is_some_and(|error| !(error > 0.0 && error.is_finite())) {
        return Err(refuse("/target_error", "`target_error` must be greater than 0".to_owned()));
    }
    let target = app.store.target(asked.target).await.map_err(|error| match error {
        StorageError::NotFound => {
            ApiError::not_found("there is no target with this id").at("/target")
        }
        other => other.into(),
    })?;
    let name = match asked.name {
        Some(name) => name,
        None if target.name.is_empty() => format!("{} target", target.kind),
        None => target.name.clone(),
    };
    check_name(&name)?;
    let is_picture = target.kind == TargetKind::Image.name();
    let (used, several) = pixels(&target);
    let has_few = Strategy::Hybrid.check_pixels(used, several).is_err();
    // Sums of models cannot continue from programs.
    let is_analytic = has_few || (is_picture && asked.start.is_empty());
    let preferred = Strategy::of_target(is_analytic);
    let Start { genomes, dialect, strategy } =
        start(app, &asked.start, requested, preferred).await?;
    let islands = match asked.islands.unwrap_or(1) {
        1 => 1,
        several @ 2..=limit::ISLANDS if strategy.has_islands() => several as u32,
        2..=limit::ISLANDS => {
            let words = format!(
                "the strategy {strategy} has no islands; use gp or hybrid, or leave `islands` out"
            );
            return Err(refuse("/islands", words));
        }
        _ => {
            let words = format!("`islands` must be 1 to {}", limit::ISLANDS);
            return Err(refuse("/islands", words));
        }
    };
    let fits = strategy.check_pixels(used, several);
    fits.map_err(|error| refuse("/strategy", error.to_string()))?;
    let given = match asked.lineage {
        Some(id) => Some(lineage(app, id, dialect).await?),
        None => None,
    };
    let objective =
        strategy.objective(objective).map_err(|error| refuse("/objective", error.to_string()))?;
    let created_ms = now_ms();
    let new_lineage = match given {
        Some(_) => None,
        None => Some(results_lineage(app, &name, dialect, created_ms).await?),
    };
    let lineage = asked.lineage.or(new_lineage.as_ref().map(|new| new.id));
    let mut ids: Vec<JobId> = (0..islands).map(|_| JobId::fresh()).collect();
    // The search is stored, and copied, before its other islands.
    ids.sort_unstable();
    Ok(NewSearch {
        id: ids.remove(0),
        islands: ids,
        target: asked.target,
        lineage: lineage.expect("it is given or made"),
        new_lineage,
        options: SearchOptions {
            name,
            strategy: strategy.name().to_owned(),
            objective: Some(objective.name().to_owned()),
            seed: asked.seed.unwrap_or(Seed(1)),
            threads,
            mirrored: asked.mirrored,
            budget,
            islands,
            target_error: asked.target_error,
            start: asked.start,
        },
        start: encode(&genomes),
        created_ms,
        idempotency: None,
    })
}

/// Returns the islands of a new search as they are before a worker claims one.
pub fn as_stored(new: &NewSearch) -> Vec<StoredSearch> {
    let one = |(island, id): (u32, JobId)| StoredSearch {
        id,
        parent: (island > 0).then_some(new.id),
        island,
        is_over: false,
        target: new.target,
        lineage: new.lineage,
        state: SearchState::Queued,
        epoch: 0,
        deaths: 0,
        worker: None,
        reason: None,
        generation: 0,
        evaluations: 0,
        seconds: 0.0,
        fitted: None,
        held: None,
        recorded: None,
        population: None,
        options: new.options.clone(),
        best: None,
        created_ms: new.created_ms,
        started_ms: None,
        ended_ms: None,
    };
    let ids = std::iter::once(new.id).chain(new.islands.iter().copied());
    (0..).zip(ids).map(one).collect()
}

fn budget(asked: &CreateSearch) -> Result<Budget, ApiError> {
    let refuse = |pointer: &str, words: String| Err(ApiError::refused(words).at(pointer));
    match (asked.seconds, asked.generations, asked.evaluations) {
        (Some(seconds), None, None) => {
            if !(seconds > 0.0 && seconds <= limit::SEARCH_SECONDS) {
                let words = format!(
                    "`seconds` must be greater than 0 and at most {}",
                    limit::SEARCH_SECONDS
                );
                return refuse("/seconds", words);
            }
            Ok(Budget::Seconds(seconds))
        }
        (None, Some(generations), None) => match u32::try_from(generations) {
            Ok(few @ 1..=limit::SEARCH_GENERATIONS) => Ok(Budget::Generations(few)),
            _ => {
                let words = format!("`generations` must be 1 to {}", limit::SEARCH_GENERATIONS);
                refuse("/generations", words)
            }
        },
        (None, None, Some(evaluations)) => {
            if !(1..=limit::SEARCH_EVALUATIONS).contains(&evaluations) {
                let words = format!("`evaluations` must be 1 to {}", limit::SEARCH_EVALUATIONS);
                return refuse("/evaluations", words);
            }
            Ok(Budget::Evaluations(evaluations))
        }
        _ => refuse(
            "",
            "give exactly one budget: `seconds`, `generations` or `evaluations`".to_owned(),
        ),
    }
}

fn strategy(name: &str) -> Result<Option<Strategy>, ApiError> {
    let known = Strategy::choice(name);
    known.map_err(|error| ApiError::refused(error.to_string()).at("/strategy"))
}

/// Numbers of pixels of a target's fitted views: those that one light reaches, and those that are
/// lit from several directions.
fn pixels(target: &Target) -> (u64, u64) {
    let fitted = target.views.iter().filter(|view| !view.held_out);
    fitted.fold((0, 0), |(used, several), view| {
        (used + view.pixels.used, several + view.pixels.several_lights)
    })
}

async fn lineage(app: &App, id: LineageId, needed: Dialect) -> Result<Lineage, ApiError> {
    let lineage = app.store.lineage(id).await.map_err(|error| match error {
        StorageError::NotFound => {
            ApiError::not_found("there is no lineage with this id").at("/lineage")
        }
        other => other.into(),
    })?;
    let own = lineage.dialect;
    let as_long = Dialect { length: needed.length, ..own };
    if own.length != 0 && (own.length < needed.length || !as_long.is_compatible(&needed)) {
        let words = format!(
            "results have dialect {needed}, length at most {}; the lineage has {own}, length {}",
            needed.length, own.length
        );
        return Err(ApiError::refused(words).at("/lineage"));
    }
    Ok(lineage)
}

/// Starting point of a search.
struct Start {
    /// Canonical bytes of the start genomes.
    genomes: Vec<Vec<u8>>,
    /// Dialect of the results: genetic programming stays in the dialect of the start genomes.
    dialect: Dialect,
    /// Requested strategy, or else one that can continue from the start individuals.
    strategy: Strategy,
}

async fn start(
    app: &App,
    individuals: &[IndividualId],
    requested: Option<Strategy>,
    preferred: Strategy,
) -> Result<Start, ApiError> {
    if individuals.len() > limit::SEARCH_START {
        let words = format!("`start` must have at most {} items", limit::SEARCH_START);
        return Err(ApiError::refused(words).at("/start"));
    }
    let (mut found, mut strategy) = (Strategy::DIALECT, requested.unwrap_or(preferred));
    let mut genomes = Vec::with_capacity(individuals.len());
    for (index, id) in individuals.iter().enumerate() {
        let pointer = format!("/start/{index}");
        let individual = app.store.individual(*id).await.map_err(|error| match error {
            StorageError::NotFound => {
                ApiError::not_found("there is no individual with this id").at(pointer.clone())
            }
            other => other.into(),
        })?;
        let material =
            app.library.brdf(individual.hash).await.map_err(|error| error.at(pointer.clone()))?;
        let own = *material.genome.dialect();
        if index == 0 && own.length != 0 {
            if requested.is_none() && !own.is_compatible(&found) {
                strategy = Strategy::Gp;
            }
            if strategy == Strategy::Gp {
                found = own;
            }
        }
        if !own.is_compatible(&found) {
            let words = format!(
                "the individual has dialect {own}, length {}; the strategy {strategy} needs {found}, length {}",
                own.length, found.length
            );
            return Err(ApiError::refused(words).at(pointer));
        }
        genomes.push(material.genome.canonical_bytes());
    }
    Ok(Start { genomes, dialect: found, strategy })
}

/// Returns a new lineage for the results.
async fn results_lineage(
    app: &App,
    name: &str,
    dialect: Dialect,
    created_ms: i64,
) -> Result<Lineage, ApiError> {
    let name = format!("Fit of {name}");
    let name: String = name.chars().take(limit::NAME_CHARS).collect();
    check_length(&name, limit::NAME_CHARS, "/name")?;
    Ok(Lineage {
        id: LineageId::fresh(),
        name,
        notes: String::new(),
        tags: Vec::new(),
        hidden: false,
        cover_individual: None,
        scene: crate::controller::scene::store(app, &Scene::default()).await?,
        thumbnail_px: THUMBNAIL_PX,
        start: brood_genome::Start::of(&dialect),
        dialect,
        saturation: 1.0,
        energy_limit: true,
        generations: 0,
        favourites: 0,
        created_ms,
        version: 1,
    })
}
