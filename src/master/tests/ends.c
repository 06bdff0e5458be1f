/* An FMU that wants the simulation to end at 0.25 s: it discards the step that gets there, and tells
 * fmi2Terminated. Its output x is the time [s]. MISSING: it has no fmi2GetBooleanStatus. */
#include "clock.h"

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const void *given, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)given, (void)visible, (void)logging;
    return &x;
}
int fmi2Terminate(void *c) { (void)c; return 0; }
int fmi2DoStep(void *c, double time, double step, int fresh) {
    (void)c, (void)fresh;
    x = time + step < 0.25 ? time + step : 0.25;
    return x < 0.25 ? 0 : 2;
}
int fmi2GetRealStatus(void *c, int kind, double *value) {
    (void)c;
    *value = x;
    return kind == 2 ? 0 : 2;
}
#ifndef MISSING
int fmi2GetBooleanStatus(void *c, int kind, int *value) {
    (void)c;
    *value = 1;
    return kind == 3 ? 0 : 2;
}
#endif
