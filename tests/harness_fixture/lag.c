/* First-order lag x' = (u - x) / tau, stepped exactly; the harness tests' own small FMU. Besides,
 * m becomes 2 n and c becomes not b at every step. `delay` is how long a step takes [s]; before the
 * first such step ends there is the file that the environment calls LAG_IS_SLOW. A step longer than `reach` ends in Discard after `reach`, one longer than `most` in Discard at its beginning;
 * `mute` other than 0: it does not tell how far it got. Steps past `ends` end there in Discard, and it wants
 * the simulation to end; a step that touches it too. `unsure` other than 0: it says so with an Error. y = gain u + bias at once. Within a step u goes
 * on with the slope that fmi2SetRealInputDerivatives gave. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "fmi2Functions.h"
enum { U, X, TAU, FAIL_AT, NAN_AT, DELAY, REACH, MOST, MUTE, Y, GAIN, BIAS, SLOPE, ENDS, UNSURE, REALS }; /* value references of reals: doStep returns */
typedef struct {                                   /* Error from FAIL_AT, x is NaN from NAN_AT   */
    double v[REALS];
    int n[2], b[2]; /* value references: 0 input, 1 output */
    double reached, end; /* last time; u there */
    fmi2Boolean over; /* it wants the simulation to end */
    fmi2Boolean log; /* it is asked to */
    const fmi2CallbackFunctions *cb;
} Lag;
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type t, fmi2String g, fmi2String r,
    const fmi2CallbackFunctions *cb, fmi2Boolean vis, fmi2Boolean log) {
    (void)n; (void)t; (void)g; (void)r; (void)vis;
    Lag *m = calloc(1, sizeof *m);
    m->log = log;
    m->v[TAU] = 1.0; m->v[FAIL_AT] = 1e9; m->v[NAN_AT] = m->v[REACH] = m->v[MOST] = m->v[ENDS] = 1e9; m->cb = cb;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, double b, double d, fmi2Boolean e,
    double f) { (void)c; (void)a; (void)b; (void)d; (void)e; (void)f; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2OK; }
static void answer(Lag *m) { m->v[Y] = m->v[GAIN] * m->v[U] + m->v[BIAS]; }
#define ACCESS(type, field) \
    fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference r[], size_t n, \
        const fmi2##type v[]) { \
        for (size_t i = 0; i < n; i++) ((Lag *)c)->field[r[i]] = v[i]; \
        answer(c); \
        return fmi2OK; \
    } \
    fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference r[], size_t n, \
        fmi2##type v[]) { \
        for (size_t i = 0; i < n; i++) v[i] = ((Lag *)c)->field[r[i]]; \
        return fmi2OK; \
    }
ACCESS(Real, v)
ACCESS(Integer, n)
ACCESS(Boolean, b)
static void is_slow(void) {
    const char *name = getenv("LAG_IS_SLOW");
    FILE *file = name ? fopen(name, "w") : NULL;
    if (file) fclose(file);
}
fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean f) {
    Lag *m = c; (void)f;
    struct timespec pause = {(time_t)m->v[DELAY], (long)(fmod(m->v[DELAY], 1.0) * 1e9)};
    if (m->v[DELAY] > 0) is_slow();
    if (m->v[DELAY] > 0) nanosleep(&pause, NULL);
    if (t >= m->v[FAIL_AT]) {
        m->cb->logger(m->cb->componentEnvironment, "lag", fmi2Error, "logStatusError", "told to");
        return fmi2Error;
    }
    m->reached = t;
    m->over = 0;
    if (h > m->v[MOST]) return fmi2Discard;
    fmi2Status status = h > m->v[REACH] ? fmi2Discard : fmi2OK;
    if (status) h = m->v[REACH];
    if (t + h >= m->v[ENDS] - 1e-12) {
        status = fmi2Discard;
        h = m->v[ENDS] - t;
        m->over = 1;
    }
    m->reached = t + h;
    double late = m->v[U] - m->v[SLOPE] * m->v[TAU]; /* what x follows, behind a ramp */
    m->v[X] = t >= m->v[NAN_AT] ? NAN
        : late + m->v[SLOPE] * h + (m->v[X] - late) * exp(-h / m->v[TAU]);
    m->end = m->v[U] + m->v[SLOPE] * h;
    m->n[1] = 2 * m->n[0];
    m->b[1] = !m->b[0];
    return status;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, double *value) {
    *value = ((Lag *)c)->reached;
    if (((Lag *)c)->v[MUTE] != 0) return fmi2Discard;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    Lag *m = c;
    *value = m->over;
    if (m->v[UNSURE] != 0) return fmi2Error;
    return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
    const fmi2Integer order[], const fmi2Real v[]) {
    if (n != 1 || r[0] != U || order[0] != 1) return fmi2Error;
    ((Lag *)c)->v[SLOPE] = v[0];
    return fmi2OK;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
    const fmi2Integer order[], fmi2Real v[]) {
    Lag *m = c;
    if (n != 1 || r[0] != X || order[0] != 1) return fmi2Error;
    v[0] = (m->end - m->v[X]) / m->v[TAU];
    return fmi2OK;
}
