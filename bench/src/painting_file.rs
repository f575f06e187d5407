//! PICTURE arguments: the colours of a PNG or JPEG file, or JSON of a painting palette.

use std::path::Path;

use anyhow::{Context, Result};
use brood_eval::{DisplayPicture, decode_display};
use brood_genome::PaintingPalette;
use brood_target::KnownView;

use crate::output::read_input;

/// Largest file, as on the server.
const LIMIT_BYTES: u64 = 64 << 20;

/// Reads the painting palette of the picture, or in the JSON file, at `path`; `-` is stdin.
///
/// # Errors
/// If the file cannot be read or is neither, or all of the picture is transparent.
pub fn read(path: &Path) -> Result<PaintingPalette> {
    parse(&read_input(path, LIMIT_BYTES)?).with_context(|| path.display().to_string())
}

fn parse(bytes: &[u8]) -> Result<PaintingPalette> {
    if bytes.trim_ascii_start().starts_with(b"{") {
        return Ok(serde_json::from_slice(bytes)?);
    }
    let DisplayPicture { width, height, rgba } = decode_display(bytes, KnownView::SIDE_MOST)?;
    Ok(PaintingPalette::of_picture(width, height, &rgba)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_and_its_json_give_the_same_palette() {
        let rgba: Vec<u8> = (0..64_u8).flat_map(|at| [at * 3, 40, 200 - at, 255]).collect();
        let palette = parse(&brood_eval::encode_png(8, 8, &rgba)).unwrap();
        assert_eq!(palette, PaintingPalette::of_picture(8, 8, &rgba).unwrap());
        let json = serde_json::to_string(&palette).unwrap();
        assert_eq!(parse(format!(" {json}").as_bytes()).unwrap(), palette);
        let error = parse(b"colours").unwrap_err().to_string();
        assert_eq!(error, "the picture must be a PNG or JPEG file");
        assert!(parse(b"{\"regions\": []}").unwrap_err().to_string().contains("1 to 6 regions"));
    }
}
