//! Other vehicles than the paper's: a wet six-speed and a dry seven-speed box.
//!
//! ```
//! use dct_driveline::Params;
//! use dct_driveline::params::Actuation;
//!
//! let p = Params::WET_6;
//! let pressed = Actuation { pressure: 20e5, ..Actuation::default() };
//! assert_eq!(p.clutch[0].force(pressed), 1500.0); // 20 bar on 0.001 m² against the spring's 500 N
//! assert_eq!(Params::DRY_7.i_t(0, 7) > 0.0, true);
//! ```

use crate::ForceMap;
use crate::friction::FrictionCurve;
use crate::params::{ClutchParams, Params, RoadParams};
use crate::thermal::Thermal;

/// Final-drive ratio of output shaft 1 (gears 1-4) of the box that [`Params::DRY_7`] follows [1].
const DRY_7_FINAL: f64 = 4.438;
/// Final-drive ratio of output shaft 2 (gears 5-7) by that of output shaft 1 [1].
const DRY_7_UPPER: f64 = 3.227 / DRY_7_FINAL;

/// Acceleration of an input shaft by its synchroniser [rad/s²].
///
/// `assumed:` 160 rad/s, about an upshift by two gears at 2500 rpm, in 80 ms; no source was found.
const SYNCHRONISER_RATE: f64 = 2000.0;
/// J_ct of [`Params::WET_6`] [kg·m²].
const WET_6_SHAFTS: [f64; 2] = [0.0023 + 3.0 * 0.001, 0.0009 + 3.0 * 0.001];
/// J_ct of [`Params::DRY_7`] [kg·m²].
const DRY_7_SHAFTS: [f64; 2] = [0.012, 0.010];

/// T_s of shafts with these inertias [N·m].
const fn synchroniser(j_ct: [f64; 2]) -> [f64; 2] {
    [SYNCHRONISER_RATE * j_ct[0], SYNCHRONISER_RATE * j_ct[1]]
}

impl Params {
    /// Preset `wet6`: six gears, wet clutches moved by pressure.
    ///
    /// From the public repository mathworks/Simscape-Dual-Clutch, `Scripts_Data/DCT_Model_PARAM.m`:
    /// J_e, all ratios and the final drive, inertias of shafts, gears, side shafts and tyres, torque
    /// radius 130 mm × 4 surfaces, piston area, μ_k, μ_s, mass, r_w, A_v, C_D. Inertias behind the final
    /// drive are seen through its ratio, and J_v is M_v r_w² and four tyres. The return force is its
    /// pressure below which a clutch is open (5 bar) times the piston area.
    /// `assumed:` k_d, c_d, J_d, k_t, c_t, k_o, c_o as in Table 1; ρ_air, C_rr as in preset `paper`;
    /// T_s turns a shaft by 160 rad/s in 80 ms.
    pub const WET_6: Self = Self {
        j_e: 0.2,
        j_ct: WET_6_SHAFTS,
        t_s: synchroniser(WET_6_SHAFTS),
        i_t: [[3.78, 1.43, 0.935, 0.0], [2.18, 1.03, 0.84, 0.0]],
        i_f: [3.7, 3.7],
        j_o: 0.008 * 3.7 * 3.7 + 0.01,
        j_v: 1600.0 * 0.312 * 0.312 + 4.0 * 0.5,
        clutch: [ClutchParams::WET_6; 2],
        road: RoadParams {
            m_v: 1600.0,
            r_w: 0.312,
            a_v: 3.0,
            c_drag: 0.4,
            v_eps: 0.0,
            ..Self::TABLE_1.road
        },
        ..Self::TABLE_1
    };

    /// Preset `dry7`: seven gears, dry clutches moved by a position.
    ///
    /// Arrangement of Volkswagen's 0AM (DQ200), self-study programme 390, p. 14: gears 1, 3, 5, 7 behind
    /// clutch 1, gears 2, 4, 6 and reverse behind clutch 2, gears 1-4 on output shaft 1, the others on
    /// output shaft 2. Ratios of the Škoda Superb III 1.8 TSI 132 kW with it (press kit of the IAA 2015, seen in a
    /// public catalogue of gearboxes that quotes it): 3.765 2.273 1.531 1.133 1.176 0.956 0.795, final drives
    /// 4.438 for gears 1-4 and 3.227 for 5-7. Here both shafts have the final drive of gears 1-4, so the ratios of
    /// gears 5-7 are theirs times 3.227/4.438.
    /// `assumed:` reverse, 4.17 with the final drive of gears 5-7: no source for its ratio was found.
    /// `assumed:` everything else, a compact car of 1320 kg: J_e, J_d, J_ct, J_o, vehicle, T_s, and r_c N as
    /// two surfaces at 97.5 mm; k_d, c_d, k_t, c_t, k_o, c_o, the maps and the road as in preset `paper`.
    pub const DRY_7: Self = Self {
        j_e: 0.15,
        j_d: 0.05,
        j_ct: DRY_7_SHAFTS,
        t_s: synchroniser(DRY_7_SHAFTS),
        i_t: [
            [3.765, 1.531, 1.176 * DRY_7_UPPER, 0.795 * DRY_7_UPPER],
            [2.273, 1.133, 0.956 * DRY_7_UPPER, 0.0],
        ],
        i_r: [0.0, 4.17 * DRY_7_UPPER],
        i_f: [DRY_7_FINAL, DRY_7_FINAL],
        j_o: 0.05,
        j_v: 1320.0 * 0.308 * 0.308 + 4.0 * 0.9,
        clutch: [
            ClutchParams::dry_7(ForceMap::CLUTCH_1),
            ClutchParams::dry_7(ForceMap::CLUTCH_2),
        ],
        road: RoadParams {
            m_v: 1320.0,
            r_w: 0.308,
            v_eps: 0.0,
            ..Self::TABLE_1.road
        },
        ..Self::TABLE_1
    };
}

impl ClutchParams {
    /// A clutch of [`Params::WET_6`]; its map is not used.
    const WET_6: Self = Self {
        mu_k: 0.30,
        mu_s: 0.31,
        curve: FrictionCurve::CONSTANT,
        thermal: Thermal::OFF,
        specific_wear: 0.0,
        r_c_n: 0.130 * 4.0,
        map: ForceMap::CLUTCH_1,
        piston_area: 0.001,
        return_force: 5e5 * 0.001,
    };

    /// A clutch of [`Params::DRY_7`]. `assumed:` an organic lining.
    const fn dry_7(map: ForceMap) -> Self {
        Self {
            mu_k: 0.30,
            mu_s: 0.33,
            curve: FrictionCurve::CONSTANT,
            thermal: Thermal::OFF,
            specific_wear: 0.0,
            r_c_n: 2.0 * 0.0975,
            map,
            piston_area: 0.0,
            return_force: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Params;

    /// Total ratios fall from gear to gear, and neighbours sit on different shafts.
    #[test]
    fn ratios_fall_from_gear_to_gear() {
        for (p, gears) in [(Params::WET_6, 6), (Params::DRY_7, 7)] {
            let total = |gear: i32| [0, 1].map(|i| p.i_t(i, gear) * p.i_f[i]);
            let all = (1..=gears).map(|gear| total(gear)[0] + total(gear)[1]);
            assert!(all.clone().zip(all.skip(1)).all(|(low, high)| low > high));
            assert_eq!(total(gears + 1), [0.0; 2]);
        }
    }

    #[test]
    fn a_wet_clutch_touches_where_its_spring_yields() {
        let clutch = Params::WET_6.clutch[1];
        for (bar, force) in [(0.0, 0.0), (5.0, 0.0), (50.0, 4500.0)] {
            let actuation = crate::params::Actuation {
                pressure: bar * 1e5,
                ..Default::default()
            };
            assert_eq!(clutch.force(actuation), force, "{bar} bar");
        }
    }
}
