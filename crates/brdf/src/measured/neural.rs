//! Neural materials: published weights of small networks that were trained on measured tables.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use crate::{Brdf, Claims, DirectionPair};

/// A network of 6, 21, 21 and 3 units that was trained on a measured material.
///
/// # Source
/// Sztrajman, Rainer, Ritschel and Weyrich, *Neural BRDF Representation and Importance Sampling*
/// (2021): input is the half vector, rotated to the xz plane, and the difference vector; output is
/// max(exp(x) - 1, 0). Not exactly reciprocal.
#[derive(Debug, Clone, Deserialize)]
pub struct Neural {
    w1: Vec<[f64; 21]>,
    b1: [f64; 21],
    w2: Vec<[f64; 21]>,
    b2: [f64; 21],
    w3: Vec<[f64; 3]>,
    b3: [f64; 3],
}

/// Error of reading neural materials.
#[derive(Debug, thiserror::Error)]
pub enum NeuralError {
    /// The text is not the JSON of a file of weights.
    #[error("not a file of neural materials: {0}")]
    Json(#[from] serde_json::Error),
    /// The file has no material of that name.
    #[error("there is no material {name}; the file has {known}")]
    Unknown {
        /// The unknown name.
        name: String,
        /// Names of the file's materials.
        known: String,
    },
    /// The weights have the wrong shape, or one is not finite.
    #[error("the weights of {0} are not those of a 6-21-21-3 network")]
    Weights(String),
}

#[derive(Deserialize)]
struct File {
    materials: BTreeMap<String, Neural>,
}

impl Neural {
    /// Returns the names of the materials in a file of weights, sorted.
    ///
    /// # Errors
    /// Returns [`NeuralError::Json`] if the bytes are not such a file.
    pub fn names(bytes: &[u8]) -> Result<Vec<String>, NeuralError> {
        let file: File = serde_json::from_slice(bytes)?;
        Ok(file.materials.into_keys().collect())
    }

    /// Reads a material from a file of weights: `materials` by name, each with `w1` (6 x 21),
    /// `b1`, `w2`, `b2`, `w3` (21 x 3) and `b3`; a row holds the weights of one input.
    ///
    /// # Errors
    /// Returns [`NeuralError`] if the bytes are not such a file, the name is unknown, or the
    /// weights have the wrong shape.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self, NeuralError> {
        let mut file: File = serde_json::from_slice(bytes)?;
        let Some(neural) = file.materials.remove(name) else {
            let known: Vec<&str> = file.materials.keys().map(String::as_str).collect();
            return Err(NeuralError::Unknown { name: name.to_owned(), known: known.join(", ") });
        };
        let counts = (neural.w1.len(), neural.w2.len(), neural.w3.len());
        let weights =
            neural.w1.iter().chain(&neural.w2).flatten().chain(neural.w3.iter().flatten());
        let biases = neural.b1.iter().chain(&neural.b2).chain(&neural.b3);
        if counts != (6, 21, 21) || !weights.chain(biases).all(|weight| weight.is_finite()) {
            return Err(NeuralError::Weights(name.to_owned()));
        }
        Ok(neural)
    }
}

impl Brdf for Neural {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        if pair.cos_i() <= 0.0 || pair.cos_o() <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (pair.wi() + pair.wo()).normalize();
        let across = half.truncate().length();
        let (cos, sin) = if across > 0.0 { (half.x / across, half.y / across) } else { (1.0, 0.0) };
        // wi rotated by -phi_h about the normal, then by -theta_h about y.
        let turned = {
            let wi = pair.wi();
            DVec3::new(cos * wi.x + sin * wi.y, cos * wi.y - sin * wi.x, wi.z)
        };
        let difference = DVec3::new(
            half.z * turned.x - across * turned.z,
            turned.y,
            across * turned.x + half.z * turned.z,
        );
        let input = [across, 0.0, half.z, difference.x, difference.y, difference.z];
        let first = layer(&input, &self.w1, &self.b1).map(|x| x.max(0.0));
        let second = layer(&first, &self.w2, &self.b2).map(|x| x.max(0.0));
        let out = layer(&second, &self.w3, &self.b3);
        // The limit of 40 keeps exp far above any reflectance and within f64.
        DVec3::from_array(out.map(|x| libm::expm1(x.min(40.0)).max(0.0)))
    }

    fn claims(&self) -> Claims {
        Claims::default()
    }
}

fn layer<const N: usize>(input: &[f64], weights: &[[f64; N]], bias: &[f64; N]) -> [f64; N] {
    let mut out = *bias;
    for (x, row) in input.iter().zip(weights) {
        for (out, weight) in out.iter_mut().zip(row) {
            *out += x * weight;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(w1_rows: usize) -> String {
        let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
        let value = serde_json::json!({"materials": {"grey": {
            "w1": zeros(w1_rows, 21), "b1": vec![0.0; 21], "w2": zeros(21, 21), "b2": vec![0.0; 21],
            "w3": zeros(21, 3), "b3": [2f64.ln(), 0.0, -1.0],
        }}});
        value.to_string()
    }

    #[test]
    fn network_with_zero_weights_returns_its_bias() {
        let neural = Neural::read(file(6).as_bytes(), "grey").unwrap();
        let pair = DirectionPair::new(DVec3::new(0.6, 0.0, 0.8), DVec3::Z).unwrap();
        assert!((neural.f(&pair) - DVec3::new(1.0, 0.0, 0.0)).length() < 1e-15);
        let below = DirectionPair::new(DVec3::new(0.6, 0.0, -0.8), DVec3::Z).unwrap();
        assert_eq!(neural.f(&below), DVec3::ZERO);
    }

    #[test]
    fn files_are_rejected_with_a_reason() {
        let refused =
            |text: &str, name: &str| Neural::read(text.as_bytes(), name).unwrap_err().to_string();
        assert_eq!(refused(&file(6), "gold"), "there is no material gold; the file has grey");
        assert_eq!(
            refused(&file(5), "grey"),
            "the weights of grey are not those of a 6-21-21-3 network"
        );
        assert!(refused("[1, 2]", "grey").starts_with("not a file of neural materials: "));
    }
}
