//! Logical lines: comments removed, continued lines joined, numbered by their first physical line.

use std::borrow::Cow;

/// Logical line.
pub(super) struct Line<'a> {
    /// Number of the first physical line, from 1.
    pub number: u32,
    /// Text without comment and line end.
    pub text: Cow<'a, [u8]>,
}

/// Iterator over the logical lines of a file.
pub(super) struct Lines<'a> {
    remaining: &'a [u8],
    /// Number of physical lines read so far.
    pub taken: u32,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        // Some programs write a byte order mark.
        Self { remaining: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), taken: 0 }
    }

    /// Returns the next physical line without line end and comment, and true if it is continued.
    fn physical(&mut self) -> Option<(&'a [u8], bool)> {
        if self.remaining.is_empty() {
            return None;
        }
        let end =
            self.remaining.iter().position(|byte| *byte == b'\n').unwrap_or(self.remaining.len());
        let line = &self.remaining[..end];
        self.remaining = self.remaining.get(end + 1..).unwrap_or_default();
        self.taken = self.taken.saturating_add(1);
        // A backslash at the end of a comment does not continue the line.
        if let Some(comment) = line.iter().position(|byte| *byte == b'#') {
            return Some((&line[..comment], false));
        }
        match line.trim_ascii_end().split_last() {
            Some((b'\\', before)) => Some((before, true)),
            _ => Some((line, false)),
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let (first, mut continued) = self.physical()?;
        let number = self.taken;
        let mut text = Cow::Borrowed(first);
        while continued {
            let Some((next, more)) = self.physical() else { break };
            let joined = text.to_mut();
            joined.push(b' ');
            joined.extend_from_slice(next);
            continued = more;
        }
        Some(Line { number, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_numbered_when_ending_in_backslash() {
        let lines: Vec<(u32, String)> = Lines::new(b"a # c \\\r\nb \\\r\n c\\\n d\n\ne\\")
            .map(|line| (line.number, String::from_utf8_lossy(&line.text).trim().to_owned()))
            .collect();
        let expected = [(1, "a"), (2, "b   c  d"), (5, ""), (6, "e")];
        assert_eq!(lines, expected.map(|(number, text)| (number, text.to_owned())));
    }
}
