//! `model.png`: a picture drawn by code, the same bytes on every machine.

mod raster;

use crate::Result;
use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};
use raster::{SIZE, pixels};
use std::io::Write as _;

/// A shape; coordinates from (0, 0), top left, to (100, 100), bottom right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Left, top, right, bottom.
    Box([f64; 4]),
    /// Centre and radius.
    Disc([f64; 2], f64),
    /// Centre, radius and width of its line.
    Ring([f64; 2], f64, f64),
    /// From one point to another, and its width; its ends are round.
    Line([f64; 2], [f64; 2], f64),
}

/// Red, green, blue.
pub type Colour = [u8; 3];

/// A picture: shapes with their colours, later ones on top.
pub type Icon = &'static [(Shape, Colour)];

/// A block with an input and an output: the icon of a model that brings none.
pub const BLOCK: Icon = &[
    (Shape::Line([4.0, 50.0], [96.0, 50.0], 5.0), DARK),
    (Shape::Box([20.0, 20.0, 80.0, 80.0]), BLUE),
    (Shape::Box([24.0, 24.0, 76.0, 76.0]), WHITE),
    (Shape::Line([82.0, 42.0], [94.0, 50.0], 5.0), DARK),
    (Shape::Line([82.0, 58.0], [94.0, 50.0], 5.0), DARK),
];

const BLUE: Colour = [0x0b, 0x5f, 0xa5];
const DARK: Colour = [0x1d, 0x25, 0x30];
const WHITE: Colour = [0xff, 0xff, 0xff];

/// The picture as a PNG file.
pub(crate) fn png(icon: Icon) -> Result<Vec<u8>> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend(SIZE.to_be_bytes());
    header.extend(SIZE.to_be_bytes());
    header.extend([8, 6, 0, 0, 0]); // 8 bits of red, green, blue, opacity
    chunk(&mut file, b"IHDR", &header);
    chunk(&mut file, b"IDAT", &compressed(&pixels(icon))?);
    chunk(&mut file, b"IEND", &[]);
    Ok(file)
}

/// Rows, each behind the number of its filter (0: none).
fn compressed(pixels: &[u8]) -> Result<Vec<u8>> {
    let row = pixels.len() / raster::ROWS;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let written = pixels.chunks_exact(row).try_for_each(|row| {
        encoder.write_all(&[0])?;
        encoder.write_all(row)
    });
    let done = written.and_then(|()| encoder.finish());
    done.map_err(crate::Error::io(MEMBER))
}

/// Where it lies in an FMU.
pub(crate) const MEMBER: &str = "model.png";

fn chunk(file: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    let mut crc = Crc::new();
    crc.update(name);
    crc.update(data);
    file.extend(u32::try_from(data.len()).unwrap_or(u32::MAX).to_be_bytes());
    file.extend(name);
    file.extend(data);
    file.extend(crc.sum().to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_small_and_the_same_every_time() {
        let file = png(BLOCK).unwrap();
        assert!(file.len() < 8192, "{} bytes", file.len());
        assert!(file == png(BLOCK).unwrap());
    }

    #[test]
    fn shapes_cover_what_they_say() {
        const RED: Colour = [255, 0, 0];
        const QUARTER: Icon = &[(Shape::Box([0.0, 0.0, 50.0, 50.0]), RED)];
        let red = pixels(QUARTER)
            .chunks(4)
            .filter(|p| **p == [255, 0, 0, 255])
            .count();
        assert_eq!(red * 4, pixels(QUARTER).len() / 4);
        const DISC: Icon = &[(Shape::Disc([50.0, 50.0], 50.0), RED)];
        let covered: u32 = pixels(DISC).chunks(4).map(|p| u32::from(p[3])).sum();
        let area = f64::from(covered) / 255.0 / f64::from(SIZE * SIZE);
        assert!((area - std::f64::consts::FRAC_PI_4).abs() < 1e-3, "{area}");
    }
}
