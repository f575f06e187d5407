//! HTML report of a run: actual, expected and difference side by side.

use std::fmt::Write;
use std::path::Path;

/// Outcome of one case.
pub struct Case {
    /// Name of the folder.
    pub name: String,
    /// Difference, if any.
    pub failure: Option<String>,
}

const HEAD: &str = "<!doctype html><meta charset=utf-8><title>brood: golden images</title>
<style>body{background:#1e1e1e;color:#ddd;font:15px system-ui;margin:2em}img{width:192px;image-rendering:pixelated}
td,th{padding:.4em 1em;text-align:left}.bad{color:#f88}</style>
<h1>Golden images</h1><table><tr><th>case<th>actual<th>expected<th>difference x 8\n";

/// Writes index.html next to the pictures.
pub fn write(folder: &Path, cases: &[Case]) {
    let mut page = HEAD.to_owned();
    for Case { name, failure } in cases {
        let verdict = match failure {
            Some(text) => format!("<br><span class=bad>{text}</span>"),
            None => String::new(),
        };
        write!(page, "<tr><td>{name}{verdict}").expect("writing to a string cannot fail");
        for kind in ["actual", "expected", "difference"] {
            writeln!(page, "<td><img src=\"{name}-{kind}.png\" alt=\"{name}, {kind}\">")
                .expect("writing to a string cannot fail");
        }
    }
    page.push_str("</table>\n");
    std::fs::write(folder.join("index.html"), page).expect("the report can be written");
}
