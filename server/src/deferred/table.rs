//! Table of deferred answers: a job for each request, with its answer once that is ready.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::body::{Body, to_bytes};
use axum::response::{IntoResponse, Response};
use brood_protocol::{DeferredAnswer, JobId, JobStatus};
use bytes::Bytes;
use http::response::Parts;
use http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use serde_json::json;
use tokio::task::{AbortHandle, JoinError, JoinHandle};

use super::progress::AnswerProgress;
use crate::client::Client;
use crate::clock::now_ms;
use crate::dispatch::PictureService;
use crate::event::Events;
use crate::limit;
use crate::problem::{ApiError, Pending};

/// Interval at which the progress of running requests is published.
const TICK: Duration = Duration::from_millis(500);

/// Deferred answers of all clients.
pub struct Deferred {
    pictures: Arc<PictureService>,
    events: Arc<Events>,
    jobs: Mutex<HashMap<JobId, Job>>,
    taken: Places,
}

/// Number of places that each client has taken.
type Places = Arc<Mutex<HashMap<Client, usize>>>;

/// Place of a request whose answer may be deferred; free again when this is dropped.
pub struct DeferredPlace {
    client: Client,
    taken: Places,
}

impl Drop for DeferredPlace {
    fn drop(&mut self) {
        let mut taken = lock(&self.taken);
        if let Some(own) = taken.get_mut(&self.client) {
            *own -= 1;
            if *own == 0 {
                taken.remove(&self.client);
            }
        }
    }
}

/// Method, address and client of a request.
#[derive(Debug, Clone)]
pub struct RequestOutline {
    /// Method.
    pub method: Method,
    /// Address.
    pub uri: Uri,
    /// Client that sent it.
    pub client: Client,
}

struct Job {
    request: RequestOutline,
    created_ms: i64,
    progress: Arc<AnswerProgress>,
    state: State,
}

enum State {
    Running { task: AbortHandle, _place: DeferredPlace },
    Cancelled { at_ms: i64 },
    Answered { at_ms: i64, answer: Box<Kept> },
}

/// Answer of a request.
#[derive(Debug, Clone)]
struct Kept {
    status: StatusCode,
    headers: HeaderMap,
    body: Bytes,
    /// Problem of an error answer.
    problem: Option<Pending>,
}

impl State {
    fn ended_ms(&self) -> Option<i64> {
        match self {
            Self::Running { .. } => None,
            Self::Cancelled { at_ms } | Self::Answered { at_ms, .. } => Some(*at_ms),
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Answered { answer, .. } => answer.body.len(),
            Self::Running { .. } | Self::Cancelled { .. } => 0,
        }
    }
}

impl Job {
    fn status(&self) -> JobStatus {
        match &self.state {
            State::Running { .. } => JobStatus::Running,
            State::Cancelled { .. } => JobStatus::Cancelled,
            State::Answered { answer, .. } if answer.is_error() => JobStatus::Failed,
            State::Answered { .. } => JobStatus::Succeeded,
        }
    }
}

impl Kept {
    /// Reads the answer of a job to its end. An error answer has no body, only its problem, whose
    /// details go to the log.
    async fn of(id: JobId, response: Response) -> Self {
        let (head, body) = match read(response).await {
            Ok(read) => read,
            Err(refused) => (refused.into_response().into_parts().0, Bytes::new()),
        };
        let Parts { status, headers, mut extensions, .. } = head;
        let mut problem = extensions.remove::<Pending>();
        if let Some(inner) = problem.as_mut().and_then(|problem| problem.inner.take()) {
            match status.is_server_error() {
                true => tracing::error!(%id, reason = %inner, "a deferred request failed"),
                false => tracing::debug!(%id, reason = %inner, "a deferred request was refused"),
            }
        }
        Self { status, headers, body, problem }
    }

    fn is_error(&self) -> bool {
        self.status.is_client_error() || self.status.is_server_error()
    }

    fn reason(&self) -> Option<String> {
        let problem = self.problem.as_ref().map(|pending| pending.problem.detail.clone());
        self.is_error().then(|| problem.unwrap_or_else(|| self.status.to_string()))
    }
}

impl IntoResponse for Kept {
    fn into_response(self) -> Response {
        let mut response = Response::new(Body::from(self.body));
        *response.status_mut() = self.status;
        *response.headers_mut() = self.headers;
        let headers = response.headers_mut();
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Some(problem) = self.problem {
            response.extensions_mut().insert(problem);
        }
        response
    }
}

impl Deferred {
    /// Creates an empty table.
    pub fn new(pictures: Arc<PictureService>, events: Arc<Events>) -> Self {
        Self { pictures, events, jobs: Mutex::default(), taken: Places::default() }
    }

    /// Returns a place for a request whose answer may be deferred.
    ///
    /// # Errors
    /// 503 if too many answers are deferred.
    pub fn place(&self, client: Client) -> Result<DeferredPlace, ApiError> {
        let mut taken = lock(&self.taken);
        let own = taken.get(&client).copied().unwrap_or(0);
        let all: usize = taken.values().sum();
        if all >= limit::DEFERRED_REQUESTS || own >= limit::CLIENT_DEFERRED {
            let words = format!(
                "at most {} answers are deferred at the same time, {} of one client; retry when \
                 one has ended",
                limit::DEFERRED_REQUESTS,
                limit::CLIENT_DEFERRED
            );
            return Err(ApiError::busy(words));
        }
        taken.insert(client, own + 1);
        Ok(DeferredPlace { client, taken: self.taken.clone() })
    }

    /// Adds a job that keeps the answer of `task` once it is ready. Returns the job.
    ///
    /// # Errors
    /// 500 if the job is lost.
    pub fn keep(
        self: &Arc<Self>,
        (request, place): (RequestOutline, DeferredPlace),
        progress: Arc<AnswerProgress>,
        task: JoinHandle<Response>,
    ) -> Result<DeferredAnswer, ApiError> {
        let id = JobId::fresh();
        let state = State::Running { task: task.abort_handle(), _place: place };
        let job = Job { request, created_ms: now_ms(), progress: progress.clone(), state };
        self.lock().insert(id, job);
        let own = self.clone();
        self.pictures.jobs.tasks.spawn(async move { own.follow(id, progress, task).await });
        self.job(id).ok_or_else(|| ApiError::internal("a deferred answer was lost"))
    }

    /// Publishes the progress of a request until it is answered, then keeps its answer.
    async fn follow(
        &self,
        id: JobId,
        progress: Arc<AnswerProgress>,
        mut task: JoinHandle<Response>,
    ) {
        let (mut published, mut tick) = (0.0, tokio::time::interval(TICK));
        let response = loop {
            tokio::select! {
                response = &mut task => break response,
                // Its answer would be lost with the process.
                () = self.pictures.jobs.stopping.cancelled() => return task.abort(),
                _ = tick.tick() => {
                    let share = self.share(&progress);
                    if share > published {
                        published = share;
                        self.events.job(id, "progress", &json!({ "id": id, "progress": share }));
                    }
                }
            }
        };
        let answer = match response {
            Ok(response) => Kept::of(id, response).await,
            // `cancel` sets the state of the job.
            Err(error) if error.is_cancelled() => return,
            Err(error) => Kept::of(id, panicked(&error).into_response()).await,
        };
        self.end(id, State::Answered { at_ms: now_ms(), answer: Box::new(answer) });
    }

    /// Sets the final state of a job. A job that has ended stays as it is.
    fn end(&self, id: JobId, state: State) {
        {
            let mut jobs = self.lock();
            let running = jobs.get(&id).filter(|job| job.state.ended_ms().is_none());
            let Some(client) = running.map(|job| job.request.client) else { return };
            make_space(&mut jobs, client, state.bytes());
            if let Some(job) = jobs.get_mut(&id) {
                job.state = state;
            }
        }
        if let Some(DeferredAnswer { state, reason, .. }) = self.job(id) {
            self.events.job(id, "state", &json!({ "id": id, "state": state, "reason": reason }));
        }
    }

    /// Returns a job.
    pub fn job(&self, id: JobId) -> Option<DeferredAnswer> {
        let jobs = self.lock();
        let job = jobs.get(&id)?;
        let (state, ended_ms) = (job.status(), job.state.ended_ms());
        let answer = match &job.state {
            State::Answered { answer, .. } => Some(&**answer),
            State::Running { .. } | State::Cancelled { .. } => None,
        };
        let ttl = i64::try_from(limit::DEFERRED_TTL.as_millis()).unwrap_or(i64::MAX);
        let is_done = state == JobStatus::Succeeded;
        Some(DeferredAnswer {
            id,
            kind: "answer".to_owned(),
            state,
            reason: answer.and_then(Kept::reason),
            progress: if is_done { 1.0 } else { self.share(&job.progress) },
            method: job.request.method.to_string(),
            request: job.request.uri.to_string(),
            status: answer.map(|answer| answer.status.as_u16()),
            answer: answer.map(|_| format!("/v1/jobs/{id}/answer")),
            created_ms: job.created_ms,
            ended_ms,
            expires_ms: ended_ms.map(|ended| ended.saturating_add(ttl)),
        })
    }

    /// Returns the answer of a job; `None` if there is no such job.
    ///
    /// # Errors
    /// 409 if there is no answer: the job is running or was cancelled.
    pub fn answer(&self, id: JobId) -> Option<Result<Response, ApiError>> {
        let jobs = self.lock();
        let job = jobs.get(&id)?;
        Some(match &job.state {
            // Clients repeat requests that are answered with 503; this answer stays the same.
            State::Answered { answer, .. } if answer.status == StatusCode::SERVICE_UNAVAILABLE => {
                let reason = answer.reason().unwrap_or_default();
                let words = format!("the request failed: {reason}; send it again");
                Err(ApiError::conflict(words))
            }
            State::Answered { answer, .. } => Ok(Kept::clone(answer).into_response()),
            State::Running { .. } | State::Cancelled { .. } => {
                let state = job.status().name();
                Err(ApiError::conflict(format!("there is no answer: the job is {state}")))
            }
        })
    }

    /// Cancels a job; `None` if there is no such job. Nothing changes if it is cancelled already.
    ///
    /// # Errors
    /// 409 if it has an answer.
    pub fn cancel(&self, id: JobId) -> Option<Result<DeferredAnswer, ApiError>> {
        let running = match &self.lock().get(&id)?.state {
            State::Running { task, .. } => Some(task.clone()),
            State::Cancelled { .. } | State::Answered { .. } => None,
        };
        if let Some(task) = running {
            task.abort();
            self.end(id, State::Cancelled { at_ms: now_ms() });
        }
        let job = self.job(id)?;
        Some(match job.state {
            JobStatus::Cancelled => Ok(job),
            _ => {
                let state = job.state.name();
                let words = format!("the job has already ended: it is {state}");
                Err(ApiError::conflict(words))
            }
        })
    }

    /// Client that a job belongs to; `None` if there is no such job.
    pub fn client(&self, id: JobId) -> Option<Client> {
        Some(self.lock().get(&id)?.request.client)
    }

    /// Number of requests that are being answered.
    pub fn running(&self) -> usize {
        self.lock().values().filter(|job| job.state.ended_ms().is_none()).count()
    }

    /// Deletes jobs that have expired.
    pub fn sweep(&self) {
        let ttl = i64::try_from(limit::DEFERRED_TTL.as_millis()).unwrap_or(i64::MAX);
        let oldest = now_ms() - ttl;
        self.lock().retain(|_, job| job.state.ended_ms().is_none_or(|ended| ended >= oldest));
    }

    fn share(&self, progress: &AnswerProgress) -> f64 {
        progress.share(|key| self.pictures.cache.progress(key))
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<JobId, Job>> {
        lock(&self.jobs)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads a response to its end.
///
/// # Errors
/// 422 if it is too large.
async fn read(response: Response) -> Result<(Parts, Bytes), ApiError> {
    let (head, body) = response.into_parts();
    let read = to_bytes(body, limit::DEFERRED_BYTES).await;
    let words = || format!("the answer has more than {} MiB", limit::DEFERRED_BYTES >> 20);
    let body = read.map_err(|error| ApiError::refused(words()).with_inner(error.to_string()))?;
    Ok((head, body))
}

/// Deletes jobs that have ended until an answer of this many bytes of a client fits: those of the
/// client first, the oldest first.
fn make_space(jobs: &mut HashMap<JobId, Job>, client: Client, bytes: usize) {
    loop {
        let used: usize = jobs.values().map(|job| job.state.bytes()).sum();
        let ended = jobs.iter().filter_map(|(id, job)| {
            Some((job.request.client != client, job.state.ended_ms()?, *id))
        });
        let ended: Vec<_> = ended.collect();
        if used + bytes <= limit::DEFERRED_BYTES && ended.len() < limit::DEFERRED_KEPT {
            return;
        }
        let Some((_, _, oldest)) = ended.into_iter().min() else { return };
        jobs.remove(&oldest);
    }
}

fn panicked(error: &JoinError) -> ApiError {
    ApiError::internal(format!("a handler panicked: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ServerConfig;
    use crate::server::Server;

    fn outline() -> RequestOutline {
        let (method, uri) = (Method::GET, Uri::from_static("/v1/slow.png"));
        RequestOutline { method, uri, client: Client::Server }
    }

    async fn deferred() -> (tempfile::TempDir, Arc<Deferred>) {
        let dir = tempfile::tempdir().unwrap();
        let config = ServerConfig::new("127.0.0.1:0".parse().unwrap(), dir.path().to_owned());
        let app = Server::bind(config).await.unwrap().app();
        (dir, app.deferred.clone())
    }

    /// Defers an answer, and waits until its job has ended.
    async fn ended(deferred: &Arc<Deferred>, task: JoinHandle<Response>) -> DeferredAnswer {
        let job = {
            let place = deferred.place(Client::Server).unwrap();
            deferred.keep((outline(), place), Arc::default(), task).unwrap()
        };
        loop {
            match deferred.job(job.id).unwrap() {
                job if job.state == JobStatus::Running => tokio::task::yield_now().await,
                job => return job,
            }
        }
    }

    #[tokio::test]
    async fn refused_request_is_a_failed_job_whose_answer_is_the_problem() {
        let (_dir, deferred) = deferred().await;
        let slow = async { ApiError::refused("too green").at("/count").into_response() };
        let job = ended(&deferred, tokio::spawn(slow)).await;
        assert_eq!((job.state, job.status), (JobStatus::Failed, Some(422)));
        assert_eq!(job.reason.as_deref(), Some("too green"));
        let answer = deferred.answer(job.id).unwrap().unwrap();
        let problem = &answer.extensions().get::<Pending>().unwrap().problem;
        assert_eq!((answer.status().as_u16(), problem.pointer.as_deref()), (422, Some("/count")));
    }

    #[tokio::test]
    async fn request_that_the_server_was_too_busy_for_is_not_answered_with_503_again() {
        let (_dir, deferred) = deferred().await;
        let busy = async { ApiError::busy("too many pictures are queued").into_response() };
        let job = ended(&deferred, tokio::spawn(busy)).await;
        assert_eq!((job.state, job.status), (JobStatus::Failed, Some(503)));
        let error = deferred.answer(job.id).unwrap().unwrap_err();
        assert_eq!(error.status(), 409);
        assert!(error.problem().detail.contains("too many pictures"), "{error:?}");
    }

    #[tokio::test]
    async fn places_are_free_again_when_requests_end() {
        let (_dir, deferred) = deferred().await;
        let never = || tokio::spawn(std::future::pending());
        let mut jobs = Vec::new();
        for _ in 0..limit::CLIENT_DEFERRED {
            let place = deferred.place(Client::Server).unwrap();
            jobs.push(deferred.keep((outline(), place), Arc::default(), never()).unwrap().id);
        }
        assert_eq!(deferred.place(Client::Server).err().unwrap().status(), 503);
        assert!(deferred.place(Client::Token([1; 32])).is_ok());
        for _ in 0..2 {
            let cancelled = deferred.cancel(jobs[0]).unwrap().unwrap();
            assert_eq!(cancelled.state, JobStatus::Cancelled);
        }
        drop(deferred.place(Client::Server).unwrap());
        deferred.place(Client::Server).unwrap();
    }

    #[tokio::test]
    async fn request_that_panics_is_a_failed_job() {
        let (_dir, deferred) = deferred().await;
        let job = ended(&deferred, tokio::spawn(async { panic!("no") })).await;
        assert_eq!((job.state, job.status), (JobStatus::Failed, Some(500)));
        assert!(!job.reason.unwrap().contains("no"), "details are for the log only");
    }

    #[tokio::test]
    async fn oldest_answers_are_deleted_for_new_ones_and_too_large_answers_are_refused() {
        let (_dir, deferred) = deferred().await;
        let answer = |bytes: usize| tokio::spawn(async move { vec![0_u8; bytes].into_response() });
        let mut jobs = Vec::new();
        for _ in 0..5 {
            jobs.push(ended(&deferred, answer(limit::DEFERRED_BYTES / 4)).await.id);
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
        let kept: Vec<bool> = jobs.iter().map(|id| deferred.job(*id).is_some()).collect();
        assert_eq!(kept, [false, true, true, true, true]);
        let large = ended(&deferred, answer(limit::DEFERRED_BYTES + 1)).await;
        assert_eq!(large.reason.as_deref(), Some("the answer has more than 64 MiB"));
    }
}
