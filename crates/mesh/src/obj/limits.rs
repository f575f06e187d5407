//! Limits of the OBJ parser.

/// Limits on the size of a file; a file above any of them is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObjLimits {
    /// Length of the file in bytes.
    pub bytes: usize,
    /// Number of `v`, of `vt` and of `vn` lines, and of vertices after joining equal corners.
    pub vertices: usize,
    /// Number of triangles after triangulation.
    pub triangles: usize,
    /// Number of corners of one polygon.
    pub polygon_corners: usize,
}

impl Default for ObjLimits {
    fn default() -> Self {
        Self { bytes: 32 << 20, vertices: 2_000_000, triangles: 2_000_000, polygon_corners: 1000 }
    }
}
