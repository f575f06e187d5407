//! The gallery's page: what each picture shows, as Markdown that needs nothing but the files beside it.

use super::exhibit::{Exhibit, Room};
use super::{FOLDER, SHEET};

const HEAD: &str = "\
# Gallery

What the models, layers and lights look like, rendered by brood itself. This page and its pictures are written by
`brood model gallery -o docs`; a test holds them against what that command writes. The formulas are in
[Models of reflectance](maths/shading.md), the lights in [Lights](maths/lights.md).

";

/// The page.
pub fn markdown(rooms: &[Room]) -> String {
    let mut text = format!("{HEAD}![All of them, in the order of this page]({SHEET})\n");
    for room in rooms {
        text += &format!("\n## {}\n\n{}\n\n", room.title, room.words);
        text += "| picture | what | parameters |\n|---|---|---|\n";
        room.exhibits.iter().for_each(|exhibit| text += &row(exhibit));
    }
    text
}

fn row(exhibit: &Exhibit) -> String {
    let Exhibit { name, about, source, lines, .. } = exhibit;
    let source = if source.is_empty() { String::new() } else { format!("<br>{source}") };
    let lines: Vec<String> = lines.iter().map(|line| format!("`{line}`")).collect();
    let picture = format!("![{name}]({FOLDER}/{})", exhibit.file());
    format!("| {picture} | **{name}**: {about}{source} | {} |\n", lines.join("<br>"))
}
