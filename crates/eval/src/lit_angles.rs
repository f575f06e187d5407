//! Files of lit angles for the page.

use brood_scene::{LitAngles, Toggles};

const MAGIC: &[u8; 8] = b"broodang";
const VERSION: u32 = 1;
/// Bytes before the angles.
const HEAD: usize = 20;

/// Encodes lit angles.
///
/// # Shapes
/// Little-endian: the magic `broodang`, u32 version, u32 side of the picture in pixels, u32 lights
/// (twice as many with both kinds of angles), then for each light the pixels row by row from the
/// bottom, eight u16 each: the angles of [`LitAngles::toggles`], 65,535 where there are fewer.
#[must_use]
pub fn encode_angles(angles: &LitAngles) -> Vec<u8> {
    let pixels = angles.side() * angles.side();
    let toggles = angles.toggles();
    let lights = toggles.len() as u32 / pixels;
    let mut bytes = Vec::with_capacity(HEAD + size_of_val(toggles));
    bytes.extend(MAGIC);
    for number in [VERSION, angles.side(), lights] {
        bytes.extend(number.to_le_bytes());
    }
    for toggle in toggles.as_flattened() {
        bytes.extend(toggle.to_le_bytes());
    }
    bytes
}

/// True if bytes are lit angles of a picture of this side, complete.
#[must_use]
pub fn are_angles(bytes: &[u8], side: u32) -> bool {
    let number = |at: usize| word_at(bytes, at);
    let angles = side as usize * side as usize * number(16) as usize;
    bytes.starts_with(MAGIC)
        && [number(8), number(12)] == [VERSION, side]
        && bytes.len() == HEAD + angles * size_of::<Toggles>()
}

/// Returns the little-endian number at a place; 0 beyond the end.
pub(crate) fn word_at(bytes: &[u8], at: usize) -> u32 {
    let chunk = bytes.get(at..).and_then(<[u8]>::first_chunk);
    chunk.map_or(0, |chunk| u32::from_le_bytes(*chunk))
}

#[cfg(test)]
mod tests {
    use brood_mesh::{BuiltinMesh, Mesh};

    use super::*;

    #[test]
    fn files_are_recognised() {
        let json = r#"{"shadows": true, "lights": [{}, {"position": [1, 2, 3]}]}"#;
        let scene = serde_json::from_str(json).unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let bytes = encode_angles(&LitAngles::trace(&scene, &mesh, 5));
        assert_eq!(bytes.len(), 20 + 2 * 25 * 16);
        assert!(are_angles(&bytes, 5));
        assert!(!are_angles(&bytes, 4) && !are_angles(&bytes[..20], 5) && !are_angles(b"", 5));
    }
}
