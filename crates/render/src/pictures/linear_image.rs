//! Pictures of linear radiance.

/// Linear radiance, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Radiance of the pixels: red, green and blue, with Rec. 709 primaries. It is that of what is covered alone, times
    /// its part of the pixel, where there is an alpha.
    pub pixels: Vec<[f32; 3]>,
    /// Part of each pixel that is covered, 0 to 1; `None` for a picture with its background.
    pub alpha: Option<Vec<f32>>,
}

impl Image {
    /// Picture whose pixels have the radiance of what is covered in them, whatever their alpha, and black where nothing is.
    pub fn straight(&self) -> Self {
        let Some(alpha) = &self.alpha else { return self.clone() };
        let of_covered = |(pixel, alpha): (&[f32; 3], &f32)| {
            if *alpha > 0.0 { pixel.map(|channel| channel / alpha) } else { [0.0; 3] }
        };
        Self { pixels: self.pixels.iter().zip(alpha).map(of_covered).collect(), ..self.clone() }
    }

    /// Picture resized to `width` x `height` pixels: each is the mean of what it covers, so the mean of all stays. Without its alpha.
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
        Self { width, height, pixels, alpha: None }
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
