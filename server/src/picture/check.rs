//! Whether bytes that a worker sent can be the picture asked for: its kind and its size, from the header.

use brood_protocol::PictureFormat;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
const EXR: &[u8] = b"\x76\x2f\x31\x01";

/// Refuses bytes that do not begin as a picture of that format, width and height.
pub fn check(bytes: &[u8], format: PictureFormat, size_px: (u32, u32)) -> Result<(), String> {
    match format {
        PictureFormat::Png => {
            let header = bytes.strip_prefix(PNG).ok_or("it does not begin as a PNG file")?;
            let sides = header.get(..8).ok_or("its header is cut off")?;
            let (width, height) = sides.split_at(4);
            let (wide, high) = size_px;
            if width != wide.to_be_bytes() || height != high.to_be_bytes() {
                return Err(format!("it is not {wide} pixels wide and {high} high"));
            }
            let end = b"\0\0\0\0IEND\xaeB`\x82";
            if bytes.ends_with(end) { Ok(()) } else { Err("its end is missing".to_owned()) }
        }
        PictureFormat::Exr if bytes.starts_with(EXR) => Ok(()),
        PictureFormat::Exr => Err("it does not begin as an EXR file".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_takes_pictures_of_the_right_size_only() {
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
    }
}
