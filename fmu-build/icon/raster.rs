//! Shapes become pixels: every pixel is the mean of 16 points, so edges are smooth.

use super::{Icon, Shape};

/// Width and height of a picture [pixels].
pub(super) const SIZE: u32 = 96;
/// As many rows.
pub(super) const ROWS: usize = 96;
/// Points per pixel and direction.
const POINTS: u32 = 4;

/// Red, green, blue and opacity of every pixel, row by row from the top.
pub(super) fn pixels(icon: Icon) -> Vec<u8> {
    let places = (0..SIZE).flat_map(|row| (0..SIZE).map(move |column| (column, row)));
    places.flat_map(|place| pixel(icon, place)).collect()
}

fn pixel(icon: Icon, (column, row): (u32, u32)) -> [u8; 4] {
    let (mut sum, mut covered) = ([0_u32; 3], 0_u32);
    for point in 0..POINTS * POINTS {
        let x = 100.0 * part(column, point % POINTS);
        let y = 100.0 * part(row, point / POINTS);
        let top = icon.iter().rev().find(|(shape, _)| shape.holds(x, y));
        if let Some((_, colour)) = top {
            covered += 1;
            for (sum, value) in sum.iter_mut().zip(colour) {
                *sum += u32::from(*value);
            }
        }
    }
    let mean = |sum: u32| byte(sum.checked_div(covered).unwrap_or(0));
    let opacity = byte(255 * covered / (POINTS * POINTS));
    [mean(sum[0]), mean(sum[1]), mean(sum[2]), opacity]
}

/// Where a point lies in the picture, from 0 to 1.
fn part(pixel: u32, point: u32) -> f64 {
    (f64::from(pixel) + (f64::from(point) + 0.5) / f64::from(POINTS)) / f64::from(SIZE)
}

fn byte(value: u32) -> u8 {
    u8::try_from(value).unwrap_or(u8::MAX)
}

impl Shape {
    /// Whether a point is inside.
    fn holds(&self, x: f64, y: f64) -> bool {
        match *self {
            Self::Box([left, top, right, bottom]) => {
                (left..=right).contains(&x) && (top..=bottom).contains(&y)
            }
            Self::Disc([cx, cy], radius) => distance([cx, cy], x, y) <= radius,
            Self::Ring([cx, cy], radius, width) => {
                (distance([cx, cy], x, y) - radius).abs() <= 0.5 * width
            }
            Self::Line(from, to, width) => from_line(from, to, [x, y]) <= 0.5 * width,
        }
    }
}

fn distance([cx, cy]: [f64; 2], x: f64, y: f64) -> f64 {
    ((x - cx) * (x - cx) + (y - cy) * (y - cy)).sqrt()
}

/// Distance of a point from a line between two others.
fn from_line(from: [f64; 2], to: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let square = dx * dx + dy * dy;
    let along = ((x - from[0]) * dx + (y - from[1]) * dy) / square;
    let along = if square > 0.0 {
        along.clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance([from[0] + along * dx, from[1] + along * dy], x, y)
}
