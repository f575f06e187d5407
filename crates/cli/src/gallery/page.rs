//! Page of the gallery, as Markdown that refers only to files in the same folder.

use super::exhibit::{Exhibit, Section};
use super::{FOLDER, SHEET};

const HEAD: &str = "\
# Gallery

What the models, layers and lights look like, rendered by brood itself. `brood model gallery -o docs` writes this page
and its pictures; a test compares them with the output of that command. The formulas are in [Models of
reflectance](maths/shading.md), the lights in [Lights](maths/lights.md).

";

/// Renders the page.
pub fn markdown(sections: &[Section]) -> String {
    let mut text = format!("{HEAD}![All pictures in the order of this page]({SHEET})\n");
    for section in sections {
        text += &format!("\n## {}\n\n{}\n\n", section.title, section.words);
        text += "| picture | what | parameters |\n|---|---|---|\n";
        section.exhibits.iter().for_each(|exhibit| text += &row(exhibit));
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
