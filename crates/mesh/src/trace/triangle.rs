//! Watertight ray-triangle test in f64.

use glam::DVec3;

/// Ray with a frame of permuted and sheared axes in which it runs along +z.
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: Axes,
    shear: [f64; 3],
}

/// Permutation of the components of a vector.
#[derive(Clone, Copy)]
enum Axes {
    Xyz,
    Yzx,
    Zxy,
    Yxz,
    Zyx,
    Xzy,
}

impl ShearedRay {
    /// Returns `None` if the direction is zero, or the ray is not finite.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let size = direction.abs();
        // The last axis is that of the largest component. If it is negative the other two are
        // swapped, which preserves the orientation of triangles.
        let (axes, w) = if size.x >= size.y && size.x >= size.z {
            let forward = direction.x >= 0.0;
            let w = DVec3::new(direction.y, direction.z, direction.x);
            (if forward { Axes::Yzx } else { Axes::Zyx }, w)
        } else if size.y >= size.z {
            let forward = direction.y >= 0.0;
            let w = DVec3::new(direction.z, direction.x, direction.y);
            (if forward { Axes::Zxy } else { Axes::Xzy }, w)
        } else {
            let forward = direction.z >= 0.0;
            (if forward { Axes::Xyz } else { Axes::Yxz }, direction)
        };
        let w = match axes {
            Axes::Xyz | Axes::Yzx | Axes::Zxy => w,
            Axes::Yxz | Axes::Zyx | Axes::Xzy => DVec3::new(w.y, w.x, w.z),
        };
        let is_valid = w.z != 0.0 && direction.is_finite() && origin.is_finite();
        let shear = [w.x / w.z, w.y / w.z, 1.0 / w.z];
        is_valid.then_some(Self { origin, axes, shear })
    }

    /// Returns the distance and corner weights of a hit, from either side, edges included.
    ///
    /// Two triangles that share an edge compute its sign from the same numbers, so no ray passes
    /// between them.
    ///
    /// # Source
    /// Woop, Benthin and Wald 2013, *Watertight Ray/Triangle Intersection*.
    #[inline]
    pub fn intersect(&self, corners: &[DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = [self.shear(corners[0]), self.shear(corners[1]), self.shear(corners[2])];
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let weights = [u / sum, v / sum, w / sum];
        let distance = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
        (distance > 0.0 && distance.is_finite()).then_some((distance, weights))
    }

    /// Transforms a corner into the ray's frame.
    #[inline]
    fn shear(&self, corner: DVec3) -> DVec3 {
        let w = corner - self.origin;
        let [sx, sy, sz] = self.shear;
        // A match instead of indexing: indexing would store the vector to memory.
        let (x, y, z) = match self.axes {
            Axes::Xyz => (w.x, w.y, w.z),
            Axes::Yzx => (w.y, w.z, w.x),
            Axes::Zxy => (w.z, w.x, w.y),
            Axes::Yxz => (w.y, w.x, w.z),
            Axes::Zyx => (w.z, w.y, w.x),
            Axes::Xzy => (w.x, w.z, w.y),
        };
        DVec3::new(x - sx * z, y - sy * z, sz * z)
    }
}
