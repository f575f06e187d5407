//! Target of the searches: samples of a coloured, glossy, reciprocal material as CSV, as those of
//! the tests in `tests/src/target.rs`.

use std::array;
use std::f64::consts::TAU;

/// Seed of the directions.
const SEED: u64 = 1;
/// Factor and summand of a linear congruential generator (Knuth, MMIX).
const STEP: (u64, u64) = (6_364_136_223_846_793_005, 1_442_695_040_888_963_407);

/// Samples at directions that are the same in each run.
pub fn csv(rows: usize) -> String {
    let mut draws = Draws(SEED.wrapping_mul(2).wrapping_add(1));
    let mut text = String::from("wix,wiy,wiz,wox,woy,woz,r,g,b\n");
    for _ in 0..rows {
        let (i, o) = (draws.direction(), draws.direction());
        let sum: [f64; 3] = array::from_fn(|axis| i[axis] + o[axis]);
        let length = sum.iter().map(|part| part * part).sum::<f64>().sqrt();
        let gloss = 0.3 * (sum[2] / length).powi(24);
        let colour = [0.25, 0.12, 0.05].map(|diffuse| diffuse + gloss);
        let numbers = [i, o, colour].concat();
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        text += &numbers.join(",");
        text.push('\n');
    }
    text
}

/// Random numbers.
struct Draws(u64);

impl Draws {
    /// Number from 0 to 1.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(STEP.0).wrapping_add(STEP.1);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Direction above the surface.
    fn direction(&mut self) -> [f64; 3] {
        let (z, turn) = (0.05 + 0.95 * self.number(), TAU * self.number());
        let across = (1.0 - z * z).sqrt();
        [across * turn.cos(), across * turn.sin(), z]
    }
}

#[cfg(test)]
mod tests {
    use super::csv;

    #[test]
    fn samples_are_unit_directions_and_reflectances() {
        let text = csv(50);
        assert_eq!(text, csv(50));
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|word| word.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows.len(), 50);
        for row in rows {
            for direction in [&row[..3], &row[3..6]] {
                let square: f64 = direction.iter().map(|part| part * part).sum();
                assert!((square - 1.0).abs() < 1e-9 && direction[2] > 0.0, "{row:?}");
            }
            assert!(row.len() == 9 && row[6..].iter().all(|f| (0.05..0.6).contains(f)), "{row:?}");
        }
    }
}
