//! Warnings of the OBJ parser, bounded in number and length for any file.

use std::collections::HashSet;

use crate::mesh::Repairs;

/// Largest number of unknown keywords with a warning of their own.
const KEYWORDS_MAX: usize = 20;
/// Largest number of bytes of a keyword in a warning.
const KEYWORD_BYTES_MAX: usize = 32;

/// Warning with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjWarning {
    /// Line of the file, from 1; the last line if the warning concerns the whole file.
    pub line: u32,
    /// Text of the warning.
    pub text: String,
}

/// Warnings collected so far, without duplicates.
#[derive(Default)]
pub(super) struct Warnings {
    list: Vec<ObjWarning>,
    reported: HashSet<&'static str>,
    keywords: HashSet<Vec<u8>>,
}

impl Warnings {
    /// Adds a warning unless the same text was added before.
    pub fn once(&mut self, line: u32, text: &'static str) {
        if self.reported.insert(text) {
            self.list.push(ObjWarning { line, text: text.to_owned() });
        }
    }

    /// Adds a warning for an unknown keyword, once per keyword.
    pub fn unknown_keyword(&mut self, line: u32, keyword: &[u8]) {
        let keyword = &keyword[..keyword.len().min(KEYWORD_BYTES_MAX)];
        if self.keywords.contains(keyword) {
            return;
        }
        if self.keywords.len() == KEYWORDS_MAX {
            return self.once(line, "more unknown keywords are ignored");
        }
        self.keywords.insert(keyword.to_vec());
        let text = format!("unknown keyword `{}` is ignored", keyword.escape_ascii());
        self.list.push(ObjWarning { line, text });
    }

    /// Adds warnings for missing or degenerate data that was replaced.
    pub fn repairs(&mut self, repairs: &Repairs, has_uv: bool, line: u32) {
        if !has_uv {
            let text =
                "no texture coordinates: u and v are 0, tangents depend on the normals alone";
            self.once(line, text);
        }
        let counted = [
            (repairs.empty_triangles, "triangles with zero area"),
            (repairs.zero_normals, "zero-length normals, replaced by smooth normals"),
            (repairs.normals, "smooth normals that the adjacent faces do not determine"),
            (repairs.uvs, "vertices without texture coordinates, where u and v are 0"),
            (
                repairs.tangents,
                "vertices whose texture coordinates give no tangent, derived from the normal instead",
            ),
        ];
        for (count, text) in counted {
            if count > 0 {
                self.list.push(ObjWarning { line, text: format!("{text}: {count}") });
            }
        }
    }

    pub fn into_list(self) -> Vec<ObjWarning> {
        self.list
    }
}
