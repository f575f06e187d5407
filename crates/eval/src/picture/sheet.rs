//! Contact sheets: twenty pictures around a centre, or a near-square grid.

/// A picture of a sheet: RGBA, row by row from the top.
#[derive(Debug, Clone, Copy)]
pub struct SheetCell<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Four bytes per pixel.
    pub rgba: &'a [u8],
}

/// The neutral dark surround of the page.
const SURROUND: [u8; 3] = [0x1e, 0x1e, 0x1e];
/// Cells along a side of a sheet with a centre.
const RING: u32 = 6;
/// Cells along a side of the centre.
const SPAN: u32 = 4;

/// Returns the side of the centre in pixels for cells of side `cell_px` with gaps of `gap_px`.
#[must_use]
pub fn centre_px(cell_px: u32, gap_px: u32) -> u32 {
    SPAN * cell_px + (SPAN - 1) * gap_px
}

/// Composes a sheet and returns width, height and opaque RGBA.
///
/// With a centre and twenty cells: 6 x 6, slots row by row around the 4 x 4 centre. Otherwise
/// near-square without the centre. Pictures that do not have the size of their cell are resampled.
#[must_use]
pub fn sheet(
    cells: &[SheetCell<'_>],
    centre: Option<SheetCell<'_>>,
    cell_px: u32,
    gap_px: u32,
) -> (u32, u32, Vec<u8>) {
    let ring = centre.filter(|_| cells.len() == 20);
    let count = u32::try_from(cells.len().max(1)).expect("a sheet has few cells");
    let columns = if ring.is_some() { RING } else { count.isqrt() + u32::from(!is_square(count)) };
    let rows = if ring.is_some() { RING } else { count.div_ceil(columns) };
    let pitch = cell_px + gap_px;
    let mut canvas = Canvas::new(columns * pitch + gap_px, rows * pitch + gap_px);
    let places = (0..rows * columns).map(|index| (index % columns, index / columns));
    let inner = 1..=SPAN;
    let free = places.filter(|(x, y)| ring.is_none() || !(inner.contains(x) && inner.contains(y)));
    for (cell, (column, row)) in cells.iter().zip(free) {
        canvas.place(*cell, gap_px + column * pitch, gap_px + row * pitch, cell_px);
    }
    if let Some(centre) = ring {
        let corner = gap_px + pitch;
        canvas.place(centre, corner, corner, centre_px(cell_px, gap_px));
    }
    (canvas.width, canvas.height, canvas.rgba)
}

fn is_square(count: u32) -> bool {
    count.isqrt().pow(2) == count
}

/// RGBA pixels of a sheet, opaque.
struct Canvas {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl Canvas {
    fn new(width: u32, height: u32) -> Self {
        let [r, g, b] = SURROUND;
        let rgba = [r, g, b, 255].repeat(width as usize * height as usize);
        Self { width, height, rgba }
    }

    /// Draws a picture, resampled to `side` pixels, with its upper left corner at (x, y).
    fn place(&mut self, cell: SheetCell<'_>, x: u32, y: u32, side: u32) {
        for row in 0..side {
            for column in 0..side {
                let colour = area(cell, column, row, side);
                let at = 4 * ((y + row) as usize * self.width as usize + (x + column) as usize);
                self.rgba[at..at + 3].copy_from_slice(&colour);
            }
        }
    }
}

/// Returns the mean over the pixels that a target pixel covers (at least the nearest one),
/// composited over the surround.
fn area(cell: SheetCell<'_>, column: u32, row: u32, side: u32) -> [u8; 3] {
    let range = |index: u32, length: u32| {
        let start = index * length / side;
        start..((index + 1) * length / side).max(start + 1)
    };
    let (mut sum, mut count) = ([0u32; 3], 0);
    for y in range(row, cell.height) {
        for x in range(column, cell.width) {
            let at = 4 * (y as usize * cell.width as usize + x as usize);
            let pixel = &cell.rgba[at..at + 4];
            let alpha = u32::from(pixel[3]);
            for channel in 0..3 {
                let over = u32::from(pixel[channel]) * alpha;
                sum[channel] += over + u32::from(SURROUND[channel]) * (255 - alpha);
            }
            count += 255;
        }
    }
    sum.map(|channel| u8::try_from((channel + count / 2) / count).expect("a mean of bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheet_has_twenty_cells_around_the_centre_row_by_row() {
        let pictures: Vec<Vec<u8>> = (0..21u8).map(|k| [k * 10, 0, 0, 255].repeat(16)).collect();
        let cell = |k: usize| SheetCell { width: 4, height: 4, rgba: &pictures[k] };
        let cells: Vec<_> = (0..20).map(cell).collect();
        let (width, height, rgba) = sheet(&cells, Some(cell(20)), 4, 2);
        assert_eq!((width, height), (38, 38));
        let red = |x: usize, y: usize| rgba[4 * (y * 38 + x)];
        let middle = |k: usize| 2 + 6 * k + 2;
        assert_eq!([red(middle(0), middle(0)), red(middle(5), middle(0))], [0, 50]);
        assert_eq!([red(middle(0), middle(1)), red(middle(5), middle(1))], [60, 70]);
        assert_eq!([red(middle(0), middle(5)), red(middle(5), middle(5))], [140, 190]);
        assert_eq!(red(19, 19), 200);
        assert_eq!(red(0, 0), 0x1e);
    }

    #[test]
    fn sheet_is_near_square_when_there_is_no_centre() {
        let picture = [9, 9, 9, 255].repeat(16);
        let cell = SheetCell { width: 4, height: 4, rgba: &picture };
        let (width, height, _) = sheet(&[cell; 7], None, 4, 0);
        assert_eq!((width, height), (12, 12));
        let (width, height, _) = sheet(&[cell; 20], None, 4, 0);
        assert_eq!((width, height), (20, 16));
    }
}
