//! Rebuilds the crate when a migration is added: the embedding macro only notices changes of files it knows.

fn main() {
    println!("cargo:rerun-if-changed=../../migrations");
}
