//! The birth of a brood: one transaction that holds all of it, and render jobs for the pictures that do not exist yet.
//!
//! The first job is part of the transaction. A worker that waits gets it while the disk is still busy with the
//! transaction: pictures are derived from their keys, so one whose brood never became a fact harms nobody. The 201
//! comes after the disk all the same. A large brood's other jobs follow in the batch queue, so that its first pictures
//! come at once and somebody else's brood need not wait for its last ones.

use std::collections::HashSet;
use std::sync::Arc;

use brood_genome::Model;
use brood_program::ProgramHash;
use brood_protocol::{
    Breed, DialectConstraints, Generation, GenerationId, IndividualId, JobId, Lineage, ParentRef,
    PictureKey, RenderJob, Seed, encode,
};
use brood_storage::{
    Committed, NewGeneration, NewIndividual, NewJob, NewPicture, Queue, SearchStep, StorageError,
    StoredGeneration, StoredIndividual,
};
use futures::poll;
use http::StatusCode;

use super::{Newborn, Parent};
use crate::dispatch::{FrameId, Waiting, queued_job, render_work};
use crate::idempotency::Attempt;
use crate::library::{Framed, Material};
use crate::limit;
use crate::picture::Failure;
use crate::presenter::{individual, thumbnail_url};
use crate::problem::ApiError;
use crate::stage::Stages;
use crate::state::{App, AppState, now_ms};

impl AppState {
    /// Makes a brood a fact and gets its pictures under way.
    pub(super) async fn birth(
        self: &App,
        lineage: &Lineage,
        framed: &Arc<Framed>,
        parents: &[Parent],
        brood: Brood,
        attempt: &Attempt,
        stages: &mut Stages,
    ) -> Result<(Generation, Option<JobId>), ApiError> {
        let centre = parents.first().filter(|parent| parent.individual.is_some());
        let (id, created_ms) = (GenerationId::fresh(), now_ms());
        let (ids, search) = match brood.recording {
            Some(Recording { ids, step }) => (ids, Some(step)),
            None => (brood.children.iter().map(|_| IndividualId::fresh()).collect(), None),
        };
        let mut materials: Vec<Wanted> = Vec::new();
        let mut pictures: Vec<NewPicture> = Vec::new();
        let mut individuals: Vec<NewIndividual> = Vec::new();
        if let Some(centre) = centre
            && let Some(individual) = &centre.individual
        {
            let key = framed.key(centre.material.program.hash());
            pictures.push(framed.row(key, centre.hash));
            materials.push((key, individual.id, centre.material.clone()));
        }
        let mut redraws = 0;
        let mut twins = 0;
        for (Newborn { child, bytes }, id) in brood.children.into_iter().zip(&ids) {
            let key = framed.key(child.program_hash);
            pictures.push(framed.row(key, child.hash));
            redraws += u64::from(child.attempts - 1);
            twins += u64::from(child.twin);
            individuals.push(NewIndividual {
                id: *id,
                slot: child.slot,
                hash: child.hash,
                genome_bytes: bytes,
                program_hash: *child.program_hash.as_bytes(),
                operator: brood.operator,
                live_instructions: child.live_instructions,
                layers: child.genome.layers().iter().map(Model::kind).collect(),
                attempts: child.attempts,
                twin: child.twin,
            });
            let material = self.library.keep(child.hash, child.genome, child.program);
            materials.push((key, *id, material));
        }
        for row in &pictures {
            self.gallery.learn(&Arc::new(row.clone()));
        }
        let answer = Generation {
            id,
            lineage: lineage.id,
            index: 0,
            seed: brood.seed,
            parents: brood.breed.parents.clone(),
            centre: centre.and_then(|parent| {
                let key = framed.key(parent.material.program.hash());
                Some(individual(parent.individual.clone()?, key))
            }),
            mutation: brood.breed.mutation,
            recombination: brood.breed.recombination,
            curation: brood.breed.curation,
            constraints: brood.constraints,
            saturation: brood.breed.saturation,
            energy_limit: brood.breed.energy_limit,
            locks: brood.breed.locks.clone(),
            individuals: individuals
                .iter()
                .map(|new| {
                    let stored = stored(new, lineage, id, &brood.breed.parents);
                    let program = ProgramHash::from_bytes(new.program_hash);
                    individual(stored, framed.key(program))
                })
                .collect(),
            created_ms,
        };

        let departed = self.gallery.depart(materials.iter().map(|(key, ..)| *key));
        let distinct: HashSet<_> = materials.iter().map(|(key, ..)| *key).collect();
        self.metrics.shared.increment((materials.len() - distinct.len()) as u64);
        self.metrics.skipped.increment((distinct.len() - departed.len()) as u64);
        let batch = FrameId::pictures_per_job(&framed.frame);
        let first = departed.get(..batch).unwrap_or(&departed);
        let errand = (!first.is_empty()).then(|| {
            let work = render_work(&framed.frame, items(first, &materials));
            (JobId::fresh(), work, self.dispatch.next_waiting())
        });
        let job = errand.as_ref().map(|(id, work, waiting)| NewJob {
            id: *id,
            leased_to: waiting.as_ref().map(|waiting| waiting.worker.clone()),
            ..queued_job(Queue::Interactive, encode(work))
        });
        let job_id = job.as_ref().map(|job| job.id);
        let errand = errand
            .and_then(|(job, work, waiting)| waiting.map(|waiting| Errand { job, work, waiting }));
        let new = NewGeneration {
            id,
            lineage: lineage.id,
            seed: brood.seed,
            parents: brood.breed.parents,
            centre: answer.centre.as_ref().map(|centre| centre.id),
            mutation: brood.breed.mutation,
            recombination: brood.breed.recombination,
            curation: brood.breed.curation,
            constraints: brood.constraints,
            saturation: brood.breed.saturation,
            energy_limit: brood.breed.energy_limit,
            locks: brood.breed.locks,
            created_ms,
            individuals,
            pictures,
            job,
            search,
            idempotency: attempt.record(StatusCode::CREATED, &answer),
        };
        let flights = Flights { app: self.clone(), keys: departed };
        let framed = framed.clone();
        let birth = Birth { new, errand, answer, framed, materials, flights, redraws, twins };
        stages.end("prepare");
        let app = self.clone();
        // In a task of its own: what was written must be told even if the request was given up meanwhile.
        let born = self.tasks.spawn(async move { app.deliver(birth).await });
        let born = born.await.map_err(|error| ApiError::internal(error.to_string()))?;
        let (generation, committed) = born?;
        stages.note("queue", committed.queued);
        stages.note("write", committed.written);
        stages.note("commit", committed.synced);
        stages.end("birth");
        Ok((generation, job_id))
    }

    /// Writes a brood and tells of it.
    async fn deliver(self: App, birth: Birth) -> Result<(Generation, Committed), ApiError> {
        let Birth { new, errand, mut answer, framed, materials, mut flights, redraws, twins } =
            birth;
        let (born, committed) = self.write_and_hand_out(new, errand).await?;
        let batch = FrameId::pictures_per_job(&framed.frame).min(flights.keys.len());
        flights.keys.drain(..batch);
        self.dispatch.bell.notify_one();
        answer.index = born.index;
        self.metrics.breeds.increment(1);
        self.metrics.births.increment(answer.individuals.len() as u64);
        self.metrics.redraws.increment(redraws);
        self.metrics.twins.increment(twins);
        self.events.generation(answer.lineage, answer.id);
        for (key, individual, _) in &materials {
            // First the wish, then the look: a picture that lands between the two is told of all the same.
            self.gallery.interest(*key, answer.lineage, *individual);
            if self.gallery.has(*key) {
                for (lineage, individual) in self.gallery.take_interests(*key) {
                    self.events.thumbnail(lineage, individual, &thumbnail_url(*key));
                }
            }
        }
        if !flights.keys.is_empty() {
            let app = self.clone();
            self.tasks.spawn(async move { app.enqueue_rest(&framed, &materials, flights).await });
        }
        Ok((answer, committed))
    }

    /// Writes a brood; a worker that waits begins with its pictures meanwhile.
    async fn write_and_hand_out(
        self: &App,
        new: NewGeneration,
        errand: Option<Errand>,
    ) -> Result<(StoredGeneration, Committed), StorageError> {
        let write = self.store.create_generation_timed(new);
        let mut write = std::pin::pin!(write);
        // Asked for first: whatever becomes of the job is written behind its birth.
        if let std::task::Poll::Ready(refused) = poll!(write.as_mut()) {
            return refused;
        }
        let ticket = errand.map(|Errand { job, work, waiting }| self.hand_out(job, work, waiting));
        let born = write.await;
        if born.is_err()
            && let Some(ticket) = ticket
        {
            // There is no such job: its results are stale.
            self.dispatch.table.end(&ticket);
        }
        born
    }

    /// Queues the pictures beyond the first job. Those that find no room, or that a crash keeps from being queued, are
    /// rendered when somebody asks for them.
    async fn enqueue_rest(&self, framed: &Framed, materials: &[Wanted], mut flights: Flights) {
        while !flights.keys.is_empty() {
            let batch = FrameId::pictures_per_job(&framed.frame).min(flights.keys.len());
            let work = render_work(&framed.frame, items(&flights.keys[..batch], materials));
            let job = queued_job(Queue::Batch, encode(&work));
            if let Err(error) = self.store.enqueue(job, limit::QUEUED_JOBS).await {
                let pictures = flights.keys.len();
                tracing::warn!(%error, pictures, "the rest of a brood is left until it is asked for");
                return;
            }
            flights.keys.drain(..batch);
            self.dispatch.bell.notify_one();
        }
    }
}

/// A picture, whose it is, and what it is made of.
type Wanted = (PictureKey, IndividualId, Arc<Material>);

/// The materials of pictures, each once, in the order of the keys.
fn items<'a>(
    keys: &[PictureKey],
    materials: &'a [Wanted],
) -> impl Iterator<Item = (PictureKey, &'a Material)> {
    keys.iter().filter_map(|key| {
        let (_, _, material) = materials.iter().find(|(known, ..)| known == key)?;
        Some((*key, material.as_ref()))
    })
}

/// A brood that is ready to be written, and what is to be told of it then.
struct Birth {
    new: NewGeneration,
    errand: Option<Errand>,
    answer: Generation,
    framed: Arc<Framed>,
    materials: Vec<Wanted>,
    flights: Flights,
    redraws: u64,
    twins: u64,
}

/// A job for a worker that waits.
struct Errand {
    job: JobId,
    work: RenderJob,
    waiting: Waiting,
}

/// What was made and how it was asked for.
pub(super) struct Brood {
    pub recording: Option<Recording>,
    pub seed: Seed,
    pub constraints: DialectConstraints,
    pub operator: &'static str,
    pub breed: Breed,
    pub children: Vec<Newborn>,
}

/// The step of a search that a brood is written with, and the ids that it has for its children.
pub(super) struct Recording {
    pub ids: Vec<IndividualId>,
    pub step: SearchStep,
}

/// Flights that have no job yet; they crash unless they get one.
struct Flights {
    app: App,
    keys: Vec<PictureKey>,
}

impl Drop for Flights {
    fn drop(&mut self) {
        if !self.keys.is_empty() {
            self.app.gallery.crash(self.keys.iter().copied(), &Failure::Busy);
        }
    }
}

fn stored(
    new: &NewIndividual,
    lineage: &Lineage,
    generation: GenerationId,
    parents: &[ParentRef],
) -> StoredIndividual {
    StoredIndividual {
        id: new.id,
        lineage: lineage.id,
        generation,
        hash: new.hash,
        program_hash: new.program_hash,
        slot: new.slot,
        parents: parents.to_vec(),
        operator: new.operator.to_owned(),
        live_instructions: new.live_instructions,
        layers: new.layers.clone(),
        attempts: new.attempts,
        twin: new.twin,
        favourite: false,
        note: String::new(),
        version: 1,
    }
}
