//! Gains that follow the communication step, and the gears and vehicle at hand.

use crate::Params;
use crate::observer::Sample;
use nalgebra::ComplexField;

/// Largest (Ω h)² of an adaptation that swings with Ω [1].
const FOLLOWED: f64 = 0.8;

/// A gain given for 1 ms at a step `h` [s].
///
/// It follows the power of h that leads from the default at 1 ms to the one at 10 ms, `defaults`; below
/// 1 ms it stays. Beyond 10 ms what one sample corrects is held, gain · h^`order`: the same power of h
/// would lose stability before 20 ms.
pub fn scaled(gain: f64, defaults: [f64; 2], order: u32, h: f64) -> f64 {
    if h <= 1e-3 {
        return gain;
    }
    let decades = ComplexField::log10((h / 1e-3).clamp(1.0, 10.0));
    let beyond = (1e-2 / h).min(1.0);
    let at_step = gain * ComplexField::powf(defaults[1] / defaults[0], decades);
    (0..order).fold(at_step, |gain, _| gain * beyond)
}

/// L of `energy` for the gears of a sample and a step `h` [s] [N·m/rad].
///
/// The adaptation swings with Ω² = L (1/J_ed + g_i²/J_out), which a light gearbox raises beyond what samples follow.
pub fn followed(l_c: f64, p: &Params, sample: &Sample, i: usize, h: f64) -> f64 {
    let g = p.g(sample.gear);
    let pace = l_c * (1.0 / p.j_ed() + g[i] * g[i] / p.j_out(g));
    l_c * (FOLLOWED / (pace * h * h)).min(1.0)
}

/// L_c for the gears and the vehicle at hand, shape (2); `l_c` is given for those of Table 1.
///
/// `pace`: what L_ci m_i² moves x1 or w by, `of_table` the same of Table 1; `radius`: (r_ci N_i)² of Table 1 over that at
/// hand; each shape (2).
///
/// Deviation: the adaptation moves x1 by L_c a_i² m_i², and a_i grows where a shaft in neutral, a higher gear or a
/// lighter gearbox leaves less inertia at the output; the same L_c would lose stability.
pub fn paced(l_c: [f64; 2], radius: [f64; 2], pace: [f64; 2], of_table: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| l_c[i] * (of_table[i] / pace[i] * radius[i]).min(1.0))
}

/// (r_ci N_i)² of Table 1 over that of a vehicle [1], shape (2).
pub fn radius(p: &Params) -> [f64; 2] {
    [0, 1].map(|i| {
        let ratio = Params::TABLE_1.clutch[i].r_c_n / p.clutch[i].r_c_n;
        ratio * ratio
    })
}

/// Ratio of each shaft's lowest gear, which stands in until a shaft has had a gear; 1 without any.
pub fn lowest_ratios(p: &Params) -> [f64; 2] {
    [0, 1].map(|i| {
        let lowest = p.i_t[i].iter().find(|i_t| **i_t != 0.0);
        lowest.map_or(1.0, |i_t| i_t * p.i_f[i])
    })
}

#[cfg(test)]
mod tests {
    use super::scaled;

    #[test]
    fn defaults_come_back_at_their_steps() {
        for (h, expected) in [(1e-4, 80.0), (1e-3, 80.0), (1e-2, 24.0)] {
            assert!((scaled(80.0, [80.0, 24.0], 1, h) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn beyond_10_ms_a_sample_corrects_as_much_as_at_10_ms() {
        assert!((scaled(80.0, [80.0, 24.0], 1, 2e-2) * 2e-2 - 0.24).abs() < 1e-12);
        assert!((scaled(5.0, [1.0, 1.0], 2, 2e-2) * 4e-4 - 5e-4).abs() < 1e-12);
    }
}
