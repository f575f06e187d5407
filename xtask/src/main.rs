//! `cargo xtask`: development tasks of this repository.
//!
//! Owns the tasks, their order and the criterion of success. It only starts cargo, node and the
//! package manager and reads their output. Kept small, because it is built before everything else.

mod accept;
mod bench;
mod callgrind;
mod cluster;
mod contract;
mod deny;
mod dev;
mod dist;
mod faults;
mod fuzz;
mod golden;
mod mutants;
mod object_server;
mod packaging;
mod postgres;
mod prerequisite;
mod python;
mod sbom;
mod shell;
mod suite;
mod tidy;
mod wheel;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask <task>

  test                        install missing tools, build once, run all checks and tests
  ci                          the same; what .ci/run calls
  dev                         quick loop: check and unit tests without the gpu feature
  golden [--update]           compare the golden images, or rewrite them; report in target/golden/
  accept [--short | --long] [--peers] [--client] [--exports | --formats NAME,...]
                              [--genomes N] [--data DIR]
                              check functions against f64 and random programs, for some arguments or for all 2^32;
                              --client: call the API with a client that openapi-python-client generates;
                              --exports: read exported materials with the programs that the formats are for;
                              --formats NAME,...: as --exports, of some formats;
                              --genomes N: as --exports, with N random genomes in each format
  callgrind [--update]        compare instruction counts of fixed work with docs/bench/instructions.json, or update it
  bench peers [--out DIR] [--rounds N] [--release | --brood FILE] [--require]
                              compare the speed of other programs on the same work, installed below target/
  bench fit --data DIR [--materials NAME,...] [--seeds N] [--out DIR] [--release | --brood FILE] [--require]
                              compare fits of measured materials with symbolic regression and published fits
  bench inverse [--starts N] [--out DIR] [--release | --brood FILE] [--require]
                              recover known kinds of material from one picture, compared with Mitsuba with Adam and pycma
  bench photographs [--data DIR] [--materials NAME,...] [--grades NAME,...] [--pictures N] [--strategy NAME]
                    [--seconds N] [--peers NAME,...|none] [--out DIR] [--release | --brood FILE] [--require]
                              recover materials from pictures by Mitsuba, compared with Mitsuba under other lights and on
                              another mesh, and with fits by Mitsuba with Adam; grades: exact, codes, misaligned, environment;
                              peers: principled, generating
  bench live [--angle NAME,...] [--hardware] [--out DIR] [--release | --brood FILE] [--require]
                              measure the frame rate of the page and the bits of exports with each available graphics driver
  bench look [--out DIR] [--release | --brood FILE]
                              measure broods in environments, starts of lineages, mutation and steering
  bench far [--out DIR] [--release | --brood FILE]
                              measure the page over a slow network: time to pictures, requests, bytes
  bench scale [--only NAME,...] [--seconds N] [--rounds N] [--out DIR] [--release | --brood FILE]
                              measure several servers under CPU quota on one PostgreSQL database, workers that sleep,
                              both engines, with a load model, and searches with islands;
                              series: births, workers, engines, demands, islands
  bench pictures [--data DIR] [--out DIR] [--release | --brood FILE] [--require]
                              compare pictures of the same materials with those of another renderer
  faults [--long | --minutes N]
                              kill, stop and starve the server and its workers, fill its disk, measure its memory: a line
                              of figures for each; --long: again and again for an hour
  faults --cluster [--rounds N] [--minutes N] [--seed N]
                              kill, cut and restart three servers, their workers and PostgreSQL under load, as root: 100
                              rounds in 30 minutes
  contract [--minutes N]      call every route as openapi.json describes it, and as it does not, with schemathesis
  deny                        check licences, sources and advisories of the dependencies with cargo-deny
  fuzz [PARSER ...] [--minutes N]
                              feed every parser, or these, with inputs that libFuzzer makes from seeds
  mutants [CRATE ...] [--shard K/N] [--file GLOB] [--compare]
                              change the code in small ways and list the changes that no test detects
  packaging                   check the files of packaging/ with promtool, kubernetes-validate, hadolint, haproxy,
                              systemd-analyze and, if it is there, docker compose
  postgres [FILTER ...]       run the tests of the store and of the API on a temporary PostgreSQL, or those of the API that
                              filters of nextest choose
  wheel [--test]              build the Python package in the release profile into target/wheels;
                              --test: test the package of the last build of the workspace
  dist                        build the files of a release into target/dist: a tarball of the static binary with
                              systemd unit and container file, the Python wheel, checksums
  tidy [PREFIX ...]           rules of the source tree: crate dependencies, file lengths, wording; in all files or those
                              whose path begins with a PREFIX
  tidy --update-duplicates    writes the list of duplicate dependencies anew
  help                        this text
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["test" | "ci"] => suite::run(),
        ["deny"] => deny::run(),
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
        ["bench", "photographs", options @ ..] => bench::photographs(options),
        ["bench", "live", options @ ..] => bench::live(options),
        ["bench", "far", options @ ..] => bench::far(options),
        ["bench", "look", options @ ..] => bench::look(options),
        ["bench", "scale", options @ ..] => bench::scale(options),
        ["contract", options @ ..] => contract::run(options),
        ["faults", options @ ..] => faults::run(options),
        ["fuzz", options @ ..] => fuzz::run(options),
        ["packaging"] => packaging::run(),
        ["postgres", filter @ ..] => postgres::run(filter),
        ["mutants", options @ ..] => mutants::run(options),
        ["dist"] => dist::run(),
        ["wheel"] => wheel::run(),
        ["wheel", "--test"] => wheel::test_built(),
        ["tidy", "--update-duplicates"] => tidy::update_duplicates(),
        ["tidy", prefixes @ ..] => tidy::run(prefixes),
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
