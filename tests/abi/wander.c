/* Instances and states that go from thread to thread and from instance to instance, and a logger that uses the FMU. */
#include "cases.h"
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum { RING = 16, LEGS = 8 };

typedef struct {
    const Fmu *fmu;
    fmi2Component c;
    fmi2FMUstate state;
    int leg;
} Traveller;

/* One leg of a life, in whichever thread: made, started, stepped, saved, put back, freed. */
static void *leg(void *argument)
{
    Traveller *t = argument;
    const Fmu *fmu = t->fmu;
    switch (t->leg) {
    case 0: t->c = instantiate(fmu, NULL); break;
    case 1: start(fmu, t->c); break;
    case 2: run(fmu, t->c, 0, 16); break;
    case 3: CHECK(fmu->GetFMUstate(t->c, &t->state) == fmi2OK); break;
    case 4: run(fmu, t->c, 16, 32); break;
    case 5: CHECK(fmu->SetFMUstate(t->c, t->state) == fmi2OK); break;
    case 6: run(fmu, t->c, 16, 48); break;
    default: CHECK(fmu->FreeFMUstate(t->c, &t->state) == fmi2OK && !t->state);
    }
    return NULL;
}

/* Sixteen lives at once; each leg of each is in a thread of its own, and the last thread frees all of them. */
void wanders(Fmu *fmu, const char *argument)
{
    (void)argument;
    Traveller all[RING] = {0};
    size_t size, again;
    fmi2Component alone = instantiate(fmu, NULL);
    start(fmu, alone);
    run(fmu, alone, 0, 48);
    fmi2Byte *wanted = bytes_of(fmu, alone, &size);
    for (int number = 0; number < LEGS; number++) {
        pthread_t ids[RING];
        for (int i = 0; i < RING; i++) {
            all[i].fmu = fmu;
            all[i].leg = number;
            CHECK(pthread_create(&ids[i], NULL, leg, &all[i]) == 0);
        }
        for (int i = 0; i < RING; i++)
            CHECK(pthread_join(ids[i], NULL) == 0);
    }
    for (int i = 0; i < RING; i++) {
        fmi2Byte *bytes = bytes_of(fmu, all[i].c, &again);
        CHECK(again == size && memcmp(bytes, wanted, size) == 0);
        free(bytes);
        fmu->FreeInstance(all[i].c);
    }
    free(wanted);
    fmu->FreeInstance(alone);
}

/* A state is of the FMU, not of the instance it was taken of: it fits another one in any state of its life, also when
 * its own is gone, and before initialization. */
void states_travel(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2FMUstate fresh = NULL, running = NULL;
    fmi2Component one = instantiate(fmu, NULL);
    CHECK(fmu->GetFMUstate(one, &fresh) == fmi2OK);
    start(fmu, one);
    run(fmu, one, 0, 8);
    CHECK(fmu->GetFMUstate(one, &running) == fmi2OK);
    run(fmu, one, 8, 16);
    double wanted = get(fmu, one, fmu->output);
    fmu->FreeInstance(one);
    for (int stage = 0; stage < 4; stage++) {
        fmi2Component c = instantiate(fmu, NULL);
        if (stage == 1)
            CHECK(fmu->EnterInitializationMode(c) == fmi2OK);
        if (stage >= 2) {
            start(fmu, c);
            run(fmu, c, 0, 3);
        }
        if (stage == 3)
            CHECK(fmu->Terminate(c) == fmi2OK);
        CHECK(fmu->SetFMUstate(c, running) == fmi2OK);
        CHECK(fmu->DoStep(c, 0, STEP, fmi2True) == fmi2Error); /* it stands at 8 steps */
        run(fmu, c, 8, 16);
        CHECK(get(fmu, c, fmu->output) == wanted);
        CHECK(fmu->SetFMUstate(c, fresh) == fmi2OK);
        CHECK(fmu->DoStep(c, 0, STEP, fmi2True) == fmi2Error); /* not initialized */
        start(fmu, c);
        run(fmu, c, 0, 16);
        CHECK(get(fmu, c, fmu->output) == wanted);
        if (stage == 3)
            CHECK(fmu->FreeFMUstate(c, &fresh) == fmi2OK && fmu->FreeFMUstate(c, &running) == fmi2OK);
        fmu->FreeInstance(c);
    }
}

typedef struct {
    const Fmu *fmu;
    fmi2Component c;
    _Atomic(fmi2FMUstate) *state; /* one for all threads */
    atomic_int freed;
} Shared;

static void *pull(void *argument)
{
    Shared *own = argument;
    const Fmu *fmu = own->fmu;
    for (int i = 0; i < 2000; i++) {
        fmi2FMUstate state = atomic_load(own->state);
        fmi2Status status = i % 4 ? fmu->SetFMUstate(own->c, state) : fmu->GetFMUstate(own->c, &state);
        CHECK(status == fmi2OK || status == fmi2Error);
        size_t size = 0;
        status = fmu->SerializedFMUstateSize(own->c, state, &size);
        CHECK(status == fmi2OK || (status == fmi2Error && size == 0));
        if (i % 500 == 499 && fmu->FreeFMUstate(own->c, &state) == fmi2OK) {
            fmi2FMUstate other = NULL;
            own->freed++;
            CHECK(fmu->GetFMUstate(own->c, &other) == fmi2OK);
            atomic_store(own->state, other);
        }
    }
    return NULL;
}

/* One state that eight threads set, overwrite, measure and free: each time it is a state or refused. */
void states_shared(Fmu *fmu, const char *argument)
{
    (void)argument;
    Shared all[8];
    pthread_t ids[8];
    fmi2FMUstate first = NULL;
    int freed = 0;
    for (int i = 0; i < 8; i++) {
        all[i] = (Shared){.fmu = fmu, .c = instantiate(fmu, NULL)};
        start(fmu, all[i].c);
    }
    CHECK(fmu->GetFMUstate(all[0].c, &first) == fmi2OK);
    _Atomic(fmi2FMUstate) state = first;
    for (int i = 0; i < 8; i++) {
        all[i].state = &state;
        CHECK(pthread_create(&ids[i], NULL, pull, &all[i]) == 0);
    }
    for (int i = 0; i < 8; i++) {
        CHECK(pthread_join(ids[i], NULL) == 0);
        run(fmu, all[i].c, 0, 4);
        freed += all[i].freed;
    }
    CHECK(freed > 0);
    first = atomic_load(&state);
    CHECK(fmu->FreeFMUstate(all[0].c, &first) == fmi2OK);
    for (int i = 0; i < 8; i++)
        fmu->FreeInstance(all[i].c);
}

typedef struct {
    const Fmu *fmu;
    fmi2Component neighbour;
    int steps;
} Elsewhere;

static void use_others(void *argument)
{
    Elsewhere *own = argument;
    const Fmu *fmu = own->fmu;
    fmi2Component c = instantiate(fmu, NULL);
    start(fmu, c);
    run(fmu, c, 0, 4);
    fmu->FreeInstance(c);
    run(fmu, own->neighbour, own->steps, own->steps + 1);
    own->steps++;
}

/* A logger that is busy with other instances of the FMU, which nothing forbids. */
void called_elsewhere(Fmu *fmu, const char *argument)
{
    (void)argument;
    Log log = {0};
    Elsewhere elsewhere = {fmu, instantiate(fmu, NULL), 0};
    start(fmu, elsewhere.neighbour);
    log.back = use_others;
    log.argument = &elsewhere;
    fmi2Component c = instantiate(fmu, &log);
    start(fmu, c);
    for (int k = 0; k < 8; k++) {
        CHECK(fmu->DoStep(c, -1.0, STEP, fmi2True) == fmi2Error);
        run(fmu, c, k, k + 1);
    }
    CHECK(log.calls == 8 && elsewhere.steps == 8);
    CHECK(get(fmu, c, fmu->output) == get(fmu, elsewhere.neighbour, fmu->output));
    fmi2CallbackFunctions callbacks = {NULL, NULL, NULL, NULL, NULL};
    CHECK(!fmu->Instantiate("", fmi2CoSimulation, fmu->guid, NULL, &callbacks, 0, 1));
    fmu->FreeInstance(c);
    fmu->FreeInstance(elsewhere.neighbour);
}
