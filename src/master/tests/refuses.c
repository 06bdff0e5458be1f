/* An FMU of others that refuses inputs u above 1, and says so where logging is on. Its output x is the time [s]. */
#include "clock.h"

static const Callbacks *callbacks;
static int is_logging;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *given, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)visible;
    callbacks = given;
    is_logging = logging;
    return &x;
}
int fmi2SetDebugLogging(void *c, int on, size_t count, const char *const categories[]) {
    (void)c, (void)count, (void)categories;
    is_logging = on;
    return 0;
}
int fmi2Terminate(void *c) { (void)c; return 0; }
int fmi2SetReal(void *c, const unsigned references[], size_t count, const double values[]) {
    (void)c, (void)references;
    for (size_t k = 0; k < count; k++) {
        if (values[k] <= 1.0) continue;
        if (is_logging)
            callbacks->logger(callbacks->environment, "refuses", 3, "logStatusError", "u = %g is above %d", values[k], 1);
        return 3;
    }
    return 0;
}
int fmi2DoStep(void *c, double time, double step, int fresh) {
    (void)c, (void)fresh;
    x = time + step;
    return 0;
}
