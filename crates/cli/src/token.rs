//! `brood token`: creates, lists and revokes tokens, and opens access without one, whether or not a
//! server is running.

use anyhow::{Context, Result};
use brood_bench::{logging, output};
use brood_server::now_ms;
use brood_storage::{Scope, StorageError};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;

use crate::place::{self, DataPlace};

/// Subcommands of `brood token`.
#[derive(Debug, Subcommand)]
pub enum TokenCommand {
    /// Create a token and print it; it cannot be shown again
    Add(AddArgs),
    /// List the tokens by name and scope
    List(ListArgs),
    /// Revoke a token; without any, the server refuses all requests
    Revoke(RevokeArgs),
    /// Let requests from this machine in without a token again, after the last was revoked
    Open(OpenArgs),
}

/// Options of `brood token add`.
#[derive(Debug, Args)]
pub struct AddArgs {
    /// Name of the token, 1 to 200 characters
    name: String,
    /// Rights of the token
    #[arg(long)]
    scope: ScopeWord,
    #[command(flatten)]
    place: DataPlace,
}

/// Options of `brood token list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    #[command(flatten)]
    place: DataPlace,
}

/// Options of `brood token revoke`.
#[derive(Debug, Args)]
pub struct RevokeArgs {
    /// Name of the token
    name: String,
    #[command(flatten)]
    place: DataPlace,
}

/// Options of `brood token open`.
#[derive(Debug, Args)]
pub struct OpenArgs {
    #[command(flatten)]
    place: DataPlace,
}

/// Command-line words of [`Scope`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ScopeWord {
    /// Read everything
    Read,
    /// Read everything, create lineages and breed
    Breed,
    /// Take leases and return results, nothing else
    Work,
    /// Everything
    Admin,
}

impl From<ScopeWord> for Scope {
    fn from(word: ScopeWord) -> Self {
        match word {
            ScopeWord::Read => Self::Read,
            ScopeWord::Breed => Self::Breed,
            ScopeWord::Work => Self::Work,
            ScopeWord::Admin => Self::Admin,
        }
    }
}

/// Runs the command.
pub fn run(command: &TokenCommand, json: bool) -> Result<()> {
    logging::start_offline();
    place::runtime()?.block_on(async {
        match command {
            TokenCommand::Add(args) => add(args, json).await,
            TokenCommand::List(args) => list(args, json).await,
            TokenCommand::Revoke(args) => revoke(args, json).await,
            TokenCommand::Open(args) => open_access(args, json).await,
        }
    })
}

async fn add(args: &AddArgs, json: bool) -> Result<()> {
    anyhow::ensure!(
        (1..=200).contains(&args.name.chars().count()),
        "a token's name must have 1 to 200 characters"
    );
    let token = brood_protocol::random_token().context("draw a token")?;
    // The database holds only the hash.
    let hash = *blake3::hash(token.as_bytes()).as_bytes();
    let store = args.place.open_shared().await?;
    let created = store.create_token(&args.name, args.scope.into(), hash, None).await;
    store.close().await?;
    created.map_err(|error| match error {
        StorageError::Conflict { .. } => anyhow::anyhow!("a token of that name exists already"),
        error => error.into(),
    })?;
    if json {
        return output::print_json(&json!({ "name": args.name, "token": token }));
    }
    output::print(&format!("{token}\n"))
}

async fn list(args: &ListArgs, json: bool) -> Result<()> {
    let store = args.place.open_shared().await?;
    let tokens = store.list_tokens().await;
    store.close().await?;
    let tokens = tokens?;
    let rows = tokens.iter().map(|token| (token.name.as_str(), token.scope.name()));
    if json {
        let items: Vec<_> =
            rows.map(|(name, scope)| json!({ "name": name, "scope": scope })).collect();
        return output::print_json(&items);
    }
    output::print(&rows.map(|(name, scope)| format!("{scope:<6} {name}\n")).collect::<String>())
}

async fn revoke(args: &RevokeArgs, json: bool) -> Result<()> {
    let store = args.place.open_shared().await?;
    let revoked = store.revoke_token(&args.name, now_ms()).await;
    store.close().await?;
    let was_last = revoked.map_err(|error| match error {
        StorageError::NotFound => {
            anyhow::anyhow!("no token has that name; `brood token list` shows all")
        }
        error => error.into(),
    })?;
    if json {
        return output::print_json(&json!({ "revoked": args.name, "was_last": was_last }));
    }
    output::print(&format!("revoked {}\n", args.name))?;
    if was_last {
        output::print(
            "it was the last: the server refuses requests until `brood token add` makes a new one, \
             or `brood token open` lets requests from its machine in without one\n",
        )?;
    }
    Ok(())
}

async fn open_access(args: &OpenArgs, json: bool) -> Result<()> {
    let store = args.place.open_shared().await?;
    let opened = store.open_access().await;
    store.close().await?;
    opened.map_err(|error| match error {
        StorageError::Conflict { .. } => {
            anyhow::anyhow!("there are tokens; `brood token revoke` them first")
        }
        error => error.into(),
    })?;
    if json {
        return output::print_json(&json!({ "open": true }));
    }
    output::print("requests from the server's machine need no token\n")
}
