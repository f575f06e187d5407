//! Stores a brood in one transaction and queues render jobs for its missing pictures.
//!
//! A worker gets the first job while the transaction is still being written: a picture depends only
//! on its key, so a picture of a brood that was never committed is harmless. The 201 is sent after
//! the commit. A large brood's other jobs go to the batch queue, so that its first pictures come
//! early and do not delay other broods.

use std::collections::HashSet;
use std::sync::Arc;
use std::task::Poll;

use brood_genome::Model;
use brood_program::ProgramHash;
use brood_protocol::{Generation, GenerationId, IndividualId, JobId, Lineage, PictureKey, Queue};
use brood_storage::{CommitTimes, NewGeneration, NewGenome, NewIndividual, NewPicture};
use futures::poll;
use http::StatusCode;

use super::{Brood, Newborn};
use crate::answer::individual;
use crate::client::Client;
use crate::clock::now_ms;
use crate::dispatch::{FrameId, PictureService, render_work};
use crate::idempotency::Attempt;
use crate::library::{Framed, Material};
use crate::picture::{Failure, thumbnail_url};
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;

impl Brood {
    /// Stores the brood and starts rendering its pictures.
    ///
    /// Returns the generation and the job that renders its first pictures, if any must be rendered.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails, or if a child cannot be drawn in the lineage's scene.
    pub async fn deliver(
        self,
        service: &Arc<PictureService>,
        lineage: &Lineage,
        attempt: &Attempt,
        timing: &mut ServerTiming,
    ) -> Result<(Generation, Option<JobId>), ApiError> {
        let Self { framed, seed, parents, centre, operator, options, children, step } = self;
        for Newborn { child, .. } in &children {
            framed.check(&child.program)?;
        }
        let (id, created_ms) = (GenerationId::fresh(), now_ms());
        let mut materials: Vec<ChildPicture> = Vec::new();
        let mut pictures: Vec<NewPicture> = Vec::new();
        let mut individuals: Vec<NewIndividual> = Vec::new();
        let centre = centre.map(|(centre, material)| {
            let key = framed.key(material.program.hash());
            pictures.push(framed.row(key, centre.hash));
            materials.push((key, centre.id, material));
            individual(centre, key)
        });
        let mut redraws = 0;
        let mut twins = 0;
        for Newborn { id, child, bytes } in children {
            let key = framed.key(child.program_hash);
            pictures.push(framed.row(key, child.hash));
            redraws += u64::from(child.attempts - 1);
            twins += u64::from(child.twin);
            individuals.push(NewIndividual {
                id,
                slot: child.slot,
                genome: Arc::new(NewGenome {
                    hash: child.hash,
                    bytes,
                    program_hash: *child.program_hash.as_bytes(),
                    live_instructions: child.live_instructions,
                    layers: child.genome.layers().iter().map(Model::kind).collect(),
                }),
                operator,
                attempts: child.attempts,
                twin: child.twin,
            });
            let material =
                service.library.insert_material(child.hash, child.genome, child.program).await;
            materials.push((key, id, material));
        }
        for row in &pictures {
            service.cache.insert_row(&Arc::new(row.clone()));
        }
        let answer = Generation {
            id,
            lineage: lineage.id,
            index: 0,
            seed,
            parents: parents.clone(),
            centre,
            options: options.clone(),
            individuals: individuals
                .iter()
                .map(|new| {
                    let program = ProgramHash::from_bytes(new.genome.program_hash);
                    individual(new.stored(lineage.id, id, &parents), framed.key(program))
                })
                .collect(),
            created_ms,
        };

        let client = Client::current();
        let reserved = service.cache.reserve(materials.iter().map(|(key, ..)| *key));
        let distinct: HashSet<_> = materials.iter().map(|(key, ..)| *key).collect();
        service.metrics.shared.increment((materials.len() - distinct.len()) as u64);
        service.metrics.skipped.increment((distinct.len() - reserved.len()) as u64);
        let new = NewGeneration {
            id,
            lineage: lineage.id,
            seed,
            parents,
            centre: answer.centre.as_ref().map(|centre| centre.id),
            options,
            created_ms,
            individuals,
            pictures,
            search: step,
            idempotency: attempt.record(StatusCode::CREATED, &answer),
        };
        let reservations = Reservations { service: service.clone(), keys: reserved, client };
        let birth = Birth { new, answer, framed, materials, reservations, redraws, twins };
        timing.end("prepare");
        // Runs in a separate task: committed changes must be published even if the client
        // disconnects.
        let born = service.jobs.tasks.spawn(birth.complete(service.clone()));
        let born = born.await.map_err(|error| ApiError::internal(error.to_string()))?;
        let (generation, committed, job) = born?;
        timing.note("queue", committed.queued);
        timing.note("write", committed.written);
        timing.note("commit", committed.synced);
        timing.end("birth");
        Ok((generation, job))
    }
}

/// Brood that is ready to be written, and the data to publish after the commit.
struct Birth {
    new: NewGeneration,
    answer: Generation,
    framed: Arc<Framed>,
    materials: Vec<ChildPicture>,
    reservations: Reservations,
    redraws: u64,
    twins: u64,
}

impl Birth {
    /// Writes the brood, then publishes it. A worker starts on its pictures before the commit.
    async fn complete(
        self,
        service: Arc<PictureService>,
    ) -> Result<(Generation, CommitTimes, Option<JobId>), ApiError> {
        let Self { new, mut answer, framed, materials, mut reservations, redraws, twins } = self;
        let write = service.store.create_generation_timed(new);
        let mut write = std::pin::pin!(write);
        // Polled once first, so that the brood's write is queued before the worker is busy.
        let (job, written) = match poll!(write.as_mut()) {
            Poll::Ready(written) => (None, written),
            Poll::Pending => {
                (reservations.hand_out(Queue::Interactive, &framed, &materials), write.await)
            }
        };
        let (born, committed) = written?;
        answer.index = born.index;
        service.metrics.breeds.increment(1);
        service.metrics.births.increment(answer.individuals.len() as u64);
        service.metrics.redraws.increment(redraws);
        service.metrics.twins.increment(twins);
        service.events.generation(answer.lineage, answer.id);
        for (key, individual, _) in &materials {
            // Subscribe before checking: a picture completed in between is still published.
            service.cache.add_listener(*key, answer.lineage, *individual);
            if service.cache.has(*key) {
                for (lineage, individual) in service.cache.take_listeners(*key) {
                    service.events.thumbnail(lineage, individual, &thumbnail_url(*key));
                }
            }
        }
        // Without a first job the queue is full: the pictures are rendered on request.
        if job.is_some() && !reservations.keys.is_empty() {
            service.jobs.tasks.spawn(async move { reservations.queue_rest(&framed, &materials) });
        }
        Ok((answer, committed, job))
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

/// Reserved pictures without a job; they fail on drop unless they get one.
struct Reservations {
    service: Arc<PictureService>,
    keys: Vec<PictureKey>,
    client: Client,
}

impl Reservations {
    /// Hands out a job for the first pictures. Returns `None` if there are none, or if the queue
    /// takes no more jobs.
    fn hand_out(
        &mut self,
        queue: Queue,
        framed: &Framed,
        materials: &[ChildPicture],
    ) -> Option<JobId> {
        let batch = FrameId::pictures_per_job(&framed.frame).min(self.keys.len());
        if batch == 0 {
            return None;
        }
        let work = render_work(&framed.frame, items(&self.keys[..batch], materials));
        let job = self.service.hand_out(work, queue, self.client).ok()?;
        self.keys.drain(..batch);
        Some(job)
    }

    /// Queues the pictures beyond the first job. Pictures that do not fit in the queue, or that the
    /// end of the process loses, are rendered on the first request.
    fn queue_rest(mut self, framed: &Framed, materials: &[ChildPicture]) {
        while self.hand_out(Queue::Batch, framed, materials).is_some() {}
        let pictures = self.keys.len();
        if pictures > 0 {
            tracing::warn!(
                pictures,
                "the queue is full: the rest of a brood is rendered on request"
            );
        }
    }
}

impl Drop for Reservations {
    fn drop(&mut self) {
        if !self.keys.is_empty() {
            self.service.cache.fail(self.keys.iter().copied(), &Failure::Busy);
        }
    }
}
