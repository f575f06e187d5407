use super::*;

const WIDTH: usize = 40;

/// Linear pixels that any program can generate: smooth and rough parts over a range of 2^13.
fn radiance(change: usize) -> Vec<[f64; 3]> {
    let channel = |x: usize, y: usize, phase: usize| {
        let smooth = (x + 2 * y + 8 * phase + 1) as f64 / 64.0;
        let octave = ((x / 4 + 3 * (y / 4) + phase) % 13) as i32 - 6;
        let wrong = ((x * y + phase) % 5 * change) as f64 / 256.0;
        libm::ldexp(smooth, octave) * (1.0 + wrong)
    };
    let pixel = |index: usize| {
        let (x, y) = (index % WIDTH, index / WIDTH);
        [0, 1, 2].map(|phase| channel(x, y, phase))
    };
    (0..WIDTH * 32).map(pixel).collect()
}

/// Codes of 8 bits, smooth and rough.
fn codes(change: usize) -> Vec<u8> {
    let code = |index: usize| {
        let (x, y, phase) = (index / 3 % WIDTH, index / 3 / WIDTH, index % 3);
        let wrong = (x * y + phase) % 5 * change;
        (2 * x + y + 8 * phase + (x / 4 * (y / 4) % 3) * 20 + wrong) as u8
    };
    (0..WIDTH * 32 * 3).map(code).collect()
}

/// Expected values are those of `flip_evaluator.evaluate(..., "HDR", applyMagma=False)`, package
/// flip-evaluator 1.7 of PyPI, which computes in f32.
#[test]
fn hdr_flip_agrees_with_the_reference_implementation() {
    let reference = radiance(0);
    let exposures = Exposures::of(&reference).unwrap();
    let Exposures { start_ev, stop_ev, count, mostly_black } = exposures;
    assert!((start_ev + 5.171_682_4).abs() < 2e-6 && (stop_ev - 0.082_075_9).abs() < 2e-6);
    assert_eq!((count, mostly_black), (6, false));
    for (change, expected) in [(0, 0.0), (1, 0.018_012_4), (8, 0.083_019_3), (64, 0.325_467_4)] {
        let found = mean_over(&exposures, WIDTH, &reference, &radiance(change));
        assert!((found - expected).abs() < 1e-6, "{change}: {found}, expected {expected}");
    }
}

/// The exposures are brood's own here, because flip-evaluator chooses others for a median of 0.
/// They were passed to it as `startExposure`, `stopExposure` and `numExposures`.
#[test]
fn hdr_flip_omits_black_pixels_from_the_median() {
    let on_black = |change: usize| -> Vec<[f64; 3]> {
        let inside = |index: usize| {
            (8..24).contains(&(index / WIDTH)) && (10..20).contains(&(index % WIDTH))
        };
        let of = |(index, rgb)| if inside(index) { rgb } else { [0.0; 3] };
        radiance(change).into_iter().enumerate().map(of).collect()
    };
    let reference = on_black(0);
    let exposures = Exposures::of(&reference).unwrap();
    assert!((exposures.start_ev + 4.246_746).abs() < 2e-6, "{exposures:?}");
    assert!((exposures.stop_ev - 0.103_996_5).abs() < 2e-6, "{exposures:?}");
    assert_eq!((exposures.count, exposures.mostly_black), (5, true));
    let found = mean_over(&exposures, WIDTH, &reference, &on_black(8));
    assert!((found - 0.016_048_5).abs() < 1e-6, "{found}");
    assert_eq!(Exposures::of(&[[0.0; 3]; 4]), None);
}

/// Expected values are those of `flip_evaluator.evaluate(..., "LDR", applyMagma=False)`, package
/// flip-evaluator 1.7 of PyPI.
#[test]
fn ldr_flip_agrees_with_the_reference_implementation() {
    for (change, expected) in [(0, 0.0), (1, 0.055_813_6), (4, 0.154_544_3), (16, 0.425_438_5)] {
        let found = crate::flip((WIDTH as u32, 32), &codes(0), &codes(change));
        assert!((found - expected).abs() < 1e-6, "{change}: {found}, expected {expected}");
    }
}

#[test]
fn flip_of_the_smallest_pictures_is_defined() {
    assert_eq!(crate::flip((0, 0), &[], &[]), 0.0);
    let apart = crate::flip((1, 1), &[0; 3], &[255; 3]);
    assert!((0.9..=1.0).contains(&apart), "{apart}");
}
