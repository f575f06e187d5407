use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::{Candidates, PixelFrustum, Ray, Stack, Tracer};

fn direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0f64)
        .prop_map(|(x, y, z)| DVec3::new(x, y, z))
        .prop_filter("a direction", |w| w.length() > 0.1)
        .prop_map(DVec3::normalize)
}

/// Returns the nearest hit by testing every triangle.
fn exhaustive(tracer: &Tracer, ray: Ray) -> Option<(usize, f64)> {
    let (sheared, _) = super::approach(ray)?;
    let mut best = None;
    for triangle in &tracer.triangles {
        super::test(&sheared, triangle, &mut best);
    }
    best.map(|hit| (hit.triangle, hit.distance))
}

proptest! {
    #[test]
    fn trace_equals_exhaustive_search(
        places in prop::collection::vec(direction(), 3..60),
        from in direction(),
        distance in prop::sample::select(vec![0.0, 0.5, 3.0, 1e6]),
        towards in direction(),
    ) {
        let count = places.len() as u32;
        let triangles: Vec<[u32; 3]> =
            (0..count).map(|k| [k, (k * 7 + 1) % count, (k * 3 + 2) % count]).collect();
        let tracer = Tracer::new(&places, &triangles, DVec3::ZERO, 1.0);
        let origin = from * distance;
        let ray = Ray { origin, direction: (towards * 0.5 - origin).normalize() };
        let hit = tracer.trace(ray, &mut Stack::default());
        prop_assert_eq!(hit.map(|hit| (hit.triangle, hit.distance)), exhaustive(&tracer, ray));
        if let Some(hit) = hit {
            prop_assert!(hit.weights.iter().all(|w| *w >= 0.0));
            prop_assert!((hit.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        // A hit occludes points behind it, and none in front of it.
        let start = super::approach(ray).map_or(0.0, |(_, start)| (start - origin).length());
        let distance = hit.map_or(f64::INFINITY, |hit| hit.distance + start);
        let blocked = |reach: f64| tracer.is_occluded(ray, reach, &mut Stack::default());
        prop_assert_eq!(blocked(f64::INFINITY), hit.is_some());
        prop_assert_eq!(blocked(distance + 1e-6), hit.is_some());
        prop_assert!(!blocked(distance - 1e-6));
    }
}

proptest! {
    #[test]
    fn candidates_of_frustum_give_hits_of_bvh(
        places in prop::collection::vec(direction(), 3..24),
        from in direction(),
        distance in prop::sample::select(vec![0.4, 3.0, 1e4]),
        at in (-0.9..0.9, -0.9..0.9f64),
        half in prop::sample::select(vec![1e-3, 0.02, 0.3]),
        parallel in any::<bool>(),
    ) {
        let count = places.len() as u32;
        let triangles: Vec<[u32; 3]> =
            (0..count).map(|k| [k, (k * 7 + 1) % count, (k * 3 + 2) % count]).collect();
        let tracer = Tracer::new(&places, &triangles, DVec3::ZERO, 1.0);
        let right: DVec3 = from.any_orthonormal_vector();
        let up: DVec3 = from.cross(right);
        let ray = |x: f64, y: f64| {
            let target: DVec3 = right * (at.0 + half * x) + up * (at.1 + half * y);
            if parallel {
                return Ray { origin: from * 2.0 + target, direction: -from };
            }
            let origin = from * distance;
            Ray { origin, direction: (target - origin).normalize() }
        };
        let frustum = PixelFrustum::new([ray(-1.0, -1.0), ray(1.0, -1.0), ray(1.0, 1.0), ray(-1.0, 1.0)]);
        let project = |p: DVec3| {
            let (right, up, away) = (p.dot(right), p.dot(up), p.dot(from));
            let shrunk = if parallel { 1.0 } else { distance / (distance - away) };
            let place = DVec2::new(right * shrunk - at.0, up * shrunk - at.1) / half;
            (parallel || distance - away > 1e-6).then(|| place * 0.5 + 0.5)
        };
        let (mut stack, mut candidates) = (Stack::default(), Candidates::default());
        prop_assert!(tracer.gather(&frustum.unwrap(), project, &mut stack, &mut candidates));
        for k in 0..81 {
            let place = DVec2::new(f64::from(k % 9), f64::from(k / 9)) / 8.0;
            let ray = ray(place.x * 2.0 - 1.0, place.y * 2.0 - 1.0);
            prop_assert_eq!(candidates.trace(ray, place), tracer.trace(ray, &mut stack), "{}", k);
        }
    }
}

#[test]
fn hit_is_lowest_triangle_when_several_coincide() {
    let places = [DVec3::NEG_ONE * 0.5, DVec3::X, DVec3::Y];
    let triangles = [[0, 0, 1], [1, 2, 0], [0, 1, 2], [2, 1, 0]];
    let tracer = Tracer::new(&places, &triangles, DVec3::ZERO, 1.0);
    let middle = (places[0] + places[1] + places[2]) / 3.0;
    for side in [1.0, -1.0] {
        let origin = middle + DVec3::new(1.0, 1.0, -3.0) * side;
        let ray = Ray { origin, direction: (middle - origin).normalize() };
        assert_eq!(tracer.trace(ray, &mut Stack::default()).map(|hit| hit.triangle), Some(1));
    }
}

#[test]
fn ray_hits_when_it_passes_through_edge_or_corner() {
    // A square of 8 x 8 cells; rays through every corner and points on every edge.
    let place = |i: u32, j: u32| {
        DVec3::new(f64::from(i), f64::from(j), 0.0) / 16.0 - DVec3::new(0.25, 0.25, 0.1)
    };
    let places: Vec<DVec3> = (0..9).flat_map(|j| (0..9).map(move |i| place(i, j))).collect();
    let triangles: Vec<[u32; 3]> = (0..8)
        .flat_map(|j| (0..8).map(move |i| j * 9 + i))
        .flat_map(|a| [[a, a + 1, a + 10], [a, a + 10, a + 9]])
        .collect();
    let tracer = Tracer::new(&places, &triangles, DVec3::ZERO, 1.0);
    for eye in [DVec3::Z * 2.0, DVec3::new(0.3, -0.7, 1.9), DVec3::new(1e5, 2e5, 3e5)] {
        for i in 1..32 {
            for j in 1..32 {
                let target = DVec3::new(f64::from(i), f64::from(j), 0.0) / 64.0
                    - DVec3::new(0.25, 0.25, 0.1);
                let ray = Ray { origin: eye, direction: (target - eye).normalize() };
                assert!(tracer.trace(ray, &mut Stack::default()).is_some(), "{eye} {i} {j}");
            }
        }
    }
}

#[test]
fn trace_misses_when_triangles_have_no_area_or_ray_is_not_finite() {
    let places = [DVec3::ZERO, DVec3::X, DVec3::X * 0.5];
    let flat = Tracer::new(&places, &[[0, 1, 2]], DVec3::ZERO, 1.0);
    let ray = Ray { origin: DVec3::Z, direction: DVec3::NEG_Z };
    assert_eq!(flat.trace(ray, &mut Stack::default()), None);
    let solid = Tracer::new(&[DVec3::X, DVec3::Y, DVec3::NEG_ONE], &[[0, 1, 2]], DVec3::ZERO, 1.0);
    let nowhere = Ray { origin: DVec3::NAN, direction: DVec3::Z };
    assert_eq!(solid.trace(nowhere, &mut Stack::default()), None);
}
