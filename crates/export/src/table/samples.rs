//! Writer of samples as CSV: pairs of directions with f, as targets of searches are given.

use brood_brdf::DirectionPair;

use super::source::Source;
use crate::exported::Exported;
use crate::reflectance::even_pairs;

/// Number of samples; half of them are near the mirror direction.
const SAMPLES: usize = 8192;

/// Makes the file.
pub(super) fn file(source: &Source<'_>) -> Exported {
    let pairs = even_pairs(SAMPLES);
    let f = source.f(&pairs);
    let rows = pairs.iter().zip(f.into_iter().map(|f| f.to_array()));
    let bytes = samples_csv(rows).into_bytes();
    let note =
        format!("{}; {SAMPLES} samples, half of them near the mirror direction", source.words());
    Exported { bytes, note: Some(note) }
}

/// Returns samples as CSV, in the format of a target.
#[must_use]
pub fn samples_csv<'a>(rows: impl Iterator<Item = (&'a DirectionPair, [f64; 3])>) -> String {
    let mut text = String::from("wix,wiy,wiz,wox,woy,woz,r,g,b\n");
    for (pair, [r, g, b]) in rows {
        let (wi, wo) = (pair.wi(), pair.wo());
        text += &format!("{},{},{},{},{},{},{r},{g},{b}\n", wi.x, wi.y, wi.z, wo.x, wo.y, wo.z);
    }
    text
}
