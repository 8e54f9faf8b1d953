//! Pictures of linear radiance.

/// Linear radiance, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Radiance of the pixels: red, green and blue, with Rec. 709 primaries.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// Picture resized to `width` x `height` pixels: each is the mean of what it covers, so the mean of all stays.
    pub fn resized(&self, width: u32, height: u32) -> Self {
        let (columns, rows) = (covered(self.width, width), covered(self.height, height));
        let pixel = |row: &Covered, column: &Covered| {
            let mut sum = [0.0; 3];
            for &(y, row_share) in row {
                for &(x, column_share) in column {
                    let from = self.pixels[y * self.width as usize + x];
                    let share = row_share * column_share;
                    sum = [0, 1, 2].map(|channel| sum[channel] + share * f64::from(from[channel]));
                }
            }
            sum.map(|channel| channel as f32)
        };
        let pixels = rows.iter().flat_map(|row| columns.iter().map(move |column| pixel(row, column))).collect();
        Self { width, height, pixels }
    }
}

/// Pixels of a line, and the share of each in the mean.
type Covered = Vec<(usize, f64)>;

/// Pixels of a line of `from` that each of `to` equal parts covers.
fn covered(from: u32, to: u32) -> Vec<Covered> {
    // Lengths are in units of which a pixel has `to` and a part has `from`: the borders are whole numbers.
    let (from, to) = (u64::from(from), u64::from(to));
    let part = |i: u64| {
        let (start, end) = (i * from, (i + 1) * from);
        let share = |x: u64| (end.min((x + 1) * to) - start.max(x * to)) as f64 / from as f64;
        (start / to..end.div_ceil(to)).map(|x| (x as usize, share(x))).collect()
    };
    (0..to).map(part).collect()
}
