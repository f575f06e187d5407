//! Cursor over the words of a line of text, with their columns.

use super::TextError;
use crate::RANGE;

/// A word and its position.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub text: &'a str,
    pub line: u32,
    pub column: u32,
}

impl Word<'_> {
    pub(super) fn error(&self, reason: impl Into<String>) -> TextError {
        TextError { line: self.line, column: self.column, reason: reason.into() }
    }
}

/// Rest of a line without its comment.
pub(super) struct Cursor<'a> {
    rest: &'a str,
    line: u32,
    column: u32,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(text: &'a str, line: u32) -> Self {
        let rest = text.split('#').next().unwrap_or_default();
        Self { rest: rest.trim_end(), line, column: 1 }
    }

    /// Creates a cursor over a line in which words may begin with `#`: colours. Only a `#` before
    /// a blank begins a comment.
    pub(super) fn with_colors(text: &'a str, line: u32) -> Self {
        let is_comment = |at: &usize| !text[at + 1..].starts_with(|c: char| !c.is_whitespace());
        let comment = text.match_indices('#').map(|(at, _)| at).find(is_comment);
        Self { rest: text[..comment.unwrap_or(text.len())].trim_end(), line, column: 1 }
    }

    pub(super) fn is_at_end(&mut self) -> bool {
        self.skip_space();
        self.rest.is_empty()
    }

    /// Reads the next word. A comma is a word of its own.
    pub(super) fn word(&mut self, expected: &str) -> Result<Word<'a>, TextError> {
        self.skip_space();
        if self.rest.is_empty() {
            return Err(self.here().error(format!("expected {expected}, but the line ends")));
        }
        let end = match self.rest.find([',', ' ', '\t']) {
            Some(0) => 1,
            Some(end) => end,
            None => self.rest.len(),
        };
        Ok(self.take(end))
    }

    pub(super) fn comma(&mut self) -> Result<(), TextError> {
        let word = self.word("a comma")?;
        if word.text == "," {
            Ok(())
        } else {
            Err(word.error(format!("expected a comma before {}", quote(word.text))))
        }
    }

    pub(super) fn end(&mut self) -> Result<(), TextError> {
        if self.is_at_end() {
            return Ok(());
        }
        let word = self.word("the end of the line")?;
        Err(word.error(format!("expected the end of the line before {}", quote(word.text))))
    }

    /// Reads a number from `low` (0 or -65504) to 65504.
    pub(super) fn number(&mut self, low: f32) -> Result<f32, TextError> {
        self.number_within(low, RANGE)
    }

    /// Reads a number from `low` to `high`.
    pub(super) fn number_within(&mut self, low: f32, high: f32) -> Result<f32, TextError> {
        let word = self.word("a number")?;
        let value = parse_number(word.text)
            .ok_or_else(|| word.error(format!("expected a number, got {}", quote(word.text))))?;
        if (low..=high).contains(&value) {
            Ok(value)
        } else {
            let given = quote(word.text);
            Err(word.error(format!("expected a number from {low} to {high}, got {given}")))
        }
    }

    fn here(&self) -> Word<'a> {
        Word { text: "", line: self.line, column: self.column }
    }

    fn skip_space(&mut self) {
        let space = self.rest.len() - self.rest.trim_start().len();
        self.take(space);
    }

    /// Takes the next `bytes` bytes as a word.
    fn take(&mut self, bytes: usize) -> Word<'a> {
        let word = Word { text: &self.rest[..bytes], line: self.line, column: self.column };
        let characters = u32::try_from(word.text.chars().count()).unwrap_or(u32::MAX);
        self.column = self.column.saturating_add(characters);
        self.rest = &self.rest[bytes..];
        word
    }
}

/// Parses a decimal number; names of infinities and NaN are rejected.
fn parse_number(text: &str) -> Option<f32> {
    let plain = text.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    text.parse().ok().filter(|_| plain)
}

/// Quotes at most 24 characters of a word, so that errors stay short for any input.
pub(super) fn quote(text: &str) -> String {
    let short: String = text.chars().filter(|c| !c.is_control()).take(24).collect();
    if short.chars().count() < text.chars().count() {
        format!("`{short}...`")
    } else {
        format!("`{short}`")
    }
}

/// Cuts an error text to about two lines of a terminal.
pub(super) fn shortened(reason: &str) -> String {
    const LONGEST: usize = 240;
    match reason.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &reason[..end]),
        None => reason.to_owned(),
    }
}
