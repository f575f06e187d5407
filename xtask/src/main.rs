//! `cargo xtask`: the tasks of this repository as one small program.
//!
//! Owns what is run, in which order, and what counts as a pass. Refuses to know how anything is computed: it starts
//! cargo, node and the package manager, and reads their answers. Kept light, because it is built before everything else.

mod accept;
mod bench;
mod callgrind;
mod dev;
mod golden;
mod prerequisite;
mod shell;
mod suite;
mod tidy;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask <task>

  test                        install what is missing, build once, run everything
  ci                          the same; what .ci/run calls
  dev                         quick loop: check and unit tests without the gpu feature
  golden [--update]           compare the golden images, or write them anew; report in target/golden/
  accept [--short | --long] [--data DIR]
                              functions against f64 and random programs: some of the arguments, or all 2^32 of them
  callgrind [--update]        instructions of fixed work against docs/bench/instructions.json, or write it anew
  bench peers [--out DIR] [--rounds N] [--release | --brood FILE] [--require]
                              other programs on the same work, installed below target/, with ratios
  bench fit --data DIR [--materials NAME,...] [--out DIR] [--release | --brood FILE] [--require]
                              fits of measured materials beside symbolic regression and published fits
  bench inverse [--starts N] [--out DIR] [--release | --brood FILE] [--require]
                              known kinds of material recovered from one picture, beside Mitsuba with Adam and pycma
  bench live [--angle NAME,...] [--hardware] [--out DIR] [--release | --brood FILE] [--require]
                              frames a second of the page, and exports to the bit, by each driver of graphics there is
  bench pictures [--data DIR] [--out DIR] [--release | --brood FILE] [--require]
                              another renderer's pictures of the same materials, and how far ours are from them
  tidy [--update-duplicates]  rules of the source tree: crate arrows, file lengths, forbidden words
  help                        this text
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["test" | "ci"] => suite::run(),
        ["dev"] => dev::run(),
        ["golden"] => golden::run(false),
        ["golden", "--update"] => golden::run(true),
        ["accept", options @ ..] => accept::run(options),
        ["callgrind"] => callgrind::run(false),
        ["callgrind", "--update"] => callgrind::run(true),
        ["bench", "peers", options @ ..] => bench::peers(options),
        ["bench", "pictures", options @ ..] => bench::pictures(options),
        ["bench", "fit", options @ ..] => bench::fit(options),
        ["bench", "inverse", options @ ..] => bench::inverse(options),
        ["bench", "live", options @ ..] => bench::live(options),
        ["tidy"] => tidy::run(),
        ["tidy", "--update-duplicates"] => tidy::update_duplicates(),
        [] | ["help" | "--help" | "-h"] => {
            print!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprint!("xtask: unknown task: {}\n\n{USAGE}", words.join(" "));
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}
