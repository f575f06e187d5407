//! `brood token`: makes, lists and revokes tokens, beside a running server or without one.

use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_storage::{Scope, StorageError, Store};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;

use crate::{logging, output, place};

/// What `brood token` does.
#[derive(Debug, Subcommand)]
pub enum TokenCommand {
    /// Make a token and print it; it cannot be shown again
    Add(AddArgs),
    /// List the tokens by name and scope
    List(ListArgs),
    /// Take a token's rights away
    Revoke(RevokeArgs),
}

/// Options of `brood token add`.
#[derive(Debug, Args)]
pub struct AddArgs {
    /// What it is called
    name: String,
    /// What its bearer may do
    #[arg(long)]
    scope: ScopeWord,
    /// The server's data directory
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

/// Options of `brood token list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// The server's data directory
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

/// Options of `brood token revoke`.
#[derive(Debug, Args)]
pub struct RevokeArgs {
    /// What it is called
    name: String,
    /// The server's data directory
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

/// The words of [`Scope`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ScopeWord {
    /// Look at everything
    Read,
    /// Make lineages and breed as well
    Breed,
    /// Take leases and hand results back, nothing else
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
        }
    })
}

async fn add(args: &AddArgs, json: bool) -> Result<()> {
    anyhow::ensure!(
        (1..=200).contains(&args.name.chars().count()),
        "a token's name has 1 to 200 characters"
    );
    let mut secret = [0; 32];
    getrandom::fill(&mut secret).context("draw a token")?;
    let token: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
    let hash = *blake3::hash(token.as_bytes()).as_bytes();
    let store = open(args.data.as_ref()).await?;
    let made = store.create_token(&args.name, args.scope.into(), hash, None).await;
    store.close().await?;
    made.map_err(|error| match error {
        StorageError::Conflict { .. } => anyhow::anyhow!("there is a token of that name already"),
        error => error.into(),
    })?;
    if json {
        return output::print_json(&json!({ "name": args.name, "token": token }));
    }
    output::print(&format!("{token}\n"))
}

async fn list(args: &ListArgs, json: bool) -> Result<()> {
    let store = open(args.data.as_ref()).await?;
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
    let store = open(args.data.as_ref()).await?;
    let revoked = store.revoke_token(&args.name).await;
    store.close().await?;
    revoked.map_err(|error| match error {
        StorageError::NotFound => anyhow::anyhow!("there is no token of that name"),
        error => error.into(),
    })?;
    if json {
        return output::print_json(&json!({ "revoked": args.name }));
    }
    output::print(&format!("revoked {}\n", args.name))
}

async fn open(data: Option<&PathBuf>) -> Result<Store> {
    Store::open_beside(&place::data_dir(data)?).await.context("open the data directory")
}
