/* An FMU that does not return from the function HANG, if that is fmi2DoStep from 0.4 s on. Its output x is
 * the time [s]. The file that the environment calls HUNG is there once it hangs. */
#include "clock.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const Callbacks *callbacks;

static int reach(const char *function) {
    if (strcmp(function, HANG) != 0) return 0;
    callbacks->logger(callbacks->environment, "stuck", 1, "logStatusWarning", "looks for a root");
    fclose(fopen(getenv("HUNG"), "w"));
    for (;;) pause();
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *given, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)visible, (void)logging;
    callbacks = given;
    reach(__func__);
    return &x;
}
int fmi2Terminate(void *c) { (void)c; return reach(__func__); }
int fmi2DoStep(void *c, double time, double step, int fresh) {
    (void)c, (void)fresh;
    x = time + step;
    return time < 0.4 - 1e-9 ? 0 : reach(__func__);
}
