//! About `DctPlant`.

use super::{About, Equation, equation};

pub(crate) const PLANT: About = About {
    purpose: &[
        "A vehicle with a dual-clutch transmission, from the engine's torque to the wheels: engine and damper, two \
         clutches that stick and slip, two transfer shafts with preselected gears, drive shaft, vehicle on a road. \
         It is the truth against which `DctObserver` is measured, and the plant that `DctClutchControl` moves.",
        "Between events the driveline is linear but for the road load, so a step is an exact propagation, not a \
         numerical integration: stiff parameters cost neither accuracy nor time. Lock-up, break-away and change of \
         the sign of a slip are located inside the step and never smeared.",
        "Give it the engine torque, the actuators' positions (dry clutches) or pressures (wet ones), the preselected \
         gears, brake torque and road grade. The numbers of the equations are those of the paper \"Control-oriented \
         modeling and torque estimations for vehicle driveline with dual-clutch transmission\".",
    ],
    equations: EQUATIONS,
    validity: &[
        "Torsion only: no vertical or pitch motion, tyres without slip, one wheel speed.",
        "Speeds of both signs, standstill and hill hold included; the load of (11) is odd in the speed.",
        "Communication steps up to 1 s; the inputs are held over a step, or ramped with \
         `fmi2SetRealInputDerivatives`. Speeds, slips, clutch states and shaft torques depend on states only, so a \
         loop through other FMUs is never algebraic.",
        "The gear of a shaft changes only while its clutch is open; otherwise the change waits, and the log says so.",
        "Friction coefficients may change during a run (`kineticFriction` is tunable): a lining that fades.",
        "`energy.residual` is the energy that the balance of the run cannot account for: it should stay at the \
         level of rounding.",
    ],
};

const EQUATIONS: &[Equation] = &[
    equation("(1)", "J_e omega_e' = T_e - T_d", "engine"),
    equation(
        "(2)",
        "J_d omega_d' = T_d - T_c1 - T_c2",
        "output side of the damper",
    ),
    equation(
        "(3)",
        "T_d = k_d (theta_e - theta_d) + c_d (omega_e - omega_d)",
        "torsional damper",
    ),
    equation(
        "(4), (5)",
        "J_cti omega_ci' = T_ci - {T_ti}/{i_ti}, i = 1, 2",
        "input shafts",
    ),
    equation(
        "",
        "T_ti = k_ti ({theta_ci}/{i_ti} - i_fi theta_o) + c_ti ({omega_ci}/{i_ti} - i_fi omega_o)",
        "transfer shafts; stiff with `transmission.rigid`",
    ),
    equation(
        "(6), (7)",
        "T_ci = mu_k F_n r_c N sgn(omega_d - omega_ci)",
        "a clutch that slips",
    ),
    equation(
        "(6), (7)",
        "|T_ci| <= mu_s F_n r_c N, omega_d = omega_ci",
        "an engaged clutch: the torque that keeps it so; both may be engaged at once",
    ),
    equation(
        "(8)",
        "J_o omega_o' = i_f1 T_t1 + i_f2 T_t2 - T_o",
        "output shaft",
    ),
    equation(
        "(9)",
        "J_v omega_w' = T_o - T_v - T_b sgn(omega_w)",
        "wheels and vehicle",
    ),
    equation(
        "(10)",
        "T_o = k_o (theta_o - theta_w) + c_o (omega_o - omega_w)",
        "drive shaft",
    ),
    equation(
        "(11)",
        "T_v = r_w (M_v g sin phi + {1}/{2} rho A_v C_D V |V| + M_v g cos(phi) C_rr tanh({V}/{V_eps})), V = r_w omega_w",
        "road load",
    ),
    equation(
        "",
        "j = {V - 2 V_1 + V_2}/{tau^2}",
        "`vehicle.jerk`: the speed through two low-passes",
    ),
];
