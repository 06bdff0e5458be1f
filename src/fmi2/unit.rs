//! Units with their SI exponents, each written once.

/// How a unit is shown to people: `shown = factor · SI + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplayUnit {
    /// Name as in FMI's `displayUnit`, e.g. `rpm`.
    pub name: &'static str,
    /// Multiplied with the value in the unit it belongs to.
    pub factor: f64,
    /// Added after the multiplication.
    pub offset: f64,
}

/// A unit: name, exponents of the SI base units (`BaseUnit` of the FMI schema) and display units.
///
/// All values of a model are in coherent SI units, so a unit has no factor of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name as in the Modelica convention, e.g. `N.m`.
    pub name: &'static str,
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i8; 8],
    /// Other units people read it in; the first is the default `displayUnit` of its variables.
    pub display: &'static [DisplayUnit],
}

const fn display(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit {
        name,
        factor,
        offset: 0.0,
    }
}

impl Unit {
    /// Names of the base units, in the order of [`Unit::exponents`].
    pub const BASE: [&'static str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

    /// A unit that is not in the list below, e.g. a heat capacity:
    ///
    /// ```
    /// use fmi2_cosim::{DisplayUnit, Unit};
    ///
    /// const KILO: DisplayUnit = DisplayUnit { name: "kJ/K", factor: 1e-3, offset: 0.0 };
    /// const JOULE_PER_KELVIN: Unit = Unit::new("J/K", [1, 2, -2, 0, -1, 0, 0, 0], &[KILO]);
    /// # assert_eq!(Unit::BASE[4], "K");
    /// # assert_eq!(JOULE_PER_KELVIN.exponents[4], -1);
    /// ```
    #[must_use]
    pub const fn new(
        name: &'static str,
        exponents: [i8; 8],
        display: &'static [DisplayUnit],
    ) -> Self {
        Self {
            name,
            exponents,
            display,
        }
    }

    /// A pure number.
    pub const ONE: Self = Self::new("1", [0; 8], &[]);
    /// Time.
    pub const SECOND: Self = Self::new("s", [0, 0, 1, 0, 0, 0, 0, 0], &[display("ms", 1e3)]);
    /// Rate, gain of an observer.
    pub const PER_SECOND: Self = Self::new("1/s", [0, 0, -1, 0, 0, 0, 0, 0], &[]);
    /// Length.
    pub const METRE: Self = Self::new("m", [0, 1, 0, 0, 0, 0, 0, 0], &[display("mm", 1e3)]);
    /// Area.
    pub const SQUARE_METRE: Self = Self::new("m2", [0, 2, 0, 0, 0, 0, 0, 0], &[]);
    /// Speed.
    pub const METRE_PER_SECOND: Self =
        Self::new("m/s", [0, 1, -1, 0, 0, 0, 0, 0], &[display("km/h", 3.6)]);
    /// Acceleration.
    pub const METRE_PER_SECOND_SQUARED: Self = Self::new("m/s2", [0, 1, -2, 0, 0, 0, 0, 0], &[]);
    /// Mass.
    pub const KILOGRAM: Self = Self::new("kg", [1, 0, 0, 0, 0, 0, 0, 0], &[]);
    /// Moment of inertia.
    pub const KILOGRAM_SQUARE_METRE: Self = Self::new("kg.m2", [1, 2, 0, 0, 0, 0, 0, 0], &[]);
    /// Mass density.
    pub const KILOGRAM_PER_CUBIC_METRE: Self = Self::new("kg/m3", [1, -3, 0, 0, 0, 0, 0, 0], &[]);
    /// Angle.
    pub const RADIAN: Self = Self::new(
        "rad",
        [0, 0, 0, 0, 0, 0, 0, 1],
        &[display("deg", 180.0 / core::f64::consts::PI)],
    );
    /// Angular speed.
    pub const RADIAN_PER_SECOND: Self = Self::new(
        "rad/s",
        [0, 0, -1, 0, 0, 0, 0, 1],
        &[display("rpm", 30.0 / core::f64::consts::PI)],
    );
    /// Absolute temperature.
    pub const KELVIN: Self = Self::new(
        "K",
        [0, 0, 0, 0, 1, 0, 0, 0],
        &[DisplayUnit {
            name: "degC",
            factor: 1.0,
            offset: -273.15,
        }],
    );
    /// Force.
    pub const NEWTON: Self = Self::new("N", [1, 1, -2, 0, 0, 0, 0, 0], &[display("kN", 1e-3)]);
    /// Force per length, e.g. stiffness.
    pub const NEWTON_PER_METRE: Self =
        Self::new("N/m", [1, 0, -2, 0, 0, 0, 0, 0], &[display("N/mm", 1e-3)]);
    /// Torque.
    pub const NEWTON_METRE: Self = Self::new("N.m", [1, 2, -2, 0, 0, 0, 0, 0], &[]);
    /// Torsional stiffness.
    pub const NEWTON_METRE_PER_RADIAN: Self = Self::new("N.m/rad", [1, 2, -2, 0, 0, 0, 0, -1], &[]);
    /// Torsional damping.
    pub const NEWTON_METRE_SECOND_PER_RADIAN: Self =
        Self::new("N.m.s/rad", [1, 2, -1, 0, 0, 0, 0, -1], &[]);
    /// Pressure.
    pub const PASCAL: Self = Self::new("Pa", [1, -1, -2, 0, 0, 0, 0, 0], &[display("bar", 1e-5)]);
    /// Power.
    pub const WATT: Self = Self::new("W", [1, 2, -3, 0, 0, 0, 0, 0], &[display("kW", 1e-3)]);
    /// Energy.
    pub const JOULE: Self = Self::new("J", [1, 2, -2, 0, 0, 0, 0, 0], &[display("kJ", 1e-3)]);
}
