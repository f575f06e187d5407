//! `brood breed`: breeds a brood without a server; a server breeds the same one from the same
//! options.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use brood_bench::{genome_file, logging, output, painting_file, steer_word};
use brood_eval::{
    Developed, SheetCell, centre_px, diverse_brood, express, express_brood, steered_brood,
};
use brood_genome::{DialectConstraints, Genome, Start, Steer, Variation};
use brood_program::{BroodRequest, Child, Program, make_brood};
use brood_protocol::{BreedOptions, Curation, PictureFormat, Seed};
use brood_scene::PictureSize;
use brood_worker::Renderer;
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::dialect::DialectWords;
use crate::frame::FrameArgs;
use crate::lock::LockWords;

/// Gap between the pictures of a sheet.
const GAP_PX: u32 = 4;
/// Number of children around a centre.
const RING: usize = 20;

/// Options of `brood breed`.
#[derive(Debug, Args)]
pub struct BreedArgs {
    /// Parent genome; give it twice for two parents. None: random start. One: mutation. Two:
    /// recombination, then mutation
    #[arg(long = "parent", value_name = "GENOME")]
    pub parents: Vec<PathBuf>,
    /// Seed of the brood; by default a random one, which is printed
    #[arg(long)]
    pub seed: Option<u64>,
    /// Number of children
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub count: u32,
    /// Visible amount of mutation, from 0.02, just noticeable, to 1, unrelated
    #[arg(long, value_name = "X", default_value_t = 0.3, value_parser = amount)]
    pub mutation: f32,
    /// Expected share of the second parent in a child, 0 to 1
    #[arg(long, value_name = "Y", default_value_t = 0.5, value_parser = amount)]
    pub recombination: f32,
    /// Rule for redrawing children
    #[arg(long, value_name = "CURATION", default_value = "distinct")]
    pub curation: CurationWord,
    /// Properties that children keep or change, compared with the first parent, comma-separated:
    /// keep-colour, only-gloss, warmer or cooler, rougher or glossier, more-pattern or less-pattern
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = steer_word)]
    pub steer: Vec<Steer>,
    /// Colours of painted children: a PNG or JPEG, or JSON of `brood palette --json`. Each child
    /// has the colours of a region, or the dark ones of a region and the bright ones of another
    #[arg(long, value_name = "PICTURE")]
    pub painting: Option<PathBuf>,
    /// Colour of the children, 0 grey to 1 as evolved; by default that of the first parent
    #[arg(long, value_name = "X", value_parser = amount)]
    pub saturation: Option<f32>,
    /// Energy limit: divide the reflectance of a child by its largest albedo if that is above 1; by
    /// default as the first parent
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub limit: Option<bool>,
    /// Parts of the first parent that children keep: instructions by number from 0, constants as
    /// C5, channels as r, g, b, layers as L0, their parameters as L0.roughness,
    /// effects by name, their parameters as light.palette; comma-separated
    #[arg(long, value_name = "LIST")]
    pub lock: Option<LockWords>,
    /// Dialect of random genomes, for example 'smooth registers 7' or 'extended registers 12 length
    /// 60'
    #[arg(long, value_name = "WORDS")]
    pub dialect: Option<DialectWords>,
    /// Source of random genomes [default: wild, or models if the dialect's length is 0]
    #[arg(long)]
    pub start: Option<StartWord>,
    /// The same as --start models
    #[arg(long, conflicts_with_all = ["dialect", "start"])]
    pub models: bool,
    /// Children are isotropic: unchanged by rotations about the normal
    #[arg(long)]
    pub isotropic: bool,
    /// Children are homogeneous: the same everywhere on the surface
    #[arg(long)]
    pub homogeneous: bool,
    /// on: children have bumps, which vary with them; off: none has; by default as their parents
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub bumps: Option<bool>,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Folder for the genomes and the sheet
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Command-line words of [`Curation`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum CurationWord {
    /// No redraws
    Off,
    /// Redraw until the program is new
    Distinct,
    /// Redraw also until a small preview is not black and differs from those of parents and
    /// siblings
    Diverse,
}

impl From<CurationWord> for Curation {
    fn from(word: CurationWord) -> Self {
        match word {
            CurationWord::Off => Self::Off,
            CurationWord::Distinct => Self::Distinct,
            CurationWord::Diverse => Self::Diverse,
        }
    }
}

/// Command-line words of [`Start`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum StartWord {
    /// Programs like measured materials, under the energy limit. With parents: children vary by
    /// parameters, as in a lineage that starts so
    Believable,
    /// Models of reflectance with random parameters
    Models,
    /// Painted materials with random palettes, outlines and highlights
    Painted,
    /// Random programs
    Wild,
}

impl From<StartWord> for Start {
    fn from(word: StartWord) -> Self {
        match word {
            StartWord::Believable => Self::Believable,
            StartWord::Models => Self::Models,
            StartWord::Painted => Self::Painted,
            StartWord::Wild => Self::Wild,
        }
    }
}

/// Parses `on` or `off`.
pub fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("must be on or off".to_owned()),
    }
}

fn amount(text: &str) -> Result<f32, String> {
    let amount = text.parse().ok().filter(|amount| (0.0..=1.0).contains(amount));
    amount.ok_or_else(|| "must be a number from 0 to 1".to_owned())
}

/// Runs the command.
pub fn run(args: &BreedArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let side_px = args.side_px()?;
    let parents: Vec<Genome> =
        args.parents.iter().map(|path| genome_file::read(path)).collect::<Result<_>>()?;
    let options = args.options()?;
    let variation = variation(args, &options, &parents)?;
    let seed = match args.seed {
        Some(seed) => seed,
        None => Seed::draw().context("draw a seed")?.0,
    };
    let distinct = options.curation != Curation::Off;
    let request = BroodRequest { variation, count: args.count, seed, distinct };
    let is_diverse = options.curation == Curation::Diverse;
    let children = match options.curation {
        _ if !options.steer.is_empty() => steered_brood(&request, &options.steer, is_diverse),
        Curation::Diverse => diverse_brood(&request),
        Curation::Off | Curation::Distinct => make_brood(&request),
    };
    let children = express_brood(children);
    output::make_dir(&args.output)?;
    let renderer = Renderer::new(args.frame.backend);
    let sheet = sheet((args, side_px), &renderer, &children, parents.first())?;
    for child in &children {
        let path = args.output.join(file_name(child.slot));
        output::write_file(&path, child.genome.to_string().as_bytes())?;
    }
    output::write_file(&args.output.join("sheet.png"), &sheet)?;
    report(&children, variation.operator_name(), seed, args.seed.is_none(), json)
}

impl BreedArgs {
    /// Returns the side of a cell of the sheet.
    fn side_px(&self) -> Result<u32> {
        let PictureSize { width, height } = self.frame.size;
        ensure!(
            width == height,
            "--size must be one side such as 256: the pictures of a sheet are square, got {}",
            self.frame.size
        );
        Ok(width)
    }

    fn options(&self) -> Result<BreedOptions> {
        Ok(BreedOptions {
            mutation: self.mutation,
            recombination: self.recombination,
            curation: self.curation.into(),
            constraints: DialectConstraints {
                isotropic: self.isotropic.then_some(true),
                homogeneous: self.homogeneous.then_some(true),
                bumps: self.bumps,
            },
            saturation: self.saturation,
            energy_limit: self.limit,
            locks: self.lock.as_ref().map(|LockWords(locks)| locks.clone()),
            steer: self.steer.clone(),
            painting: self.painting.as_deref().map(painting_file::read).transpose()?,
        })
    }
}

/// Returns the variation that the options describe; an error if they contradict each other or do
/// not fit the parents.
fn variation<'a>(
    args: &BreedArgs,
    options: &'a BreedOptions,
    parents: &'a [Genome],
) -> Result<Variation<'a>> {
    match parents {
        [] => ensure!(options.locks.is_none(), "--lock needs a --parent"),
        [_] => ensure!(
            options.mutation > 0.0 || options.painting.is_some(),
            "--mutation must be above 0 with one parent: at 0 every child is a copy"
        ),
        [first, second] => ensure!(
            first.dialect().is_compatible(second.dialect()),
            "the parents have different dialects; only parents of one dialect can be recombined"
        ),
        _ => bail!("--parent may be given at most twice"),
    }
    if let Some(parent) = parents.first() {
        if let Some(DialectWords(dialect)) = args.dialect {
            ensure!(
                dialect.is_compatible(parent.dialect()),
                "--dialect must match the dialect of the parents, or be left out"
            );
        }
        if let Some(locks) = &options.locks {
            locks.validate_for(parent)?;
        }
    }
    let genomes: Vec<&Genome> = parents.iter().collect();
    options.check_steer(&genomes)?;
    let given = args.dialect.map(|words| words.0);
    let start = if args.models { Some(Start::Models) } else { args.start.map(Start::from) };
    let start = start.unwrap_or_else(|| given.as_ref().map_or(Start::default(), Start::of));
    let dialect = given.unwrap_or_else(|| start.dialect());
    options.check_painted(&genomes, start == Start::Painted)?;
    ensure!(
        start.allows(&dialect),
        "--start {} needs a dialect like '{}', length {}, or none",
        start.name(),
        start.dialect(),
        start.dialect().length
    );
    let variation = options.variation((start, dialect), &genomes);
    ensure!(
        variation.has_share() || !variation.is_deterministic(),
        "--mutation 0 gives equal children; raise --mutation"
    );
    ensure!(
        !variation.is_deterministic(),
        "--mutation 0 and --recombination {} give only copies of these parents; raise --mutation",
        options.recombination
    );
    Ok(variation)
}

/// Sheet of the children around the first parent, or around the first child for a random start.
fn sheet(
    (args, side_px): (&BreedArgs, u32),
    renderer: &Renderer,
    children: &[Child],
    centre: Option<&Genome>,
) -> Result<Vec<u8>> {
    let (frame, mesh) = args.frame.load(renderer, PictureFormat::Png)?;
    let programs: Vec<&Program> = children.iter().map(|child| &child.program).collect();
    let spinner = output::spinner("rendering the sheet");
    let pictures = renderer.develop(&frame, &mesh, &programs)?;
    let centre = if children.len() == RING {
        let program = centre.map_or_else(|| children[0].program.clone(), express);
        let mut large = frame.clone();
        large.size_px = centre_px(side_px, GAP_PX).into();
        renderer.develop(&large, &mesh, &[&program])?.pop()
    } else {
        None
    };
    spinner.finish_and_clear();
    let cells: Vec<SheetCell<'_>> = pictures.iter().map(cell).collect();
    let centre = centre.as_ref().map(cell);
    let (width, height, rgba) = brood_eval::sheet(&cells, centre, side_px, GAP_PX);
    Ok(brood_eval::encode_png(width, height, &rgba))
}

fn cell(picture: &Developed) -> SheetCell<'_> {
    SheetCell { width: picture.width, height: picture.height, rgba: &picture.rgba }
}

fn file_name(slot: u32) -> String {
    format!("{slot:02}.brood")
}

/// Prints the children; also the seed if it was `drawn` here.
fn report(children: &[Child], operator: &str, seed: u64, drawn: bool, json: bool) -> Result<()> {
    if json {
        let individual = |child: &Child| {
            json!({
                "slot": child.slot,
                "hash": child.hash.to_string(),
                "program_hash": child.program_hash.to_string(),
                "live_instructions": child.live_instructions,
                "attempts": child.attempts,
                "twin": child.twin,
                "file": file_name(child.slot),
            })
        };
        let individuals: Vec<_> = children.iter().map(individual).collect();
        return output::print_json(
            &json!({ "seed": seed, "operator": operator, "individuals": individuals }),
        );
    }
    if drawn {
        eprintln!("seed {seed}");
    }
    let line =
        |child: &Child| format!("{:02} {} {}\n", child.slot, child.hash, child.live_instructions);
    output::print(&children.iter().map(line).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amount_is_refused_when_outside_0_to_1() {
        assert_eq!(amount("0.25"), Ok(0.25));
        for text in ["-0.1", "1.1", "NaN", "x"] {
            assert!(amount(text).is_err(), "{text}");
        }
    }
}
