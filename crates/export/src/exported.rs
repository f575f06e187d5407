//! Result of an export.

/// A material in a format.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// Content of the file; UTF-8 unless the format is binary.
    pub bytes: Vec<u8>,
    /// Content of a table or fit and its distance from the material; `None` for code, which is
    /// exact.
    pub note: Option<String>,
}

impl Exported {
    /// The file as text.
    ///
    /// # Panics
    /// If the format is binary.
    #[must_use]
    pub fn into_text(self) -> String {
        String::from_utf8(self.bytes).expect("the format is text")
    }
}

impl From<String> for Exported {
    fn from(text: String) -> Self {
        Self { bytes: text.into_bytes(), note: None }
    }
}
