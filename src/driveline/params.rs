//! Parameters of the driveline: Table 1, the values the paper leaves open, derived inertias.

use crate::ForceMap;
use crate::friction::FrictionCurve;
use crate::thermal::Thermal;

/// Number of forward gears a shaft can carry: eight gears and two reverse gears in all.
pub const GEARS_PER_SHAFT: usize = 4;

/// Everything the plant (1)-(11) and the observers need to know of one vehicle.
///
/// Arrays of two hold the odd shaft with clutch 1 at index 0 and the even shaft with clutch 2 at
/// index 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Params {
    /// J_e of (1): inertia of the engine [kg·m²].
    pub j_e: f64,
    /// J_d of (2): inertia of the damper's output side [kg·m²].
    pub j_d: f64,
    /// k_d of (3): stiffness of the torsional damper [N·m/rad].
    pub k_d: f64,
    /// c_d of (3): damping of the torsional damper [N·m·s/rad].
    pub c_d: f64,
    /// J_cti of (4), (5): inertia of input and transfer shaft, seen at the clutch [kg·m²].
    pub j_ct: [f64; 2],
    /// k_ti: stiffness of the transfer shafts [N·m/rad].
    pub k_t: [f64; 2],
    /// c_ti: damping of the transfer shafts [N·m·s/rad].
    pub c_t: [f64; 2],
    /// i_t of every gear, per shaft, lowest gear first; 0 where no gear is fitted [1].
    pub i_t: [[f64; GEARS_PER_SHAFT]; 2],
    /// i_t of the reverse gear per shaft, ≥ 0: the output turns the other way; 0 where none is fitted [1].
    pub i_r: [f64; 2],
    /// What every gear adds to J_ct while it is in, in the order of `i_t` [kg·m²].
    pub j_gear: [[f64; GEARS_PER_SHAFT]; 2],
    /// The same of the reverse gear per shaft [kg·m²].
    pub j_r: [f64; 2],
    /// η: part of the power that a gear and its final drive pass on, in the order of `i_t` [1], (0, 1];
    /// not below 1 where transfer shafts are rigid.
    pub eta: [[f64; GEARS_PER_SHAFT]; 2],
    /// The same of the reverse gear per shaft [1].
    pub eta_r: [f64; 2],
    /// T_s: torque of a shaft's synchroniser while it rubs, seen at its input shaft [N·m].
    pub t_s: [f64; 2],
    /// i_f1, i_f2 of (8): final-drive ratio per shaft [1].
    pub i_f: [f64; 2],
    /// J_o of (8): inertia of the output shaft [kg·m²].
    pub j_o: f64,
    /// k_o of (10): stiffness of the drive shaft [N·m/rad].
    pub k_o: f64,
    /// c_o of (10): damping of the drive shaft [N·m·s/rad].
    pub c_o: f64,
    /// J_v of (9): vehicle inertia seen at the wheel [kg·m²].
    pub j_v: f64,
    /// The two clutches.
    pub clutch: [ClutchParams; 2],
    /// Road load (11).
    pub road: RoadParams,
    /// Transfer shafts are rigid: ω_ci = g_i ω_o, and k_t, c_t are not used.
    pub rigid: bool,
}

/// One clutch: friction (6), (7) and its actuator (Fig. 6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClutchParams {
    /// μ_k: kinetic friction coefficient [1].
    pub mu_k: f64,
    /// μ_s ≥ μ_k: static friction coefficient [1].
    pub mu_s: f64,
    /// φ(|slip|): what becomes of μ_k while the clutch slips.
    pub curve: FrictionCurve,
    /// Heat capacity, cooling, and what the temperature makes of μ_k and μ_s.
    pub thermal: Thermal,
    /// k: specific wear [m³/J], volume worn off per friction energy.
    pub specific_wear: f64,
    /// r_c·N: effective torque radius times number of friction surfaces [m].
    pub r_c_n: f64,
    /// Actuator position [m] to normal force [N].
    pub map: ForceMap,
    /// Area of a hydraulic piston [m²]; 0: the clutch is moved by a position instead.
    pub piston_area: f64,
    /// Force of the return spring against a hydraulic piston [N].
    pub return_force: f64,
}

/// What moves a clutch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Actuation {
    /// θ_m: position of the actuator of a dry clutch [m].
    pub position: f64,
    /// Pressure on the piston of a wet clutch [Pa].
    pub pressure: f64,
}

impl ClutchParams {
    /// F_n [N], ≥ 0: the force-position map (Fig. 6), or for a piston its pressure times area less
    /// the return spring.
    #[inline(always)]
    pub fn force(&self, actuation: Actuation) -> f64 {
        if self.piston_area > 0.0 {
            (actuation.pressure * self.piston_area - self.return_force).max(0.0)
        } else {
            self.map.force(actuation.position)
        }
    }

    /// [`Self::force`], for a position by [`ForceMap::force_near`].
    #[inline(always)]
    pub fn force_near(&self, actuation: Actuation, piece: &mut usize) -> f64 {
        if self.piston_area > 0.0 {
            self.force(actuation)
        } else {
            self.map.force_near(actuation.position, piece)
        }
    }
}

impl ClutchParams {
    /// θ_m [m]; of a piston the position that gives its force.
    pub fn reached(&self, actuation: Actuation) -> f64 {
        if self.piston_area > 0.0 {
            self.map.position(self.force(actuation))
        } else {
            actuation.position
        }
    }

    /// Rate of [`Self::force`] [N/s] while the actuator moves by `rate`, per second.
    pub fn force_rate(&self, actuation: Actuation, rate: Actuation) -> f64 {
        if self.piston_area <= 0.0 {
            return self.map.slope(actuation.position, rate.position) * rate.position;
        }
        let free = actuation.pressure * self.piston_area - self.return_force;
        let moved = rate.pressure * self.piston_area;
        if free > 0.0 || free == 0.0 && moved > 0.0 {
            moved
        } else {
            0.0
        }
    }
}

/// Road load (11).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadParams {
    /// M_v: vehicle mass [kg].
    pub m_v: f64,
    /// r_w: wheel radius [m].
    pub r_w: f64,
    /// ρ_air: air density [kg/m³].
    pub rho_air: f64,
    /// A_v: frontal area [m²].
    pub a_v: f64,
    /// C_D: drag coefficient [1].
    pub c_drag: f64,
    /// C_rr: rolling resistance coefficient [1].
    pub c_rr: f64,
    /// V_ε: speed over which rolling resistance turns its sign, tanh(V/V_ε) [m/s]; 0: at standstill it
    /// holds the vehicle like dry friction.
    pub v_eps: f64,
}

impl RoadParams {
    /// g: standard gravity of the paper's road load [m/s²].
    pub const GRAVITY: f64 = 9.81;
}

impl Params {
    /// The paper's test bench: Table 1, and assumed values where the paper gives none.
    ///
    /// c_o,eq is 567 as in Table 1, not the 561 of section 2.2.2 (erratum E6).
    /// `assumed:` k_d, c_d, k_t, c_t, μ_k, μ_s, the road load and the force-position maps: typical
    /// of a compact car with a dry DCT; the two clutches differ on purpose. T_s turns a shaft by 100 rad/s
    /// in 0.1 s.
    pub const TABLE_1: Self = Self {
        j_e: 0.745,
        j_d: 0.0165,
        k_d: 600.0,
        c_d: 1.5,
        j_ct: [0.1, 0.1],
        k_t: [3.0e4, 3.0e4],
        c_t: [20.0, 20.0],
        i_t: [[3.0, 0.0, 0.0, 0.0], [2.4, 0.0, 0.0, 0.0]],
        i_r: [0.0, 0.0],
        j_gear: [[0.0; GEARS_PER_SHAFT]; 2],
        j_r: [0.0, 0.0],
        eta: [[1.0; GEARS_PER_SHAFT]; 2],
        eta_r: [1.0, 1.0],
        t_s: [100.0, 100.0],
        i_f: [6.0, 4.8],
        j_o: 0.04,
        k_o: 4887.0,
        c_o: 567.0,
        j_v: 134.6,
        clutch: [
            ClutchParams {
                mu_k: 0.26,
                mu_s: 0.30,
                curve: FrictionCurve::CONSTANT,
                thermal: Thermal::OFF,
                specific_wear: 0.0,
                r_c_n: 0.095,
                map: ForceMap::CLUTCH_1,
                piston_area: 0.0,
                return_force: 0.0,
            },
            ClutchParams {
                mu_k: 0.22,
                mu_s: 0.25,
                curve: FrictionCurve::CONSTANT,
                thermal: Thermal::OFF,
                specific_wear: 0.0,
                r_c_n: 0.095,
                map: ForceMap::CLUTCH_2,
                piston_area: 0.0,
                return_force: 0.0,
            },
        ],
        road: RoadParams {
            m_v: 1500.0,
            r_w: 0.30,
            rho_air: 1.20,
            a_v: 2.2,
            c_drag: 0.32,
            c_rr: 0.013,
            v_eps: 0.05,
        },
        rigid: false,
    };

    /// Number of the reverse gear of either shaft.
    pub const REVERSE: i32 = -1;

    /// Ratio i_t of the gear preselected on a shaft [1]; 0 in neutral and for a gear not fitted.
    ///
    /// `shaft`: 0 carries gears 1, 3, 5, 7 and 1 carries 2, 4, 6, 8. `gear`: number of the gear, or
    /// [`Self::REVERSE`], whose ratio is below 0.
    pub fn i_t(&self, shaft: usize, gear: i32) -> f64 {
        if gear == Self::REVERSE {
            return self.i_r.get(shaft).map_or(0.0, |ratio| 0.0 - ratio);
        }
        of_gear(&self.i_t, shaft, gear)
    }

    /// What the gear that is in adds to J_ct of a shaft [kg·m²]; arguments as of [`Self::i_t`].
    pub fn gear_inertia(&self, shaft: usize, gear: i32) -> f64 {
        if gear == Self::REVERSE {
            return self.j_r.get(shaft).copied().unwrap_or(0.0);
        }
        of_gear(&self.j_gear, shaft, gear)
    }

    /// η of the gear that is in on a shaft [1]; 1 in neutral; arguments as of [`Self::i_t`].
    pub fn efficiency(&self, shaft: usize, gear: i32) -> f64 {
        if gear == Self::REVERSE {
            return self.eta_r.get(shaft).copied().unwrap_or(1.0);
        }
        match of_gear(&self.eta, shaft, gear) {
            0.0 => 1.0,
            eta => eta,
        }
    }

    /// Whether some gear loses power.
    pub fn gears_lose_power(&self) -> bool {
        let mut all = self.eta.as_flattened().iter().chain(&self.eta_r);
        all.any(|eta| *eta != 1.0)
    }

    /// η^s: what becomes of the torque with which a shaft drives the output [1].
    ///
    /// `power`: s = sgn(T_t ω_o), see [`crate::plant::mesh`]; 0 without loss.
    pub(crate) fn mesh_factor(&self, shaft: usize, gear: i32, power: i8) -> f64 {
        match power {
            0 => 1.0,
            1.. => self.efficiency(shaft, gear),
            _ => 1.0 / self.efficiency(shaft, gear),
        }
    }

    /// Which of the gears that are in lose power, shape (2).
    pub(crate) fn gears_that_lose(&self, gear: [i32; 2]) -> [bool; 2] {
        [0, 1].map(|i| self.efficiency(i, gear[i]) < 1.0)
    }

    /// J_ct1, J_ct2 with what the gears that are in add [kg·m²], shape (2).
    pub fn j_ct_in(&self, gear: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|shaft| self.j_ct[shaft] + self.gear_inertia(shaft, gear[shaft]))
    }

    /// The driveline while `gear` is in, shape (2): J_ct is all that turns with the shafts.
    pub fn in_gears(&self, gear: [i32; 2]) -> Self {
        Self {
            j_ct: self.j_ct_in(gear),
            j_gear: [[0.0; GEARS_PER_SHAFT]; 2],
            j_r: [0.0; 2],
            ..*self
        }
    }

    /// Whether some gear adds to J_ct.
    pub fn gears_add_inertia(&self) -> bool {
        let mut all = self.j_gear.as_flattened().iter().chain(&self.j_r);
        all.any(|inertia| *inertia != 0.0)
    }

    /// J_ed = J_e + J_d of (13) [kg·m²].
    pub const fn j_ed(&self) -> f64 {
        self.j_e + self.j_d
    }

    /// g_i = i_ti i_fi for the gears preselected [1], shape (2).
    pub fn g(&self, gear: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|shaft| self.i_t(shaft, gear[shaft]) * self.i_f[shaft])
    }

    /// J_out = J_o + Σ g_i² J_cti: gearbox inertia seen at the output shaft [kg·m²].
    ///
    /// `g`: total ratios of the two shafts, shape (2).
    pub fn j_out(&self, g: [f64; 2]) -> f64 {
        self.j_o + g[0] * g[0] * self.j_ct[0] + g[1] * g[1] * self.j_ct[1]
    }

    /// J_ct2,eq = g2 J_ct2 + g1²/g2 J_ct1 + J_o/g2 of (13) [kg·m²]; g2 ≠ 0.
    ///
    /// A mixed quantity (erratum E9): the inertia seen at clutch 2 is J_ct2,eq/g2.
    pub fn j_ct2_eq(&self, g: [f64; 2]) -> f64 {
        self.j_out(g) / g[1]
    }

    /// J_v,eq = J_v + J_out + g_i² J_ed of (20): everything, seen at the wheel [kg·m²].
    ///
    /// `engaged`: index of the engaged clutch.
    pub fn j_v_eq(&self, g: [f64; 2], engaged: usize) -> f64 {
        self.j_v + self.j_out(g) + g[engaged] * g[engaged] * self.j_ed()
    }
}

/// The entry of a forward gear in a table by shaft and position; 0 in neutral and for gears of the other shaft.
fn of_gear(table: &[[f64; GEARS_PER_SHAFT]; 2], shaft: usize, gear: i32) -> f64 {
    let position = usize::try_from(gear)
        .ok()
        .and_then(|gear| gear.checked_sub(shaft + 1));
    match (position, table.get(shaft)) {
        (Some(position), Some(gears)) if position.is_multiple_of(2) => {
            gears.get(position / 2).copied().unwrap_or(0.0)
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::Params;

    const P: Params = Params::TABLE_1;

    /// Numbers of Table 1, computed by hand in double precision.
    const TOLERANCE: f64 = 1e-12;

    #[test]
    fn derived_inertias_are_those_of_table_1() {
        let g = P.g([1, 2]);
        assert!((P.j_ct2_eq(g) / 3.967_972_222_222_222_5 - 1.0).abs() < TOLERANCE);
        assert!((P.j_v_eq(g, 0) / 427.037_04 - 1.0).abs() < TOLERANCE);
        assert!((P.j_v_eq(g, 1) / 281.370_009_6 - 1.0).abs() < TOLERANCE);
    }

    #[test]
    fn a_gear_sits_on_one_shaft_only() {
        let cases = [
            (0, 1, 3.0),
            (1, 2, 2.4),
            (0, 2, 0.0),
            (1, 1, 0.0),
            (0, 0, 0.0),
            (1, -1, 0.0),
            (0, -2, 0.0),
        ];
        for (shaft, gear, ratio) in cases {
            assert_eq!(P.i_t(shaft, gear), ratio, "shaft {shaft} gear {gear}");
        }
    }
}
