use std::f64::consts::PI;
use std::fmt::Write;

use glam::DVec3;
use proptest::prelude::*;

use super::{IesError, IesErrorKind, IesProfile, Photometry};

/// Text of a file of a photometric type and angles; `candela` maps both angles in degrees to
/// intensity.
fn file(
    photometry: u32,
    vertical: &[f64],
    horizontal: &[f64],
    candela: impl Fn(f64, f64) -> f64,
) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] written by a test\nTILT=NONE\n1 -1 1 {} {} {photometry} 2 0 0 0\n1 1 60\n{}\n{}\n",
        vertical.len(),
        horizontal.len(),
        list(vertical),
        list(horizontal)
    );
    for h in horizontal {
        let column: Vec<f64> = vertical.iter().map(|v| candela(*v, *h)).collect();
        writeln!(text, "{}", list(&column)).unwrap();
    }
    text
}

fn steps(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|k| from + (to - from) * f64::from(k) / f64::from(count)).collect()
}

fn parse(text: &str) -> IesProfile {
    IesProfile::parse(text.as_bytes()).unwrap()
}

/// Mean intensity over directions distributed evenly over the sphere, times 4 pi.
fn numeric_lumens(profile: &IesProfile) -> f64 {
    let (rows, columns) = (600, 600);
    let mut sum = 0.0;
    for row in 0..rows {
        let z = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
        let r = (1.0 - z * z).sqrt();
        for column in 0..columns {
            let phi = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(columns);
            sum += profile.candela(DVec3::new(r * phi.cos(), r * phi.sin(), z));
        }
    }
    sum * 4.0 * PI / f64::from(rows * columns)
}

#[test]
fn lumens_are_the_integral_of_candela_for_every_type_and_symmetry() {
    let uneven = |v: f64, h: f64| 100.0 + v.abs() + 0.5 * h.abs() + 0.3 * (v * 0.1).sin() * h.abs();
    let half = steps(0.0, 90.0, 18);
    let both = steps(-90.0, 90.0, 20);
    let cases = [
        (1, steps(0.0, 180.0, 36), vec![0.0]),
        (1, half.clone(), steps(0.0, 90.0, 4)),
        (1, half.clone(), steps(0.0, 180.0, 8)),
        (1, half.clone(), steps(90.0, 270.0, 8)),
        (1, steps(90.0, 180.0, 9), steps(0.0, 360.0, 24)),
        (1, half.clone(), steps(0.0, 345.0, 23)),
        (2, both.clone(), both.clone()),
        (2, half.clone(), half.clone()),
        (2, both.clone(), half.clone()),
        (2, steps(-40.0, 40.0, 8), steps(-30.0, 60.0, 9)),
        (3, both.clone(), both.clone()),
        (3, half.clone(), both),
    ];
    for (photometry, vertical, horizontal) in cases {
        let profile = parse(&file(photometry, &vertical, &horizontal, uneven));
        let (lumens, numeric) = (profile.lumens(), numeric_lumens(&profile));
        let case = (photometry, vertical[0], horizontal[0], horizontal.len());
        assert!((lumens - numeric).abs() < 2e-3 * numeric, "{case:?}: {lumens} {numeric}");
    }
}

#[test]
fn lumens_are_4_pi_for_uniform_candela_and_pi_for_cosine() {
    let uniform = parse(&file(1, &[0.0, 180.0], &[0.0], |_, _| 1.0));
    assert!((uniform.lumens() - 4.0 * PI).abs() < 1e-12);
    let cosine = |v: f64, _: f64| v.to_radians().cos().max(0.0);
    let lambertian = parse(&file(1, &steps(0.0, 90.0, 180), &[0.0], cosine));
    assert!((lambertian.lumens() - PI).abs() < 1e-4, "{}", lambertian.lumens());
    let front = parse(&file(2, &[-90.0, 90.0], &[-90.0, 90.0], |_, _| 1.0));
    assert!((front.lumens() - 2.0 * PI).abs() < 1e-12, "{}", front.lumens());
}

#[test]
fn intensity_is_bilinear_and_extended_by_symmetry() {
    let direction = |v: f64, h: f64| {
        let (v, h) = (v.to_radians(), h.to_radians());
        DVec3::new(v.sin() * h.cos(), v.sin() * h.sin(), v.cos())
    };
    let plane = |v: f64, h: f64| 10.0 * v + h;
    let quadrants = parse(&file(1, &[0.0, 45.0, 90.0], &[0.0, 30.0, 90.0], plane));
    for h in [20.0, 160.0, 200.0, 340.0] {
        let found = quadrants.candela(direction(33.0, h));
        assert!((found - 350.0).abs() < 1e-9, "{h}: {found}");
    }
    let about_0 = parse(&file(1, &[0.0, 90.0], &[0.0, 180.0], plane));
    for h in [150.0, 210.0] {
        assert!((about_0.candela(direction(50.0, h)) - 650.0).abs() < 1e-9, "{h}");
    }
    let about_90 = parse(&file(1, &[0.0, 90.0], &[90.0, 270.0], plane));
    for (h, expected) in [(120.0, 120.0), (60.0, 120.0), (300.0, 240.0), (240.0, 240.0)] {
        let found = about_90.candela(direction(50.0, h));
        assert!((found - 500.0 - expected).abs() < 1e-9, "{h}: {found}");
    }
    assert_eq!(quadrants.candela(direction(91.0, 0.0)), 0.0, "no light upwards");
    // Type B: the horizontal angle is to the side, the vertical angle up.
    let flood =
        parse(&file(2, &[-90.0, 0.0, 90.0], &[-90.0, 0.0, 90.0], |v, h| 1000.0 + v + 2.0 * h));
    assert!((flood.candela(DVec3::new(0.5, 0.0, 0.75f64.sqrt())) - 1060.0).abs() < 1e-9);
    assert!((flood.candela(DVec3::new(0.0, 0.5, 0.75f64.sqrt())) - 1030.0).abs() < 1e-9);
    assert_eq!(flood.candela(-DVec3::Z), 0.0);
}

#[test]
fn header_factors_apply_and_lengths_become_metres() {
    let text = "IESNA91\nTILT=NONE\n2,1500,0.5 2 1 1 1 1,-2 3\n0.9 0.8 120\n0 90 0\n100 50\n";
    let profile = parse(text);
    assert!((profile.peak_candela() - 100.0 * 0.5 * 0.9 * 0.8).abs() < 1e-12);
    for (edition, factor) in [("IESNA:LM-63-1995", 0.8), ("IESNA:LM-63-2002", 1.0)] {
        let later = parse(&text.replace("IESNA91", edition)).peak_candela();
        assert!((later - 45.0 * factor).abs() < 1e-12, "{edition}: {later}");
    }
    assert_eq!(profile.rated_lumens(), Some(3000.0));
    assert_eq!(profile.input_watts(), 120.0);
    let [width, length, height] = profile.size_m();
    assert!((width - 0.3048).abs() < 1e-12 && length < 0.0 && (height - 0.9144).abs() < 1e-12);
    assert_eq!(profile.photometry(), Photometry::C);
}

#[test]
fn tilt_scales_lamp_output() {
    let text = |geometry: u32| {
        format!(
            "IESNA:LM-63-1995\nTILT=INCLUDE\n{geometry}\n3\n0 30 90\n0.5 1.0 0.8\n\
             1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 180\n0\n2 2\n"
        )
    };
    let profile = parse(&text(1));
    assert_eq!(profile.candela(DVec3::Z), 2.0);
    for (degrees, expected) in [(0.0, 0.5), (15.0, 0.75), (-30.0, 1.0), (60.0, 0.9), (170.0, 0.8)] {
        assert!((profile.tilt_factor(degrees) - expected).abs() < 1e-12, "{degrees}");
    }
    assert!((profile.lumens() - 4.0 * PI).abs() < 1e-12);
    assert_eq!(parse(&text(2)).tilt_factor(60.0), 0.5, "the lamp stays level");
}

#[test]
fn parser_returns_line_when_file_is_malformed() {
    let good = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 90\n0\n5 5\n";
    assert!(IesProfile::parse(good.as_bytes()).is_ok());
    let replaced = |from: &str, to: &str| good.replacen(from, to, 1);
    let cases = [
        (String::new(), 1, IesErrorKind::NoTilt),
        ("a\nb\n".to_owned(), 2, IesErrorKind::NoTilt),
        (replaced("TILT=NONE", "TILT=lamp.tlt"), 2, IesErrorKind::TiltFile),
        (replaced("5 5", "5"), 7, IesErrorKind::Ends("a candela value")),
        (
            replaced("5 5", "5 x5"),
            7,
            IesErrorKind::Number { what: "a candela value", text: "x5".to_owned() },
        ),
        (
            replaced("5 5", "5 inf"),
            7,
            IesErrorKind::Number { what: "a candela value", text: "inf".to_owned() },
        ),
        (replaced("5 5", "5 -5"), 7, IesErrorKind::Value { what: "a candela value", value: -5.0 }),
        (
            replaced("1 2 1 1 2", "1 2 1 4 2"),
            3,
            IesErrorKind::Value { what: "the photometric type", value: 4.0 },
        ),
        (
            replaced("1 2 1 1 2", "1 2.5 1 1 2"),
            3,
            IesErrorKind::Value { what: "the number of vertical angles", value: 2.5 },
        ),
        (
            replaced("1 2 1 1 2", "1 2 99999999 1 2"),
            3,
            IesErrorKind::Value { what: "the number of horizontal angles", value: 99_999_999.0 },
        ),
        (replaced("0 90\n", "90 0\n"), 5, IesErrorKind::Angles("vertical")),
        (replaced("0 90\n", "0 190\n"), 5, IesErrorKind::Angles("vertical")),
        (
            replaced("2 1 1 2 0 0 0", "1 2 1 2 0 0 0").replacen("0 90\n0\n", "0\n0 100\n", 1),
            6,
            IesErrorKind::Symmetry,
        ),
    ];
    for (text, line, kind) in cases {
        let error = IesProfile::parse(text.as_bytes()).unwrap_err();
        assert_eq!(error, IesError { line, kind }, "{text}");
    }
}

proptest! {
    #[test]
    fn parser_never_panics_and_profiles_are_finite(
        noise in prop::collection::vec((0usize..200, any::<u8>()), 0..6),
        cut in 0usize..400,
        direction in (-1.0..1.0, -1.0..1.0, -1.0..1.0f64),
    ) {
        let text = file(1, &[0.0, 30.0, 90.0], &[0.0, 45.0, 90.0], |v, h| v + h);
        let mut bytes = text.into_bytes();
        for (at, byte) in noise {
            let length = bytes.len();
            bytes[at % length] = byte;
        }
        bytes.truncate(cut);
        let (x, y, z) = direction;
        if let Ok(profile) = IesProfile::parse(&bytes) {
            let candela = profile.candela(DVec3::new(x, y, z).normalize_or(DVec3::Z));
            prop_assert!(candela.is_finite() && candela >= 0.0);
            prop_assert!(profile.lumens().is_finite());
        }
    }
}
