//! About `DctObserver`.

use super::{About, Equation, equation};

pub(crate) const OBSERVER: About = About {
    purpose: &[
        "Finds both clutch torques and the drive-shaft torque from what a production car measures - engine torque, \
         four speeds, clutch actuators, gears - though the friction of the clutches is wrongly known. It learns \
         that friction while a clutch slips; `DctClutchControl` uses it to close the loop.",
        "Five methods, chosen by `observer.method`: **paper**, the adaptive observer as printed; **lyapunov**, the \
         same with weights that carry its proof; **energy**, with the physical energy as Lyapunov function; \
         **kalman**, a filter in which a slipping clutch moves with its force and an engaged one with the damper; \
         **calibrating**, the same filter, which also learns errors of engine torque, inertias, drive shaft, wheel \
         speed and clutch maps while driving. Beside them `mapBased.*` gives what one would know without an observer.",
        "Give it the nominal friction and your vehicle's parameters, and connect the plant's outputs of equal names. \
         `status.valid` tells whether the estimates may be used; the log says why not. The numbers of the equations \
         are those of the paper \"Control-oriented modeling and torque estimations for vehicle driveline with \
         dual-clutch transmission\".",
    ],
    equations: EQUATIONS,
    validity: &[
        "Communication steps of 1 to 10 ms are what the gains are made for (`gain.scheduled` fits them to the step); \
         above 0.1 s a step is refused.",
        "Both clutches at once leave one combination of the three torques that the speeds cannot tell; learnt \
         friction bridges it. After a start it takes one slip of each clutch until its friction is known.",
        "Methods but `calibrating` pass errors of engine torque and engine inertia straight into the clutch torques. \
         `calibrating` learns them, but not one common factor on all torques, inertias and stiffnesses: what is \
         trusted is your choice by the standard deviations `calibration.*Sigma`.",
        "Speeds counted from encoder ticks over a step are wrong by up to a tick per step. The observer follows the \
         counted angle instead, once it has recognised the ticks, which the log tells, or from the start where they are \
         told by `engine.encoderTicks`, `clutch1.encoderTicks`, `clutch2.encoderTicks`, `wheel.encoderTicks`. 1024 \
         ticks at 1 ms are usable, far fewer were not tried.",
        "`paper` has no proof of stability for its printed gains; `lyapunov` and `energy` have one in continuous time \
         with the load torque known.",
    ],
};

const EQUATIONS: &[Equation] = &[
    equation(
        "(12)",
        "x_1 = omega_e - omega_c2, x_2 = {omega_c2}/{g_2} - omega_w, x_3 = T_o",
        "states of the methods paper and lyapunov, $g_i = i_ti i_fi$",
    ),
    equation(
        "(13)",
        "x_1' = {x_3}/{J_ct2_eq} + {T_e}/{J_ed} - a_1 T_c1 - a_2 T_c2, a_i = {1}/{J_ed} + {g_i}/{J_ct2_eq}",
        "slip of clutch 2",
    ),
    equation(
        "(14)",
        "x_2' = -b x_3 + h_1 T_c1 + h_2 T_c2 + {T_v}/{J_v}, h_1 = {g_1}/{g_2 J_ct2_eq}, h_2 = {1}/{J_ct2_eq}",
        "twist rate of the drive shaft",
    ),
    equation(
        "(15)",
        "x_3' = k_o_eq x_2 + c_o_eq x_2'",
        "drive-shaft torque",
    ),
    equation(
        "(19)",
        "x_hat' = A x_hat + B u_hat + E T_v + L (y - C x_hat)",
        "the observer, gains (27)",
    ),
    equation(
        "(20)",
        "T_v = g T_e - {d}/{dt} (g J_ed omega_e + J_out omega_o + J_v omega_w)",
        "load torque from momentum, while one clutch is engaged (`load.method`)",
    ),
    equation(
        "(23), (24)",
        "T_ci_hat = (mu_in f_in + eps_i_hat) r_ci N_i theta_mi sgn(omega_e - omega_ci), f_in = {F_i(theta_mi)}/{theta_mi}",
        "clutch torque with the adapted friction",
    ),
    equation(
        "(29)",
        "eps_i_hat' = L_ci (h_i x_2_err - a_i x_1_err) r_ci N_i theta_mi",
        "adaptation",
    ),
    equation(
        "",
        "T_ci = mu_in F_i(theta_mi) r_ci N_i, T_o = g_1 T_c1 + g_2 T_c2",
        "`mapBased.*`: without an observer",
    ),
    equation(
        "",
        "J_ed (1 + delta) omega_e' = (1 + alpha) T_e + beta - T_c1 - T_c2",
        "method calibrating: errors of inertia and engine torque are states of the filter",
    ),
];
