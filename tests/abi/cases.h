/* A case is a function; main.c lists them by name. */
#ifndef ABI_CASES_H
#define ABI_CASES_H

#include "fmu.h"

typedef void Case(Fmu *fmu, const char *argument);

/* life.c */
Case every_function, without_logger, cycles, cycles_beside, loads, threads, small_stack, untouched;
Case save, resume;
/* misuse.c */
Case freed, foreign, called_back, shared, extremes, too_long, corrupted, importers, panics, messages,
    overrun;
/* wander.c */
Case wanders, states_travel, states_shared, called_elsewhere;

#endif
