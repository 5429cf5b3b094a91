//! Triangles as pixels: scan lines with a depth buffer.
//!
//! ```text
//!     row y:     x from the edges that cross y + 1/2; pixels whose centre is in [left, right)
//!     nearness:  1/z is linear in x and y;  a pixel is drawn where 1/z is larger than before    (z: distance along the camera's axis, m)
//!     picture:   mean of 2 × 2 pixels
//! ```
//!
//! Because an edge is computed from its upper end in both of its triangles, each pixel belongs to exactly one of them.

/// Pixels of the canvas along each side of a pixel of the picture.
pub(super) const FINE: usize = 2;

/// Steps of the table from linear brightness to bytes.
const STEPS: usize = 4096;

/// A picture: rows of red, green, blue, from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Image {
    /// Pixels of a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// All pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// A corner of a triangle on the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Place (pixels).
    pub x: f64,
    /// From the top.
    pub y: f64,
    /// 1/z (1/m).
    pub nearness: f64,
    /// Light that falls on it; 1 shows the colour as it is.
    pub light: f64,
}

/// A colour in linear light: red, green, blue in 0..1.
pub(super) type Linear = [f32; 3];

/// The colour of bytes or of numbers in 0..1 as screens have them (sRGB, IEC 61966-2-1), in linear light.
pub(super) fn linear([red, green, blue]: [f64; 3]) -> Linear {
    let one = |value: f64| {
        let value = value.clamp(0.0, 1.0);
        (if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }) as f32
    };
    [one(red), one(green), one(blue)]
}

/// The pixels, and the nearness of what is drawn in each.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    /// Red, green, blue; the last byte is the number of the plane that is seen there, counted from 1, or 0.
    pub color: Vec<[u8; 4]>,
    /// 1/z (1/m); zero where nothing is.
    pub nearness: Vec<f32>,
    /// Bytes by linear brightness.
    bytes: Vec<u8>,
}

impl Canvas {
    /// A canvas for pictures of this size (pixels of the picture).
    pub(super) fn new([width, height]: [usize; 2]) -> Self {
        let (width, height) = (FINE * width, FINE * height);
        let byte = |k: usize| {
            let value = k as f64 / STEPS as f64;
            let screen = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
            (255.0 * screen).round() as u8
        };
        Canvas {
            width,
            height,
            color: vec![[0; 4]; width * height],
            nearness: vec![0.0; width * height],
            bytes: (0..=STEPS).map(byte).collect(),
        }
    }

    /// Pixels of a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The bytes of a colour under some light.
    pub(super) fn lit(&self, color: Linear, light: f32) -> [u8; 3] {
        color.map(|part| self.bytes[((part * light).clamp(0.0, 1.0) * STEPS as f32) as usize])
    }

    /// Draws a triangle that hides what lies behind it.
    pub(super) fn draw(&mut self, corners: &[Spot; 3], color: Linear) {
        let mut rows = Rows::of(corners, self.width, self.height);
        while let Some(row) = rows.next() {
            let (mut nearness, mut light) = (row.nearness, row.light);
            for pixel in row.first..row.end {
                if nearness > self.nearness[pixel] {
                    self.nearness[pixel] = nearness;
                    let [red, green, blue] = self.lit(color, light);
                    self.color[pixel] = [red, green, blue, 0];
                }
                nearness += rows.slope_nearness;
                light += rows.slope_light;
            }
        }
    }

    /// Draws a triangle through which others are seen; `opacity` in 0..1.
    pub(super) fn glaze(&mut self, corners: &[Spot; 3], color: Linear, opacity: f32) {
        let mut rows = Rows::of(corners, self.width, self.height);
        while let Some(row) = rows.next() {
            let (mut nearness, mut light) = (row.nearness, row.light);
            for pixel in row.first..row.end {
                if nearness > self.nearness[pixel] {
                    let over = self.lit(color, light);
                    let under = &mut self.color[pixel];
                    for channel in 0..3 {
                        let [from, to] = [f32::from(under[channel]), f32::from(over[channel])];
                        under[channel] = (from + opacity * (to - from)).round() as u8;
                    }
                }
                nearness += rows.slope_nearness;
                light += rows.slope_light;
            }
        }
    }

    /// Darkens the pixels of a plane once, however many triangles throw their shadow there.
    pub(super) fn shadow(&mut self, corners: &[Spot; 3], plane: u8) {
        /// The part of the light that shadows leave, in bytes of the screen.
        const LEFT: u16 = 216;
        let mut rows = Rows::of(corners, self.width, self.height);
        while let Some(row) = rows.next() {
            for pixel in &mut self.color[row.first..row.end] {
                if pixel[3] == plane {
                    *pixel = [0, 1, 2, 3].map(|k| if k == 3 { 0 } else { (u16::from(pixel[k]) * LEFT / 256) as u8 });
                }
            }
        }
    }

    /// The picture.
    pub(super) fn picture(&self, image: &mut Image) {
        image.width = self.width / FINE;
        image.height = self.height / FINE;
        image.pixels.clear();
        for rows in self.color.chunks_exact(FINE * self.width) {
            let (upper, lower) = rows.split_at(self.width);
            for (a, b) in upper.chunks_exact(FINE).zip(lower.chunks_exact(FINE)) {
                let mean = |k: usize| [a[0], a[1], b[0], b[1]].iter().map(|pixel| u16::from(pixel[k])).sum::<u16>();
                image.pixels.push([0, 1, 2].map(|k| ((mean(k) + 2) / 4) as u8));
            }
        }
    }
}

/// The pixels of a triangle in a row, with the values at the first of them.
struct Row {
    first: usize,
    end: usize,
    nearness: f32,
    light: f32,
}

/// The rows of a triangle, from the top.
struct Rows {
    corners: [Spot; 3],
    /// Slopes of the nearness and of the light along x and y.
    nearness: [f64; 2],
    light: [f64; 2],
    slope_nearness: f32,
    slope_light: f32,
    width: usize,
    row: usize,
    end: usize,
}

impl Rows {
    fn of(corners: &[Spot; 3], width: usize, height: usize) -> Self {
        let [a, b, c] = corners;
        let twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        let slopes = |[a_value, b_value, c_value]: [f64; 3]| {
            let (along_b, along_c) = (b_value - a_value, c_value - a_value);
            let x = (along_b * (c.y - a.y) - along_c * (b.y - a.y)) / twice_area;
            let y = (along_c * (b.x - a.x) - along_b * (c.x - a.x)) / twice_area;
            [x, y]
        };
        let nearness = slopes(corners.map(|corner| corner.nearness));
        let light = slopes(corners.map(|corner| corner.light));
        let low = corners.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max);
        // A triangle without area, or whose corners are no numbers, has no rows. Casts of numbers below zero give zero.
        let some = twice_area.is_finite() && twice_area != 0.0;
        let (row, end) = if some { (centre_at_or_after(low), centre_at_or_after(high).min(height)) } else { (0, 0) };
        let (slope_nearness, slope_light) = (nearness[0] as f32, light[0] as f32);
        Rows { corners: *corners, nearness, light, slope_nearness, slope_light, width, row, end }
    }

    fn next(&mut self) -> Option<Row> {
        if self.row >= self.end {
            return None;
        }
        let y = self.row as f64 + 0.5;
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (one, other) = (&self.corners[k], &self.corners[(k + 1) % 3]);
            let (upper, lower) = if (one.y, one.x) <= (other.y, other.x) { (one, other) } else { (other, one) };
            if upper.y <= y && y < lower.y {
                let x = upper.x + (lower.x - upper.x) * ((y - upper.y) / (lower.y - upper.y));
                left = left.min(x);
                right = right.max(x);
            }
        }
        let first = centre_at_or_after(left).min(self.width);
        let end = centre_at_or_after(right).clamp(first, self.width);
        let [a, ..] = &self.corners;
        let (dx, dy) = (first as f64 + 0.5 - a.x, y - a.y);
        let at = |value: f64, [x, v]: [f64; 2]| (value + x * dx + v * dy) as f32;
        let (nearness, light) = (at(a.nearness, self.nearness), at(a.light, self.light));
        let start = self.row * self.width;
        self.row += 1;
        Some(Row { first: start + first, end: start + end, nearness, light })
    }
}

/// The first pixel whose centre is at or after a place; 0 for places before all of them.
fn centre_at_or_after(place: f64) -> usize {
    (place - 0.5).ceil() as usize
}

#[cfg(test)]
mod tests {
    use super::{Canvas, FINE, Image, Spot};

    fn spot(x: f64, y: f64, nearness: f64) -> Spot {
        Spot { x, y, nearness, light: 1.0 }
    }

    fn covered(canvas: &Canvas) -> usize {
        canvas.color.iter().filter(|pixel| **pixel != [0; 4]).count()
    }

    #[test]
    fn two_triangles_of_a_rectangle_cover_each_of_its_pixels_once() {
        // Through glass of half opacity a pixel that were drawn twice would be brighter.
        let mut canvas = Canvas::new([40, 30]);
        let [a, b, c, d] = [spot(3.2, 4.7, 1.0), spot(70.1, 9.3, 1.0), spot(66.0, 55.5, 1.0), spot(8.8, 50.2, 1.0)];
        canvas.glaze(&[a, b, c], [1.0; 3], 0.5);
        canvas.glaze(&[a, c, d], [1.0; 3], 0.5);
        assert!(canvas.color.iter().all(|pixel| matches!(pixel[0], 0 | 128)), "a pixel is drawn twice");
        // The area of the quadrangle by its corners; the count of centres differs by less than the length of its rim, 210 pixels.
        let ring = [a, b, c, d, a];
        let area: f64 = ring.windows(2).map(|pair| 0.5 * (pair[0].x * pair[1].y - pair[1].x * pair[0].y)).sum();
        assert!((covered(&canvas) as f64 - area.abs()).abs() < 100.0, "{} of {area}", covered(&canvas));
    }

    #[test]
    fn the_nearer_triangle_is_seen_whichever_is_drawn_first() {
        let far = [spot(0.0, 0.0, 0.5), spot(80.0, 0.0, 0.5), spot(0.0, 60.0, 0.5)];
        let near = far.map(|corner| Spot { nearness: 0.8, ..corner });
        for order in [[0, 1], [1, 0]] {
            let mut canvas = Canvas::new([40, 30]);
            for which in order {
                let (corners, color) = [(far, [1.0, 0.0, 0.0]), (near, [0.0, 1.0, 0.0])][which];
                canvas.draw(&corners, color);
            }
            assert_eq!(canvas.color[0], [0, 255, 0, 0]);
        }
    }

    #[test]
    fn triangles_far_outside_and_without_numbers_draw_what_is_inside_of_the_picture() {
        let mut canvas = Canvas::new([8, 8]);
        canvas.draw(&[spot(f64::NAN, 0.0, 1.0), spot(9.0, 0.0, 1.0), spot(0.0, 9.0, 1.0)], [1.0; 3]);
        canvas.draw(&[spot(3.0, 3.0, 1.0), spot(9.0, 3.0, 1.0), spot(5.0, 3.0, 1.0)], [1.0; 3]);
        assert_eq!(covered(&canvas), 0);
        canvas.draw(&[spot(-1e9, -1e9, 1.0), spot(1e9, -1e9, 1.0), spot(0.0, 1e9, 1.0)], [1.0; 3]);
        assert_eq!(covered(&canvas), FINE * FINE * 64);
        let mut image = Image::default();
        canvas.picture(&mut image);
        assert_eq!((image.width, image.height, image.pixels[63]), (8, 8, [255; 3]));
    }
}
