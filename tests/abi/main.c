/* A C importer with one case per process: abi LIBRARY GUID INPUT OUTPUT FIXED VALUE CASE [ARGUMENT] */
#include "cases.h"
#include <string.h>

static const struct {
    const char *name;
    Case *run;
} CASES[] = {
    {"every_function", every_function}, {"without_logger", without_logger},
    {"cycles", cycles},                 {"loads", loads},
    {"cycles_beside", cycles_beside},
    {"threads", threads},               {"small_stack", small_stack},
    {"untouched", untouched},           {"save", save},
    {"resume", resume},                 {"freed", freed},
    {"foreign", foreign},               {"called_back", called_back},
    {"shared", shared},                 {"extremes", extremes},
    {"too_long", too_long},             {"corrupted", corrupted},
    {"importers", importers},           {"panics", panics},
    {"messages", messages},             {"overrun", overrun},
    {"wanders", wanders},               {"states_travel", states_travel},
    {"states_shared", states_shared},   {"called_elsewhere", called_elsewhere},
};

static fmi2ValueReference reference(const char *text)
{
    return (fmi2ValueReference)strtoul(text, NULL, 10);
}

int main(int count, char **words)
{
    CHECK(count >= 8);
    Fmu fmu = {.path = words[1], .guid = words[2], .input = reference(words[3]),
               .output = reference(words[4]), .fixed = reference(words[5]),
               .value = strtod(words[6], NULL)};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        if (strcmp(CASES[i].name, words[7]) == 0) {
            load(&fmu);
            CASES[i].run(&fmu, count > 8 ? words[8] : "");
            unload(&fmu);
            return 0;
        }
    }
    fprintf(stderr, "no case %s\n", words[7]);
    return 2;
}
