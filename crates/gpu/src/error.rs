//! What can go wrong with a GPU.

/// Why there is no GPU evaluator, or no result from it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// No driver, no device, or none that matches the options.
    #[error("no graphics adapter was found")]
    NoAdapter,
    /// An adapter is there but gives no device.
    #[error("the adapter gives no device: {0}")]
    NoDevice(String),
    /// The driver or the API refused something.
    #[error("the graphics driver refused the work: {0}")]
    Rejected(String),
    /// Not enough memory on the device.
    #[error("the graphics device is out of memory: {0}")]
    OutOfMemory(String),
    /// The device went away.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The device did not finish in time.
    #[error("the graphics device did not finish within {timeout_ms} ms")]
    Timeout {
        /// The bound that passed.
        timeout_ms: u64,
    },
    /// A program with layers, which the CPU evaluates.
    #[error("models of reflectance are evaluated on the CPU")]
    Layers,
    /// A program beyond what the shader holds; other evaluators may take it.
    #[error("a program has {given} {what}; the shader holds {most}")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much.
        given: usize,
        /// The bound.
        most: usize,
    },
}

impl GpuError {
    /// Whether a new device may do what this one did not.
    pub(crate) fn is_worth_a_new_device(&self) -> bool {
        match self {
            Self::Lost(_) | Self::Timeout { .. } => true,
            Self::NoAdapter | Self::NoDevice(_) | Self::Rejected(_) => false,
            Self::OutOfMemory(_) | Self::TooLarge { .. } | Self::Layers => false,
        }
    }
}
