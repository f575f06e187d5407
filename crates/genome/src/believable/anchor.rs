//! Anchors: parameters that fits of measured materials have found, by class of material.
//!
//! The example `anchor` of the search crate makes the table. A row has the name of the class, the
//! weights, and the level of each term: the mean of log2 of its factors.

use std::sync::LazyLock;

use super::structure::{TERMS, WEIGHTS};

crate::named_enum! {
    /// Class of materials that look alike and take their colours from one distribution.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Class {
        /// Bare metals.
        Metal => "metal",
        /// Lacquers with metal flakes.
        MetallicPaint => "metallic-paint",
        /// Plastics, acrylics and resins.
        Plastic => "plastic",
        /// Paints.
        Paint => "paint",
        /// Cloth.
        Cloth => "cloth",
        /// Varnished woods.
        Wood => "wood",
        /// Stone and ceramics.
        Stone => "stone",
        /// Rubber, latex and foam.
        Rubber => "rubber",
    }
}

/// Fitted parameters of one material, without its colours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchor {
    pub(super) class: Class,
    /// Weights and levels.
    pub(super) values: [f64; VALUES],
}

/// Number of values of an anchor.
pub(super) const VALUES: usize = WEIGHTS + TERMS;

static ANCHORS: LazyLock<Vec<Anchor>> = LazyLock::new(|| {
    let rows = include_str!("anchors.csv").lines().skip(1);
    rows.map(|row| Anchor::parse(row).expect("the table is well formed")).collect()
});

impl Anchor {
    fn parse(row: &str) -> Option<Self> {
        let mut cells = row.split(',');
        let class = Class::from_name(cells.next()?)?;
        let values: Vec<f64> = cells.map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
        Some(Self { class, values: values.try_into().ok()? })
    }

    /// All anchors.
    pub(super) fn all() -> &'static [Self] {
        &ANCHORS
    }

    /// Anchors of a class.
    pub(super) fn of(class: Class) -> Vec<&'static Self> {
        ANCHORS.iter().filter(|anchor| anchor.class == class).collect()
    }
}
