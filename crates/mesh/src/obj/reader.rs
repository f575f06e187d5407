//! Reader of statements: positions, texture positions, normals and polygons, with checked indices.

use glam::{DVec2, DVec3};

use super::face::{ABSENT, Corner, Counts, corner};
use super::line::Lines;
use super::number::{coordinate, coordinates};
use super::warning::Warnings;
use super::{ObjError, ObjErrorKind, ObjLimits};

/// Contents of all statements.
#[derive(Default)]
pub(super) struct Records {
    pub positions: Vec<DVec3>,
    pub uvs: Vec<DVec2>,
    pub normals: Vec<DVec3>,
    /// Corners of all polygons, concatenated.
    pub corners: Vec<Corner>,
    pub polygons: Vec<Polygon>,
    /// Number of the last line, at least 1.
    pub last_line: u32,
}

/// Polygon: end of its range in the corners (which starts at the end of the previous one) and its
/// line.
#[derive(Clone, Copy)]
pub(super) struct Polygon {
    pub end: usize,
    pub line: u32,
}

/// Reads all statements and checks indices, including forward references.
///
/// # Errors
/// Returns the first malformed statement, an exceeded limit, an index out of range, or a missing
/// face.
pub(super) fn read(
    bytes: &[u8],
    limits: &ObjLimits,
    warnings: &mut Warnings,
) -> Result<Records, ObjError> {
    let mut records = Records::default();
    let mut lines = Lines::new(bytes);
    for line in lines.by_ref() {
        let mut words = line
            .text
            .split(|byte| byte.is_ascii_whitespace() || *byte == 0x0b)
            .filter(|w| !w.is_empty());
        let Some(keyword) = words.next() else { continue };
        records
            .statement(keyword, &mut words, line.number, limits, warnings)
            .map_err(|kind| kind.at(line.number))?;
    }
    records.last_line = lines.taken.max(1);
    if records.polygons.is_empty() {
        return Err(ObjErrorKind::NoFace.at(records.last_line));
    }
    records.check_indices()?;
    Ok(records)
}

impl Records {
    fn statement<'a>(
        &mut self,
        keyword: &[u8],
        words: &mut impl Iterator<Item = &'a [u8]>,
        line: u32,
        limits: &ObjLimits,
        warnings: &mut Warnings,
    ) -> Result<(), ObjErrorKind> {
        match keyword {
            b"v" => {
                check_limit(self.positions.len(), limits.vertices, "vertices")?;
                self.positions.push(DVec3::from(coordinates::<3>(words, "vertex coordinate")?));
            }
            b"vt" => {
                check_limit(self.uvs.len(), limits.vertices, "texture coordinates")?;
                let what = "texture coordinate";
                let [u] = coordinates::<1>(words, what)?;
                // One-dimensional textures have u only.
                let v = words.next().map_or(Ok(0.0), |word| coordinate(word, what))?;
                self.uvs.push(DVec2::new(u, v));
            }
            b"vn" => {
                check_limit(self.normals.len(), limits.vertices, "normals")?;
                self.normals.push(DVec3::from(coordinates::<3>(words, "normal coordinate")?));
            }
            b"f" => self.face(words, line, limits)?,
            b"g" | b"o" | b"s" | b"usemtl" => {}
            b"mtllib" => warnings.once(line, "mtllib is ignored: other files are not read"),
            b"l" => warnings.once(line, "lines (l) are ignored"),
            b"p" => warnings.once(line, "points (p) are ignored"),
            _ => warnings.unknown_keyword(line, keyword),
        }
        Ok(())
    }

    fn face<'a>(
        &mut self,
        words: &mut impl Iterator<Item = &'a [u8]>,
        line: u32,
        limits: &ObjLimits,
    ) -> Result<(), ObjErrorKind> {
        let counts = Counts { v: self.positions.len(), t: self.uvs.len(), n: self.normals.len() };
        let start = self.corners.len();
        for word in words {
            let count = self.corners.len() - start;
            check_limit(count, limits.polygon_corners, "corners in a face")?;
            self.corners.push(corner(word, counts)?);
        }
        let end = self.corners.len();
        if end - start < 3 {
            return Err(ObjErrorKind::TooFewCorners);
        }
        // A polygon of k corners becomes k - 2 triangles.
        let triangles = end - 2 * (self.polygons.len() + 1);
        check_limit(triangles, limits.triangles + 1, "triangles")
            .map_err(|_| ObjErrorKind::TooMany { what: "triangles", limit: limits.triangles })?;
        self.polygons.push(Polygon { end, line });
        Ok(())
    }

    fn check_indices(&self) -> Result<(), ObjError> {
        let within = |index: u32, count: usize| (index as usize) < count;
        let mut start = 0;
        for polygon in &self.polygons {
            for corner in &self.corners[start..polygon.end] {
                let what = if !within(corner.v, self.positions.len()) {
                    "vertex"
                } else if corner.t != ABSENT && !within(corner.t, self.uvs.len()) {
                    "texture coordinate"
                } else if corner.n != ABSENT && !within(corner.n, self.normals.len()) {
                    "normal"
                } else {
                    continue;
                };
                return Err(ObjErrorKind::IndexOutOfRange { what }.at(polygon.line));
            }
            start = polygon.end;
        }
        Ok(())
    }
}

/// Error if one more item would exceed the limit.
fn check_limit(count: usize, limit: usize, what: &'static str) -> Result<(), ObjErrorKind> {
    if count < limit {
        return Ok(());
    }
    Err(ObjErrorKind::TooMany { what, limit })
}
