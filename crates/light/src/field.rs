//! Ranges of the numbers in descriptions, for which all later steps stay finite.

/// Largest magnitude of positions, distances and intensities: the range of f32, as for vertices.
const MAGNITUDE_MAX: f64 = f32::MAX as f64;

/// Error if a field of a description is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{pointer}: {reason}")]
pub struct FieldError {
    /// JSON pointer to the field, such as `/camera/fov_y_deg`.
    pub pointer: String,
    /// Reason.
    pub reason: String,
}

/// Returns an error with this pointer and reason unless `holds`.
///
/// # Errors
/// If `holds` is false.
pub fn require(holds: bool, pointer: &str, reason: &str) -> Result<(), FieldError> {
    if holds {
        return Ok(());
    }
    Err(FieldError { pointer: pointer.to_owned(), reason: reason.to_owned() })
}

/// Checks that all numbers are finite and within the range of f32.
///
/// # Errors
/// If one is not.
pub fn finite(numbers: &[f64], pointer: &str) -> Result<(), FieldError> {
    let holds = numbers.iter().all(|number| number.abs() <= MAGNITUDE_MAX);
    require(holds, pointer, "must be finite and within the range of 32-bit floats")
}

/// Checks that a number is large enough above 0 for ratios of such numbers to stay finite.
///
/// # Errors
/// If it is not, or not within the range of f32.
pub fn positive(number: f64, pointer: &str) -> Result<(), FieldError> {
    let holds = number >= f64::from(f32::MIN_POSITIVE) && number <= MAGNITUDE_MAX;
    require(holds, pointer, "must be above 0 and within the range of 32-bit floats")
}
