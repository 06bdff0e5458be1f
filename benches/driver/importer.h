/* A small FMI 2.0 importer: one FMU library, its instances, its exchanges. */
#ifndef IMPORTER_H
#define IMPORTER_H

#include "fmi2Functions.h"

enum { PORTS = 5, STARTS = 4 };

/* A library and the references the bench needs: PORTS inputs, PORTS outputs, STARTS parameters, and
 * Boolean parameters that are set to true. */
typedef struct {
    const char *path, *guid;
    fmi2ValueReference set[PORTS], get[PORTS], start[STARTS];
    double start_value[STARTS];
    int starts;
    fmi2ValueReference flag[STARTS];
    int flags;
    fmi2InstantiateTYPE *instantiate;
    fmi2FreeInstanceTYPE *free_instance;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2SetRealTYPE *set_real;
    fmi2SetBooleanTYPE *set_boolean; /* where there are flags */
    fmi2GetRealTYPE *get_real;
    fmi2DoStepTYPE *do_step;
} Library;

/* Inputs of a run: PORTS values for each of `steps` steps of `h` seconds. */
typedef struct {
    double h;
    int steps;
    double *u;
} Inputs;

/* `path;guid;set references;get references;parameter=value,...;flag,...` */
Library library_open(char *words);
Inputs inputs_read(const char *path, double h);

/* An instance after initialisation. */
fmi2Component library_start(const Library *l);

/* All steps of a run, or one; `y` receives the outputs, shape PORTS. */
void run_exchanges(const Library *l, fmi2Component c, const Inputs *in, double *y);
void run_exchange(const Library *l, fmi2Component c, const Inputs *in, int step, double *y);

/* Ends the program with a sentence. */
void fail(const char *what, const char *which);

#endif
