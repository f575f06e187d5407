//! Choice between LDR-FLIP and HDR-FLIP by the formats of two pictures, and its report.

use anyhow::{Context, Result};
use brood_inspect::Exposures;
use serde_json::{Value, json};

use super::picture::{ComparedPicture, DynamicRange};

/// FLIP error of two pictures, with the kind of FLIP.
#[derive(Debug, PartialEq)]
pub struct Flip {
    pub mean: f64,
    kind: Kind,
}

#[derive(Debug, PartialEq)]
enum Kind {
    /// `clipped` pixels of EXRs are outside of 0..1.
    Low { mixed: bool, clipped: usize },
    /// `negative` pixels count as 0 in a channel.
    High { exposures: Exposures, negative: usize },
}

impl Flip {
    /// Compares two EXRs by HDR-FLIP, and by LDR-FLIP if one of the pictures is a PNG: that one
    /// ends at the white of its display, so exposures below it would only show its clipping.
    pub fn of(reference: &ComparedPicture, test: &ComparedPicture) -> Result<Self> {
        let both = [reference, test];
        if both.iter().all(|picture| picture.range == DynamicRange::High) {
            let found = reference.image.hdr_flip(&test.image).context(
                "HDR-FLIP takes its exposures from the reference, which must have a pixel above 0",
            )?;
            let negative = both.map(ComparedPicture::negative).iter().sum();
            let kind = Kind::High { exposures: found.exposures, negative };
            return Ok(Self { mean: found.mean, kind });
        }
        let mixed = reference.range != test.range;
        let clipped = both.map(ComparedPicture::clipped).iter().sum();
        let kind = Kind::Low { mixed, clipped };
        Ok(Self { mean: reference.image.flip(&test.image), kind })
    }

    /// One line of text.
    pub fn text(&self) -> String {
        match &self.kind {
            Kind::Low { mixed: false, .. } => "LDR-FLIP of 8-bit sRGB".to_owned(),
            Kind::Low { mixed: true, clipped } => format!(
                "LDR-FLIP of 8-bit sRGB, because one picture is a PNG; {clipped} pixels of the EXR are clipped to 0..1"
            ),
            Kind::High { exposures, negative } => {
                let Exposures { start_ev, stop_ev, count, mostly_black } = exposures;
                let median = if *mostly_black { " without black pixels" } else { "" };
                let mut text = format!(
                    "HDR-FLIP, ACES: {count} exposures from {start_ev:.2} EV (brightest pixel of the reference) to {stop_ev:.2} EV \
                     (its median{median})"
                );
                if *negative > 0 {
                    text += &format!("; negative values of {negative} pixels count as 0");
                }
                text
            }
        }
    }

    /// The same as JSON.
    pub fn json(&self) -> Value {
        match &self.kind {
            Kind::Low { clipped, .. } => json!({ "range": "ldr", "clipped_pixels": clipped }),
            Kind::High { exposures, negative } => json!({
                "range": "hdr",
                "tone_curve": "aces",
                "start_ev": exposures.start_ev,
                "stop_ev": exposures.stop_ev,
                "exposures": exposures.count,
                "black_pixels_omitted": exposures.mostly_black,
                "negative_pixels": negative,
            }),
        }
    }
}
