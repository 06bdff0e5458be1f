/* What no importer should do, and what real ones do all the same. */
#include "cases.h"
#include <math.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>

static fmi2Component running(const Fmu *fmu, Log *log)
{
    fmi2Component c = instantiate(fmu, log);
    start(fmu, c);
    run(fmu, c, 0, 4);
    return c;
}

void freed(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2Component old = running(fmu, NULL);
    fmi2FMUstate state = NULL, kept;
    CHECK(fmu->GetFMUstate(old, &state) == fmi2OK);
    kept = state;
    CHECK(fmu->FreeFMUstate(old, &state) == fmi2OK);
    CHECK(fmu->SetFMUstate(old, kept) == fmi2Error);
    CHECK(fmu->FreeFMUstate(old, &kept) == fmi2Error);
    fmu->FreeInstance(old);
    fmi2Component c = running(fmu, NULL);
    for (int i = 0; i < 3; i++) {
        CHECK(fmu->DoStep(old, 4 * STEP, STEP, fmi2True) == fmi2Error);
        CHECK(set(fmu, old, fmu->input, fmu->value) == fmi2Error);
        fmu->FreeInstance(old);
    }
    run(fmu, c, 4, 8);
    fmu->FreeInstance(c);
}

void foreign(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2Component c = running(fmu, NULL);
    fmi2FMUstate state = NULL;
    CHECK(fmu->GetFMUstate(c, &state) == fmi2OK);
    void *block = calloc(1, 4096);
    void *wrong[] = {NULL, (void *)1, (void *)-1, &c, block, fmu, (char *)c + 1, state, (void *)fmu->DoStep};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        double value = 0;
        fmi2FMUstate place = wrong[i] == state ? c : wrong[i];
        CHECK(fmu->DoStep(wrong[i], 0, STEP, fmi2True) == fmi2Error);
        CHECK(fmu->GetReal(wrong[i], &fmu->output, 1, &value) == fmi2Error);
        CHECK(fmu->Reset(wrong[i]) == fmi2Error);
        fmu->FreeInstance(wrong[i]);
        CHECK(fmu->SetFMUstate(c, place) == fmi2Error);
        if (place)
            CHECK(fmu->FreeFMUstate(c, &place) == fmi2Error && fmu->GetFMUstate(c, &place) == fmi2Error);
    }
    free(block);
    CHECK(fmu->FreeFMUstate(c, &state) == fmi2OK);
    run(fmu, c, 4, 8);
    fmu->FreeInstance(c);
}

typedef struct {
    const Fmu *fmu;
    fmi2Component c;
    fmi2Status step, read;
} Again;

static void call_again(void *argument)
{
    Again *again = argument;
    double value;
    again->step = again->fmu->DoStep(again->c, 4 * STEP, STEP, fmi2True);
    again->read = again->fmu->GetReal(again->c, &again->fmu->output, 1, &value);
    again->fmu->FreeInstance(again->c);
}

void called_back(Fmu *fmu, const char *argument)
{
    (void)argument;
    Log log = {0};
    fmi2Component c = running(fmu, &log);
    Again again = {fmu, c, fmi2OK, fmi2OK};
    log.back = call_again;
    log.argument = &again;
    CHECK(set(fmu, c, fmu->input, NAN) == fmi2Discard);
    CHECK(again.step == fmi2Error && again.read == fmi2Error && log.calls == 1);
    run(fmu, c, 4, 8);
    log.back = NULL;
    fmu->FreeInstance(c);
}

static void *hammer(void *argument)
{
    Again *again = argument;
    for (int i = 0; i < 20000; i++) {
        fmi2Status status = set(again->fmu, again->c, again->fmu->input, again->fmu->value);
        CHECK(status == fmi2OK || status == fmi2Error);
    }
    return NULL;
}

void shared(Fmu *fmu, const char *argument)
{
    (void)argument;
    Again again = {fmu, running(fmu, NULL), fmi2OK, fmi2OK};
    pthread_t ids[8];
    for (int i = 0; i < 8; i++)
        CHECK(pthread_create(&ids[i], NULL, hammer, &again) == 0);
    for (int i = 0; i < 8; i++)
        CHECK(pthread_join(ids[i], NULL) == 0);
    run(fmu, again.c, 4, 8);
    fmu->FreeInstance(again.c);
}

void extremes(Fmu *fmu, const char *argument)
{
    (void)argument;
    const double odd[] = {NAN, INFINITY, -INFINITY, 1e9, -1e9, 1e300, 1e-300, -1e-300, 0};
    const size_t count = sizeof odd / sizeof *odd;
    alarm(20); /* an answer that takes a computation is none */
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < count; k++) {
            fmi2Component c = running(fmu, NULL);
            fmi2Status status = fmu->DoStep(c, odd[i], odd[k], fmi2True);
            CHECK(status == fmi2Error);
            status = fmu->DoStep(c, 4 * STEP, odd[k], fmi2True);
            CHECK(status == fmi2Error || (status <= fmi2Discard && odd[k] >= 1e9));
            CHECK(fmu->Reset(c) == fmi2OK);
            fmu->SetupExperiment(c, fmi2True, odd[i], odd[k], fmi2True, odd[i]);
            fmu->FreeInstance(c);
        }
}

void too_long(Fmu *fmu, const char *argument)
{
    (void)argument;
    Log log = {0};
    fmi2Component c = running(fmu, &log);
    size_t size, after;
    fmi2Byte *bytes = bytes_of(fmu, c, &size);
    double longest = 0, reached;
    fmi2Boolean boolean;
    CHECK(fmu->DoStep(c, 4 * STEP, 1e6, fmi2True) == fmi2Discard);
    CHECK(log.calls == 1 && log.status == fmi2Discard);
    const char *told = strstr(log.text, "communicationStepSize = 1000000 s is above ");
    CHECK(told && sscanf(strstr(told, "above"), "above %lf s", &longest) == 1 && longest > STEP);
    CHECK(fmu->DoStep(c, 4 * STEP, 1.01 * longest, fmi2True) == fmi2Discard);
    CHECK(fmu->GetRealStatus(c, fmi2LastSuccessfulTime, &reached) == fmi2OK && reached == 4 * STEP);
    CHECK(fmu->GetBooleanStatus(c, fmi2Terminated, &boolean) == fmi2Discard); /* it is not known */
    fmi2Byte *again = bytes_of(fmu, c, &after);
    CHECK(after == size && !memcmp(again, bytes, size));
    CHECK(fmu->DoStep(c, 4 * STEP, longest, fmi2True) == fmi2OK);
    CHECK(fmu->Terminate(c) == fmi2OK);
    free(again);
    free(bytes);
    fmu->FreeInstance(c);
}

void corrupted(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2Component c = running(fmu, NULL);
    size_t size, again;
    fmi2Byte *bytes = bytes_of(fmu, c, &size);
    unsigned random = 1;
    for (int i = 0; i < 400; i++) {
        fmi2Byte *damaged = malloc(size);
        memcpy(damaged, bytes, size);
        for (int hits = i % 4; hits >= 0; hits--) {
            random = random * 1664525u + 1013904223u;
            damaged[(random >> 8) % size] ^= (fmi2Byte)(1u << (random & 7));
        }
        size_t said = i % 8 == 7 ? (random >> 8) % size : size;
        fmi2FMUstate state = NULL;
        if (memcmp(damaged, bytes, size) != 0)
            CHECK(fmu->DeSerializeFMUstate(c, damaged, said, &state) == fmi2Error && !state);
        free(damaged);
    }
    fmi2Byte *after = bytes_of(fmu, c, &again);
    CHECK(again == size && memcmp(after, bytes, size) == 0);
    free(bytes);
    free(after);
    run(fmu, c, 4, 8);
    fmu->FreeInstance(c);
}

/* One call from a thread of its own. */
static void *next_step(void *argument)
{
    const Again *again = argument;
    run(again->fmu, again->c, 4, 5);
    return NULL;
}

void importers(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2Component c = instantiate(fmu, NULL);
    CHECK(get(fmu, c, fmu->fixed) == get(fmu, c, fmu->fixed)); /* start values are read here */
    CHECK(set(fmu, c, fmu->input, fmu->value) == fmi2OK);      /* fmpy, before the experiment */
    CHECK(fmu->SetupExperiment(c, fmi2True, 0, 0, fmi2True, 10 * STEP * (1 - 1e-12)) == fmi2OK);
    CHECK(fmu->EnterInitializationMode(c) == fmi2OK);
    double first = get(fmu, c, fmu->output); /* libcosim reads everything here */
    CHECK(set(fmu, c, fmu->input, fmu->value) == fmi2OK);
    CHECK(get(fmu, c, fmu->output) == first);
    CHECK(fmu->ExitInitializationMode(c) == fmi2OK);
    CHECK(get(fmu, c, fmu->output) == first); /* containers read, write and read again */
    CHECK(set(fmu, c, fmu->input, fmu->value) == fmi2OK);
    CHECK(get(fmu, c, fmu->output) == first);
    double time = 0;
    for (int k = 0; k < 4; k++) { /* sums and differences of times, not multiples */
        double h = STEP * (1 + (k % 2 ? 1e-9 : -1e-9));
        CHECK(fmu->DoStep(c, time, h, fmi2True) == fmi2OK);
        time += h;
    }
    Again again = {fmu, c, fmi2OK, fmi2OK};
    pthread_t id;
    CHECK(pthread_create(&id, NULL, next_step, &again) == 0 && pthread_join(id, NULL) == 0);
    run(fmu, c, 5, 10); /* the last step ends where the rounded stop time is */
    CHECK(fmu->DoStep(c, 10 * STEP, STEP, fmi2True) == fmi2Error);
    CHECK(fmu->Terminate(c) == fmi2OK);
    CHECK(fmu->Terminate(c) == fmi2Error); /* harmless */
    fmu->FreeInstance(c);
}

/* The probe panics when its input is above 100. */
void panics(Fmu *fmu, const char *argument)
{
    (void)argument;
    Log log = {0};
    fmi2Component c = running(fmu, &log), other = running(fmu, NULL);
    CHECK(set(fmu, c, fmu->input, 101) == fmi2OK);
    CHECK(fmu->DoStep(c, 4 * STEP, STEP, fmi2True) == fmi2Fatal);
    CHECK(log.calls == 1 && log.status == fmi2Fatal && strstr(log.text, "panicked"));
    CHECK(fmu->DoStep(c, 4 * STEP, STEP, fmi2True) == fmi2Fatal);
    CHECK(fmu->Reset(c) == fmi2Fatal);
    fmu->FreeInstance(c);
    run(fmu, other, 4, 8);
    fmu->FreeInstance(other);
}

void messages(Fmu *fmu, const char *argument)
{
    Log log = {0};
    fmi2Component c = running(fmu, &log);
    CHECK(log.calls == 0);
    CHECK(set(fmu, c, fmu->input, INFINITY) == fmi2Discard);
    CHECK(log.calls == 1 && log.status == fmi2Discard);
    CHECK(strcmp(log.category, "logStatusDiscard") == 0);
    CHECK(strstr(log.text, argument) && strstr(log.text, "fmi2SetReal"));
    CHECK(get(fmu, c, fmu->input) == fmu->value);
    CHECK(set(fmu, c, fmu->output, 1) == fmi2Error && set(fmu, c, fmu->fixed, 1) == fmi2Error);
    CHECK(log.calls == 3 && log.status == fmi2Error);
    fmi2String categories[] = {"logStatusDiscard"};
    CHECK(fmu->SetDebugLogging(c, fmi2False, 1, categories) == fmi2OK);
    CHECK(set(fmu, c, fmu->input, NAN) == fmi2Discard && log.calls == 3);
    CHECK(fmu->SetDebugLogging(c, fmi2False, 0, NULL) == fmi2OK);
    CHECK(set(fmu, c, fmu->output, 1) == fmi2Error && log.calls == 3);
    fmu->FreeInstance(c);
}

/* A lie that no FMU can see through, only the address sanitizer: two values behind one's pointer. */
void overrun(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2Component c = running(fmu, NULL);
    fmi2ValueReference references[] = {fmu->input, fmu->output};
    double *one = malloc(sizeof *one);
    fmu->GetReal(c, references, 2, one);
    free(one);
    fmu->FreeInstance(c);
}
