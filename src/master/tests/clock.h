/* What the C FMUs of these tests share: an output x, the time [s], and calls that have nothing to do. */
#include <stddef.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
static double x;

void fmi2FreeInstance(void *c) { (void)c; }
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) {
    (void)c, (void)a, (void)b, (void)d, (void)e, (void)f;
    return 0;
}
int fmi2EnterInitializationMode(void *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(void *c) { (void)c; return 0; }
int fmi2GetReal(void *c, const unsigned references[], size_t count, double values[]) {
    (void)c, (void)references;
    for (size_t k = 0; k < count; k++) values[k] = x;
    return 0;
}
