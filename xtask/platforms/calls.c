/* Makes the calls that `cargo fmu replay --calls` wrote, on this machine, and compares every value it reads:
 * calls FILE LIBRARY..., the libraries in the order of the FMUs. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define LOAD(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define LOAD(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#endif

#define PARTS 8

typedef struct {
    void *(*make)(const char *, int, const char *, const char *, const void *, int, int);
    int (*setup)(void *, int, double, double, int, double);
    int (*init)(void *), (*start)(void *), (*end)(void *);
    int (*step)(void *, double, double, int);
    int (*set_real)(void *, const unsigned *, size_t, const double *);
    int (*set_integer)(void *, const unsigned *, size_t, const int *);
    int (*set_boolean)(void *, const unsigned *, size_t, const int *);
    int (*get_real)(void *, const unsigned *, size_t, double *);
    int (*get_integer)(void *, const unsigned *, size_t, int *);
    int (*get_boolean)(void *, const unsigned *, size_t, int *);
    void *component;
} Part;

static Part parts[PARTS];
static unsigned long line, compared;

static void fail(const char *what)
{
    fprintf(stderr, "line %lu: %s\n", line, what);
    exit(1);
}

static void check(int status)
{
    if (status > 1) fail("the FMU refuses the call");
}

static void function(void *library, const char *name, void **place)
{
    if (!(*place = FIND(library, name))) fail(name);
}

static void load(Part *part, const char *path)
{
    void *library = LOAD(path);
    if (!library) fail(path);
    function(library, "fmi2Instantiate", (void **)&part->make);
    function(library, "fmi2SetupExperiment", (void **)&part->setup);
    function(library, "fmi2EnterInitializationMode", (void **)&part->init);
    function(library, "fmi2ExitInitializationMode", (void **)&part->start);
    function(library, "fmi2Terminate", (void **)&part->end);
    function(library, "fmi2DoStep", (void **)&part->step);
    function(library, "fmi2SetReal", (void **)&part->set_real);
    function(library, "fmi2SetInteger", (void **)&part->set_integer);
    function(library, "fmi2SetBoolean", (void **)&part->set_boolean);
    function(library, "fmi2GetReal", (void **)&part->get_real);
    function(library, "fmi2GetInteger", (void **)&part->get_integer);
    function(library, "fmi2GetBoolean", (void **)&part->get_boolean);
}

static double number(const char *word)
{
    uint64_t bits = strtoull(word, NULL, 16);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void set(Part *part, char kind, unsigned reference, double value)
{
    int whole = (int)value;
    if (kind == 'r') check(part->set_real(part->component, &reference, 1, &value));
    if (kind == 'i') check(part->set_integer(part->component, &reference, 1, &whole));
    if (kind == 'b') check(part->set_boolean(part->component, &reference, 1, &whole));
}

static void get(Part *part, char kind, unsigned reference, double expected)
{
    double value = 0;
    int whole = 0;
    if (kind == 'r') check(part->get_real(part->component, &reference, 1, &value));
    if (kind == 'i') check(part->get_integer(part->component, &reference, 1, &whole));
    if (kind == 'b') check(part->get_boolean(part->component, &reference, 1, &whole));
    if (kind != 'r') value = whole;
    if (memcmp(&value, &expected, sizeof value)) {
        fprintf(stderr, "line %lu: value reference %u is %a, not %a\n", line, reference, value, expected);
        exit(1);
    }
    compared++;
}

static void call(Part *part, char words[6][48])
{
    static const void *callbacks[5]; /* no logger, no memory: the FMU needs neither */
    const char *verb = words[0];
    if (!strcmp(verb, "set")) set(part, words[2][0], (unsigned)atoi(words[3]), number(words[4]));
    else if (!strcmp(verb, "get")) get(part, words[2][0], (unsigned)atoi(words[3]), number(words[4]));
    else if (!strcmp(verb, "step")) check(part->step(part->component, number(words[2]), number(words[3]), 1));
    else if (!strcmp(verb, "start")) check(part->start(part->component));
    else if (!strcmp(verb, "end")) check(part->end(part->component));
    else if (!strcmp(verb, "init")) {
        check(part->setup(part->component, 0, 0, number(words[2]), 0, 0));
        check(part->init(part->component));
    } else if (!strcmp(verb, "new")) {
        part->component = part->make("one", 1, words[2], "", callbacks, 0, 0);
        if (!part->component) fail("no instance");
    } else fail(verb);
}

int main(int count, char **paths)
{
    char text[256], words[6][48];
    FILE *file = count > 2 && count < PARTS + 2 ? fopen(paths[1], "r") : NULL;
    if (!file) fail("usage: calls FILE LIBRARY...");
    for (int at = 0; at < count - 2; at++) load(&parts[at], paths[at + 2]);
    while (fgets(text, sizeof text, file)) {
        line++;
        int found = sscanf(text, "%47s %47s %47s %47s %47s", words[0], words[1], words[2], words[3], words[4]);
        int at = found > 1 ? atoi(words[1]) : PARTS;
        if (at >= count - 2) fail("no such part");
        call(&parts[at], words);
    }
    printf("%lu values compared\n", compared);
    return compared ? 0 : 1;
}
