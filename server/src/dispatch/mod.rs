//! Job dispatch: picture requests become jobs, jobs become leases, and results become pictures.
//!
//! [`lease`] serves workers, the same for all kinds of jobs, with the waiting workers in [`queue`].
//! [`kind`] defines what differs. The kinds are services: [`PictureService`], which serves picture
//! requests by render jobs, [`Searches`] and [`Exports`]. Leases of render jobs are in [`table`],
//! those of searches and exports in the store. Render jobs wait in [`render_queue`], ordered by
//! [`turns`]; [`history`] keeps finished ones, [`admission`] refuses births while the interactive
//! queue is full.

mod admission;
mod export;
mod history;
mod kind;
mod lease;
mod pictures;
mod queue;
mod render_job;
mod render_queue;
mod request;
mod row;
mod search;
mod table;
mod turns;
mod workers;

pub use admission::admit_birth;
pub use export::{Exports, export_json};
pub use history::History;
pub use kind::{JobKind, Jobs, Lane};
pub use lease::{claim_lease, end_leases, try_end_leases};
pub use pictures::PictureService;
pub use render_queue::{JobState, RenderQueue};
pub use request::{FrameId, PictureRequest, queue_for, render_work};
pub use search::{Searches, search_json, whole_search};
pub use table::LeaseTable;
pub use workers::Workers;
