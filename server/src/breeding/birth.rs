//! Stores a brood in one transaction and queues render jobs for its missing pictures.
//!
//! The first job is part of the transaction. A waiting worker gets it while the transaction is
//! still being synced: a picture depends only on its key, so a picture of a brood that was never
//! committed is harmless. The 201 is sent after the commit. A large brood's other jobs go to the
//! batch queue, so that its first pictures come early and do not delay other broods.

use std::collections::HashSet;
use std::sync::Arc;

use brood_genome::Model;
use brood_program::ProgramHash;
use brood_protocol::{
    BreedOptions, Generation, GenerationId, IndividualId, JobId, Lineage, ParentRef, PictureKey,
    RenderJob, Seed, encode,
};
use brood_storage::{
    CommitTimes, NewGeneration, NewIndividual, NewJob, NewPicture, Queue, SearchStep, StorageError,
    StoredGeneration,
};
use futures::poll;
use http::StatusCode;

use super::{Newborn, Parent};
use crate::clock::now_ms;
use crate::dispatch::{FrameId, Render, WaitingWorker, queued_job, render_work};
use crate::idempotency::Attempt;
use crate::library::{Framed, Material};
use crate::limit;
use crate::picture::Failure;
use crate::presenter::{individual, thumbnail_url};
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;
use crate::state::{App, AppState};

impl AppState {
    /// Stores a brood and starts rendering its pictures.
    pub(super) async fn birth(
        self: &App,
        lineage: &Lineage,
        framed: &Arc<Framed>,
        parents: &[Parent],
        brood: Brood,
        attempt: &Attempt,
        timing: &mut ServerTiming,
    ) -> Result<(Generation, Option<JobId>), ApiError> {
        let centre = parents.first().filter(|parent| parent.individual.is_some());
        let (id, created_ms) = (GenerationId::fresh(), now_ms());
        let (ids, search) = match brood.recording {
            Some(Recording { ids, step }) => (ids, Some(step)),
            None => (brood.children.iter().map(|_| IndividualId::fresh()).collect(), None),
        };
        let mut materials: Vec<ChildPicture> = Vec::new();
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
            let material = self.library.insert_material(child.hash, child.genome, child.program);
            materials.push((key, *id, material));
        }
        for row in &pictures {
            self.picture_cache.insert_row(&Arc::new(row.clone()));
        }
        let answer = Generation {
            id,
            lineage: lineage.id,
            index: 0,
            seed: brood.seed,
            parents: brood.parents.clone(),
            centre: centre.and_then(|parent| {
                let key = framed.key(parent.material.program.hash());
                Some(individual(parent.individual.clone()?, key))
            }),
            options: brood.options.clone(),
            individuals: individuals
                .iter()
                .map(|new| {
                    let stored = new.stored(lineage.id, id, &brood.parents);
                    let program = ProgramHash::from_bytes(new.program_hash);
                    individual(stored, framed.key(program))
                })
                .collect(),
            created_ms,
        };

        let reserved = self.picture_cache.reserve(materials.iter().map(|(key, ..)| *key));
        let distinct: HashSet<_> = materials.iter().map(|(key, ..)| *key).collect();
        self.metrics.shared.increment((materials.len() - distinct.len()) as u64);
        self.metrics.skipped.increment((distinct.len() - reserved.len()) as u64);
        let batch = FrameId::pictures_per_job(&framed.frame);
        let first = reserved.get(..batch).unwrap_or(&reserved);
        let direct = (!first.is_empty()).then(|| {
            let work = render_work(&framed.frame, items(first, &materials));
            (JobId::fresh(), work, self.dispatch.renders.waiting.next())
        });
        let job = direct.as_ref().map(|(id, work, waiting)| NewJob {
            id: *id,
            leased_to: waiting.as_ref().map(|waiting| waiting.worker.clone()),
            ..queued_job(Queue::Interactive, encode(work))
        });
        let job_id = job.as_ref().map(|job| job.id);
        let direct = direct.and_then(|(job, work, waiting)| {
            waiting.map(|waiting| DirectDispatch { job, work, waiting })
        });
        let new = NewGeneration {
            id,
            lineage: lineage.id,
            seed: brood.seed,
            parents: brood.parents,
            centre: answer.centre.as_ref().map(|centre| centre.id),
            options: brood.options,
            created_ms,
            individuals,
            pictures,
            job,
            search,
            idempotency: attempt.record(StatusCode::CREATED, &answer),
        };
        let reservations = Reservations { app: self.clone(), keys: reserved };
        let framed = framed.clone();
        let birth = Birth { new, direct, answer, framed, materials, reservations, redraws, twins };
        timing.end("prepare");
        let app = self.clone();
        // Runs in a separate task: committed changes must be published even if the client
        // disconnects.
        let born = self.tasks.spawn(async move { app.deliver(birth).await });
        let born = born.await.map_err(|error| ApiError::internal(error.to_string()))?;
        let (generation, committed) = born?;
        timing.note("queue", committed.queued);
        timing.note("write", committed.written);
        timing.note("commit", committed.synced);
        timing.end("birth");
        Ok((generation, job_id))
    }

    /// Writes a brood, then publishes it.
    async fn deliver(self: App, birth: Birth) -> Result<(Generation, CommitTimes), ApiError> {
        let Birth { new, direct, mut answer, framed, materials, mut reservations, redraws, twins } =
            birth;
        let (born, committed) = self.write_and_dispatch(new, direct).await?;
        let batch = FrameId::pictures_per_job(&framed.frame).min(reservations.keys.len());
        reservations.keys.drain(..batch);
        self.dispatch.renders.notify.notify_one();
        answer.index = born.index;
        self.metrics.breeds.increment(1);
        self.metrics.births.increment(answer.individuals.len() as u64);
        self.metrics.redraws.increment(redraws);
        self.metrics.twins.increment(twins);
        self.events.generation(answer.lineage, answer.id);
        for (key, individual, _) in &materials {
            // Subscribe before checking: a picture completed in between is still published.
            self.picture_cache.add_listener(*key, answer.lineage, *individual);
            if self.picture_cache.has(*key) {
                for (lineage, individual) in self.picture_cache.take_listeners(*key) {
                    self.events.thumbnail(lineage, individual, &thumbnail_url(*key));
                }
            }
        }
        if !reservations.keys.is_empty() {
            let app = self.clone();
            self.tasks
                .spawn(async move { app.enqueue_rest(&framed, &materials, reservations).await });
        }
        Ok((answer, committed))
    }

    /// Writes a brood; a waiting worker starts on its pictures before the commit.
    async fn write_and_dispatch(
        self: &App,
        new: NewGeneration,
        direct: Option<DirectDispatch>,
    ) -> Result<(StoredGeneration, CommitTimes), StorageError> {
        let write = self.store.create_generation_timed(new);
        let mut write = std::pin::pin!(write);
        // Polled once first, so that the brood's write is queued before any write about the job.
        if let std::task::Poll::Ready(refused) = poll!(write.as_mut()) {
            return refused;
        }
        let ticket = direct
            .map(|DirectDispatch { job, work, waiting }| self.grant_directly(job, work, waiting));
        let born = write.await;
        if born.is_err()
            && let Some(ticket) = ticket
        {
            // The job was not stored, so its results must be rejected.
            self.dispatch.renders.leases.end(&ticket);
        }
        born
    }

    /// Queues the pictures beyond the first job. Pictures that do not fit in the queue, or that a
    /// crash loses, are rendered on the first request.
    async fn enqueue_rest(
        &self,
        framed: &Framed,
        materials: &[ChildPicture],
        mut reservations: Reservations,
    ) {
        while !reservations.keys.is_empty() {
            let batch = FrameId::pictures_per_job(&framed.frame).min(reservations.keys.len());
            let work = render_work(&framed.frame, items(&reservations.keys[..batch], materials));
            let job = queued_job(Queue::Batch, encode(&work));
            if let Err(error) = self.store.enqueue(job, limit::QUEUED_JOBS).await {
                let pictures = reservations.keys.len();
                tracing::warn!(%error, pictures, "the queue is full: the rest of a brood is rendered on request");
                return;
            }
            reservations.keys.drain(..batch);
            self.dispatch.renders.notify.notify_one();
        }
    }
}

/// Picture of an individual: key, individual and material.
type ChildPicture = (PictureKey, IndividualId, Arc<Material>);

/// Returns each key with its material, in the order of the keys.
fn items<'a>(
    keys: &[PictureKey],
    materials: &'a [ChildPicture],
) -> impl Iterator<Item = (PictureKey, &'a Material)> {
    keys.iter().filter_map(|key| {
        let (_, _, material) = materials.iter().find(|(known, ..)| known == key)?;
        Some((*key, material.as_ref()))
    })
}

/// Brood that is ready to be written, and the data to publish after the commit.
struct Birth {
    new: NewGeneration,
    direct: Option<DirectDispatch>,
    answer: Generation,
    framed: Arc<Framed>,
    materials: Vec<ChildPicture>,
    reservations: Reservations,
    redraws: u64,
    twins: u64,
}

/// Job for a worker that is already waiting.
struct DirectDispatch {
    job: JobId,
    work: RenderJob,
    waiting: WaitingWorker<Render>,
}

/// Children and the request they came from.
pub(super) struct Brood {
    pub recording: Option<Recording>,
    pub seed: Seed,
    pub parents: Vec<ParentRef>,
    pub operator: &'static str,
    pub options: BreedOptions,
    pub children: Vec<Newborn>,
}

/// Search step to write in the same transaction, and the ids of the children.
pub(super) struct Recording {
    pub ids: Vec<IndividualId>,
    pub step: SearchStep,
}

/// Reserved pictures without a job; they fail on drop unless they get one.
struct Reservations {
    app: App,
    keys: Vec<PictureKey>,
}

impl Drop for Reservations {
    fn drop(&mut self) {
        if !self.keys.is_empty() {
            self.app.picture_cache.fail(self.keys.iter().copied(), &Failure::Busy);
        }
    }
}
