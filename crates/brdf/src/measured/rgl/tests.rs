//! Reader of `.bsdf` against materials in closed form, and against damaged files.

use proptest::prelude::*;

use super::*;
use crate::measured::tensor::tests::{Written, file};

/// Dimensions of a test file.
struct Sizes {
    phi: Vec<f32>,
    theta: Vec<f32>,
    /// Entries along each side: `side` of ndf, sigma and vndf, `colors` of rgb.
    side: usize,
    colors: usize,
}

/// Polar angle and azimuth at a position in a table.
fn angles(x: f64, y: f64) -> (f64, f64) {
    (x * x * FRAC_PI_2, y * TAU - PI)
}

fn fields(
    sizes: &Sizes,
    ndf: &dyn Fn(f64) -> f64,
    sigma: &dyn Fn(f64) -> f64,
    vndf: &dyn Fn(f64, f64, f64) -> f64,
    rgb: &dyn Fn([usize; 2], usize, f64, f64) -> f64,
) -> Vec<Written> {
    let unit = |k: usize, count: usize| k as f64 / (count - 1) as f64;
    let floats = |name, shape: &[usize], numbers| Written {
        name,
        shape: shape.to_vec(),
        numbers,
        bytes: false,
    };
    let side = sizes.side;
    let radial = |f: &dyn Fn(f64) -> f64| -> Vec<f32> {
        (0..2 * side).map(|k| f(angles(unit(k % side, side), 0.0).0) as f32).collect()
    };
    let (mut densities, mut colors) = (Vec::new(), Vec::new());
    for (p, _) in sizes.phi.iter().enumerate() {
        for (t, theta_i) in sizes.theta.iter().enumerate() {
            for k in 0..side * side {
                let (x, y) = (unit(k % side, side), unit(k / side, side));
                let (theta, phi) = angles(x, y);
                // Density over the square, not the sphere: sin(theta) d theta d phi
                // in steps of the table.
                densities.push((vndf(f64::from(*theta_i), theta, phi) * theta.sin() * x) as f32);
            }
            for k in 0..3 * sizes.colors * sizes.colors {
                let (channel, k) = (k / (sizes.colors * sizes.colors), k % sizes.colors.pow(2));
                let (x, y) =
                    (unit(k % sizes.colors, sizes.colors), unit(k / sizes.colors, sizes.colors));
                colors.push(rgb([p, t], channel, x, y) as f32);
            }
        }
    }
    let (p, t, c) = (sizes.phi.len(), sizes.theta.len(), sizes.colors);
    vec![
        floats("phi_i", &[p], sizes.phi.clone()),
        floats("theta_i", &[t], sizes.theta.clone()),
        floats("ndf", &[2, side], radial(ndf)),
        floats("sigma", &[2, side], radial(sigma)),
        floats("vndf", &[p, t, side, side], densities),
        floats("rgb", &[p, t, 3, c, c], colors),
        Written { name: "jacobian", shape: vec![1], numbers: vec![1.0], bytes: true },
    ]
}

/// GGX: density of normals (`ggx`), projected area (`projected_area`), density of visible normals
/// (`visible_density`).
const ALPHA: f64 = 0.5;

fn ggx(theta: f64) -> f64 {
    let cos2 = theta.cos().powi(2);
    let tail = cos2 * (ALPHA * ALPHA - 1.0) + 1.0;
    ALPHA * ALPHA / (PI * tail * tail)
}

fn projected_area(theta: f64) -> f64 {
    let (sin, cos) = theta.sin_cos();
    0.5 * (cos + (cos * cos + (ALPHA * sin).powi(2)).sqrt())
}

/// Density of visible normals; `phi` is the azimuth of the normal minus that of the direction.
fn visible_density(theta_i: f64, theta: f64, phi: f64) -> f64 {
    let cosine = theta_i.cos() * theta.cos() + theta_i.sin() * theta.sin() * phi.cos();
    ggx(theta) * cosine.max(0.0) / projected_area(theta_i)
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn mirrored(wi: DVec3, normal: DVec3) -> DVec3 {
    2.0 * wi.dot(normal) * normal - wi
}

/// Uniform numbers of a normal by numerical integration.
fn shares(theta_i: f64, theta_m: f64, phi_m: f64) -> DVec2 {
    let steps = 400;
    let density = |x: f64, y: f64| {
        let (theta, phi) = angles(x, y);
        visible_density(theta_i, theta, phi) * theta.sin() * x
    };
    let at = square_position(theta_m, phi_m);
    let integral = |to: f64, f: &dyn Fn(f64) -> f64| -> f64 {
        let step = to / f64::from(steps);
        (0..steps).map(|k| f((f64::from(k) + 0.5) * step) * step).sum()
    };
    let row = |y: f64| integral(1.0, &|x| density(x, y));
    let first = integral(at.x, &|x| density(x, at.y)) / row(at.y);
    DVec2::new(first, integral(at.y, &row) / integral(1.0, &row))
}

#[test]
fn values_match_the_material_that_the_file_was_made_from() {
    let sizes = Sizes { phi: vec![0.0], theta: vec![0.0, 0.6, 1.2], side: 128, colors: 2 };
    // Red is constant over the samples; green and blue are the uniform numbers.
    let rgb = |_: [usize; 2], channel: usize, x: f64, y: f64| [0.25, x, y][channel];
    let rgl =
        Rgl::read(&file(&fields(&sizes, &ggx, &projected_area, &visible_density, &rgb))).unwrap();
    let mut worst = 0.0_f64;
    for theta_i in [0.6, 1.2] {
        for (theta_m, phi_m) in [(0.1, 0.0), (0.3, 1.0), (0.5, -2.0), (0.25, 3.0), (0.7, 0.2)] {
            let azimuth = 0.7;
            let (wi, normal) = (direction(theta_i, azimuth), direction(theta_m, azimuth + phi_m));
            let wo = mirrored(wi, normal);
            if wo.z < 0.05 || wi.dot(normal) < 0.05 {
                continue;
            }
            let found = rgl.f(&DirectionPair::new(wi, wo).unwrap());
            let DVec2 { x, y } = shares(theta_i, theta_m, phi_m);
            let factor = ggx(theta_m) / (4.0 * projected_area(theta_i) * wo.z);
            let wanted = DVec3::new(0.25, x, y) * factor;
            worst = worst.max(((found - wanted) / (factor * 0.25)).abs().max_element());
        }
    }
    assert!(worst < 4e-3, "{worst}");
    // At normal incidence the share of GGX normals within an angle has a closed form.
    let wo = direction(0.8, 0.3);
    let found = rgl.f(&DirectionPair::new(DVec3::Z, wo).unwrap());
    let tan2 = 0.4_f64.tan().powi(2);
    let share = found.y / found.x * 0.25;
    assert!((share - tan2 / (ALPHA * ALPHA + tan2)).abs() < 1e-3, "{share}");
}

#[test]
fn unmeasured_azimuths_are_mirrored_to_measured_ones() {
    let even = |_: f64| 1.0;
    let visible_density = |_: f64, _: f64, _: f64| 1.0;
    let rgb =
        |[p, _]: [usize; 2], channel: usize, x: f64, _: f64| p as f64 + [1.0, x, 2.0][channel];
    let read = |phi: &[f32]| {
        let sizes = Sizes { phi: phi.to_vec(), theta: vec![0.0, 1.5], side: 8, colors: 2 };
        Rgl::read(&file(&fields(&sizes, &even, &even, &visible_density, &rgb))).unwrap()
    };
    let (wi, wo) = (direction(0.5, -2.9), direction(0.7, 1.1));
    let f = |rgl: &Rgl, signs: DVec3| rgl.f(&DirectionPair::new(wi * signs, wo * signs).unwrap());
    let turned = DVec3::new(-1.0, -1.0, 1.0);
    let (across, along) = (DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0));
    let pi = std::f32::consts::PI;
    let quarter = read(&[-pi, -0.8 * pi, -0.5 * pi]);
    let half = read(&[-pi, -0.7 * pi, -0.2 * pi, 0.0]);
    let whole = read(&[-pi, -1.0, 1.0, pi]);
    let plain = f(&quarter, DVec3::ONE);
    for signs in [turned, across, along] {
        assert!((f(&quarter, signs) - plain).length() < 1e-9 * plain.length());
    }
    let plain = f(&half, DVec3::ONE);
    assert!((f(&half, turned) - plain).length() < 1e-9 * plain.length());
    assert!((f(&half, across) - plain).length() > 0.01);
    assert!((f(&whole, turned) - f(&whole, DVec3::ONE)).length() > 0.01);
}

/// Fields of the smallest valid file.
fn tiny() -> Vec<Written> {
    let sizes = Sizes { phi: vec![0.0], theta: vec![0.0, 1.5], side: 3, colors: 2 };
    let rgb =
        |[_, t]: [usize; 2], channel: usize, x: f64, y: f64| [1.0, x - 0.5, y + t as f64][channel];
    fields(&sizes, &ggx, &projected_area, &visible_density, &rgb)
}

#[test]
fn truncated_or_incomplete_files_are_rejected_with_a_reason() {
    let whole = file(&tiny());
    assert!(Rgl::read(&whole).is_ok());
    for length in 0..whole.len() {
        assert!(Rgl::read(&whole[..length]).is_err(), "{length}");
    }
    for missing in 0..tiny().len() {
        let mut fields = tiny();
        let name = fields.remove(missing).name;
        let error = Rgl::read(&file(&fields)).err().unwrap().to_string();
        assert_eq!(error, format!("the .bsdf file cannot be read: it has no field {name}"));
    }
    let changed = |change: &dyn Fn(&mut Vec<Written>)| {
        let mut fields = tiny();
        change(&mut fields);
        Rgl::read(&file(&fields)).err().unwrap()
    };
    let spectral = changed(&|fields| {
        fields[5].name = "spectra";
    });
    assert_eq!(spectral, RglError::Spectral(3));
    assert!(spectral.to_string().contains("only the RGB variant"));
    assert_eq!(changed(&|fields| fields[1].numbers[1] = 0.0), RglError::Angles("theta_i"));
    assert_eq!(changed(&|fields| fields[3].numbers[2] = -1.0), RglError::Negative("sigma", 2));
    assert_eq!(changed(&|fields| fields[4].numbers[10..].fill(0.0)), RglError::Empty(1));
    let error = changed(&|fields| fields[5].shape = vec![1, 2, 2, 2, 3]);
    assert!(
        error.to_string().ends_with("its field rgb is 1 x 2 x 2 x 2 x 3, not 1 x 2 x 3 x 2 x 3")
    );
    let error = changed(&|fields| fields[2].shape = vec![6, 1]);
    assert_eq!(error, RglError::Small("ndf"));
}

#[test]
fn negative_values_become_zero_and_nothing_is_reflected_below() {
    let rgl = Rgl::read(&file(&tiny())).unwrap();
    let pair = DirectionPair::new(DVec3::Z, direction(0.02, 1.0)).unwrap();
    let f = rgl.f(&pair);
    assert!(f.x > 0.0 && f.y == 0.0, "{f}");
    let below = DirectionPair::new(DVec3::Z, DVec3::NEG_Z).unwrap();
    assert_eq!(rgl.f(&below), DVec3::ZERO);
    let kept = rgl.keep_negative();
    let g = kept.f(&pair);
    assert!(g.y < 0.0 && (g.x, g.z) == (f.x, f.z), "{g} and {f}");
    assert_eq!(kept.f(&below), DVec3::ZERO);
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    let cosine = prop_oneof![0.0..1.0, Just(1.0), Just(1e-9), -0.1..0.1];
    (cosine, -4.0..4.0).prop_map(|(z, phi): (f64, f64)| {
        let sine = (1.0 - z * z).sqrt();
        DVec3::new(sine * phi.cos(), sine * phi.sin(), z)
    })
}

proptest! {
    #[test]
        fn values_are_finite_and_not_negative_for_any_numbers_in_the_file(
        numbers in prop::collection::vec(
            prop_oneof![Just(0.0_f32), 0.0..1.0_f32, Just(1e-38), Just(1e38)], 60),
        (wi, wo) in (any_direction(), any_direction()),
    ) {
        let mut fields = tiny();
        for (k, number) in numbers.into_iter().enumerate() {
            let field = &mut fields[2 + k % 4];
            let at = (k * 7) % field.numbers.len();
            field.numbers[at] = number;
        }
        if let Ok(rgl) = Rgl::read(&file(&fields)) {
            let f = rgl.f(&DirectionPair::new(wi, wo).unwrap());
            prop_assert!(f.is_finite() && f.min_element() >= 0.0, "{f}");
            let kept = rgl.keep_negative().f(&DirectionPair::new(wi, wo).unwrap());
            prop_assert!(kept.is_finite() && kept.max(DVec3::ZERO) == f, "{kept} and {f}");
        }
    }
}
