//! About `DctClutchControl`.

use super::{About, equation};

pub(crate) const CONTROL: About = About {
    purpose: &[
        "Turns requested clutch torques into actuator positions. With `feedback.enabled` it counts on the friction \
         that `DctObserver` has learnt and trims by its torque estimates; without it on the nominal friction alone: \
         the map-based control of a production car, for comparison.",
        "Connect it between a supervisory control that requests torques and the actuators of `DctPlant`; estimates \
         come from `DctObserver` under equal names. While `status.valid` is false the last friction stays and no \
         torque is fed back.",
    ],
    equations: &[
        equation(
            "(21)",
            "T_c = mu F(theta_m) r_c N",
            "what a slipping clutch carries",
        ),
        equation(
            "",
            "theta_m = F^{-1}({(1 + z) |T_req| - k_d sgn(s) T_o_hat'}/{mu_hat r_c N})",
            "position for a requested torque at the slip $s = omega_e - omega_c$, within stroke and rate",
        ),
        equation(
            "",
            "z' = k_c {|T_req| - |T_c_hat|}/{|T_req|}",
            "trim by the estimated torque, not while a limit holds; $k_c$ is `torqueGain`, $k_d$ `damping`",
        ),
    ],
    validity: &[
        "Dry clutches that a position moves; a wet clutch's pressure is not an output.",
        "A clutch carries torque against its slip, whatever is asked: a request below 0 closes it only where it \
         brakes, and waits at the touch point while the engine is faster.",
        "The position is written by a step, so a loop through plant and observer is never algebraic; it acts one \
         communication step late.",
        "The gains are far below the bandwidth of the estimates at steps of 1 to 10 ms.",
    ],
};
