//! One comparison: what was measured, and what follows from it.
//!
//! Pure. The goal is one for all: no farther from the peer than two of its own pictures may well be from each other.

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::case::Case;

/// How many times the peer's noise brood may be off.
pub const GOAL: f64 = 2.0;

/// brood's picture against the peer's.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What is seen.
    pub object: String,
    /// What it is lit by.
    pub light: String,
    /// What it is made of.
    pub material: String,
    /// Whether the peer's picture is one that was recorded earlier; else it is the mean of some made now.
    pub recorded: bool,
    /// RMSE between brood's picture and the peer's.
    pub rmse: f64,
    /// RMSE between two of the peer's pictures over sqrt 2.
    pub noise: f64,
    /// How many of the peer's pictures are in what brood is held against.
    pub averaged: u32,
    /// RMSE between the recorded picture and the mean of those made now.
    pub recorded_rmse: Option<f64>,
    /// The largest value.
    pub brightest: f64,
}

impl Row {
    /// From what the peer's script says of a case.
    pub fn new(case: &Case, found: &Value) -> Result<Self> {
        let number =
            |key: &str| found[key].as_f64().with_context(|| format!("{}: no {key}", case.name()));
        let averaged = found["averaged"].as_u64().and_then(|count| u32::try_from(count).ok());
        Ok(Self {
            object: case.object.to_owned(),
            light: case.light.to_owned(),
            material: case.material_name.clone(),
            recorded: case.recorded.is_some(),
            rmse: number("rmse")?,
            noise: number("noise")?,
            averaged: averaged.with_context(|| format!("{}: no averaged", case.name()))?,
            recorded_rmse: found["recorded_rmse"].as_f64(),
            brightest: number("brightest")?,
        })
    }

    /// How many times the peer's noise it is off.
    pub fn times(&self) -> f64 {
        self.rmse / self.noise
    }

    /// What of the RMSE is not the noise of what brood is held against.
    pub fn beyond_noise(&self) -> f64 {
        let noise2 = self.noise * self.noise / f64::from(self.averaged);
        (self.rmse * self.rmse - noise2).max(0.0).sqrt()
    }

    /// Whether it is off by less than the goal.
    pub fn holds(&self) -> bool {
        self.times() < GOAL
    }

    /// As it is written.
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
    fn row_holds_when_it_is_off_by_less_than_twice_the_noise() {
        assert!(row(1.9e-3, 1e-3).holds());
        assert!(!row(2e-3, 1e-3).holds());
        assert!(!row(1e-3, 0.0).holds());
        assert!(!row(f64::NAN, 1e-3).holds());
    }

    #[test]
    fn noise_of_the_mean_is_taken_off() {
        // The mean of four has half the noise.
        assert!(row(0.5e-3, 1e-3).beyond_noise() < 1e-12);
        assert!((row(1.3e-3, 1e-3).beyond_noise() - 1.2e-3).abs() < 1e-12);
    }
}
