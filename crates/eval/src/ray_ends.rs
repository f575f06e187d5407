//! Files of ray ends for the page.

use brood_scene::{PixelRays, RayEnd, RayEnds, Toggles};
use half::f16;

use crate::lit_angles::word_at;

const MAGIC: &[u8; 8] = b"broodend";
const VERSION: u32 = 1;
/// Bytes before the numbers of rows.
const HEAD: usize = 28;
/// Bytes of a pixel, of an end, and of the angles of an end.
const PIXEL: usize = 24;
const END: usize = 48;
const ANGLES: usize = size_of::<Toggles>();

/// Encodes ray ends, as blocks that are textures.
///
/// # Shapes
/// Little-endian: the magic `broodend`, u32 version, u32 side of the picture in pixels, u32 ends in
/// a row, u32 parts (the subject, the other objects, the ground, the background), u32 sets of
/// angles, and u32 rows of each part. Then, for the pixels row by row from the bottom, four u32
/// each: the numbers of the ends of the mirrored ray and of both ways, from 1, 0 without a ray; and
/// 0. Then four f16 for each pixel: the lengths of these rays inside the body, and the share of the
/// first way. Then, for the ends part after part, each from a new row, five blocks: position and 1
/// (f32), and in f16 what painted materials read, direction against the ray with texture position,
/// normal and 1, tangent and 0. Places without an end are 0. Then a block for each set of
/// [`RayEnds::angles`], eight u16 an end.
#[must_use]
pub fn encode_ray_ends(ends: &RayEnds) -> Vec<u8> {
    let (across, rows) = layout(ends);
    let firsts: Vec<usize> = rows
        .iter()
        .scan(0, |next, rows| {
            let first = *next;
            *next += across * rows;
            Some(first)
        })
        .collect();
    let places = across * rows.iter().sum::<usize>();
    let (side, pixels) = (ends.side() as usize, ends.pixels());
    let mut bytes = Vec::with_capacity(HEAD + PIXEL * pixels.len() + END * places);
    bytes.extend(MAGIC);
    for number in [VERSION, ends.side(), word(across), word(rows.len()), word(ends.angles().len())]
    {
        bytes.extend(number.to_le_bytes());
    }
    for rows in &rows {
        bytes.extend(word(*rows).to_le_bytes());
    }
    let upwards = || pixels.chunks(side.max(1)).rev().flatten();
    let number = |end: Option<(usize, usize)>| {
        word(end.map_or(0, |(part, number)| 1 + firsts[part] + number)).to_le_bytes()
    };
    for PixelRays { ends, .. } in upwards() {
        bytes.extend(ends.iter().flat_map(|end| number(*end)));
        bytes.extend(0u32.to_le_bytes());
    }
    for PixelRays { lengths: [mirrored, first, second], share, .. } in upwards() {
        bytes.extend(halves([*mirrored, *first, *second, *share]));
    }
    let mut block = |size: usize, texel: &dyn Fn(&RayEnd, &mut Vec<u8>)| {
        for (part, rows) in ends.parts().iter().zip(&rows) {
            part.iter().for_each(|end| texel(end, &mut bytes));
            bytes.resize(bytes.len() + size * (across * rows - part.len()), 0);
        }
    };
    block(16, &|end, bytes| {
        let at = end.position.extend(1.0).to_array();
        bytes.extend(at.into_iter().flat_map(f32::to_le_bytes));
    });
    block(8, &|end, bytes| bytes.extend(halves(end.own)));
    block(8, &|end, bytes| bytes.extend(halves([end.eye.x, end.eye.y, end.uv.x, end.uv.y])));
    block(8, &|end, bytes| bytes.extend(halves(end.n.extend(1.0).to_array())));
    block(8, &|end, bytes| bytes.extend(halves(end.u.extend(0.0).to_array())));
    for (part, rows) in ends.angles().iter().flat_map(|set| set.iter().zip(&rows)) {
        bytes.extend(part.as_flattened().iter().flat_map(|toggle| toggle.to_le_bytes()));
        bytes.resize(bytes.len() + ANGLES * (across * rows - part.len()), 0);
    }
    bytes
}

/// Number of ends in a row, and of rows of each part: the smallest square that holds all.
fn layout(ends: &RayEnds) -> (usize, Vec<usize>) {
    let all: usize = ends.parts().iter().map(Vec::len).sum();
    let rows = |across: usize| -> Vec<usize> {
        ends.parts().iter().map(|part| part.len().div_ceil(across)).collect()
    };
    let mut across = all.isqrt().max(1);
    while rows(across).iter().sum::<usize>() > across {
        across += 1;
    }
    (across, rows(across))
}

fn word(count: usize) -> u32 {
    u32::try_from(count).expect("pictures have fewer than 2^32 rays")
}

fn halves(values: [f32; 4]) -> impl Iterator<Item = u8> {
    let largest = f16::MAX.to_f32();
    values
        .into_iter()
        .flat_map(move |value| f16::from_f32(value.clamp(-largest, largest)).to_le_bytes())
}

/// True if bytes are ray ends of a picture of this side, complete.
#[must_use]
pub fn are_ray_ends(bytes: &[u8], side: u32) -> bool {
    let number = |at: usize| word_at(bytes, at);
    let (across, parts, sets) = (u64::from(number(16)), number(20) as usize, u64::from(number(24)));
    if !bytes.starts_with(MAGIC) || [number(8), number(12)] != [VERSION, side] {
        return false;
    }
    // Parts of a scene are few; the bytes of more could overflow.
    let rows: u64 = (0..parts.min(256)).map(|part| u64::from(number(HEAD + 4 * part))).sum();
    let pixels = u64::from(side) * u64::from(side);
    let (head, ends) = ((HEAD + 4 * parts) as u64, across.saturating_mul(rows));
    let expected = head + PIXEL as u64 * pixels;
    let size = END as u64 + ANGLES as u64 * sets;
    expected.saturating_add(ends.saturating_mul(size)) == bytes.len() as u64
}

#[cfg(test)]
mod tests {
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::Scene;

    use super::*;

    fn encoded(side: u32) -> (RayEnds, Vec<u8>) {
        let mesh = Mesh::builtin(BuiltinMesh::Torus);
        let ends = RayEnds::trace((&Scene::default(), 1.5), &mesh, side);
        let bytes = encode_ray_ends(&ends);
        (ends, bytes)
    }

    #[test]
    fn files_are_recognised() {
        let (_, bytes) = encoded(9);
        assert!(are_ray_ends(&bytes, 9));
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let scene = Scene { shadows: true, ..Scene::default() };
        let lit = RayEnds::trace((&scene, 1.5), &mesh, 9);
        assert!(are_ray_ends(&encode_ray_ends(&lit), 9) && lit.angles().len() == 1);
        assert!(!are_ray_ends(&bytes, 8) && !are_ray_ends(b"", 9));
        assert!(!are_ray_ends(&bytes[..bytes.len() - 1], 9) && !are_ray_ends(&bytes[..40], 9));
    }

    #[test]
    fn numbers_lead_to_the_ends_of_the_rays() {
        const SIDE: u32 = 24;
        let (ends, bytes) = encoded(SIDE);
        let number = |at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize;
        let (across, parts) = (number(16), number(20));
        assert_eq!(parts, 2, "the subject, and what is behind");
        let pixels = HEAD + 4 * parts;
        let positions = pixels + PIXEL * (SIDE * SIDE) as usize;
        let rows: usize = (0..parts).map(|part| number(HEAD + 4 * part)).sum();
        assert!(rows <= across, "{rows} rows of {across}");
        let mut seen = 0;
        for (row, pixel) in ends.pixels().chunks(SIDE as usize).rev().flatten().enumerate() {
            for (ray, end) in pixel.ends.iter().enumerate() {
                let at = number(pixels + 16 * row + 4 * ray);
                let Some((part, own)) = end else {
                    assert_eq!(at, 0);
                    continue;
                };
                let place = positions + 16 * (at - 1);
                let x = f32::from_le_bytes(*bytes[place..].first_chunk().unwrap());
                assert_eq!(x.to_bits(), ends.parts()[*part][*own].position.x.to_bits());
                seen += 1;
            }
        }
        assert!(seen > 100, "{seen}");
    }
}
