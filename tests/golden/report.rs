//! The report: actual, expected and difference side by side, as a page that opens from the disk.
//!
//! Owns the page. Refuses to judge the pictures.

use std::fmt::Write;
use std::path::Path;

/// The outcome of one case.
pub struct Case {
    /// Name of its folder.
    pub name: String,
    /// How it differs, where it does.
    pub failure: Option<String>,
}

const HEAD: &str = "<!doctype html><meta charset=utf-8><title>brood: golden images</title>
<style>body{background:#1e1e1e;color:#ddd;font:15px system-ui;margin:2em}img{width:192px;image-rendering:pixelated}
td,th{padding:.4em 1em;text-align:left}.bad{color:#f88}</style>
<h1>Golden images</h1><table><tr><th>case<th>actual<th>expected<th>difference x 8\n";

/// Writes index.html beside the pictures.
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
