/* A first-order lag as an FMU, written by hand: T x' = u - x, y = x, z = x + gain u, m = 2 n; gain = 2.
 *
 * It is sound, and strict: as FMI 2.0.4 says in 4.2.4, nothing can be read before initialization mode.
 * Compiled with -DX it has the defect X, which the check must find. FMI's own headers are not needed: the
 * types below are those of fmi2FunctionTypes.h. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void *Component;
typedef unsigned Ref;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING_ } Status;
#define EXPORT __attribute__((visibility("default")))
#define REFUSED(name, ...) EXPORT Status name(__VA_ARGS__) { return ERROR; }

typedef struct {
    double u, T, x, slope;
    int n, readable, steps, pending;
} Lag;

static Lag *instances[8];
static void (*finished)(void *environment, Status status);
static double cancelled;
#ifdef SHARED_STATE
static Lag shared;
#define LAG(c) (memcpy((c), (c), 0), &shared)
#else
#define LAG(c) ((Lag *)(c))
#endif

#ifdef STARTS_PROGRAM
static pid_t program;
__attribute__((destructor)) static void stop(void) { if (program) kill(program, SIGKILL); }
#endif

static void start(Lag *lag) {
    *lag = (Lag){.u = 1.0, .T = 0.5, .n = 3};
}

#ifdef UNTIDY
EXPORT const char *lag_version(void) { return "/home/lag/lag.c"; }
#endif
EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT Status fmi2SetDebugLogging(Component c, int on, size_t count, const char *const names[]) {
#ifdef NO_CATEGORIES
    return count > 0 ? ERROR : OK;
#endif
    return OK;
}

EXPORT Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                                 const void *const *functions, int visible, int logging) {
#ifdef PRINTS
    printf("Licence of Lag Ltd. found\n");
#endif
    if (strcmp(guid, "{lag}") != 0) return NULL;
#ifdef URI_NOT_DECODED
    if (strchr(resources, '%')) return NULL;
#endif
#ifdef NO_TOOL
    return NULL;
#endif
#ifdef ONLY_ONE
    for (int i = 0; i < 8; i++) if (instances[i]) return NULL;
#endif
#ifdef IMPORTERS_MEMORY
    void *(*allocate)(size_t, size_t) = (void *(*)(size_t, size_t))functions[1];
    if (!allocate) return NULL;
#endif
#ifdef STARTS_PROGRAM
    if (!program && !(program = vfork())) execlp("sleep", "sleep", "9", (char *)NULL);
#endif
    finished = (void (*)(void *, Status))functions[3];
    Lag *lag = calloc(1, sizeof *lag);
    start(LAG(lag));
    for (int i = 0; i < 8; i++) if (!instances[i]) { instances[i] = lag; break; }
    return lag;
}

EXPORT void fmi2FreeInstance(Component c) {
    for (int i = 0; i < 8; i++) if (instances[i] == c) instances[i] = NULL;
    free(c);
#ifdef CRASH_FREE
    free(c);
#endif
}

EXPORT Status fmi2SetupExperiment(Component c, int has, double tolerance, double t, int stops, double stop) {
    return OK;
}
EXPORT Status fmi2EnterInitializationMode(Component c) {
#ifdef EXIT_ENTER
    exit(0);
#endif
    LAG(c)->readable = 1;
    return OK;
}
EXPORT Status fmi2ExitInitializationMode(Component c) {
#ifdef CRASH_EXIT
    *(volatile int *)8 = 1;
#endif
    return OK;
}
EXPORT Status fmi2Terminate(Component c) {
#ifdef HANG_TERMINATE
    for (;;) sleep(1);
#endif
    return OK;
}
EXPORT Status fmi2Reset(Component c) {
    double x = LAG(c)->x;
    start(LAG(c));
#ifdef RESET_KEEPS
    LAG(c)->x = x;
#endif
    LAG(c)->x += cancelled;
    return OK;
}

static double *real(Lag *lag, Ref ref) { return ref == 0 ? &lag->u : ref == 1 ? &lag->T : NULL; }

EXPORT Status fmi2GetReal(Component c, const Ref refs[], size_t count, double values[]) {
    Lag *lag = LAG(c);
    if (!lag->readable) return ERROR;
    for (size_t i = 0; i < count; i++) {
        double *found = real(lag, refs[i]);
        if (found) values[i] = *found;
#ifdef FEEDS_THROUGH
        else if (refs[i] == 2) values[i] = lag->x + 1e-6 * lag->u;
#endif
        else if (refs[i] == 2) values[i] = lag->x;
        else if (refs[i] == 3) values[i] = lag->x + 2 * lag->u;
#ifdef CONSTANT_DRIFTS
        else if (refs[i] == 4) values[i] = lag->steps < 20 ? 2 : 2.5;
#endif
        else if (refs[i] == 4) values[i] = 2;
        else return ERROR;
#ifdef NOT_A_NUMBER
        if (refs[i] == 2 && lag->steps == 7) values[i] = 0.0 / (lag->n - lag->n);
#endif
    }
    return OK;
}
EXPORT Status fmi2GetInteger(Component c, const Ref refs[], size_t count, int values[]) {
    if (!LAG(c)->readable) return ERROR;
    for (size_t i = 0; i < count; i++) values[i] = refs[i] == 0 ? LAG(c)->n : 2 * LAG(c)->n;
    return OK;
}
EXPORT Status fmi2SetReal(Component c, const Ref refs[], size_t count, const double values[]) {
    for (size_t i = 0; i < count; i++) {
        double *found = real(LAG(c), refs[i]);
#ifdef CONSTANT_SET
        if (refs[i] == 4) continue;
#endif
        if (!found) return ERROR;
#ifdef SET_FORGETS
        if (refs[i] == 0 && values[i] > 1.0) continue;
#endif
#ifdef SET_REFUSES_START
        if (refs[i] == 1 && values[i] == 0.5) return DISCARD;
#endif
        *found = values[i];
    }
    return OK;
}
EXPORT Status fmi2SetInteger(Component c, const Ref refs[], size_t count, const int values[]) {
    for (size_t i = 0; i < count; i++) LAG(c)->n = values[i];
    return OK;
}
REFUSED(fmi2GetBoolean, Component c, const Ref refs[], size_t count, int values[])
REFUSED(fmi2GetString, Component c, const Ref refs[], size_t count, const char *values[])
REFUSED(fmi2SetBoolean, Component c, const Ref refs[], size_t count, const int values[])
REFUSED(fmi2SetString, Component c, const Ref refs[], size_t count, const char *const values[])

EXPORT Status fmi2GetFMUstate(Component c, void **state) {
    if (!*state) *state = malloc(sizeof(Lag));
    memcpy(*state, LAG(c), sizeof(Lag));
    return OK;
}
EXPORT Status fmi2SetFMUstate(Component c, void *state) {
    double x = LAG(c)->x;
    memcpy(LAG(c), state, sizeof(Lag));
#ifdef STATE_FORGETS
    LAG(c)->x = x;
#endif
    return OK;
}
EXPORT Status fmi2FreeFMUstate(Component c, void **state) {
    free(*state);
    *state = NULL;
    return OK;
}
EXPORT Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size) {
    *size = sizeof(Lag);
    return OK;
}
EXPORT Status fmi2SerializeFMUstate(Component c, void *state, unsigned char bytes[], size_t size) {
    memcpy(bytes, state, sizeof(Lag));
#ifdef BYTES_FORGET
    memset(bytes + 16, 0, 8);
#endif
#ifdef BYTES_OVERFLOW
    memset(bytes, 0, 4096);
#endif
    return OK;
}
EXPORT Status fmi2DeSerializeFMUstate(Component c, const unsigned char bytes[], size_t size, void **state) {
    if (size != sizeof(Lag)) return ERROR;
    *state = malloc(sizeof(Lag));
    memcpy(*state, bytes, sizeof(Lag));
    return OK;
}

EXPORT Status fmi2GetDirectionalDerivative(Component c, const Ref unknowns[], size_t count, const Ref knowns[],
                                           size_t known_count, const double seeds[], double out[]) {
#ifdef NO_DIRECTIONAL
    return ERROR;
#endif
    for (size_t i = 0; i < count; i++) {
        out[i] = 0.0;
        for (size_t k = 0; k < known_count; k++)
            if (unknowns[i] == 3 && knowns[k] == 0) out[i] += 2.0 * seeds[k];
#ifdef WRONG_DIRECTIONAL
        out[i] *= 1.01;
#endif
    }
    return OK;
}
EXPORT Status fmi2SetRealInputDerivatives(Component c, const Ref refs[], size_t count, const int orders[],
                                          const double values[]) {
#ifdef NO_SLOPES
    return ERROR;
#endif
#ifndef SLOPES_IGNORED
    LAG(c)->slope = values[0];
#endif
    return OK;
}
EXPORT Status fmi2GetRealOutputDerivatives(Component c, const Ref refs[], size_t count, const int orders[],
                                           double values[]) {
#ifdef NO_RATES
    return ERROR;
#endif
    for (size_t i = 0; i < count; i++) values[i] = (LAG(c)->u - LAG(c)->x) / LAG(c)->T;
#ifdef WRONG_RATES
    for (size_t i = 0; i < count; i++) values[i] *= -1.0;
#endif
    return OK;
}

EXPORT Status fmi2DoStep(Component c, double t, double h, int keep) {
    Lag *lag = LAG(c);
#ifdef CRASH_STEP
    if (++lag->steps == 3) abort();
#else
    lag->steps++;
#endif
#ifdef STEP_REFUSED
    if (lag->steps == 3) return ERROR;
#endif
#ifdef FIXED_STEP
    if (h != 0.01) return ERROR;
#endif
#ifdef OWN_STEP
    h = 0.01;
#endif
#ifdef CLOCK
    lag->x += 1e-9 * (double)rand();
#endif
    for (int i = 0; i < 50; i++) {
        lag->x += h / 50 * (lag->u + (i + 0.5) / 50 * h * lag->slope - lag->x) / lag->T;
    }
    lag->slope = 0.0;
#ifdef PENDING
    lag->pending = 3;
    return PENDING_;
#endif
    return OK;
}
EXPORT Status fmi2CancelStep(Component c) {
#if defined(PENDING) && !defined(CANCEL_REFUSED)
    if (LAG(c)->pending > 0) {
        LAG(c)->pending = 0;
#ifdef CANCEL_LEAVES
        cancelled = 0.1;
#endif
        return OK;
    }
#endif
#ifdef CANCELS_NOTHING
    return OK;
#endif
#ifdef CRASH_CANCEL
    abort();
#endif
    return ERROR;
}
#ifdef PENDING
EXPORT Status fmi2GetStatus(Component c, int kind, Status *value) {
    int left = LAG(c)->pending;
#ifdef FOR_EVER
    left++;
#endif
    *value = left > 0 ? PENDING_ : OK;
    LAG(c)->pending = left - 1;
#ifndef NO_SIGNAL
    if (left == 1) finished(NULL, OK);
#endif
    return OK;
}
#else
REFUSED(fmi2GetStatus, Component c, int kind, Status *value)
#endif
REFUSED(fmi2GetRealStatus, Component c, int kind, double *value)
REFUSED(fmi2GetIntegerStatus, Component c, int kind, int *value)
REFUSED(fmi2GetBooleanStatus, Component c, int kind, int *value)
#ifndef NO_STRING_STATUS
REFUSED(fmi2GetStringStatus, Component c, int kind, const char **value)
#endif
