//! Every parser of bytes that come from outside, as a function that must not panic for any bytes.
//!
//! Some also check a law: what was read and is written again reads as the same. `seeds` has a
//! folder of inputs for each parser, among them those that once failed. The tests read these and
//! changed copies of them; `cargo xtask fuzz` lets libFuzzer search for others.

use std::sync::LazyLock;

use brood_brdf::{Merl, Neural, Rgl};
use brood_eval::{decode_display, decode_environment, decode_image, decode_linear, picture_size};
use brood_genome::Genome;
use brood_light::IesProfile;
use brood_mesh::{ObjLimits, parse_obj};
use brood_protocol::{
    ExportReport, LeaseRenewal, LeaseRequest, LeaseResults, LeaseTicket, RenderJob, SearchReport,
    decode,
};
use brood_scene::Scene;
use brood_target::{PictureBundle, TargetFile, TargetKind};

/// Function that reads bytes.
pub type Parser = fn(&[u8]);

/// Largest side of pictures, so that decoding stays quick.
const SIDE: u32 = 512;
/// Largest number of vertices and triangles.
const VERTICES: usize = 10_000;

/// Parsers by name.
pub const PARSERS: [(&str, Parser); 15] = [
    ("bundle", bundle),
    ("cornell", |bytes| target(TargetKind::Cornell, bytes)),
    ("environment", environment),
    ("genome_bytes", genome_bytes),
    ("genome_json", genome_json),
    ("genome_text", genome_text),
    ("image", image),
    ("merl", |bytes| drop(Merl::read(bytes))),
    ("message", message),
    ("neural", |bytes| drop(Neural::read(bytes, "fuzz"))),
    ("obj", obj),
    ("profile", |bytes| drop(IesProfile::parse(bytes))),
    ("rgl", |bytes| drop(Rgl::read(bytes))),
    ("samples", |bytes| target(TargetKind::Samples, bytes)),
    ("scene", scene),
];

/// Returns the parser that the environment variable names.
///
/// # Panics
/// If it names none.
#[must_use]
pub fn chosen() -> Parser {
    static CHOSEN: LazyLock<Parser> = LazyLock::new(|| {
        let name = std::env::var("BROOD_PARSER").unwrap_or_default();
        let found = PARSERS.iter().find(|(known, _)| *known == name);
        found.unwrap_or_else(|| panic!("BROOD_PARSER must name a parser, got {name:?}")).1
    });
    *CHOSEN
}

fn bundle(bytes: &[u8]) {
    if let Ok(bundle) = PictureBundle::decode(bytes) {
        drop(bundle.target());
    }
}

fn target(kind: TargetKind, bytes: &[u8]) {
    drop(TargetFile::read(kind, bytes));
}

/// As the server does: the size in the head is checked before decoding.
fn environment(bytes: &[u8]) {
    if picture_size(bytes).is_ok_and(|(width, height)| width <= 2 * SIDE && height <= SIDE) {
        drop(decode_environment(bytes));
    }
}

fn image(bytes: &[u8]) {
    if picture_size(bytes).is_ok_and(|(width, height)| width <= SIDE && height <= SIDE) {
        drop(decode_image(bytes));
        drop(decode_linear(bytes, SIDE));
        drop(decode_display(bytes, SIDE));
    }
}

fn genome_bytes(bytes: &[u8]) {
    if let Ok(genome) = Genome::from_canonical_bytes(bytes) {
        assert_eq!(genome.canonical_bytes(), bytes, "each genome has one form");
    }
}

fn genome_json(bytes: &[u8]) {
    let Ok(json) = serde_json::from_slice(bytes) else { return };
    if let Ok(genome) = Genome::from_json(json) {
        assert_eq!(Genome::from_json(genome.to_json()).as_ref(), Ok(&genome));
        same_bytes(&genome);
    }
}

fn genome_text(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(genome) = text.parse::<Genome>() {
        assert_eq!(genome.to_string().parse().as_ref(), Ok(&genome));
        same_bytes(&genome);
    }
}

fn same_bytes(genome: &Genome) {
    let read = Genome::from_canonical_bytes(&genome.canonical_bytes());
    assert_eq!(read.as_ref(), Ok(genome));
}

fn message(bytes: &[u8]) {
    drop(decode::<LeaseRequest>(bytes));
    drop(decode::<LeaseTicket>(bytes));
    drop(decode::<LeaseRenewal>(bytes));
    drop(decode::<LeaseResults>(bytes));
    drop(decode::<SearchReport>(bytes));
    drop(decode::<ExportReport>(bytes));
    drop(decode::<RenderJob>(bytes));
}

fn obj(bytes: &[u8]) {
    let limits = ObjLimits { vertices: VERTICES, triangles: VERTICES, ..ObjLimits::default() };
    drop(parse_obj(bytes, &limits));
}

fn scene(bytes: &[u8]) {
    let Ok(scene) = serde_json::from_slice::<Scene>(bytes) else { return };
    if scene.validate().is_ok() {
        let text = serde_json::to_vec(&scene).expect("a scene is plain data");
        assert_eq!(serde_json::from_slice::<Scene>(&text).ok().as_ref(), Some(&scene));
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// Changed copies of each seed.
    const COPIES: u64 = 400;

    fn seeds(parser: &str) -> Vec<(PathBuf, Vec<u8>)> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("seeds").join(parser);
        let files =
            std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
        let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
        paths.sort();
        paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
    }

    /// Changes a few bytes, cuts, repeats or swaps parts.
    fn changed(seed: &[u8], number: u64) -> Vec<u8> {
        let mut state = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut draw = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % below.max(1)
        };
        let mut bytes = seed.to_vec();
        for _ in 0..=draw(4) {
            let (at, other) = (draw(bytes.len()), draw(bytes.len()));
            match draw(6) {
                0 => bytes.truncate(at),
                1 => bytes.extend_from_slice(&seed[at.min(seed.len())..]),
                2 => bytes.insert(at.min(bytes.len()), b"\0-e9.{[\"\n\xff"[draw(10)]),
                3 if at < bytes.len() => bytes[at] ^= 1 << draw(8),
                4 if at < bytes.len() => bytes[at] = b"0-91e.\0\xff \n"[draw(10)],
                _ if at.max(other) < bytes.len() => bytes.swap(at, other),
                _ => {}
            }
        }
        bytes
    }

    #[test]
    fn seeds_and_changed_copies_are_read_without_panic() {
        for (name, parser) in PARSERS {
            let seeds = seeds(name);
            assert!(!seeds.is_empty(), "{name} has no seed");
            for (path, seed) in seeds {
                parser(&seed);
                for number in 0..COPIES {
                    let bytes = changed(&seed, number);
                    let read = std::panic::catch_unwind(|| parser(&bytes));
                    assert!(read.is_ok(), "{}, copy {number}: {bytes:?}", path.display());
                }
            }
        }
    }

    #[test]
    fn seeds_reach_beyond_the_first_error() {
        let seed = |parser: &str, file: &str| {
            let found = seeds(parser).into_iter().find(|(path, _)| path.ends_with(file));
            found.unwrap_or_else(|| panic!("{parser}/{file}")).1
        };
        let text = String::from_utf8(seed("genome_text", "program.brood")).unwrap();
        let genome: Genome = text.parse().unwrap();
        assert_eq!(Genome::from_canonical_bytes(&seed("genome_bytes", "program")).unwrap(), genome);
        let json = serde_json::from_slice(&seed("genome_json", "program.json")).unwrap();
        assert_eq!(Genome::from_json(json).unwrap(), genome);
        parse_obj(&seed("obj", "pyramid.obj"), &ObjLimits::default()).unwrap();
        IesProfile::parse(&seed("profile", "small.ies")).unwrap();
        decode_environment(&seed("environment", "small.hdr")).unwrap();
        decode_environment(&seed("environment", "small.exr")).unwrap();
        decode_image(&seed("image", "small.png")).unwrap();
        TargetFile::read(TargetKind::Samples, &seed("samples", "grey.csv")).unwrap();
        serde_json::from_slice::<Scene>(&seed("scene", "lights.json")).unwrap().validate().unwrap();
        decode::<LeaseRequest>(&seed("message", "request")).unwrap();
        decode::<LeaseTicket>(&seed("message", "ticket")).unwrap();
        decode::<LeaseRenewal>(&seed("message", "renewal")).unwrap();
        decode::<LeaseResults>(&seed("message", "results")).unwrap();
        decode::<LeaseResults>(&seed("message", "failed")).unwrap();
    }
}
