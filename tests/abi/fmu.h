/* One FMU library, loaded: its 34 functions and what the cases need to know of its model. */
#ifndef ABI_FMU_H
#define ABI_FMU_H

#include "fmi2FunctionTypes.h"
#include <stdio.h>
#include <stdlib.h>

#define FUNCTIONS(X)                                                                               \
    X(GetTypesPlatform) X(GetVersion) X(SetDebugLogging) X(Instantiate) X(FreeInstance)            \
    X(SetupExperiment) X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate) X(Reset)  \
    X(GetReal) X(GetInteger) X(GetBoolean) X(GetString) X(SetReal) X(SetInteger) X(SetBoolean)     \
    X(SetString) X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate) X(SerializedFMUstateSize)           \
    X(SerializeFMUstate) X(DeSerializeFMUstate) X(GetDirectionalDerivative)                        \
    X(SetRealInputDerivatives) X(GetRealOutputDerivatives) X(DoStep) X(CancelStep) X(GetStatus)    \
    X(GetRealStatus) X(GetIntegerStatus) X(GetBooleanStatus) X(GetStringStatus)

typedef struct {
    void *library;
    const char *path, *guid;
    fmi2ValueReference input, output, fixed; /* Real variables */
    double value;                            /* legal for the input */
#define MEMBER(name) fmi2##name##TYPE *name;
    FUNCTIONS(MEMBER)
#undef MEMBER
} Fmu;

/* What the logger was told last, and how often it was called. */
typedef struct {
    int calls, status;
    char category[64], text[1200];
    void (*back)(void *); /* called from the logger, with `argument` */
    void *argument;
} Log;

/* Ends the process with a sentence: a case that fails is a process that fails. */
#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

void load(Fmu *fmu);
void unload(Fmu *fmu);

/* An instance that tells `log`; both may be NULL. */
fmi2Component instantiate(const Fmu *fmu, Log *log);
/* From instantiated to the first communication point. */
void start(const Fmu *fmu, fmi2Component c);
/* Steps `first` to `last` - 1 of 1/512 s. */
void run(const Fmu *fmu, fmi2Component c, int first, int last);
double get(const Fmu *fmu, fmi2Component c, fmi2ValueReference reference);
fmi2Status set(const Fmu *fmu, fmi2Component c, fmi2ValueReference reference, double value);
/* The instance's state as bytes, to be freed by the caller. */
fmi2Byte *bytes_of(const Fmu *fmu, fmi2Component c, size_t *size);

#define STEP (1.0 / 512)

#endif
