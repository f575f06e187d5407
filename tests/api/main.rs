//! Tests of the HTTP interface from outside: a real server on a free port, one file per resource.

#![expect(
    clippy::unwrap_used,
    reason = "this is a test; clippy only knows those with an attribute"
)]

mod access;
mod archive;
mod attack;
mod backend;
mod blobs;
mod breed;
mod bumps;
mod circle;
mod command_line;
mod comparison;
mod control_image;
mod deferred;
mod develop;
mod edit;
mod energy;
mod event;
mod evolve;
mod export;
mod export_job;
mod fair;
mod far;
mod fit;
mod fit_image;
mod gallery;
mod genome;
mod guide;
mod idempotency;
mod individual;
mod islands;
mod job;
mod light;
mod lineage;
mod lineage_list;
mod lock;
mod mesh;
mod model;
mod operation;
mod painted;
mod painting;
mod picture;
mod preset;
mod rolling_upgrade;
mod scene;
mod scene_image;
mod search;
mod several_servers;
mod start;
mod target;
mod target_environment;
mod target_picture;
mod target_refine;
mod target_render;
mod upgrade;
