/* A supplier's dual-clutch driveline as an FMI 2.0 co-simulation FMU. It shares nothing with the
 * rest of this repository: clutches are smooth, T = C tanh(slip / v); speeds are in 1/min, forces
 * come from a parabola over the release travel, and an implicit Rosenbrock method integrates.
 *
 *   J_M w_M' = T_M - T_D                 T_D  torsion damper between engine and hub
 *   J_N w_N' = T_D - T_K1 - T_K2         T_Ki clutches
 *   J_E w_Ei' = T_Ki - T_Wi              T_Wi input shaft i, seen at the clutch
 *   J_A w_A' = sum g_i T_Wi - T_G        T_G  drive shaft
 *   J_F w_R' = T_G - T_L                 T_L  road, grade, air, brake
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

enum { GEARS = 4, N = 10, REALS = 64, INTEGERS = 8 };
static const double PI = 3.14159265358979323846, G = 9.80665;

/* Value references; antrieb.xml names them. */
enum { R_TORQUE, R_BRAKE, R_GRADE, R_TRAVEL1, R_TRAVEL2,                         /* inputs */
    R_SPEED = 10, R_SHAFT1, R_SHAFT2, R_VEHICLE, R_ACCEL, R_DRIVE, R_CLUTCH1, R_CLUTCH2,
    R_SLIP1, R_SLIP2, R_TEMP1, R_TEMP2,                                          /* outputs */
    R_J_ENGINE = 30, R_J_HUB, R_J_SHAFT, R_J_OUT, R_J_VEHICLE, R_K_DAMPER, R_D_DAMPER,
    R_K_SHAFT, R_D_SHAFT, R_K_DRIVE, R_D_DRIVE, R_MASS, R_RADIUS, R_AREA, R_DRAG, R_ROLL,
    R_AIR_TEMP, R_MU1, R_MU2, R_WIDTH, R_SPEED0, R_FINAL1, R_FINAL2, R_LEVER,    /* parameters */
    R_RATIO1 = 54, R_RATIO2 = 58 };
enum { I_GEAR1, I_GEAR2, I_STATE1, I_STATE2 };
/* States: speeds rad/s and twists rad. */
enum { W_M, W_N, W_E1, W_E2, W_A, W_R, P_D, P_W1, P_W2, P_G };

typedef struct {
    double r[REALS], x[N], heat[2];
    int i[INTEGERS];
} Plant;

static const double START[][2] = {
    {R_TRAVEL1, 10}, {R_TRAVEL2, 10}, {R_J_ENGINE, 0.70}, {R_J_HUB, 0.02}, {R_J_SHAFT, 0.09},
    {R_J_OUT, 0.05}, {R_J_VEHICLE, 141}, {R_K_DAMPER, 640}, {R_D_DAMPER, 1.8},
    {R_K_SHAFT, 26000}, {R_D_SHAFT, 20}, {R_K_DRIVE, 5.3}, {R_D_DRIVE, 0.48}, {R_MASS, 1470},
    {R_RADIUS, 310}, {R_AREA, 2.15}, {R_DRAG, 0.31}, {R_ROLL, 0.012}, {R_AIR_TEMP, 20},
    {R_MU1, 0.26}, {R_MU2, 0.22}, {R_WIDTH, 0.02}, {R_SPEED0, 860}, {R_FINAL1, 5.8},
    {R_FINAL2, 4.7}, {R_LEVER, 98}, {R_RATIO1, 3.1}, {R_RATIO1 + 1, 1.62},
    {R_RATIO1 + 2, 0.98}, {R_RATIO2, 2.45}, {R_RATIO2 + 1, 1.30}, {R_RATIO2 + 2, 0.81} };

/* Ratio of input shaft k to output; 0 in neutral, which is item 0 of the enumeration. */
static double ratio(const Plant *p, int k) {
    int gear = p->i[I_GEAR1 + k], first = k ? R_RATIO2 : R_RATIO1;
    if (gear < 1 || gear > GEARS) return 0;
    return p->r[first + gear - 1] * p->r[R_FINAL1 + k];
}

/* Capacity [N.m]: spring force over how far the clutch is closed; 10 mm of travel is open. */
static double capacity(const Plant *p, int k) {
    double closed = 10 - p->r[R_TRAVEL1 + k] - (k ? 2.3 : 2.1);
    double force = closed > 0 ? 150 * closed * closed : 0;
    return p->r[R_MU1 + k] * force * p->r[R_LEVER] * 1e-3;
}

static double clutch(const Plant *p, int k) {
    return capacity(p, k) * tanh((p->x[W_N] - p->x[W_E1 + k]) / p->r[R_WIDTH]);
}

static double load(const Plant *p, const double x[N]) {
    double r = p->r[R_RADIUS] * 1e-3, v = r * x[W_R], grade = p->r[R_GRADE] * PI / 180;
    double air = 101325 / (287.05 * (p->r[R_AIR_TEMP] + 273.15));
    double drag = 0.5 * air * p->r[R_AREA] * p->r[R_DRAG] * v * fabs(v);
    double roll = p->r[R_ROLL] * cos(grade) * tanh(v / 0.05);
    double weight = p->r[R_MASS] * G;
    return r * (weight * (sin(grade) + roll) + drag) + 1e3 * p->r[R_BRAKE] * tanh(x[W_R] / 0.1);
}

static double drive(const Plant *p, const double x[N]) {
    return 1e3 * (p->r[R_K_DRIVE] * x[P_G] + p->r[R_D_DRIVE] * (x[W_A] - x[W_R]));
}

static void derivative(const Plant *p, const double x[N], double dx[N]) {
    const double *r = p->r;
    double damper = r[R_K_DAMPER] * x[P_D] + r[R_D_DAMPER] * (x[W_M] - x[W_N]);
    double out = -drive(p, x), hub = damper;
    for (int k = 0; k < 2; k++) {
        double g = ratio(p, k), twist = x[W_E1 + k] - g * x[W_A];
        double shaft = g > 0 ? r[R_K_SHAFT] * x[P_W1 + k] + r[R_D_SHAFT] * twist : 0;
        double slip = capacity(p, k) * tanh((x[W_N] - x[W_E1 + k]) / r[R_WIDTH]);
        dx[W_E1 + k] = (slip - shaft) / r[R_J_SHAFT];
        dx[P_W1 + k] = g > 0 ? twist : 0;
        out += g * shaft;
        hub -= slip;
    }
    dx[W_M] = (r[R_TORQUE] - damper) / r[R_J_ENGINE];
    dx[W_N] = hub / r[R_J_HUB];
    dx[W_A] = out / r[R_J_OUT];
    dx[W_R] = (drive(p, x) - load(p, x)) / r[R_J_VEHICLE];
    dx[P_D] = x[W_M] - x[W_N];
    dx[P_G] = x[W_A] - x[W_R];
}

/* Factorises I - c J in place, J by differences; returns 0 when it is singular. */
static int factorise(const Plant *p, const double f[N], double c, double a[N][N], int row[N]) {
    for (int j = 0; j < N; j++) {
        double x[N], g[N], d = 1e-7 * (1 + fabs(p->x[j]));
        memcpy(x, p->x, sizeof x);
        x[j] += d;
        derivative(p, x, g);
        for (int i = 0; i < N; i++) a[i][j] = (i == j) - c * (g[i] - f[i]) / d;
    }
    for (int j = 0; j < N; j++) {
        int best = j;
        for (int i = j + 1; i < N; i++) if (fabs(a[i][j]) > fabs(a[best][j])) best = i;
        row[j] = best;
        for (int k = 0; k < N; k++) { double t = a[j][k]; a[j][k] = a[best][k]; a[best][k] = t; }
        if (!(fabs(a[j][j]) > 0)) return 0;
        for (int i = j + 1; i < N; i++) {
            double l = a[i][j] /= a[j][j];
            for (int k = j + 1; k < N; k++) a[i][k] -= l * a[j][k];
        }
    }
    return 1;
}

static void solve(double a[N][N], const int row[N], double b[N]) {
    for (int j = 0; j < N; j++) {
        double t = b[j]; b[j] = b[row[j]]; b[row[j]] = t;
    }
    for (int i = 0; i < N; i++) for (int k = 0; k < i; k++) b[i] -= a[i][k] * b[k];
    for (int i = N - 1; i >= 0; i--) {
        for (int k = i + 1; k < N; k++) b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
}

/* One step of ROS2 (Verwer et al. 1999), second order and L-stable; 0 when it fails. */
static int advance(Plant *p, double h) {
    const double gamma = 1 - sqrt(0.5);
    double f[N], k1[N], k2[N], a[N][N];
    int row[N];
    derivative(p, p->x, f);
    if (!factorise(p, f, gamma * h, a, row)) return 0;
    memcpy(k1, f, sizeof k1);
    solve(a, row, k1);
    double x[N];
    for (int i = 0; i < N; i++) x[i] = p->x[i] + h * k1[i];
    derivative(p, x, k2);
    for (int i = 0; i < N; i++) k2[i] -= 2 * k1[i];
    solve(a, row, k2);
    for (int i = 0; i < N; i++) p->x[i] += h * (1.5 * k1[i] + 0.5 * k2[i]);
    for (int k = 0; k < 2; k++) p->heat[k] += h * fabs(clutch(p, k) * (p->x[W_N] - p->x[W_E1 + k]));
    return isfinite(p->x[W_M]);
}

static void outputs(Plant *p) {
    const double rpm = 30 / PI, *x = p->x;
    double dx[N];
    derivative(p, x, dx);
    p->r[R_SPEED] = x[W_M] * rpm;
    p->r[R_VEHICLE] = x[W_R] * p->r[R_RADIUS] * 1e-3 * 3.6;
    p->r[R_ACCEL] = dx[W_R] * p->r[R_RADIUS] * 1e-3 / G;
    p->r[R_DRIVE] = -drive(p, x) * 1e-3;
    for (int k = 0; k < 2; k++) {
        double slip = x[W_N] - x[W_E1 + k], c = capacity(p, k);
        p->r[R_SHAFT1 + k] = x[W_E1 + k] * rpm;
        p->r[R_CLUTCH1 + k] = clutch(p, k);
        p->r[R_SLIP1 + k] = -slip * rpm;
        p->r[R_TEMP1 + k] = p->r[R_AIR_TEMP] + p->heat[k] / 4200;
        p->i[I_STATE1 + k] = c > 0 ? (fabs(slip) > 1 ? 1 : 0) : 2;
    }
}

/* FMI functions: the smallest set that a co-simulation needs. */
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2Reset(fmi2Component c) {
    Plant *p = c;
    memset(p, 0, sizeof *p);
    for (size_t k = 0; k < sizeof START / sizeof *START; k++) p->r[(int)START[k][0]] = START[k][1];
    p->i[I_GEAR1] = p->i[I_GEAR2] = 1;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String where,
    const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean log) {
    (void)name; (void)where; (void)call; (void)visible; (void)log;
    if (type != fmi2CoSimulation || strcmp(guid, "{antrieb-2026-11}") != 0) return NULL;
    Plant *p = malloc(sizeof *p);
    if (p) fmi2Reset(p);
    return p;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d,
    fmi2Boolean e, fmi2Real f) {
    (void)c; (void)a; (void)b; (void)d; (void)e; (void)f;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Plant *p = c;
    p->x[W_M] = p->x[W_N] = p->r[R_SPEED0] * PI / 30;
    outputs(p);
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { outputs(c); return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep) {
    (void)t; (void)keep;
    int parts = (int)ceil(h / 1e-4 - 1e-9);
    for (int k = 0; k < parts; k++) if (!advance(c, h / parts)) return fmi2Error;
    outputs(c);
    return fmi2OK;
}
#define ACCESS(name, type, field, count) \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference v[], size_t n, \
        type out[]) { \
        for (size_t k = 0; k < n; k++) { \
            if (v[k] >= count) return fmi2Error; \
            out[k] = ((Plant *)c)->field[v[k]]; \
        } \
        return fmi2OK; \
    } \
    fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference v[], size_t n, \
        const type in[]) { \
        for (size_t k = 0; k < n; k++) { \
            if (v[k] >= count) return fmi2Error; \
            ((Plant *)c)->field[v[k]] = in[k]; \
        } \
        return fmi2OK; \
    }
ACCESS(Real, fmi2Real, r, REALS)
ACCESS(Integer, fmi2Integer, i, INTEGERS)

/* What this plant has no use for, but every FMU must export. */
#define NONE(name, ...) \
    fmi2Status name(fmi2Component c, __VA_ARGS__) { (void)c; return fmi2Error; }
#pragma GCC diagnostic ignored "-Wunused-parameter"
NONE(fmi2SetDebugLogging, fmi2Boolean on, size_t n, const fmi2String categories[])
NONE(fmi2GetBoolean, const fmi2ValueReference v[], size_t n, fmi2Boolean out[])
NONE(fmi2SetBoolean, const fmi2ValueReference v[], size_t n, const fmi2Boolean in[])
NONE(fmi2GetString, const fmi2ValueReference v[], size_t n, fmi2String out[])
NONE(fmi2SetString, const fmi2ValueReference v[], size_t n, const fmi2String in[])
NONE(fmi2GetFMUstate, fmi2FMUstate *state)
NONE(fmi2SetFMUstate, fmi2FMUstate state)
NONE(fmi2FreeFMUstate, fmi2FMUstate *state)
NONE(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
NONE(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte out[], size_t size)
NONE(fmi2DeSerializeFMUstate, const fmi2Byte in[], size_t size, fmi2FMUstate *state)
NONE(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t nu,
    const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
NONE(fmi2SetRealInputDerivatives, const fmi2ValueReference v[], size_t n,
    const fmi2Integer order[], const fmi2Real in[])
NONE(fmi2GetRealOutputDerivatives, const fmi2ValueReference v[], size_t n,
    const fmi2Integer order[], fmi2Real out[])
fmi2Status fmi2CancelStep(fmi2Component c) { (void)c; return fmi2Error; }
NONE(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *out)
NONE(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *out)
NONE(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *out)
NONE(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *out)
NONE(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *out)
