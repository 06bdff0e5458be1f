/* The driveline (1)-(11) the usual way: clutch friction smeared by tanh, RK4 at 0.1 ms.
 *
 * Rigid transfer shafts, because RK4 at 0.1 ms is unstable on compliant ones (fastest eigenvalue
 * -42 673 1/s, stable below 65 us): this peer has six states where DctPlant integrates ten.
 * The right-hand side is a function of inputs and states, evaluated in full at every stage of the
 * method, as code generators write it. */
#include "model.h"

#include <math.h>

enum { ENGINE, DAMPER, OUTPUT, WHEEL, TWIST_DAMPER, TWIST_DRIVE };
enum { TORQUE, POSITION_1, POSITION_2, GRADE, BRAKE };

/* Table 1 and the assumed values of the preset `paper`. */
static const double J_E = 0.745, J_D = 0.0165, K_D = 600.0, C_D = 1.5, J_O = 0.04;
static const double K_O = 4887.0, C_O = 567.0, J_V = 134.6, RADIUS = 0.095;
static const double RATIO[2] = {18.0, 11.52}, J_CT[2] = {0.1, 0.1}, MU_K[2] = {0.26, 0.22};
static const double MASS = 1500.0, R_W = 0.30, RHO = 1.20, AREA = 2.2, DRAG = 0.32, ROLL = 0.013;
static const double GRAVITY = 9.81, V_EPS = 0.05;

/* Slip over which a clutch torque turns its sign [rad/s], and the step of the method [s]. */
static const double SLIP_WIDTH = 1.0, METHOD_STEP = 1e-4;
static const double START_SPEED = 90.0;

enum { POINTS = 10 };
static const double POSITION[2][POINTS] = {
    {0.0, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3},
    {0.0, 2.2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3}};
static const double FORCE[2][POINTS] = {
    {0.0, 0.0, 250.0, 700.0, 1350.0, 2200.0, 3300.0, 4700.0, 6400.0, 8500.0},
    {0.0, 0.0, 220.0, 680.0, 1330.0, 2200.0, 3350.0, 4800.0, 6600.0, 8800.0}};

static double normal_force(int clutch, double position) {
    const double *x = POSITION[clutch], *y = FORCE[clutch];
    for (int k = 1; k < POINTS; k++)
        if (position <= x[k])
            return y[k - 1] + (y[k] - y[k - 1]) * (position - x[k - 1]) / (x[k] - x[k - 1]);
    return y[POINTS - 1];
}

static double load_torque(const double *u, double wheel) {
    double v = R_W * wheel, weight = MASS * GRAVITY, direction = tanh(v / V_EPS);
    double drag = 0.5 * RHO * AREA * DRAG * v * fabs(v);
    double roll = weight * cos(u[GRADE]) * ROLL * direction;
    return R_W * (weight * sin(u[GRADE]) + drag + roll) + u[BRAKE] * direction;
}

static double drive_shaft(const double *x) {
    return K_O * x[TWIST_DRIVE] + C_O * (x[OUTPUT] - x[WHEEL]);
}

static void derivative(const double *u, const double *x, double *dx) {
    double damper = K_D * x[TWIST_DAMPER] + C_D * (x[ENGINE] - x[DAMPER]);
    double shaft = drive_shaft(x), clutches = 0.0, driven = 0.0, inertia = J_O;
    for (int i = 0; i < 2; i++) {
        double slip = x[DAMPER] - RATIO[i] * x[OUTPUT];
        double peak = MU_K[i] * RADIUS * normal_force(i, u[POSITION_1 + i]);
        double torque = peak * tanh(slip / SLIP_WIDTH);
        clutches += torque;
        driven += RATIO[i] * torque;
        inertia += RATIO[i] * RATIO[i] * J_CT[i];
    }
    dx[ENGINE] = (u[TORQUE] - damper) / J_E;
    dx[DAMPER] = (damper - clutches) / J_D;
    dx[OUTPUT] = (driven - shaft) / inertia;
    dx[WHEEL] = (shaft - load_torque(u, x[WHEEL])) / J_V;
    dx[TWIST_DAMPER] = x[ENGINE] - x[DAMPER];
    dx[TWIST_DRIVE] = x[OUTPUT] - x[WHEEL];
}

static void rk4(const double *u, double *x, double t) {
    double k[4][STATES], at[STATES];
    derivative(u, x, k[0]);
    for (int stage = 1; stage < 4; stage++) {
        double reach = stage < 3 ? 0.5 * t : t;
        for (int i = 0; i < STATES; i++)
            at[i] = x[i] + reach * k[stage - 1][i];
        derivative(u, at, k[stage]);
    }
    for (int i = 0; i < STATES; i++)
        x[i] += t / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
}

/* Speeds of engine, both clutches and wheel, and the torque of the drive shaft. */
static void read_outputs(Model *m) {
    m->y[0] = m->x[ENGINE];
    m->y[1] = RATIO[0] * m->x[OUTPUT];
    m->y[2] = RATIO[1] * m->x[OUTPUT];
    m->y[3] = m->x[WHEEL];
    m->y[4] = drive_shaft(m->x);
}

void model_start(Model *m) {
    for (int i = 0; i < STATES; i++)
        m->x[i] = 0.0;
    m->x[ENGINE] = m->x[DAMPER] = START_SPEED;
    read_outputs(m);
}

void model_step(Model *m, double h) {
    int steps = (int)ceil(h / METHOD_STEP - 1e-6);
    for (int k = 0; k < steps; k++)
        rk4(m->u, m->x, h / steps);
    read_outputs(m);
}
