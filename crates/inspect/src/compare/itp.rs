//! Colour difference of Recommendation ITU-R BT.2124.

/// Largest luminance of the PQ curve in cd/m2.
const PQ_PEAK: f64 = 10_000.0;
/// BT.2087: linear RGB of BT.709 to that of BT.2020.
const TO_2020: [[f64; 3]; 3] =
    [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]];
/// BT.2100: linear RGB of BT.2020 to LMS.
const TO_LMS: [[f64; 3]; 3] = [
    [1688.0 / 4096.0, 2146.0 / 4096.0, 262.0 / 4096.0],
    [683.0 / 4096.0, 2951.0 / 4096.0, 462.0 / 4096.0],
    [99.0 / 4096.0, 309.0 / 4096.0, 3688.0 / 4096.0],
];
/// BT.2124: PQ-encoded LMS to ITP, which is ICtCp with the second component halved.
const TO_ITP: [[f64; 3]; 3] = [
    [0.5, 0.5, 0.0],
    [0.5 * 6610.0 / 4096.0, -0.5 * 13613.0 / 4096.0, 0.5 * 7003.0 / 4096.0],
    [17933.0 / 4096.0, -17390.0 / 4096.0, -543.0 / 4096.0],
];

/// Delta E_ITP of two colours in linear RGB with the primaries of BT.709, where 1 is `white` cd/m2.
pub fn difference(a: [f64; 3], b: [f64; 3], white: f64) -> f64 {
    let (a, b) = (itp(a, white), itp(b, white));
    let [i, t, p] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    720.0 * (i * i + t * t + p * p).sqrt()
}

/// Returns ITP of a colour.
fn itp(rgb: [f64; 3], white: f64) -> [f64; 3] {
    let absolute = rgb.map(|value| value.max(0.0) * white);
    let lms = apply(&TO_LMS, apply(&TO_2020, absolute));
    apply(&TO_ITP, lms.map(encode_pq))
}

/// Inverse EOTF of SMPTE ST 2084.
fn encode_pq(luminance: f64) -> f64 {
    const M1: f64 = 2610.0 / 16384.0;
    const M2: f64 = 2523.0 / 32.0;
    const C1: f64 = 3424.0 / 4096.0;
    const C2: f64 = 2413.0 / 128.0;
    const C3: f64 = 2392.0 / 128.0;
    let power = libm::pow((luminance / PQ_PEAK).clamp(0.0, 1.0), M1);
    libm::pow((C1 + C2 * power) / (1.0 + C3 * power), M2)
}

fn apply(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pq_has_its_published_values() {
        for (luminance, code) in
            [(0.0, 0.0), (100.0, 0.508_078), (1000.0, 0.751_827), (10_000.0, 1.0)]
        {
            assert!((encode_pq(luminance) - code).abs() < 1e-5, "{luminance}");
        }
    }

    #[test]
    fn greys_have_no_colour_and_differ_by_their_pq_codes() {
        let [i, t, p] = itp([1.0; 3], 100.0);
        assert!((i - 0.508_078).abs() < 1e-4 && t.abs() < 1e-4 && p.abs() < 1e-4, "{i} {t} {p}");
        let difference = difference([1.0; 3], [0.0; 3], 100.0);
        assert!((difference - 720.0 * 0.508_078).abs() < 0.1, "{difference}");
    }
}
