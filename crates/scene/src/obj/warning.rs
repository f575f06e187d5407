//! What is odd in a file and does not stop it from being read; bounded, whatever the file holds.

use std::collections::HashSet;

use crate::mesh::Guesses;

/// Unknown keywords that are told one by one.
const KEYWORDS_MAX: usize = 20;
/// Bytes of a keyword that a warning repeats.
const KEYWORD_BYTES_MAX: usize = 32;

/// Something odd.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjWarning {
    /// Line of the file, from 1; the last one for what concerns the whole.
    pub line: u32,
    /// What is odd.
    pub text: String,
}

/// Warnings as they come, one per matter.
#[derive(Default)]
pub(super) struct Warnings {
    list: Vec<ObjWarning>,
    told: HashSet<&'static str>,
    keywords: HashSet<Vec<u8>>,
}

impl Warnings {
    /// Tells of something once, at its first line.
    pub fn once(&mut self, line: u32, text: &'static str) {
        if self.told.insert(text) {
            self.list.push(ObjWarning { line, text: text.to_owned() });
        }
    }

    /// Tells of a keyword that is not of the format, once per keyword.
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

    /// Tells what had to be made up for the mesh.
    pub fn guesses(&mut self, guesses: &Guesses, has_uv: bool, line: u32) {
        if !has_uv {
            let text = "no texture coordinates: u and v are 0, tangents follow the normals";
            self.once(line, text);
        }
        let counted = [
            (guesses.empty_triangles, "triangles without an area"),
            (guesses.zero_normals, "normals of length 0, replaced by smooth ones"),
            (guesses.normals, "smooth normals that their faces do not determine"),
            (guesses.uvs, "vertices without texture coordinates, where u and v are 0"),
            (
                guesses.tangents,
                "vertices whose texture coordinates give no tangent, so that it follows the normal",
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
