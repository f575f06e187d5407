//! `brood bench brood`: counts the useful pictures of broods under each kind of curation.
//!
//! A picture is useful if it is not black and differs visibly, by FLIP, from the parent and from
//! every sibling. A picture of a painted material is useful if its lightness has a range that shows
//! the shape, and it differs in codes.
//!
//! All kinds of curation breed from the same parents: a chain in which each brood's parent is a
//! child of the previous one, or independent random parents of one kind.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use brood_eval::{Appearance, Preview, diverse_brood, steered_brood};
use brood_genome::{Genome, PaintingPalette, Start, Steer, Variation};
use brood_program::{BroodRequest, Child, Program, make_brood};
use brood_protocol::Curation;
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use super::amount::{Kind, parent_kind};
use super::flip::PictureSet;
use super::measure::{is_visible, quantile, visible_genomes};
use crate::{logging, output, painting_file};

/// Options of `brood bench brood`.
#[derive(Debug, Args)]
pub struct BenchBroodArgs {
    /// Number of broods
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// Amount of mutation, 0 to 1
    #[arg(long, value_name = "X", default_value_t = 0.3)]
    mutation: f32,
    /// Words of a steer, comma-separated: also measures broods that follow them
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = steer_word)]
    steer: Vec<Steer>,
    /// Breed from independent random parents of this kind, none black, instead of a chain of
    /// programs: wild, believable, models, layers, program and layer, or painted
    #[arg(long, value_name = "KIND", value_parser = parent_kind)]
    kind: Option<Kind>,
    /// Colours of painted children: a PNG or JPEG, or JSON of `brood palette --json`
    #[arg(long, value_name = "PICTURE")]
    painting: Option<PathBuf>,
    /// Side of the compared pictures in pixels
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(16..=256))]
    size: u32,
    /// Seed of the first parent and of the broods
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Number of children of a brood.
const CHILDREN: u32 = 20;
/// Mean FLIP over the object above which two pictures differ visibly.
const VISIBLE: f64 = 0.05;
/// Mean difference in codes of 255 above which two pictures of painted materials differ visibly.
const VISIBLE_CODES: f64 = 7.0;
/// Range of lightness in Oklab from which a painted material shows its shape.
const SHAPE_RANGE: f64 = 0.25;

/// Results of all broods under one kind of curation.
#[derive(Debug, Serialize)]
struct Figures {
    /// Curation, or `steered`.
    curation: &'static str,
    /// Share of the children that follow the steer; 1 without one.
    followed: f64,
    /// Share of the parents of which a child follows it.
    parents_followed: f64,
    /// Share of the pictures that are useful.
    useful: f64,
    /// Share of the broods with at least 18 useful pictures.
    broods_with_18: f64,
    /// Share of the broods with at least 19 useful pictures.
    broods_with_19: f64,
    /// Number of black pictures.
    black: usize,
    /// Mean number of draws per brood.
    draws: f64,
    /// Median time to breed a brood.
    median_ms: f64,
    p99_ms: f64,
    /// Longest time.
    most_ms: f64,
}

/// Runs the command.
pub fn run(args: &BenchBroodArgs, json: bool) -> Result<()> {
    logging::start_offline();
    if args.kind == Some(Kind::Painted) && !args.steer.is_empty() {
        bail!("painted materials are not steered: omit --steer");
    }
    if args.kind != Some(Kind::Painted) && args.painting.is_some() {
        bail!("--painting colours painted materials: add --kind painted");
    }
    let parents = parents(args)?;
    let painting = args.painting.as_deref().map(painting_file::read).transpose()?;
    let mut rules = [Curation::Off, Curation::Distinct, Curation::Diverse].map(Some).to_vec();
    if !args.steer.is_empty() {
        rules.push(None);
    }
    let bar = output::bar(rules.len() as u64 * u64::from(args.count), "breeding and comparing");
    let mut all = Vec::new();
    for curation in rules {
        let (mut useful, mut followed) = (Vec::new(), Vec::new());
        let (mut black, mut draws, mut times) = (0, 0, Vec::new());
        for (number, parent) in (0..).zip(&parents) {
            let request = request(args, (parent, painting.as_ref()), number);
            let started = Instant::now();
            let brood = breed(&request, curation, &args.steer);
            times.push(started.elapsed().as_secs_f64() * 1e3);
            draws += brood.iter().map(|child| child.attempts).sum::<u32>();
            followed.push(following(parent, &brood, &args.steer));
            let is_painted = args.kind == Some(Kind::Painted);
            let (seen, dark) = judged(args.size, (parent, is_painted), &brood)?;
            useful.push(seen);
            black += dark;
            bar.inc(1);
        }
        let broods = f64::from(args.count);
        all.push(Figures {
            curation: curation.map_or("steered", Curation::name),
            followed: followed.iter().sum::<usize>() as f64 / broods / f64::from(CHILDREN),
            parents_followed: followed.iter().filter(|count| **count > 0).count() as f64 / broods,
            useful: useful.iter().sum::<usize>() as f64 / broods / f64::from(CHILDREN),
            broods_with_18: useful.iter().filter(|count| **count >= 18).count() as f64 / broods,
            broods_with_19: useful.iter().filter(|count| **count >= 19).count() as f64 / broods,
            black,
            draws: f64::from(draws) / broods,
            median_ms: quantile(&times, 0.5),
            p99_ms: quantile(&times, 0.99),
            most_ms: times.iter().copied().fold(0.0, f64::max),
        });
    }
    bar.finish_and_clear();
    if json {
        return output::print_json(&all);
    }
    let mut text = format!(
        "{} broods of {CHILDREN}, {}{}, mutation {}; a frame is useful if {}\n\
         curation  useful frames  broods with 18 or more  broods with 19 or more  black frames  \
         draws / brood  births ms median    p99    most  follow the steer  parents followed\n",
        args.count,
        args.kind.map_or_else(
            || "a chain of parents".to_owned(),
            |kind| format!("parents: {}", kind.name())
        ),
        match &painting {
            Some(painting) => {
                format!(", colours of a painting of {} regions", painting.regions().len())
            }
            None => String::new(),
        },
        args.mutation,
        match args.kind {
            Some(Kind::Painted) => format!(
                "its lightness has a range of {SHAPE_RANGE} and its mean difference over the object from the parent and \
                 every sibling is over {VISIBLE_CODES} codes"
            ),
            _ => format!(
                "it is not black and its mean FLIP over the object from the parent and every sibling is over {VISIBLE}"
            ),
        }
    );
    for f in &all {
        text += &format!(
            "{:<8}  {:>11.1} %  {:>20.1} %  {:>20.1} %  {:>12}  {:>13.1}  {:>16.2}  {:>5.2}  {:>6.1}  {:>14.1} %  {:>14.1} %\n",
            f.curation,
            100.0 * f.useful,
            100.0 * f.broods_with_18,
            100.0 * f.broods_with_19,
            f.black,
            f.draws,
            f.median_ms,
            f.p99_ms,
            f.most_ms,
            100.0 * f.followed,
            100.0 * f.parents_followed
        );
    }
    output::print(&text)
}

fn request<'a>(
    args: &BenchBroodArgs,
    (parent, painting): (&'a Genome, Option<&'a PaintingPalette>),
    number: u64,
) -> BroodRequest<'a> {
    let start = args.kind.map_or(Start::Wild, Kind::start);
    let variation =
        Variation::mutate(parent, args.mutation).with_start(start).with_painting(painting);
    BroodRequest { variation, count: CHILDREN, seed: args.seed + number, distinct: true }
}

/// Breeds under a curation, or steered and diverse if it is `None`.
fn breed(request: &BroodRequest<'_>, curation: Option<Curation>, steer: &[Steer]) -> Vec<Child> {
    match curation {
        Some(Curation::Off) => make_brood(&BroodRequest { distinct: false, ..*request }),
        Some(Curation::Distinct) => make_brood(request),
        Some(Curation::Diverse) => diverse_brood(request),
        None => {
            let variation = request.variation.with_steer(steer);
            steered_brood(&BroodRequest { variation, ..*request }, steer, true)
        }
    }
}

/// Number of children that follow all words.
fn following(parent: &Genome, brood: &[Child], steer: &[Steer]) -> usize {
    if steer.is_empty() {
        return brood.len();
    }
    let parent = Appearance::of(&Program::lower(parent));
    let follows = |child: &&Child| {
        let own = Appearance::of(&child.program);
        steer.iter().all(|word| own.follows(*word, &parent) >= 1.0)
    };
    brood.iter().filter(follows).count()
}

/// Parses a word of a steer.
///
/// # Errors
/// A list of the known words.
pub fn steer_word(text: &str) -> Result<Steer, String> {
    let known = || Steer::ALL.map(Steer::name).join(", ");
    Steer::from_name(text.trim()).ok_or_else(|| format!("must be one of {}", known()))
}

/// Random parents of a kind, or a chain of parents, none of them black, as a person would choose
/// them.
fn parents(args: &BenchBroodArgs) -> Result<Vec<Genome>> {
    if let Some(kind) = args.kind {
        return kind.parents(args.seed, args.count as usize);
    }
    let mut parents: Vec<Genome> = visible_genomes(args.seed)?.take(1).collect();
    for number in 0..u64::from(args.count) - 1 {
        let last = parents.last().expect("the first was drawn");
        let brood = make_brood(&request(args, (last, None), number));
        let pick = number as usize % brood.len();
        let turned = brood[pick..].iter().chain(&brood[..pick]);
        let next = turned.map(|child| &child.genome).find(|genome| is_visible(genome));
        let next = next.unwrap_or(last).clone();
        parents.push(next);
    }
    Ok(parents)
}

/// Numbers of useful and of black children. For painted materials, flat ones count as black.
fn judged(
    size_px: u32,
    (parent, is_painted): (&Genome, bool),
    brood: &[Child],
) -> Result<(usize, usize)> {
    let parent = Program::lower(parent);
    let programs: Vec<&Program> =
        std::iter::once(&parent).chain(brood.iter().map(|child| &child.program)).collect();
    let pictures = PictureSet::of(&programs, size_px)?;
    let black: Vec<bool> = match is_painted {
        true => (0..pictures.len())
            .map(|picture| pictures.lightness_range(picture) < SHAPE_RANGE)
            .collect(),
        false => programs.iter().map(|program| Preview::of(program).is_black()).collect(),
    };
    let pairs: Vec<(usize, usize)> =
        (0..pictures.len()).flat_map(|one| (0..one).map(move |other| (one, other))).collect();
    let alike: Vec<(usize, usize)> = pairs
        .into_par_iter()
        .filter(|(one, other)| match is_painted {
            true => pictures.codes(*one, *other) <= VISIBLE_CODES,
            false => pictures.flip(*one, *other) <= VISIBLE,
        })
        .collect();
    // If two pictures look alike, neither is useful.
    let useful = (1..pictures.len())
        .filter(|one| !black[*one] && !alike.iter().any(|(a, b)| a == one || b == one));
    Ok((useful.count(), black[1..].iter().filter(|black| **black).count()))
}
