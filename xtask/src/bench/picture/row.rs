//! One comparison of a picture of brood with the peer's.
//!
//! Pure. One goal holds for all rows: brood may differ from the peer by little more than two of the
//! peer's own pictures do.

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::case::Case;

/// Largest RMSE, as a multiple of the peer's noise.
pub const GOAL: f64 = 2.0;

/// brood's picture against the peer's.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the object.
    pub object: String,
    /// Name of the light.
    pub light: String,
    /// Name of the material.
    pub material: String,
    /// True if the peer's picture was recorded earlier; else it is the mean of several new ones.
    pub recorded: bool,
    /// RMSE between brood's picture and the peer's.
    pub rmse: f64,
    /// RMSE between two of the peer's pictures over sqrt 2.
    pub noise: f64,
    /// Number of the peer's pictures averaged in the one that brood is compared with.
    pub averaged: u32,
    /// RMSE between the recorded picture and the mean of the new ones.
    pub recorded_rmse: Option<f64>,
    /// Largest value of the picture.
    pub brightest: f64,
}

impl Row {
    /// Combines a case with the peer's results.
    pub fn new(case: &Case, found: &Value) -> Result<Self> {
        let number = |key: &str| {
            found[key]
                .as_f64()
                .with_context(|| format!("{}: the peer's row must have {key}", case.name()))
        };
        let averaged = found["averaged"].as_u64().and_then(|count| u32::try_from(count).ok());
        Ok(Self {
            object: case.object.to_owned(),
            light: case.light.to_owned(),
            material: case.material_name.clone(),
            recorded: case.recorded.is_some(),
            rmse: number("rmse")?,
            noise: number("noise")?,
            averaged: averaged
                .with_context(|| format!("{}: the peer's row must have averaged", case.name()))?,
            recorded_rmse: found["recorded_rmse"].as_f64(),
            brightest: number("brightest")?,
        })
    }

    /// RMSE as a multiple of the peer's noise.
    pub fn times(&self) -> f64 {
        self.rmse / self.noise
    }

    /// RMSE without the noise of the picture that brood is compared with.
    pub fn beyond_noise(&self) -> f64 {
        let noise2 = self.noise * self.noise / f64::from(self.averaged);
        (self.rmse * self.rmse - noise2).max(0.0).sqrt()
    }

    /// True if the RMSE is below the goal.
    pub fn holds(&self) -> bool {
        self.times() < GOAL
    }

    /// Row as it is written to the report.
    pub fn json(&self) -> Value {
        json!({
            "object": self.object,
            "light": self.light,
            "material": self.material,
            "recorded": self.recorded,
            "rmse": self.rmse,
            "peer_noise": self.noise,
            "peer_pictures_averaged": self.averaged,
            "recorded_rmse_against_anew": self.recorded_rmse,
            "times_noise": self.times(),
            "beyond_noise": self.beyond_noise(),
            "brightest": self.brightest,
            "holds": self.holds(),
        })
    }
}

#[cfg(test)]
pub mod tests {
    use super::Row;

    pub fn row(rmse: f64, noise: f64) -> Row {
        Row {
            object: "sphere".to_owned(),
            light: "point".to_owned(),
            material: "gold".to_owned(),
            recorded: false,
            rmse,
            noise,
            averaged: 4,
            recorded_rmse: None,
            brightest: 2.0,
        }
    }

    #[test]
    fn row_holds_when_its_rmse_is_below_twice_the_noise() {
        assert!(row(1.9e-3, 1e-3).holds());
        assert!(!row(2e-3, 1e-3).holds());
        assert!(!row(1e-3, 0.0).holds());
        assert!(!row(f64::NAN, 1e-3).holds());
    }

    #[test]
    fn noise_of_the_mean_is_subtracted() {
        // The mean of four has half the noise.
        assert!(row(0.5e-3, 1e-3).beyond_noise() < 1e-12);
        assert!((row(1.3e-3, 1e-3).beyond_noise() - 1.2e-3).abs() < 1e-12);
    }
}
