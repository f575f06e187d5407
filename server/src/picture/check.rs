//! Checks of pictures sent by workers: format, size, and for workers on other machines also that
//! they can be decoded.

use brood_eval::{LitSpheres, are_angles, are_ray_ends, decode_linear, decode_png};
use brood_protocol::PictureFormat;
use brood_scene::{PictureSize, SphereLayout};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
const EXR: &[u8] = b"\x76\x2f\x31\x01";

/// Bytes of a file beside those of its pixels.
const OVERHEAD_BYTES: usize = 64 << 10;

/// Checks that bytes look like a picture of this format, width and height.
///
/// # Errors
/// Reason why they do not.
pub fn check(bytes: &[u8], format: PictureFormat, size_px: (u32, u32)) -> Result<(), String> {
    // Packed pixels may take a little more than those of the picture: 4 and 16 bytes.
    let pixel_bytes = match format {
        PictureFormat::Png => 5,
        PictureFormat::Exr => 20,
        PictureFormat::Angles | PictureFormat::RayEnds | PictureFormat::Spheres => 0,
    };
    let pixels = size_px.0 as usize * size_px.1 as usize;
    let most = pixel_bytes * pixels + OVERHEAD_BYTES;
    if pixel_bytes > 0 && bytes.len() > most {
        return Err(format!("it has {} bytes, at most {most} are possible", bytes.len()));
    }
    match format {
        PictureFormat::Png => {
            let header = bytes.strip_prefix(PNG).ok_or("it must begin with a PNG header")?;
            let sides = header.get(..8).ok_or("the PNG header is incomplete")?;
            let (width, height) = sides.split_at(4);
            let (wide, high) = size_px;
            if width != wide.to_be_bytes() || height != high.to_be_bytes() {
                return Err(format!("it must be {wide} pixels wide and {high} high"));
            }
            let end = b"\0\0\0\0IEND\xaeB`\x82";
            if bytes.ends_with(end) {
                Ok(())
            } else {
                Err("the end of the PNG is missing".to_owned())
            }
        }
        PictureFormat::Exr if bytes.starts_with(EXR) => Ok(()),
        PictureFormat::Exr => Err("it must begin with an EXR header".to_owned()),
        PictureFormat::Angles => {
            let words = || format!("it must be lit angles of {} pixels a side", size_px.0);
            are_angles(bytes, size_px.0).then_some(()).ok_or_else(words)
        }
        PictureFormat::RayEnds => {
            let words = || format!("it must be ray ends of {} pixels a side", size_px.0);
            are_ray_ends(bytes, size_px.0).then_some(()).ok_or_else(words)
        }
        PictureFormat::Spheres => {
            let (width, height) = size_px;
            let layout = SphereLayout::of_size(PictureSize { width, height })
                .ok_or("no lit spheres have this size")?;
            let whole = LitSpheres::sizes(layout).contains(&bytes.len())
                && LitSpheres::layout_of(bytes) == Some(layout);
            let SphereLayout { texels, turns } = layout;
            let words = || format!("it must be lit spheres of {texels} texels in {turns} turns");
            whole.then_some(()).ok_or_else(words)
        }
    }
}

/// Checks that a picture, which [`check`] has passed, can be decoded.
///
/// # Errors
/// Reason why it cannot.
pub fn decode(bytes: &[u8], format: PictureFormat, size_px: (u32, u32)) -> Result<(), String> {
    let found = match format {
        PictureFormat::Png => {
            let (width, height, _) = decode_png(bytes).map_err(|error| error.to_string())?;
            (width, height)
        }
        PictureFormat::Exr => {
            let side = size_px.0.max(size_px.1);
            let picture = decode_linear(bytes, side).map_err(|error| error.to_string())?;
            (picture.width, picture.height)
        }
        // Checked from the first to the last byte.
        PictureFormat::Angles | PictureFormat::RayEnds | PictureFormat::Spheres => size_px,
    };
    if found == size_px { Ok(()) } else { Err(format!("it has {} x {} pixels", found.0, found.1)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_in_the_frame_of_a_picture_and_padding_are_refused() {
        let png = brood_eval::encode_png(16, 12, &[7; 16 * 12 * 4]);
        decode(&png, PictureFormat::Png, (16, 12)).unwrap();
        let mut noise = png.clone();
        let (from, to) = (41, noise.len() - 16);
        noise[from..to].fill(0x5a);
        check(&noise, PictureFormat::Png, (16, 12)).unwrap();
        assert!(decode(&noise, PictureFormat::Png, (16, 12)).is_err());
        let padded = [&png[..33], &vec![0; 1 << 20], &png[33..]].concat();
        assert!(check(&padded, PictureFormat::Png, (16, 12)).is_err());
        assert!(decode(b"\x76\x2f\x31\x01rest", PictureFormat::Exr, (16, 12)).is_err());
    }

    #[test]
    fn check_accepts_only_pictures_of_the_right_format_and_size() {
        let png = brood_eval::encode_png(16, 12, &[7; 16 * 12 * 4]);
        check(&png, PictureFormat::Png, (16, 12)).unwrap();
        assert!(check(&png, PictureFormat::Png, (12, 16)).is_err());
        assert!(check(&png, PictureFormat::Png, (16, 16)).is_err());
        assert!(check(&png, PictureFormat::Exr, (16, 12)).is_err());
        assert!(check(&png[..20], PictureFormat::Png, (16, 12)).is_err());
        assert!(check(&png[..png.len() - 1], PictureFormat::Png, (16, 12)).is_err());
        assert!(check(b"", PictureFormat::Png, (16, 12)).is_err());
        assert!(check(b"GIF89a", PictureFormat::Png, (16, 12)).is_err());
        check(b"\x76\x2f\x31\x01rest", PictureFormat::Exr, (16, 12)).unwrap();
        let spheres = SphereLayout { texels: 4, turns: 1 };
        let spheres = LitSpheres::encode(spheres, &[[0.5; 3]; 144], None);
        check(&spheres, PictureFormat::Spheres, (12, 12)).unwrap();
        assert!(check(&spheres, PictureFormat::Spheres, (15, 15)).is_err());
        assert!(check(&spheres, PictureFormat::Spheres, (12, 24)).is_err());
        assert!(check(&spheres[..40], PictureFormat::Spheres, (12, 12)).is_err());
        assert!(check(&png, PictureFormat::Spheres, (12, 12)).is_err());
    }
}
