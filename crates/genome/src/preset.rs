//! Presets: hand-written materials that serve as readable examples of genomes and as starting
//! points for breeding. Programs come first, then models, then painted materials.
//!
//! The texts are in the folder `presets` of the crate, their order in [`PRESETS`]. How they look is
//! checked by the pictures that the `preset` test renders.
//!
//! # Example
//! ```
//! use brood_genome::preset::{PRESETS, Preset};
//!
//! let gold = Preset::find("gold").unwrap();
//! assert_eq!(gold.title, "Gold");
//! assert_eq!(PRESETS[0].name, "matt-clay");
//! println!("{}", gold.genome());
//! ```

use std::sync::LazyLock;

use crate::{Dialect, Genome};

/// A hand-written material.
#[derive(Debug)]
pub struct Preset {
    /// Name in requests and on the command line.
    pub name: &'static str,
    /// Title on the page.
    pub title: &'static str,
    /// Description of its look, in one sentence.
    pub words: &'static str,
    /// Source text of the genome, with its comments.
    pub text: &'static str,
    genome: LazyLock<Genome>,
}

/// Presets by name, title and description. A genome is parsed at its first use.
macro_rules! presets {
    ($($name:literal $title:literal $words:literal)+) => {
        /// All presets, the simplest first.
        pub static PRESETS: [Preset; [$($name),+].len()] = [$({
            const TEXT: &str = include_str!(concat!("../presets/", $name, ".brood"));
            let genome = || TEXT.parse().expect("presets are genomes");
            Preset {
                name: $name,
                title: $title,
                words: $words,
                text: TEXT,
                genome: LazyLock::new(genome),
            }
        }),+];
    };
}

presets! {
    "matt-clay" "Matt clay"
        "Unglazed terracotta, nearly the same from everywhere."
    "red-plastic" "Red plastic"
        "A glossy red body under a small, crisp, white highlight."
    "velvet" "Velvet"
        "Deep crimson cloth with glowing edges."
    "gold" "Gold"
        "Polished metal, from deep orange in the shade to pale yellow in the highlight."
    "brushed-metal" "Brushed metal"
        "Steel brushed in one direction, its highlight drawn out into a streak."
    "car-paint" "Two-tone car paint"
        "Turquoise in the light, violet towards the edges, under a hard clear coat."
    "pearl" "Pearl"
        "Creamy white over which rose and sea green drift with the angle."
    "satin" "Satin"
        "Blue cloth with a long, soft sheen and a rosy shimmer at the edges."
    "soap-film" "Soap film"
        "Rings of interference colours on a dark bubble."
    "checkered-ceramic" "Checkered ceramic"
        "Cobalt blue and ivory squares under a smooth glaze."
    "marble" "Marble"
        "Polished white stone with wandering grey veins."
    "moon-dust" "Moon dust"
        "Grey powder that looks as flat as the full moon."
    "retro-vest" "Retro-reflective vest"
        "Lime cloth with silver bands that flare up when the light is behind the eye."
    "rainbow-grooves" "Rainbow grooves"
        "Fine grooves that split white light into bands of pure colour."
    "model-gold" "Gold, by its constants"
        "Real gold: a rough conductor with the metal's refractive index and extinction."
    "model-copper" "Copper, brushed"
        "Copper by its reflectance at normal incidence, its highlight drawn out along u."
    "model-plastic" "Plastic, physical"
        "A blue body under a coat that sends light back and forth."
    "model-car-paint" "Car paint, principled"
        "A dark red metallic body under a clear coat."
    "model-velvet" "Cloth, principled"
        "Green cloth with the principled model's sheen at its edges."
    "model-clay" "Clay, Oren-Nayar"
        "Rough clay that is as bright at its edges as in the middle."
    "model-two-layers" "Varnished wood"
        "A warm diffuse base and two highlights, one wide and one narrow: three models, added."
    "model-phong" "Phong, 1975"
        "The first highlight of computer graphics, over a teal body."
    "model-chrome" "Chrome, by its constants"
        "A mirror that is slightly rough: a conductor with chromium's refractive index and extinction."
    "model-porcelain" "Porcelain"
        "A white body under a smooth glaze."
    "model-hammered-copper" "Hammered copper"
        "Copper with the marks of a hammer: bumps by a program."
    "model-golf-ball" "Golf ball"
        "White plastic with dimples: bumps by a program."
    "paint-clay" "Painted clay"
        "A dark and a bright colour of paint, mixed over the whole sphere of light."
    "paint-toon" "Tooned diffuse"
        "Three flat colours with sharp edges."
    "paint-cartoon" "Cartoon"
        "Flat colours, a dark outline and a hard highlight."
    "paint-ink" "Chinese ink"
        "Ink on paper, darker where the surface turns away."
    "paint-watercolor" "Water colour"
        "Pale blue washes whose borders wander."
    "paint-brush" "Brush strokes"
        "Ochre fields with edges that bristles have broken up."
    "paint-airbrush" "Airbrush"
        "One smooth curve from violet to cream, with a soft gleam."
    "paint-gouache" "Gouache"
        "Flat greens with soft borders."
    "paint-stage" "Stage plaster"
        "White plaster that takes the colours of the lights."
    "paint-mist" "Slate in mist"
        "Grey slate whose far side fades away."
    "paint-gold" "Gold leaf"
        "Brown shade, orange and yellow, with a bright band, as on illuminated pages."
    "paint-comic-metal" "Comic metal"
        "Bands of bright and dark steel with a glint."
    "paint-glass" "Painted glass"
        "A clear body that mirrors and bends what is around it, blue-green where it is thick."
    "paint-jelly" "Jelly"
        "Deep red where it is thick, clear where it is thin, with a dark outline."
    "paint-gold-toon" "Gold, tooned"
        "Real gold in five flat colours: what the metal reflects, in its highlights and its shade."
    "paint-velvet-toon" "Velvet, tooned"
        "The glowing edges of velvet as soft bands of gouache."
}

/// Returns the material of objects that have none: neutral grey that scatters half of the light
/// evenly.
#[must_use]
pub fn neutral() -> &'static Genome {
    static NEUTRAL: LazyLock<Genome> = LazyLock::new(|| {
        let text = "brood 1\n.model lambert\nalbedo 0.5 0.5 0.5\n";
        text.parse().expect("it is a genome")
    });
    &NEUTRAL
}

impl Preset {
    /// Returns the preset of that name.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// Genome as written, a few dozen instructions long.
    #[must_use]
    pub fn genome(&self) -> &Genome {
        &self.genome
    }

    /// Dialect for a lineage that breeds it: its own dialect, with the default length of lineages
    /// if it has a program.
    #[must_use]
    pub fn dialect(&self) -> Dialect {
        let own = *self.genome.dialect();
        let length = if own.length == 0 { 0 } else { Dialect::default().length };
        Dialect { length, ..own }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid_genomes_with_unique_names() {
        let mut names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        assert!(names.len() >= 12);
        for preset in &PRESETS {
            let genome = preset.genome();
            assert!(
                preset.text.starts_with("brood 1\n# "),
                "{} begins with a comment",
                preset.name
            );
            assert!(preset.words.ends_with('.') && !preset.title.is_empty());
            let padded = genome.clone().padded(preset.dialect().length).unwrap();
            assert_eq!(padded.dialect(), &preset.dialect());
        }
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), PRESETS.len());
        assert!(Preset::find("gold").is_some() && Preset::find("Gold").is_none());
    }
}
