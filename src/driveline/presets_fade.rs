//! The boxes of `presets.rs` with linings that follow slip and temperature.
//!
//! ```
//! use dct_driveline::Params;
//!
//! let (wet, dry) = (Params::WET_6_FADE.clutch[0], Params::DRY_7_FADE.clutch[0]);
//! assert!(wet.curve.at(100.0).0 > wet.curve.at(0.0).0); // no shudder
//! assert!(dry.thermal.at(623.15).0 < dry.thermal.at(523.15).0); // a lining that is too hot fades
//! ```

use crate::friction::FrictionCurve;
use crate::params::{ClutchParams, Params};
use crate::thermal::Thermal;

impl Params {
    /// Preset `wet6_fade`: [`Self::WET_6`] with the friction of a wet paper lining and its oil.
    ///
    /// - φ rises with slip: linings of automatic and dual-clutch boxes have little friction at small and much at high
    ///   sliding speeds, against shudder (Strobl et al., Forschung im Ingenieurwesen 87, 2023, abstract).
    ///   `assumed:` by how much, from 0.93 to 1.05 of μ_k, which is that of [`Self::WET_6`] at 10 rad/s (1.3 m/s).
    /// - C: `assumed:` 1.5 kg of steel plates a clutch, 490 J/(kg K).
    /// - G: `assumed:` 6 l/min of oil a clutch, 830 kg/m³ and 2000 J/(kg K), that leave with the plates' temperature.
    /// - T_a: `assumed:` oil at 90 °C.
    /// - θ: `assumed:` 0.8 of the friction is left at 200 °C.
    ///
    /// No number of these was found in a public source that could be checked; wear is off for the same reason.
    pub const WET_6_FADE: Self = Self {
        clutch: [Self::WET_6.clutch[0].with(WET, OIL_COOLED); 2],
        ..Self::WET_6
    };

    /// Preset `dry7_fade`: [`Self::DRY_7`] with the friction of a dry organic lining.
    ///
    /// - φ falls with slip (Humphrey et al., Clutch lining frictional characteristics under thermal tribodynamic
    ///   conditions, 2016, abstract; Myklebust and Eriksson, VPPC 2012, find little or none on a truck).
    ///   `assumed:` by how much, to 0.94 of μ_k at 200 rad/s.
    /// - θ falls slowly up to 250 °C and sharply beyond 300 °C, where the resin decomposes (Pisaturo and Senatore,
    ///   Applied Thermal Engineering 93, 2016, abstract). `assumed:` the factors there.
    /// - C: 542 J/(kg K), measured on a new lining (Appl. Sci. 9, 4287, 2019, table A2), times 0.3 kg of lining,
    ///   `assumed:`. A launch with the engine at 1500 rpm then warms it by 33 K; Pisaturo and Senatore find 30 to 35 K
    ///   at the faces an engagement. The node stands for the faces, not for the pressure plate behind them.
    /// - G: `assumed:` the faces cool with a time constant of a minute. T_a: `assumed:` 40 °C in the housing.
    ///
    /// Wear is off: no specific wear was found in a public source that could be checked.
    pub const DRY_7_FADE: Self = Self {
        clutch: [
            Self::DRY_7.clutch[0].with(DRY, AIR_COOLED),
            Self::DRY_7.clutch[1].with(DRY, AIR_COOLED),
        ],
        ..Self::DRY_7
    };
}

impl ClutchParams {
    const fn with(self, curve: FrictionCurve, thermal: Thermal) -> Self {
        Self {
            curve,
            thermal,
            ..self
        }
    }
}

const WET: FrictionCurve = FrictionCurve {
    slip: [0.0, 2.0, 10.0, 50.0, 200.0],
    factor: [0.93, 0.96, 1.0, 1.03, 1.05],
};

const OIL_COOLED: Thermal = Thermal {
    capacity: 1.5 * 490.0,
    conductance: 6e-3 / 60.0 * 830.0 * 2000.0,
    ambient: 363.15,
    start: 0.0,
    temperature: [293.15, 363.15, 423.15, 473.15],
    factor: [1.05, 1.0, 0.92, 0.8],
};

const DRY: FrictionCurve = FrictionCurve {
    slip: [0.0, 10.0, 50.0, 100.0, 200.0],
    factor: [1.02, 1.0, 0.98, 0.97, 0.94],
};

/// C of a dry clutch [J/K].
const DRY_CAPACITY: f64 = 0.3 * 542.0;

const AIR_COOLED: Thermal = Thermal {
    capacity: DRY_CAPACITY,
    conductance: DRY_CAPACITY / 60.0,
    ambient: 313.15,
    start: 0.0,
    temperature: [313.15, 523.15, 573.15, 623.15],
    factor: [1.0, 0.95, 0.85, 0.6],
};
