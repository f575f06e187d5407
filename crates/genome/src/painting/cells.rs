//! Cells of a picture: means of its pixels on a grid of bounded size.

use crate::oklab::{Oklab, linear};

/// Most cells a side. Bounds the cost of pictures of any size; means of smaller cells would mix
/// brush strokes less, and of larger ones more.
const SIDE: usize = 256;

/// Mean colour of a part of a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Mean of the light of the pixels, by alpha.
    pub color: Oklab,
    /// Sum of the alpha of the pixels over their number, above 0.
    pub weight: f64,
}

/// Averages a picture to at most [`SIDE`] cells a side, row by row. Cells without opaque pixels are
/// left out.
pub(super) fn of(width: u32, height: u32, rgba: &[u8]) -> Vec<Cell> {
    let (width, height) = (width as usize, height as usize);
    assert_eq!(rgba.len(), 4 * width * height, "`rgba` has four values for each pixel");
    let light: Vec<f64> = (0..=255).map(|code: u8| linear(f64::from(code) / 255.0)).collect();
    let longest = width.max(height);
    let count = |side: usize| match longest > SIDE {
        true => (side * SIDE / longest).max(1),
        false => side,
    };
    let (columns, rows) = (count(width), count(height));
    let mut cells = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let lines = row * height / rows..(row + 1) * height / rows;
        for column in 0..columns {
            let places = column * width / columns..(column + 1) * width / columns;
            let number = (lines.len() * places.len()) as f64;
            let (mut sum, mut opacity) = ([0.0; 3], 0.0);
            for line in lines.clone() {
                let pixels =
                    &rgba[4 * (line * width + places.start)..4 * (line * width + places.end)];
                for pixel in pixels.chunks_exact(4) {
                    let alpha = f64::from(pixel[3]) / 255.0;
                    opacity += alpha;
                    for (sum, code) in sum.iter_mut().zip(pixel) {
                        *sum += alpha * light[usize::from(*code)];
                    }
                }
            }
            if opacity > 0.0 {
                let color = Oklab::of_linear(sum.map(|sum| sum / opacity));
                cells.push(Cell { color, weight: opacity / number });
            }
        }
    }
    cells
}
