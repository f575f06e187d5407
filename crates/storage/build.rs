//! Rebuilds the crate when a migration is added: the embedding macro tracks existing files only.

fn main() {
    println!("cargo:rerun-if-changed=../../migrations");
}
