/* An FMU that does not return from the function HANG, if that is fmi2DoStep from 0.4 s on. Its output x is
 * the time [s]. The file that the environment calls HUNG is there once it hangs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
static const Callbacks *callbacks;
static double x;

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
void fmi2FreeInstance(void *c) { (void)c; }
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) {
    (void)c, (void)a, (void)b, (void)d, (void)e, (void)f;
    return 0;
}
int fmi2EnterInitializationMode(void *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(void *c) { (void)c; return 0; }
int fmi2Terminate(void *c) { (void)c; return reach(__func__); }
int fmi2GetReal(void *c, const unsigned references[], size_t count, double values[]) {
    (void)c, (void)references;
    for (size_t k = 0; k < count; k++) values[k] = x;
    return 0;
}
int fmi2DoStep(void *c, double time, double step, int fresh) {
    (void)c, (void)fresh;
    x = time + step;
    return time < 0.4 - 1e-9 ? 0 : reach(__func__);
}
