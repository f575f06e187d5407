//! Regions of a picture by hue and saturation.
//!
//! Shading a paint scales its lightness and its chroma alike, so regions are found in the plane of
//! chroma over lightness. There the dark and the bright places of one paint are near each other.

use super::cells::Cell;
use super::region::{PaintingRegion, REGIONS_MAX};
use crate::oklab::Oklab;

/// Lightness below which colours count as greyer and form no regions: codes of grey are below 34,
/// where noise decides the hue and the straight part of the transfer curve takes chroma. They
/// belong to the nearest region.
const DARK: f64 = 0.25;
/// Bins a side of the plane, and the largest coordinate; blue has 0.69.
const BINS: usize = 160;
const EDGE: f64 = 0.8;
/// A place where a region starts has at least this share of the area within this many bins.
const SEED_SHARE: f64 = 0.005;
const SEED_BINS: usize = 3;
/// Least distance of the places where regions start: more than that of a saturated paint from its
/// own shade at a quarter of its codes.
const SEED_DISTANCE: f64 = 0.08;
/// Most steps of Lloyd's algorithm, which ends earlier when nothing moves.
const STEPS: usize = 64;
/// Parts of a region, by lightness, whose means are its three colours.
const PARTS: [(f64, f64); 3] = [(0.0, 0.1), (0.45, 0.55), (0.9, 1.0)];
/// Shares are rounded to one over this.
const SHARES: f64 = 1e4;

/// A place in the plane.
type Place = [f64; 2];

/// Bin with colours.
struct Bin {
    /// Index in the grid.
    at: usize,
    /// Mean of the places in it.
    place: Place,
    weight: f64,
}

/// Returns the regions of a picture, the largest first. `cells` is not empty.
pub(super) fn regions(cells: &[Cell]) -> Vec<PaintingRegion> {
    let places: Vec<Place> = cells.iter().map(|cell| place(cell.color)).collect();
    let bins = bins(cells, &places);
    let centres = lloyd(&bins, seeds(&bins));
    let mut parts: Vec<Vec<Cell>> = vec![Vec::new(); centres.len()];
    for (cell, place) in cells.iter().zip(&places) {
        parts[nearest(&centres, *place)].push(*cell);
    }
    let weight = |part: &[Cell]| part.iter().map(|cell| cell.weight).sum::<f64>();
    let all = weight(cells);
    let mut regions: Vec<(f64, Vec<Cell>)> =
        parts.into_iter().map(|part| (weight(&part) / all, part)).collect();
    regions.retain(|(_, part)| !part.is_empty());
    regions.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    regions.into_iter().map(|(share, part)| region(share, part)).collect()
}

fn place(color: Oklab) -> Place {
    let lightness = color.lightness.max(DARK);
    [color.a / lightness, color.b / lightness]
}

/// Returns the bins that have colours which are not dark, in the order of the grid; if all are
/// dark, those of all.
fn bins(cells: &[Cell], places: &[Place]) -> Vec<Bin> {
    let mut sums = vec![([0.0; 2], 0.0); BINS * BINS];
    // The cast cuts off; places are within the edge.
    let at = |value: f64| (((value + EDGE) / (2.0 * EDGE) * BINS as f64) as usize).min(BINS - 1);
    let is_lit = |cell: &Cell| cell.color.lightness >= DARK;
    let is_dark = !cells.iter().any(is_lit);
    for (cell, place) in cells.iter().zip(places).filter(|(cell, _)| is_dark || is_lit(cell)) {
        let (sum, weight) = &mut sums[at(place[0]) * BINS + at(place[1])];
        *weight += cell.weight;
        *sum = [0, 1].map(|axis| sum[axis] + cell.weight * place[axis]);
    }
    let filled = sums.into_iter().enumerate().filter(|(_, (_, weight))| *weight > 0.0);
    filled
        .map(|(at, (sum, weight))| Bin { at, place: sum.map(|sum| sum / weight), weight })
        .collect()
}

/// Returns the places where regions start: the densest, then repeatedly that which is farthest from
/// all others, among those that enough of the area is near to.
fn seeds(bins: &[Bin]) -> Vec<Place> {
    let density = density(bins);
    let least = SEED_SHARE * bins.iter().map(|bin| bin.weight).sum::<f64>();
    let densest = first_largest(density.iter().copied());
    let mut seeds = vec![bins[densest].place];
    while seeds.len() < REGIONS_MAX {
        let distances = bins.iter().zip(&density).map(|(bin, density)| {
            if *density < least {
                0.0
            } else {
                distance(seeds[nearest(&seeds, bin.place)], bin.place)
            }
        });
        let distances: Vec<f64> = distances.collect();
        let farthest = first_largest(distances.iter().copied());
        if distances[farthest] < SEED_DISTANCE {
            break;
        }
        seeds.push(bins[farthest].place);
    }
    seeds
}

/// Weight within [`SEED_BINS`] of each bin.
fn density(bins: &[Bin]) -> Vec<f64> {
    let mut grid = vec![0.0; BINS * BINS];
    for bin in bins {
        grid[bin.at] = bin.weight;
    }
    let near = |at: usize| at.saturating_sub(SEED_BINS)..(at + SEED_BINS + 1).min(BINS);
    let around = |bin: &Bin| {
        let rows = near(bin.at / BINS);
        rows.map(|row| near(bin.at % BINS).map(|column| grid[row * BINS + column]).sum::<f64>())
            .sum()
    };
    bins.iter().map(around).collect()
}

/// Moves the centres to the means of what is nearest to them, until nothing moves.
fn lloyd(bins: &[Bin], mut centres: Vec<Place>) -> Vec<Place> {
    for _ in 0..STEPS {
        let mut sums = vec![([0.0; 2], 0.0); centres.len()];
        for bin in bins {
            let (sum, weight) = &mut sums[nearest(&centres, bin.place)];
            *weight += bin.weight;
            *sum = [0, 1].map(|axis| sum[axis] + bin.weight * bin.place[axis]);
        }
        let moved: Vec<Place> = sums
            .iter()
            .zip(&centres)
            .map(
                |((sum, weight), old)| {
                    if *weight > 0.0 { sum.map(|sum| sum / weight) } else { *old }
                },
            )
            .collect();
        if moved == centres {
            break;
        }
        centres = moved;
    }
    centres
}

fn distance(one: Place, other: Place) -> f64 {
    libm::hypot(one[0] - other[0], one[1] - other[1])
}

/// Index of the nearest centre; the first of equals.
fn nearest(centres: &[Place], place: Place) -> usize {
    first_largest(centres.iter().map(|centre| -distance(*centre, place)))
}

/// Index of the first of the largest values.
fn first_largest(values: impl Iterator<Item = f64>) -> usize {
    let best = values.enumerate().reduce(|best, one| if one.1 > best.1 { one } else { best });
    best.expect("there are values").0
}

/// Returns the colours of a region from its cells.
fn region(share: f64, mut cells: Vec<Cell>) -> PaintingRegion {
    cells.sort_by(|one, other| one.color.lightness.total_cmp(&other.color.lightness));
    let mut colors = PARTS.map(|part| mean_color(&cells, part).codes());
    // Rounding to codes may exchange colours that are nearly equal.
    let lightness = |codes: &[u8; 3]| Oklab::of_codes(*codes).lightness;
    colors.sort_by(|one, other| lightness(one).total_cmp(&lightness(other)));
    let [dark, middle, bright] = colors;
    let share = libm::round(share * SHARES).max(1.0) / SHARES;
    PaintingRegion { dark, middle, bright, share }
}

/// Mean colour of the cells in a part of the area, `from` to `to` as shares of it.
fn mean_color(cells: &[Cell], (from, to): (f64, f64)) -> Oklab {
    let all: f64 = cells.iter().map(|cell| cell.weight).sum();
    let (from, to) = (from * all, to * all);
    let (mut below, mut sum) = (0.0, [0.0; 4]);
    for Cell { color, weight } in cells {
        let above = below + weight;
        let own = (to.min(above) - from.max(below)).max(0.0);
        below = above;
        let parts = [color.lightness, color.a, color.b, 1.0];
        sum = [0, 1, 2, 3].map(|at| sum[at] + own * parts[at]);
    }
    let [lightness, a, b, weight] = sum;
    Oklab { lightness: lightness / weight, a: a / weight, b: b / weight }
}
