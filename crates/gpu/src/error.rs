//! Errors of the GPU evaluator.

/// Error of opening a GPU evaluator, or of a batch.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// There is no driver, no device, or none that matches the options.
    #[error("no graphics adapter was found")]
    NoAdapter,
    /// The adapter does not provide a device.
    #[error("the graphics adapter provides no device: {0}")]
    NoDevice(String),
    /// The driver or the API rejected something.
    #[error("the graphics driver rejected the work: {0}")]
    Rejected(String),
    /// The device has not enough memory.
    #[error("the graphics device is out of memory: {0}")]
    OutOfMemory(String),
    /// The device was lost.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The device did not finish in time.
    #[error("the graphics device did not finish within {timeout_ms} ms")]
    Timeout {
        /// Timeout that was exceeded.
        timeout_ms: u64,
    },
    /// A program has layers, which only the CPU evaluates.
    #[error("the GPU evaluator does not support layers of models; use the CPU")]
    Layers,
    /// A program exceeds a limit of the shader; other evaluators may run it.
    #[error("a program needs {given} {what}; the shader supports at most {most}")]
    TooLarge {
        /// Quantity that is too large.
        what: &'static str,
        /// Number required.
        given: usize,
        /// Largest number supported.
        most: usize,
    },
}

impl GpuError {
    /// True if a new device may succeed.
    pub(crate) fn may_succeed_on_a_new_device(&self) -> bool {
        match self {
            Self::Lost(_) | Self::Timeout { .. } => true,
            Self::NoAdapter | Self::NoDevice(_) | Self::Rejected(_) => false,
            Self::OutOfMemory(_) | Self::TooLarge { .. } | Self::Layers => false,
        }
    }
}
