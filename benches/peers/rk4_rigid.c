/* The driveline (1)-(11) with rigid transfer shafts by RK4 at 0.1 ms: DctPlant with
 * transmission.rigid = true. */
enum { ENGINE, DAMPER, OUTPUT, WHEEL, TWIST_DAMPER, TWIST_DRIVE, FRICTION, STATES = FRICTION + 2 };
static const double METHOD_STEP = 1e-4;

#include "driveline.h"

static double slip(const double *x, int clutch) {
    return x[DAMPER] - RATIO[clutch] * x[OUTPUT];
}

/* All but the shafts, which are rigid: their torque follows from the acceleration. */
static Torques torques(const double *u, const double *x) {
    Torques t = {.damper = K_D * x[TWIST_DAMPER] + C_D * (x[ENGINE] - x[DAMPER]),
                 .drive = K_O * x[TWIST_DRIVE] + C_O * (x[OUTPUT] - x[WHEEL]),
                 .load = load_torque(u, x[WHEEL])};
    for (int i = 0; i < 2; i++)
        t.clutch[i] = clutch_torque(u, i, slip(x, i));
    return t;
}

static void derivative(const double *u, const double *x, double *dx) {
    Torques t = torques(u, x);
    double driven = -t.drive, inertia = J_O;
    for (int i = 0; i < 2; i++) {
        driven += RATIO[i] * t.clutch[i];
        inertia += RATIO[i] * RATIO[i] * J_CT[i];
        dx[FRICTION + i] = t.clutch[i] * slip(x, i);
    }
    dx[ENGINE] = (u[TORQUE] - t.damper) / J_E;
    dx[DAMPER] = (t.damper - t.clutch[0] - t.clutch[1]) / J_D;
    dx[OUTPUT] = driven / inertia;
    dx[WHEEL] = (t.drive - t.load) / J_V;
    dx[TWIST_DAMPER] = x[ENGINE] - x[DAMPER];
    dx[TWIST_DRIVE] = x[OUTPUT] - x[WHEEL];
}

static void read_outputs(Model *m) {
    const double *x = m->x, clutch_speed[2] = {RATIO[0] * x[OUTPUT], RATIO[1] * x[OUTPUT]};
    double dx[STATES];
    Torques t = torques(m->u, x);
    derivative(m->u, x, dx);
    for (int i = 0; i < 2; i++)
        t.shaft[i] = I_T[i] * (t.clutch[i] - J_CT[i] * RATIO[i] * dx[OUTPUT]);
    read_torques(m, &t, x[DAMPER], clutch_speed, x[WHEEL]);
    m->y[Y_ENGINE] = x[ENGINE], m->y[Y_DAMPER_SPEED] = x[DAMPER], m->y[Y_OUTPUT_SPEED] = x[OUTPUT];
    m->y[Y_ENERGY] = x[FRICTION], m->y[Y_ENERGY + 1] = x[FRICTION + 1];
}
