#include "importer.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fail(const char *what, const char *which) {
    fprintf(stderr, "driver: %s: %s\n", which, what);
    exit(1);
}

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String kind,
                   fmi2String text, ...) {
    (void)e, (void)name, (void)status, (void)kind, (void)text;
}

static const fmi2CallbackFunctions CALLBACKS = {logger, calloc, free, NULL, NULL};

static void *symbol(void *library, const char *path, const char *name) {
    void *found = dlsym(library, name);
    if (!found)
        fail(name, path);
    return found;
}

static void references(char *words, fmi2ValueReference *to) {
    for (int k = 0; k < PORTS; k++)
        to[k] = (fmi2ValueReference)strtoul(words, &words, 10), words += *words == ',';
}

static void start_values(Library *l, char *words) {
    for (; words && *words && l->starts < STARTS; l->starts++) {
        l->start[l->starts] = (fmi2ValueReference)strtoul(words, &words, 10);
        l->start_value[l->starts] = strtod(words + 1, &words);
        words += *words == ',';
    }
}

static void flags(Library *l, char *words) {
    for (; words && *words && l->flags < STARTS; words += *words == ',')
        l->flag[l->flags++] = (fmi2ValueReference)strtoul(words, &words, 10);
}

Library library_open(char *words) {
    Library l = {.path = strsep(&words, ";")};
    l.guid = strsep(&words, ";");
    references(strsep(&words, ";"), l.set);
    references(strsep(&words, ";"), l.get);
    start_values(&l, strsep(&words, ";"));
    flags(&l, words);
    void *library = dlopen(l.path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        fail(dlerror(), l.path);
    l.instantiate = symbol(library, l.path, "fmi2Instantiate");
    l.free_instance = symbol(library, l.path, "fmi2FreeInstance");
    l.setup = symbol(library, l.path, "fmi2SetupExperiment");
    l.enter = symbol(library, l.path, "fmi2EnterInitializationMode");
    l.leave = symbol(library, l.path, "fmi2ExitInitializationMode");
    l.set_real = symbol(library, l.path, "fmi2SetReal");
    if (l.flags)
        l.set_boolean = symbol(library, l.path, "fmi2SetBoolean");
    l.get_real = symbol(library, l.path, "fmi2GetReal");
    l.do_step = symbol(library, l.path, "fmi2DoStep");
    return l;
}

Inputs inputs_read(const char *path, double h) {
    FILE *file = fopen(path, "rb");
    if (!file)
        fail("cannot be read", path);
    fseek(file, 0, SEEK_END);
    size_t bytes = (size_t)ftell(file);
    rewind(file);
    Inputs in = {.h = h, .steps = (int)(bytes / (PORTS * sizeof(double))), .u = malloc(bytes)};
    if (!in.u || fread(in.u, 1, bytes, file) != bytes)
        fail("cannot be read", path);
    fclose(file);
    return in;
}

fmi2Component library_start(const Library *l) {
    fmi2Component c =
        l->instantiate("bench", fmi2CoSimulation, l->guid, "", &CALLBACKS, fmi2False, fmi2False);
    if (!c)
        fail("fmi2Instantiate returned NULL", l->path);
    int bad = l->setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) | l->enter(c);
    for (int k = 0; k < l->flags; k++)
        bad |= l->set_boolean(c, l->flag + k, 1, &(fmi2Boolean){fmi2True});
    if (l->starts)
        bad |= l->set_real(c, l->start, (size_t)l->starts, l->start_value);
    if (bad | l->leave(c))
        fail("does not initialise", l->path);
    return c;
}

void run_exchange(const Library *l, fmi2Component c, const Inputs *in, int step, double *y) {
    int bad = l->set_real(c, l->set, PORTS, in->u + PORTS * step);
    bad |= l->do_step(c, step * in->h, in->h, fmi2True);
    if (bad | l->get_real(c, l->get, PORTS, y))
        fail("an exchange failed", l->path);
}

/* Not inlined: callgrind counts what happens inside of it. */
__attribute__((noinline)) void run_exchanges(const Library *l, fmi2Component c, const Inputs *in,
                                             double *y) {
    for (int step = 0; step < in->steps; step++)
        run_exchange(l, c, in, step, y);
}
