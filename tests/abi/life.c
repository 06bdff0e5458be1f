/* What a well-behaved importer does: often, in threads, with little stack, in another process. */
#include "cases.h"
#include <dlfcn.h>
#include <fenv.h>
#include <locale.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#define STEPS 64

static void live(const Fmu *fmu, int steps)
{
    fmi2Component c = instantiate(fmu, NULL);
    start(fmu, c);
    run(fmu, c, 0, steps);
    CHECK(fmu->Terminate(c) == fmi2OK);
    fmu->FreeInstance(c);
}

void every_function(Fmu *fmu, const char *argument)
{
    (void)argument;
    Log log = {0};
    fmi2Component c = instantiate(fmu, &log);
    double before, after, none = 0;
    size_t size;
    fmi2FMUstate state = NULL, copy = NULL;
    fmi2Integer integer = 0, order = 1;
    fmi2Boolean boolean;
    fmi2String string;
    fmi2Status status;
    fmi2ValueReference input = fmu->input, output = fmu->output;

    CHECK(strcmp(fmu->GetVersion(), "2.0") == 0);
    CHECK(strcmp(fmu->GetTypesPlatform(), "default") == 0);
    CHECK(fmu->SetDebugLogging(c, fmi2True, 0, NULL) == fmi2OK);
    start(fmu, c);
    before = get(fmu, c, output);
    CHECK(set(fmu, c, input, 1.5 * fmu->value) == fmi2OK);
    run(fmu, c, 0, STEPS);
    CHECK(get(fmu, c, output) != before);
    CHECK(fmu->GetRealStatus(c, fmi2LastSuccessfulTime, &after) == fmi2OK && after == STEPS * STEP);
    CHECK(fmu->GetStatus(c, fmi2DoStepStatus, &status) == fmi2Discard);
    CHECK(fmu->GetIntegerStatus(c, fmi2DoStepStatus, &integer) == fmi2Discard);
    CHECK(fmu->GetBooleanStatus(c, fmi2Terminated, &boolean) == fmi2Discard);
    CHECK(fmu->GetStringStatus(c, fmi2PendingStatus, &string) == fmi2Discard);
    CHECK(fmu->CancelStep(c) == fmi2Error);
    CHECK(fmu->GetInteger(c, NULL, 0, NULL) == fmi2OK && fmu->SetInteger(c, NULL, 0, NULL) == fmi2OK);
    CHECK(fmu->GetBoolean(c, NULL, 0, NULL) == fmi2OK && fmu->SetBoolean(c, NULL, 0, NULL) == fmi2OK);
    CHECK(fmu->GetString(c, NULL, 0, NULL) == fmi2OK && fmu->SetString(c, NULL, 0, NULL) == fmi2OK);
    CHECK(fmu->SetRealInputDerivatives(c, &output, 1, &order, &none) == fmi2Error);
    CHECK(fmu->GetRealOutputDerivatives(c, &input, 1, &order, &none) == fmi2Error);
    CHECK(fmu->GetDirectionalDerivative(c, &output, 1, &output, 1, &none, &none) == fmi2Error);

    CHECK(fmu->GetFMUstate(c, &state) == fmi2OK);
    CHECK(fmu->SerializedFMUstateSize(c, state, &size) == fmi2OK);
    fmi2Byte *bytes = malloc(size);
    CHECK(fmu->SerializeFMUstate(c, state, bytes, size) == fmi2OK);
    run(fmu, c, STEPS, 2 * STEPS);
    after = get(fmu, c, output);
    CHECK(fmu->DeSerializeFMUstate(c, bytes, size, &copy) == fmi2OK);
    free(bytes);
    CHECK(fmu->SetFMUstate(c, copy) == fmi2OK);
    run(fmu, c, STEPS, 2 * STEPS);
    CHECK(get(fmu, c, output) == after);
    CHECK(fmu->FreeFMUstate(c, &state) == fmi2OK && fmu->FreeFMUstate(c, &copy) == fmi2OK);
    CHECK(!state && !copy);
    CHECK(fmu->Terminate(c) == fmi2OK);
    CHECK(fmu->Reset(c) == fmi2OK);
    start(fmu, c);
    CHECK(get(fmu, c, output) == before);
    fmu->FreeInstance(c);
}

void without_logger(Fmu *fmu, const char *argument)
{
    (void)argument;
    fmi2CallbackFunctions none = {NULL, NULL, NULL, NULL, NULL};
    const fmi2CallbackFunctions *given[] = {&none, NULL};
    for (int i = 0; i < 2; i++) {
        fmi2Component c = fmu->Instantiate("one", fmi2CoSimulation, fmu->guid, "file:///a%20b", given[i], 1, 1);
        CHECK(c);
        CHECK(fmu->DoStep(c, 0, 1, fmi2True) == fmi2Error);
        start(fmu, c);
        run(fmu, c, 0, STEPS);
        fmu->FreeInstance(c);
        CHECK(!fmu->Instantiate("one", fmi2CoSimulation, "no GUID", NULL, given[i], 0, 0));
        CHECK(!fmu->Instantiate("one", fmi2ModelExchange, fmu->guid, NULL, given[i], 0, 0));
        CHECK(!fmu->Instantiate(NULL, fmi2CoSimulation, fmu->guid, NULL, given[i], 0, 0));
        CHECK(!fmu->Instantiate("one", fmi2CoSimulation, NULL, NULL, given[i], 0, 0));
    }
}

/* Bytes that are allocated now, in all arenas. */
static size_t allocated(void)
{
    struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/* Times until the allocator's caches are full, and what may still come into them [bytes]. One block
 * that every life leaves behind, of 32 bytes at least, is far more. */
#define WARM 300
#define CACHED 4096

/* The last instance takes what instances share with it: each life begins from nothing. */
void cycles(Fmu *fmu, const char *argument)
{
    long count = strtol(argument, NULL, 10);
    CHECK(count * 32 > CACHED);
    for (int i = 0; i < WARM; i++)
        live(fmu, 4);
    size_t before = allocated();
    for (long i = 0; i < count; i++)
        live(fmu, 4);
    CHECK(allocated() <= before + CACHED);
}

/* Beside an instance that keeps what they share. */
void cycles_beside(Fmu *fmu, const char *argument)
{
    fmi2Component c = instantiate(fmu, NULL);
    start(fmu, c);
    run(fmu, c, 0, 4);
    cycles(fmu, argument);
    run(fmu, c, 4, 8);
    fmu->FreeInstance(c);
}

void loads(Fmu *fmu, const char *argument)
{
    long count = strtol(argument, NULL, 10);
    CHECK(count * 32 > CACHED);
    size_t before = 0;
    unload(fmu);
    for (long i = 0; i < count + WARM; i++) {
        before = i == WARM ? allocated() : before;
        load(fmu);
        live(fmu, 2);
        unload(fmu);
        CHECK(!dlopen(fmu->path, RTLD_NOW | RTLD_NOLOAD)); /* it is really gone */
    }
    CHECK(allocated() <= before + CACHED);
    load(fmu);
}

/* What a thread hands back: its instance's state after the run. */
typedef struct {
    const Fmu *fmu;
    fmi2Byte *bytes;
    size_t size;
} Run;

static void *run_alone(void *argument)
{
    Run *own = argument;
    fmi2Component c = instantiate(own->fmu, NULL);
    start(own->fmu, c);
    run(own->fmu, c, 0, 4 * STEPS);
    own->bytes = bytes_of(own->fmu, c, &own->size);
    own->fmu->FreeInstance(c);
    return NULL;
}

void threads(Fmu *fmu, const char *argument)
{
    enum { COUNT = 64 };
    (void)argument;
    Run serial = {fmu, NULL, 0}, runs[COUNT];
    pthread_t ids[COUNT];
    run_alone(&serial);
    for (int i = 0; i < COUNT; i++) {
        runs[i] = (Run){fmu, NULL, 0};
        CHECK(pthread_create(&ids[i], NULL, run_alone, &runs[i]) == 0);
    }
    for (int i = 0; i < COUNT; i++) {
        CHECK(pthread_join(ids[i], NULL) == 0);
        CHECK(runs[i].size == serial.size);
        CHECK(memcmp(runs[i].bytes, serial.bytes, serial.size) == 0);
        free(runs[i].bytes);
    }
    free(serial.bytes);
}

static void *all_calls(void *fmu)
{
    every_function(fmu, "");
    return NULL;
}

void small_stack(Fmu *fmu, const char *argument)
{
    size_t size = strtoul(argument, NULL, 10); /* KiB */
    pthread_attr_t attributes;
    pthread_t id;
    CHECK(pthread_attr_init(&attributes) == 0);
    CHECK(pthread_attr_setstacksize(&attributes, 1024 * size) == 0);
    CHECK(pthread_create(&id, &attributes, all_calls, fmu) == 0);
    CHECK(pthread_join(id, NULL) == 0);
}

/* What belongs to the process and not to an FMU. */
typedef struct {
    char locale[256], folder[1024];
    int rounding, exceptions_trapped;
    void *handlers[64];
} Process;

static Process look(void)
{
    Process p;
    memset(&p, 0, sizeof p);
    snprintf(p.locale, sizeof p.locale, "%s", setlocale(LC_ALL, NULL));
    CHECK(getcwd(p.folder, sizeof p.folder));
    p.rounding = fegetround();
    p.exceptions_trapped = fegetexcept();
    for (int number = 1; number < 64; number++) {
        struct sigaction action;
        if (sigaction(number, NULL, &action) == 0)
            p.handlers[number] = (void *)action.sa_handler;
    }
    return p;
}

void untouched(Fmu *fmu, const char *argument)
{
    unload(fmu);
    setlocale(LC_ALL, "C.UTF-8");
    CHECK(fesetround(FE_UPWARD) == 0);
    Process before = look();
    load(fmu);
    every_function(fmu, argument);
    Process after = look();
    CHECK(memcmp(&before, &after, sizeof before) == 0);
}

void save(Fmu *fmu, const char *path)
{
    fmi2Component c = instantiate(fmu, NULL);
    size_t size;
    start(fmu, c);
    run(fmu, c, 0, STEPS);
    fmi2Byte *bytes = bytes_of(fmu, c, &size);
    run(fmu, c, STEPS, 2 * STEPS);
    double output = get(fmu, c, fmu->output);
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(&output, sizeof output, 1, file) == 1);
    CHECK(fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
    free(bytes);
    fmu->FreeInstance(c);
}

/* In another process: on an instance that was made and nothing else. */
void resume(Fmu *fmu, const char *path)
{
    fmi2Component c = instantiate(fmu, NULL);
    static fmi2Byte bytes[1 << 20];
    double output;
    FILE *file = fopen(path, "rb");
    CHECK(file && fread(&output, sizeof output, 1, file) == 1);
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    fmi2FMUstate state = NULL;
    CHECK(fmu->DeSerializeFMUstate(c, bytes, size, &state) == fmi2OK);
    CHECK(fmu->SetFMUstate(c, state) == fmi2OK && fmu->FreeFMUstate(c, &state) == fmi2OK);
    run(fmu, c, STEPS, 2 * STEPS);
    CHECK(get(fmu, c, fmu->output) == output);
    fmu->FreeInstance(c);
}
