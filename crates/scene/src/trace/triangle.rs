//! The watertight ray-triangle test, in f64.

use glam::DVec3;

/// A ray with the axes permuted and sheared so that it runs along +z of its own frame.
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: [f64; 3],
}

impl ShearedRay {
    /// `None` where the direction is zero or not finite.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let size = direction.abs();
        let kz = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        // Keeps the sense of triangles.
        if direction[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let depth = direction[kz];
        let usable = depth != 0.0 && direction.is_finite() && origin.is_finite();
        let shear = [direction[kx] / depth, direction[ky] / depth, 1.0 / depth];
        usable.then_some(Self { origin, axes: [kx, ky, kz], shear })
    }

    /// Distance and corner weights of the hit, from either side, edges included.
    ///
    /// Two triangles that share an edge compute its sign from the same numbers, so that no ray slips between them.
    ///
    /// # Source
    /// Woop, Benthin and Wald 2013, *Watertight Ray/Triangle Intersection*.
    pub fn intersect(&self, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let [a, b, c] = corners.map(|corner| {
            let w = corner - self.origin;
            DVec3::new(w[kx] - sx * w[kz], w[ky] - sy * w[kz], sz * w[kz])
        });
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
}
