/* Counts heap calls of 4,000 steps of an FMU: path, GUID, references of engine torque, of a clutch's
 * position and of what is shown, then pairs "reference value" of Real parameters. Linked with benches/driver/heap.c, which counts. */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "heap.h"

#define CHECK(ok) do { if (!(ok)) { printf("failed: %s\n", #ok); exit(1); } } while (0)

enum { STEPS = 4000 };
static const double H = 1e-3; /* s */

static void silent(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

int main(int count, char **words) {
    static const fmi2CallbackFunctions callbacks = {silent, calloc, free, NULL, NULL};
    void *library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    CHECK(library && count > 5);
    fmi2InstantiateTYPE *make = (fmi2InstantiateTYPE *)dlsym(library, "fmi2Instantiate");
    fmi2SetRealTYPE *set = (fmi2SetRealTYPE *)dlsym(library, "fmi2SetReal");
    fmi2GetRealTYPE *get = (fmi2GetRealTYPE *)dlsym(library, "fmi2GetReal");
    fmi2DoStepTYPE *step = (fmi2DoStepTYPE *)dlsym(library, "fmi2DoStep");
    fmi2SetupExperimentTYPE *setup = (fmi2SetupExperimentTYPE *)dlsym(library, "fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter =
        (fmi2EnterInitializationModeTYPE *)dlsym(library, "fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave =
        (fmi2ExitInitializationModeTYPE *)dlsym(library, "fmi2ExitInitializationMode");
    long unborn = heap.calls;
    fmi2Component c = make("one", fmi2CoSimulation, words[2], "", &callbacks, fmi2False, fmi2False);
    CHECK(c && heap.calls > unborn); /* the library does ask this heap */
    fmi2ValueReference torque = (fmi2ValueReference)atoi(words[3]);
    fmi2ValueReference position = (fmi2ValueReference)atoi(words[4]);
    fmi2ValueReference shown = (fmi2ValueReference)atoi(words[5]);
    for (int k = 6; k + 1 < count; k += 2) {
        fmi2ValueReference reference = (fmi2ValueReference)atoi(words[k]);
        double value = strtod(words[k + 1], NULL);
        CHECK(set(c, &reference, 1, &value) == fmi2OK);
    }
    CHECK(setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    CHECK(enter(c) == fmi2OK && leave(c) == fmi2OK);
    double value = 0.0;
    long before = heap.calls;
    for (int k = 0; k < STEPS; k++) { /* slips, locks, is driven, opens and closes again */
        double t_e = k % 1000 < 500 ? 80.0 : -40.0, theta = k % 2000 < 1800 ? 5.5e-3 : 0.0;
        CHECK(set(c, &torque, 1, &t_e) == fmi2OK && set(c, &position, 1, &theta) == fmi2OK);
        CHECK(step(c, k * H, H, fmi2True) == fmi2OK && get(c, &shown, 1, &value) == fmi2OK);
    }
    long calls = heap.calls - before;
    printf("%ld %.17g\n", calls, value);
    return 0;
}
