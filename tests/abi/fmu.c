#include "fmu.h"
#include <dlfcn.h>
#include <stdarg.h>
#include <string.h>

void load(Fmu *fmu)
{
    fmu->library = dlopen(fmu->path, RTLD_NOW | RTLD_LOCAL);
    if (!fmu->library)
        fprintf(stderr, "%s\n", dlerror());
    CHECK(fmu->library);
#define FIND(name)                                                                                 \
    *(void **)&fmu->name = dlsym(fmu->library, "fmi2" #name);                                      \
    CHECK(fmu->name);
    FUNCTIONS(FIND)
#undef FIND
}

void unload(Fmu *fmu)
{
    CHECK(dlclose(fmu->library) == 0);
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...)
{
    Log *log = environment;
    va_list arguments;
    CHECK(name && category && message && strlen(message) < 1000);
    if (!log)
        return;
    va_start(arguments, message);
    vsnprintf(log->text, sizeof log->text, message, arguments);
    va_end(arguments);
    snprintf(log->category, sizeof log->category, "%s", category);
    log->status = status;
    log->calls++;
    if (log->back)
        log->back(log->argument);
}

fmi2Component instantiate(const Fmu *fmu, Log *log)
{
    fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, log};
    fmi2Component c = fmu->Instantiate("one", fmi2CoSimulation, fmu->guid, NULL, &callbacks, 0, 1);
    memset((void *)&callbacks, 0x5a, sizeof callbacks); /* the FMU has copied it */
    CHECK(c);
    return c;
}

void start(const Fmu *fmu, fmi2Component c)
{
    CHECK(set(fmu, c, fmu->input, fmu->value) == fmi2OK);
    CHECK(fmu->SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0) == fmi2OK);
    CHECK(fmu->EnterInitializationMode(c) == fmi2OK);
    CHECK(fmu->ExitInitializationMode(c) == fmi2OK);
}

void run(const Fmu *fmu, fmi2Component c, int first, int last)
{
    for (int k = first; k < last; k++)
        CHECK(fmu->DoStep(c, k * STEP, STEP, fmi2True) == fmi2OK);
}

double get(const Fmu *fmu, fmi2Component c, fmi2ValueReference reference)
{
    double value;
    CHECK(fmu->GetReal(c, &reference, 1, &value) == fmi2OK);
    return value;
}

fmi2Status set(const Fmu *fmu, fmi2Component c, fmi2ValueReference reference, double value)
{
    return fmu->SetReal(c, &reference, 1, &value);
}

fmi2Byte *bytes_of(const Fmu *fmu, fmi2Component c, size_t *size)
{
    fmi2FMUstate state = NULL;
    CHECK(fmu->GetFMUstate(c, &state) == fmi2OK);
    CHECK(fmu->SerializedFMUstateSize(c, state, size) == fmi2OK);
    fmi2Byte *bytes = malloc(*size);
    CHECK(bytes);
    CHECK(fmu->SerializeFMUstate(c, state, bytes, *size) == fmi2OK);
    CHECK(fmu->FreeFMUstate(c, &state) == fmi2OK);
    return bytes;
}
