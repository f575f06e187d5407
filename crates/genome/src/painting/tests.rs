//! Palettes of pictures with known paints, of few colours and of random pixels.

use proptest::prelude::*;

use super::*;

/// Paints with their light scaled from 0.05 to 1, one below the other.
const PAINTS: [[f64; 3]; 3] = [[0.9, 0.25, 0.05], [0.1, 0.2, 0.8], [0.1, 0.6, 0.15]];

fn codes(light: [f64; 3]) -> [u8; 3] {
    Oklab::of_linear(light).codes()
}

fn opaque([red, green, blue]: [u8; 3]) -> [u8; 4] {
    [red, green, blue, 255]
}

/// Palette of a picture whose pixels are a function of column and row.
fn palette(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> PaintingPalette {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgba: Vec<u8> = places.flat_map(|(x, y)| pixel(x, y)).collect();
    PaintingPalette::of_picture(width, height, &rgba).unwrap()
}

fn shaded(x: u32, y: u32, width: u32, height: u32) -> [u8; 4] {
    let light = 0.05 + 0.95 * f64::from(x) / f64::from(width - 1);
    opaque(codes(PAINTS[(y * 3 / height) as usize].map(|value| light * value)))
}

fn hue(codes: [u8; 3]) -> f64 {
    let color = Oklab::of_codes(codes);
    color.b.atan2(color.a)
}

fn turn(one: f64, other: f64) -> f64 {
    let turn = (one - other).rem_euclid(std::f64::consts::TAU);
    turn.min(std::f64::consts::TAU - turn)
}

#[test]
fn region_is_a_paint_with_its_dark_and_bright_places() {
    let found = palette(60, 48, |x, y| shaded(x, y, 60, 48));
    assert_eq!(found.regions().len(), 3, "{found:?}");
    for paint in PAINTS {
        let near = |region: &&PaintingRegion| turn(hue(region.middle), hue(codes(paint))) < 0.1;
        let region = found.regions().iter().find(near);
        let region = region.unwrap_or_else(|| panic!("no region of {paint:?} in {found:?}"));
        assert!((region.share - 1.0 / 3.0).abs() < 0.01, "{region:?}");
        // 5 and 95 % of the light's range.
        for (color, light) in [(region.dark, 0.0975), (region.bright, 0.9525)] {
            let (own, wanted) =
                (Oklab::of_codes(color), Oklab::of_linear(paint.map(|v| light * v)));
            // The mean of lightness over a tenth of the light's range is not that of its middle.
            assert!((own.lightness - wanted.lightness).abs() < 0.015, "{own:?} for {wanted:?}");
            assert!((own.chroma() - wanted.chroma()).abs() < 0.01, "{own:?} for {wanted:?}");
        }
    }
}

#[test]
fn palette_does_not_depend_on_the_size_of_the_picture() {
    let small = palette(60, 48, |x, y| shaded(x, y, 60, 48));
    let twice = palette(120, 96, |x, y| shaded(x / 2, y / 2, 60, 48));
    assert_eq!(small, twice);
    // Averaged to 256 x 204 cells, which mix neighbours.
    let large = palette(1260, 1008, |x, y| shaded(x / 21, y / 21, 60, 48));
    for (one, other) in small.regions().iter().zip(large.regions()) {
        assert!((one.share - other.share).abs() < 0.01, "{one:?} {other:?}");
        for (one, other) in one.colors().iter().zip(other.colors()) {
            let near = one.iter().zip(other).all(|(one, other)| one.abs_diff(other) <= 3);
            assert!(near, "{small:?} {large:?}");
        }
    }
    assert_eq!(small.regions().len(), large.regions().len());
}

#[test]
fn large_pictures_are_averaged_in_linear_light() {
    let boards =
        |x: u32, y: u32| if (x + y).is_multiple_of(2) { opaque([255; 3]) } else { opaque([0; 3]) };
    let [region] = palette(512, 512, boards).regions().try_into().unwrap();
    assert_eq!(region.colors(), [[188; 3]; 3]);
}

#[test]
fn pictures_of_few_colours_have_few_regions() {
    let codes = [0x2b, 0x1e, 0x46];
    for (width, height) in [(1, 1), (3, 2), (400, 1), (1, 700)] {
        let found = palette(width, height, |_, _| opaque(codes));
        let whole = PaintingRegion { dark: codes, middle: codes, bright: codes, share: 1.0 };
        assert_eq!(found.regions(), [whole]);
    }
    // Lightness is even, so its quantiles are known.
    let [grey] = palette(200, 4, |x, _| {
        opaque(Oklab { lightness: 0.2 + 0.8 * f64::from(x) / 199.0, a: 0.0, b: 0.0 }.codes())
    })
    .regions()
    .try_into()
    .unwrap();
    for (color, wanted) in grey.colors().iter().zip([0.24, 0.6, 0.96]) {
        assert!((Oklab::of_codes(*color).lightness - wanted).abs() < 0.01, "{grey:?}");
    }
    let two = palette(8, 8, |x, _| opaque(if x < 2 { [200, 30, 30] } else { [30, 30, 200] }));
    let shares: Vec<f64> = two.regions().iter().map(|region| region.share).collect();
    assert_eq!(shares, [0.75, 0.25]);
    assert_eq!(two.regions()[1].dark, [200, 30, 30]);
}

#[test]
fn transparent_pixels_are_ignored() {
    let half = palette(8, 8, |x, _| if x < 4 { [255, 0, 0, 0] } else { [30, 60, 200, 255] });
    let codes = [30, 60, 200];
    assert_eq!(
        half.regions(),
        [PaintingRegion { dark: codes, middle: codes, bright: codes, share: 1.0 }]
    );
    // A pixel counts by its alpha.
    let glazed =
        palette(8, 8, |x, _| if x < 4 { [200, 30, 30, 51] } else { opaque([30, 30, 200]) });
    assert!((glazed.regions()[0].share - 1.0 / 1.2).abs() < 1e-3, "{glazed:?}");
    for (width, height, rgba) in [(2, 1, &[1, 2, 3, 0, 4, 5, 6, 0][..]), (0, 0, &[]), (0, 7, &[])] {
        let refused = PaintingPalette::of_picture(width, height, rgba);
        assert_eq!(refused, Err(PaintingError::Transparent));
    }
}

#[test]
fn single_pixels_have_no_region() {
    let blue = |x: u32, y: u32| {
        let light = 0.2 + f64::from(x * 7 % 64) / 80.0;
        if (x, y) == (40, 17) {
            [255, 0, 0, 255]
        } else {
            opaque(codes([0.1, 0.2, 0.8].map(|v| light * v)))
        }
    };
    let found = palette(64, 64, blue);
    assert_eq!(found.regions().len(), 1, "{found:?}");
}

#[test]
fn nearly_black_places_are_the_dark_ones_of_regions() {
    let noise = |x: u32, y: u32| {
        let codes = [[2, 0, 1], [0, 2, 0], [1, 1, 3], [3, 1, 0], [0, 0, 0]];
        codes[((x * 7 + y * 13) % 5) as usize]
    };
    let tan = [200, 160, 90];
    let found = palette(64, 64, |x, y| opaque(if x < 20 { noise(x, y) } else { tan }));
    assert_eq!(found.regions().len(), 1, "{found:?}");
    assert_eq!((found.regions()[0].middle, found.regions()[0].bright), (tan, tan));
    assert!(found.regions()[0].dark.iter().all(|code| *code < 4), "{found:?}");
    // Of dark pictures all is used.
    let dark = palette(64, 64, |x, _| opaque(if x < 32 { [18, 2, 2] } else { [2, 2, 18] }));
    assert_eq!(dark.regions().len(), 2, "{dark:?}");
}

#[test]
fn invalid_palettes_are_refused() {
    let refused = |json: serde_json::Value| {
        serde_json::from_value::<PaintingPalette>(json).unwrap_err().to_string()
    };
    let region = |dark: &str, bright: &str, share: f64| serde_json::json!({"dark": dark, "middle": bright, "bright": bright, "share": share});
    let good = region("#000000", "#ffffff", 0.5);
    let text = refused(serde_json::json!({"regions": []}));
    assert_eq!(text, "a painting palette must have 1 to 6 regions, got 0");
    let text = refused(serde_json::json!({"regions": vec![good.clone(); 7]}));
    assert_eq!(text, "a painting palette must have 1 to 6 regions, got 7");
    let text = refused(serde_json::json!({"regions": [good, region("#000000", "#ffffff", 0.0)]}));
    assert_eq!(text, "`share` of region 1 must be above 0 and at most 1, got 0");
    let text = refused(serde_json::json!({"regions": [region("#ffffff", "#000000", 1.0)]}));
    assert!(text.contains("must ascend in lightness, got #ffffff #000000 #000000"), "{text}");
    let text = refused(serde_json::json!({"regions": [region("white", "#ffffff", 1.0)]}));
    assert!(text.contains("a colour must be like #2b1e46, got \"white\""), "{text}");
    let text = refused(serde_json::json!({"regions": [], "name": "x"}));
    assert!(text.contains("unknown field `name`"), "{text}");
}

proptest! {
    #[test]
    fn palettes_of_random_pictures_are_valid(
        width in 1_u32..14,
        colors in prop::collection::vec(prop::array::uniform4(any::<u8>()), 1..200),
        used in 1_usize..40,
    ) {
        let height = colors.len() as u32 / width;
        // Few different colours as well as many.
        let pixels = (0..(width * height) as usize).map(|at| colors[at % used.min(colors.len())]);
        let rgba: Vec<u8> = pixels.flatten().collect();
        let is_seen = rgba.chunks(4).any(|pixel| pixel[3] > 0);
        let found = PaintingPalette::of_picture(width, height, &rgba);
        prop_assert_eq!(found.is_ok(), is_seen);
        if let Ok(found) = found {
            prop_assert_eq!(&PaintingPalette::of_picture(width, height, &rgba).unwrap(), &found);
            let shares: Vec<f64> = found.regions().iter().map(|region| region.share).collect();
            prop_assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{:?}", shares);
            prop_assert!(shares.is_sorted_by(|one, other| one >= other), "{:?}", shares);
            let json = serde_json::to_string(&found).unwrap();
            prop_assert_eq!(serde_json::from_str::<PaintingPalette>(&json).unwrap(), found, "{}", json);
        }
    }
}
