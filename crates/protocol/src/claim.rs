//! Messages that all kinds of jobs have in common: requests for a job, and tickets.

use std::fmt::{Debug, Display};
use std::hash::Hash;

use serde::{Serialize, de::DeserializeOwned};

use crate::{
    ExportGrant, ExportRequest, ExportTicket, JobId, LeaseGrant, LeaseId, LeaseRequest,
    LeaseTicket, SearchGrant, SearchRequest, SearchTicket,
};

/// Request of a worker for a job of one kind.
pub trait ClaimRequest: Serialize + Send + Sync {
    /// Lease that answers the request.
    type Grant: DeserializeOwned + Send;
    /// Route of the request.
    const ROUTE: &'static str;
}

/// Proof of a lease.
pub trait Ticket: Copy + Debug + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Key of the lease.
    type Key: Copy + Eq + Hash + Display + Debug + Send + Sync + 'static;
    /// Route of the leases of this kind.
    const ROUTE: &'static str;

    /// Returns the key.
    fn key(&self) -> Self::Key;

    /// Returns the epoch. A lease of another epoch is not valid any more.
    fn epoch(&self) -> u64;
}

impl ClaimRequest for LeaseRequest {
    type Grant = LeaseGrant;
    const ROUTE: &'static str = LeaseTicket::ROUTE;
}

impl ClaimRequest for SearchRequest {
    type Grant = SearchGrant;
    const ROUTE: &'static str = SearchTicket::ROUTE;
}

impl ClaimRequest for ExportRequest {
    type Grant = ExportGrant;
    const ROUTE: &'static str = ExportTicket::ROUTE;
}

impl Ticket for LeaseTicket {
    type Key = LeaseId;
    const ROUTE: &'static str = "/v1/leases";

    fn key(&self) -> LeaseId {
        self.lease
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }
}

impl Ticket for SearchTicket {
    type Key = JobId;
    const ROUTE: &'static str = "/v1/leases/searches";

    fn key(&self) -> JobId {
        self.job
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }
}

impl Ticket for ExportTicket {
    type Key = JobId;
    const ROUTE: &'static str = "/v1/leases/exports";

    fn key(&self) -> JobId {
        self.job
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }
}
