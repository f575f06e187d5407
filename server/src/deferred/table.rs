//! Table of deferred answers: a job for each request, with its answer once that is ready.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use axum::body::{Body, to_bytes};
use axum::response::{IntoResponse, Response};
use brood_protocol::{DeferredAnswer, JobId, JobStatus};
use bytes::Bytes;
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
    Running(AbortHandle),
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
            Self::Running(_) => None,
            Self::Cancelled { at_ms } | Self::Answered { at_ms, .. } => Some(*at_ms),
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Answered { answer, .. } => answer.body.len(),
            Self::Running(_) | Self::Cancelled { .. } => 0,
        }
    }
}

impl Job {
    fn status(&self) -> JobStatus {
        match &self.state {
            State::Running(_) => JobStatus::Running,
            State::Cancelled { .. } => JobStatus::Cancelled,
            State::Answered { answer, .. } if answer.is_error() => JobStatus::Failed,
            State::Answered { .. } => JobStatus::Succeeded,
        }
    }
}

impl Kept {
    /// Reads an answer to its end. An error answer has no body, only its problem.
    async fn of(response: Response) -> Self {
        let (mut head, body) = response.into_parts();
        let problem = head.extensions.remove::<Pending>();
        match to_bytes(body, limit::DEFERRED_BYTES).await {
            Ok(body) => Self { status: head.status, headers: head.headers, body, problem },
            Err(error) => {
                let words = format!("the answer has more than {} MiB", limit::DEFERRED_BYTES >> 20);
                let refused = ApiError::refused(words).with_inner(error.to_string());
                let (mut head, _) = refused.into_response().into_parts();
                let problem = head.extensions.remove::<Pending>();
                let (status, headers) = (head.status, head.headers);
                Self { status, headers, body: Bytes::new(), problem }
            }
        }
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
        Self { pictures, events, jobs: Mutex::default() }
    }

    /// Adds a job that keeps the answer of `task` once it is ready. Returns the job.
    ///
    /// # Errors
    /// 503 if too many answers are deferred; the task is cancelled.
    pub fn keep(
        self: &Arc<Self>,
        request: RequestOutline,
        progress: Arc<AnswerProgress>,
        task: JoinHandle<Response>,
    ) -> Result<DeferredAnswer, ApiError> {
        let id = JobId::fresh();
        {
            let mut jobs = self.lock();
            let running = jobs.values().filter(|job| job.state.ended_ms().is_none());
            let clients = running.map(|job| job.request.client).collect::<Vec<_>>();
            let own = clients.iter().filter(|client| **client == request.client).count();
            if clients.len() >= limit::DEFERRED_REQUESTS || own >= limit::CLIENT_DEFERRED {
                task.abort();
                let words = format!(
                    "at most {} answers are deferred at the same time, {} of one client; retry when \
                     one has ended",
                    limit::DEFERRED_REQUESTS,
                    limit::CLIENT_DEFERRED
                );
                return Err(ApiError::busy(words));
            }
            let state = State::Running(task.abort_handle());
            let created_ms = now_ms();
            let _ = jobs.insert(id, Job { request, created_ms, progress: progress.clone(), state });
        }
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
            Ok(response) => Kept::of(response).await,
            // `cancel` sets the state of the job.
            Err(error) if error.is_cancelled() => return,
            Err(error) => Kept::of(panicked(&error).into_response()).await,
        };
        self.end(id, State::Answered { at_ms: now_ms(), answer: Box::new(answer) });
    }

    /// Ends a running job. Returns false if there is none with this id.
    fn end(&self, id: JobId, state: State) -> bool {
        {
            let mut jobs = self.lock();
            make_space(&mut jobs, state.bytes());
            match jobs.get_mut(&id) {
                Some(job) if job.state.ended_ms().is_none() => job.state = state,
                _ => return false,
            }
        }
        if let Some(DeferredAnswer { state, reason, .. }) = self.job(id) {
            self.events.job(id, "state", &json!({ "id": id, "state": state, "reason": reason }));
        }
        true
    }

    /// Returns a job.
    pub fn job(&self, id: JobId) -> Option<DeferredAnswer> {
        let jobs = self.lock();
        let job = jobs.get(&id)?;
        let (state, ended_ms) = (job.status(), job.state.ended_ms());
        let answer = match &job.state {
            State::Answered { answer, .. } => Some(&**answer),
            State::Running(_) | State::Cancelled { .. } => None,
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
            State::Answered { answer, .. } => Ok(Kept::clone(answer).into_response()),
            State::Running(_) | State::Cancelled { .. } => {
                let state = job.status().name();
                Err(ApiError::conflict(format!("there is no answer: the job is {state}")))
            }
        })
    }

    /// Cancels a job; `None` if there is no such job.
    ///
    /// # Errors
    /// 409 if it has ended.
    pub fn cancel(&self, id: JobId) -> Option<Result<DeferredAnswer, ApiError>> {
        let running = match &self.lock().get(&id)?.state {
            State::Running(task) => Some(task.clone()),
            State::Cancelled { .. } | State::Answered { .. } => None,
        };
        let is_ended = match running {
            Some(task) => {
                task.abort();
                self.end(id, State::Cancelled { at_ms: now_ms() })
            }
            None => false,
        };
        let job = self.job(id)?;
        Some(match is_ended {
            true => Ok(job),
            false => {
                let state = job.state.name();
                let words = format!("the job has already ended: it is {state}");
                Err(ApiError::conflict(words))
            }
        })
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
        self.jobs.lock().expect("nothing panics under this lock")
    }
}

/// Deletes the jobs that ended first until an answer of this many bytes fits.
fn make_space(jobs: &mut HashMap<JobId, Job>, bytes: usize) {
    loop {
        let used: usize = jobs.values().map(|job| job.state.bytes()).sum();
        let ended = jobs.iter().filter_map(|(id, job)| Some((job.state.ended_ms()?, *id)));
        let ended: Vec<_> = ended.collect();
        if used + bytes <= limit::DEFERRED_BYTES && ended.len() < limit::DEFERRED_KEPT {
            return;
        }
        let Some((_, oldest)) = ended.into_iter().min() else { return };
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
        let job = deferred.keep(outline(), Arc::default(), task).unwrap();
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
