/* The driveline (1)-(11) with compliant transfer shafts by RK4: DctPlant as it is.
 *
 * Its fastest eigenvalue, -42 673 1/s, and the reach of RK4 on the negative axis, 2.785, leave steps
 * of up to 65 us; 1/16 ms is the longest one that divides a millisecond. */
enum { ENGINE, DAMPER, CLUTCH, OUTPUT = CLUTCH + 2, WHEEL, TWIST_DAMPER, TWIST_SHAFT,
       TWIST_DRIVE = TWIST_SHAFT + 2, FRICTION, STATES = FRICTION + 2 };
static const double METHOD_STEP = 1e-3 / 16;

#include "driveline.h"

static Torques torques(const double *u, const double *x) {
    Torques t = {.damper = K_D * x[TWIST_DAMPER] + C_D * (x[ENGINE] - x[DAMPER]),
                 .drive = K_O * x[TWIST_DRIVE] + C_O * (x[OUTPUT] - x[WHEEL]),
                 .load = load_torque(u, x[WHEEL])};
    for (int i = 0; i < 2; i++) {
        double rate = x[CLUTCH + i] / I_T[i] - I_F[i] * x[OUTPUT];
        t.shaft[i] = K_T * x[TWIST_SHAFT + i] + C_T * rate;
        t.clutch[i] = clutch_torque(u, i, x[DAMPER] - x[CLUTCH + i]);
    }
    return t;
}

static void derivative(const double *u, const double *x, double *dx) {
    Torques t = torques(u, x);
    double driven = -t.drive;
    for (int i = 0; i < 2; i++) {
        driven += I_F[i] * t.shaft[i];
        dx[CLUTCH + i] = (t.clutch[i] - t.shaft[i] / I_T[i]) / J_CT[i];
        dx[TWIST_SHAFT + i] = x[CLUTCH + i] / I_T[i] - I_F[i] * x[OUTPUT];
        dx[FRICTION + i] = t.clutch[i] * (x[DAMPER] - x[CLUTCH + i]);
    }
    dx[ENGINE] = (u[TORQUE] - t.damper) / J_E;
    dx[DAMPER] = (t.damper - t.clutch[0] - t.clutch[1]) / J_D;
    dx[OUTPUT] = driven / J_O;
    dx[WHEEL] = (t.drive - t.load) / J_V;
    dx[TWIST_DAMPER] = x[ENGINE] - x[DAMPER];
    dx[TWIST_DRIVE] = x[OUTPUT] - x[WHEEL];
}

static void read_outputs(Model *m) {
    const double *x = m->x;
    Torques t = torques(m->u, x);
    read_torques(m, &t, x[DAMPER], x + CLUTCH, x[WHEEL]);
    m->y[Y_ENGINE] = x[ENGINE], m->y[Y_DAMPER_SPEED] = x[DAMPER], m->y[Y_OUTPUT_SPEED] = x[OUTPUT];
    m->y[Y_ENERGY] = x[FRICTION], m->y[Y_ENERGY + 1] = x[FRICTION + 1];
}
