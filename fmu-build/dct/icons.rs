//! The icons of this workspace's models.

use crate::icon::Shape::{self, Box, Disc, Line, Ring};
use crate::icon::{Colour, Icon};

const BLUE: Colour = [0x0b, 0x5f, 0xa5];
const ORANGE: Colour = [0xd9, 0x77, 0x06];
const DARK: Colour = [0x1d, 0x25, 0x30];
const GREY: Colour = [0x9a, 0xa7, 0xb4];
const WHITE: Colour = [0xff, 0xff, 0xff];

const FRAME: (Shape, Colour) = (Box([2.0, 2.0, 98.0, 98.0]), BLUE);
const SHEET: (Shape, Colour) = (Box([5.0, 5.0, 95.0, 95.0]), WHITE);

/// Engine, two clutches, two shafts, wheel.
pub(crate) const PLANT: Icon = &[
    FRAME,
    SHEET,
    (Line([20.0, 50.0], [36.0, 50.0], 5.0), DARK),
    (Box([11.0, 39.0, 25.0, 61.0]), DARK),
    (Line([36.0, 18.0], [36.0, 82.0], 5.0), DARK),
    (Line([45.0, 29.0], [63.0, 29.0], 4.0), ORANGE),
    (Line([63.0, 29.0], [63.0, 50.0], 4.0), ORANGE),
    (Line([45.0, 18.0], [45.0, 40.0], 5.0), ORANGE),
    (Line([45.0, 71.0], [63.0, 71.0], 4.0), BLUE),
    (Line([63.0, 71.0], [63.0, 50.0], 4.0), BLUE),
    (Line([45.0, 60.0], [45.0, 82.0], 5.0), BLUE),
    (Line([63.0, 50.0], [78.0, 50.0], 5.0), DARK),
    (Disc([78.0, 50.0], 14.0), WHITE),
    (Ring([78.0, 50.0], 11.0, 6.0), DARK),
    (Disc([78.0, 50.0], 4.0), DARK),
];

/// A torque and its estimate under a magnifier.
pub(crate) const OBSERVER: Icon = &[
    FRAME,
    SHEET,
    (Line([12.0, 84.0], [88.0, 84.0], 2.5), GREY),
    (Line([12.0, 84.0], [12.0, 14.0], 2.5), GREY),
    (Line([12.0, 72.0], [30.0, 68.0], 4.0), ORANGE),
    (Line([30.0, 68.0], [46.0, 40.0], 4.0), ORANGE),
    (Line([46.0, 40.0], [66.0, 34.0], 4.0), ORANGE),
    (Line([66.0, 34.0], [88.0, 22.0], 4.0), ORANGE),
    (Disc([53.0, 43.0], 20.0), WHITE),
    (Line([36.0, 58.0], [48.0, 40.0], 4.0), ORANGE),
    (Line([48.0, 40.0], [70.0, 34.0], 4.0), ORANGE),
    (Line([37.0, 62.0], [51.0, 44.0], 4.0), BLUE),
    (Line([51.0, 44.0], [70.0, 40.0], 4.0), BLUE),
    (Ring([53.0, 43.0], 20.0, 5.0), DARK),
    (Line([68.0, 58.0], [82.0, 74.0], 8.0), DARK),
];

/// Two actuators at their positions.
pub(crate) const CONTROL: Icon = &[
    FRAME,
    SHEET,
    (Line([16.0, 34.0], [84.0, 34.0], 4.0), GREY),
    (Line([16.0, 34.0], [60.0, 34.0], 4.0), ORANGE),
    (Disc([60.0, 34.0], 9.0), ORANGE),
    (Disc([60.0, 34.0], 4.0), WHITE),
    (Line([16.0, 66.0], [84.0, 66.0], 4.0), GREY),
    (Line([16.0, 66.0], [34.0, 66.0], 4.0), BLUE),
    (Disc([34.0, 66.0], 9.0), BLUE),
    (Disc([34.0, 66.0], 4.0), WHITE),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::icon::png;

    #[test]
    fn the_pictures_are_small() {
        for icon in [PLANT, OBSERVER, CONTROL] {
            let file = png(icon).unwrap();
            assert!(file.len() < 8192, "{} bytes", file.len());
        }
    }
}
