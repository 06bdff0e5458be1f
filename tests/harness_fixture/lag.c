/* First-order lag x' = (u - x) / tau, stepped exactly; the harness tests' own small FMU. */
#include <math.h>
#include <stdlib.h>
#include "fmi2Functions.h"
/* value references: 0 u, 1 x, 2 tau, 3 failAt (doStep returns Error from there), 4 nanAt */
typedef struct { double v[5]; const fmi2CallbackFunctions *cb; } Lag;
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type t, fmi2String g, fmi2String r,
    const fmi2CallbackFunctions *cb, fmi2Boolean vis, fmi2Boolean log) {
    (void)n; (void)t; (void)g; (void)r; (void)vis; (void)log;
    Lag *m = calloc(1, sizeof *m);
    m->v[2] = 1.0; m->v[3] = 1e9; m->v[4] = 1e9; m->cb = cb;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, double b, double d, fmi2Boolean e,
    double f) { (void)c; (void)a; (void)b; (void)d; (void)e; (void)f; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) ((Lag *)c)->v[r[i]] = v[i];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((Lag *)c)->v[r[i]];
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean b) {
    Lag *m = c; (void)b;
    if (t >= m->v[3]) {
        m->cb->logger(m->cb->componentEnvironment, "lag", fmi2Error, "logStatusError", "told to");
        return fmi2Error;
    }
    m->v[1] = t >= m->v[4] ? NAN : m->v[0] + (m->v[1] - m->v[0]) * exp(-h / m->v[2]);
    return fmi2OK;
}
