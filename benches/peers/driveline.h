/* What the RK4 peers share: parameters, clutches smeared by tanh, road load (11), the method.
 *
 * A peer is DctPlant written the usual way: the same parameters, inputs with rates, and outputs, but
 * for the residual of the energy balance and the filtered acceleration and jerk, which it does without.
 * Its right-hand side is a function of inputs and states, evaluated in full at every stage of the
 * method, as code generators write it; the inputs change within a step by their rates. All in one
 * compilation unit, so that the compiler may inline what it likes.
 *
 * A peer defines STATES, METHOD_STEP and these two: */
#ifndef DRIVELINE_H
#define DRIVELINE_H

#include "model.h"

#include <math.h>

typedef struct Torques Torques;
static Torques torques(const double *u, const double *x);
static void derivative(const double *u, const double *x, double *dx);

enum { TORQUE, POSITION_1, POSITION_2, GRADE, BRAKE };
enum { Y_ENGINE, Y_CLUTCH, Y_WHEEL = 3, Y_DRIVE, Y_DAMPER_SPEED, Y_OUTPUT_SPEED, Y_DAMPER, Y_LOAD,
       Y_SPEED, Y_ACCELERATION, Y_SLIP, Y_CLUTCH_TORQUE = 13, Y_SHAFT = 15, Y_POWER = 17,
       Y_ENERGY = 19 };

/* Table 1 and the assumed values of the preset `paper`. */
static const double J_E = 0.745, J_D = 0.0165, K_D = 600.0, C_D = 1.5, J_O = 0.04;
static const double K_T = 3e4, C_T = 20.0, K_O = 4887.0, C_O = 567.0, J_V = 134.6, RADIUS = 0.095;
static const double I_T[2] = {3.0, 2.4}, I_F[2] = {6.0, 4.8}, RATIO[2] = {18.0, 11.52};
static const double J_CT[2] = {0.1, 0.1}, MU_K[2] = {0.26, 0.22};
static const double MASS = 1500.0, R_W = 0.30, RHO = 1.20, AREA = 2.2, DRAG = 0.32, ROLL = 0.013;
static const double GRAVITY = 9.81, V_EPS = 0.05;

/* Slip over which a clutch torque turns its sign [rad/s]. */
static const double SLIP_WIDTH = 1.0;
static const double START_SPEED = 90.0;

/* Torques at an instant [N.m]. */
struct Torques {
    double damper, clutch[2], shaft[2], drive, load;
};

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

static double clutch_torque(const double *u, int clutch, double slip) {
    double peak = MU_K[clutch] * RADIUS * normal_force(clutch, u[POSITION_1 + clutch]);
    return peak * tanh(slip / SLIP_WIDTH);
}

static double load_torque(const double *u, double wheel) {
    double v = R_W * wheel, weight = MASS * GRAVITY, direction = tanh(v / V_EPS);
    double drag = 0.5 * RHO * AREA * DRAG * v * fabs(v);
    double roll = weight * cos(u[GRADE]) * ROLL * direction;
    return R_W * (weight * sin(u[GRADE]) + drag + roll) + u[BRAKE] * direction;
}

/* Inputs `t` seconds after the start of the step. */
static void inputs_after(const Model *m, double t, double *u) {
    for (int i = 0; i < INPUTS; i++)
        u[i] = m->u[i] + t * m->u_rate[i];
}

/* One step of `h` seconds, `t` seconds after the start of the communication step. */
static void rk4(Model *m, double t, double h) {
    double k[4][STATES], at[STATES], u[INPUTS], *x = m->x;
    inputs_after(m, t, u);
    derivative(u, x, k[0]);
    for (int stage = 1; stage < 4; stage++) {
        double reach = stage < 3 ? 0.5 * h : h;
        for (int i = 0; i < STATES; i++)
            at[i] = x[i] + reach * k[stage - 1][i];
        inputs_after(m, t + reach, u);
        derivative(u, at, k[stage]);
    }
    for (int i = 0; i < STATES; i++)
        x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
}

/* Outputs but for the speeds of the peer's own states. */
static void read_torques(Model *m, const Torques *t, double damper_speed, const double *clutch_speed,
                         double wheel) {
    double *y = m->y;
    y[Y_DAMPER] = t->damper, y[Y_DRIVE] = t->drive, y[Y_LOAD] = t->load;
    y[Y_WHEEL] = wheel, y[Y_SPEED] = R_W * wheel;
    y[Y_ACCELERATION] = R_W * (t->drive - t->load) / J_V;
    for (int i = 0; i < 2; i++) {
        y[Y_CLUTCH + i] = clutch_speed[i];
        y[Y_SLIP + i] = damper_speed - clutch_speed[i];
        y[Y_CLUTCH_TORQUE + i] = t->clutch[i], y[Y_SHAFT + i] = t->shaft[i];
        y[Y_POWER + i] = t->clutch[i] * y[Y_SLIP + i];
    }
}

static void read_outputs(Model *m);

void model_start(Model *m) {
    for (int i = 0; i < STATES; i++)
        m->x[i] = 0.0;
    m->x[0] = m->x[1] = START_SPEED; /* engine and damper */
    read_outputs(m);
}

void model_step(Model *m, double h) {
    int steps = (int)ceil(h / METHOD_STEP - 1e-6);
    for (int k = 0; k < steps; k++)
        rk4(m, k * h / steps, h / steps);
    read_outputs(m);
}

#endif
