/* A hand-written FMI 2.0 shell in C, as most tools write theirs: each call is checked against the
 * life cycle, each value reference against the model, each step against the model's time. */
#include "fmi2Functions.h"
#include "model.h"

#include <math.h>
#include <stdlib.h>

typedef enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 } State;

typedef struct {
    State state;
    double time;
    double stop;
    const fmi2CallbackFunctions *callbacks;
    Model model;
} Instance;

static fmi2Status refuse(Instance *instance, const char *text) {
    if (instance && instance->callbacks && instance->callbacks->logger)
        instance->callbacks->logger(instance->callbacks->componentEnvironment, "peer", fmi2Error,
                                    "logStatusError", "%s", text);
    return fmi2Error;
}

/* The instance, if its life cycle allows the call. */
static Instance *enter(fmi2Component c, int legal) {
    Instance *instance = c;
    return instance && (instance->state & legal) ? instance : NULL;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)resources, (void)visible, (void)logging;
    if (!name || !guid || type != fmi2CoSimulation)
        return NULL;
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance)
        return NULL;
    instance->state = INSTANTIATED;
    instance->stop = INFINITY;
    instance->callbacks = callbacks;
    return instance;
}

void fmi2FreeInstance(fmi2Component c) {
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    (void)tolerance_defined, (void)tolerance;
    Instance *instance = enter(c, INSTANTIATED);
    if (!instance)
        return refuse(c, "fmi2SetupExperiment: illegal call");
    instance->time = start;
    if (stop_defined)
        instance->stop = stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *instance = enter(c, INSTANTIATED);
    if (!instance)
        return refuse(c, "fmi2EnterInitializationMode: illegal call");
    instance->state = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *instance = enter(c, INITIALIZATION);
    if (!instance)
        return refuse(c, "fmi2ExitInitializationMode: illegal call");
    model_start(&instance->model);
    instance->state = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[]) {
    Instance *instance = enter(c, INSTANTIATED | INITIALIZATION | STEPPING);
    if (!instance || (n && (!vr || !value)))
        return refuse(c, "fmi2SetReal: illegal call");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= INPUTS || !isfinite(value[i]))
            return refuse(c, "fmi2SetReal: illegal reference or value");
        instance->model.u[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    Instance *instance = enter(c, INSTANTIATED | INITIALIZATION | STEPPING);
    if (!instance || (n && (!vr || !order || !value)))
        return refuse(c, "fmi2SetRealInputDerivatives: illegal call");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= INPUTS || order[i] != 1 || !isfinite(value[i]))
            return refuse(c, "fmi2SetRealInputDerivatives: illegal reference, order or value");
        instance->model.u_rate[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *instance = enter(c, INITIALIZATION | STEPPING | TERMINATED);
    if (!instance || (n && (!vr || !value)))
        return refuse(c, "fmi2GetReal: illegal call");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < INPUTS)
            value[i] = instance->model.u[vr[i]];
        else if (vr[i] < INPUTS + OUTPUTS)
            value[i] = instance->model.y[vr[i] - INPUTS];
        else
            return refuse(c, "fmi2GetReal: unknown reference");
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set_state) {
    (void)no_set_state;
    Instance *instance = enter(c, STEPPING);
    if (!instance)
        return refuse(c, "fmi2DoStep: illegal call");
    double tolerance = 1e-9 * fmax(1.0, fabs(instance->time));
    if (!(h > 0.0) || !isfinite(h) || !(fabs(time - instance->time) <= tolerance))
        return refuse(c, "fmi2DoStep: the step does not start at the time of the model");
    if (time + h > instance->stop + tolerance)
        return refuse(c, "fmi2DoStep: the step leads past the stop time");
    model_step(&instance->model, h);
    instance->time = time + h;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *instance = enter(c, STEPPING);
    if (!instance)
        return refuse(c, "fmi2Terminate: illegal call");
    instance->state = TERMINATED;
    return fmi2OK;
}
