/* Replays measurements through the observer: CSV from standard input, estimates as CSV to standard output.
 *
 * The first line in names the columns: `time`, then measurements under the FMU's names, SI; what is not among them
 * stays 0, gears 1 and 2. Parameters come as words, numbers under the FMU's names:
 *
 *     replay observer.method=5 clutch1.nominalFriction=0.4 'shaft1.gearRatio[1]=3.0' < measured.csv > estimated.csv
 *
 * The first row is the instant of the start. `--next FILE` writes the parameters that the next drive starts with, one
 * a line, after what DCT_CALIBRATING has learnt.
 */
#include "names.h"
#include <stdlib.h>

#define COLUMNS 32
#define LINE 4096

/* All memory that the observer ever uses. */
static dct_observer observer;

static char line[LINE];
static char *columns[COLUMNS];
static char header[LINE];
static int count;

/* Reads the names of the columns; 0: there are none, or too many. */
static int read_header(void)
{
    if (!fgets(header, LINE, stdin))
        return 0;
    for (char *name = strtok(header, ",\r\n"); name; name = strtok(NULL, ",\r\n")) {
        if (count == COLUMNS)
            return 0;
        columns[count++] = name;
    }
    return count > 1 && strcmp(columns[0], "time") == 0;
}

/* Reads a row into `sample`: 1, at the end of the input 0, where it makes no sense -1. */
static int next(double *time)
{
    if (!fgets(line, LINE, stdin))
        return 0;
    char *cell = line;
    for (int k = 0; k < count; k++) {
        char *end;
        double value = strtod(cell, &end);
        int separated = *end == (k + 1 < count ? ',' : '\n') || *end == '\r';
        if (end == cell || !separated)
            return -1;
        cell = end + 1;
        if (k == 0)
            *time = value;
        else if (!put(inputs, COUNT(inputs), columns[k], value))
            return -1;
    }
    return 1;
}

static void show_names(void)
{
    for (size_t k = 0; k < COUNT(outputs); k++)
        printf("%s%s", k ? "," : "", outputs[k].name);
    putchar('\n');
}

static void show(void)
{
    for (size_t k = 0; k < COUNT(outputs); k++) {
        if (k)
            putchar(',');
        if (outputs[k].real)
            printf("%.17g", *outputs[k].real);
        else
            printf("%d", (int)*outputs[k].integer);
    }
    putchar('\n');
}

/* A difference of times without its rounding: equal steps are equal to the bit, as in the FMU. */
static double picoseconds(double step)
{
    return (double)(int64_t)(step * 1e12 + 0.5) / 1e12;
}

/* Takes `name=value`; 0: there is no such parameter. */
static int take(char *word)
{
    char *equals = strchr(word, '=');
    if (!equals)
        return 0;
    *equals = '\0';
    return put_parameter(word, atof(equals + 1));
}

static int replay(void)
{
    double time = 0.0, last = 0.0;
    int row = next(&last);
    int32_t said = DCT_OK;
    show_names();
    if (row == 1)
        said = dct_observer_start(&observer, &vehicle, &settings, &sample, &estimate);
    while (row == 1 && said == DCT_OK) {
        show();
        row = next(&time);
        if (row == 1)
            said = dct_observer_step(&observer, &sample, picoseconds(time - last), &estimate);
        last = time;
    }
    if (said != DCT_OK)
        fprintf(stderr, "replay: t = %g s: the observer says %d\n", last, (int)said);
    if (row < 0)
        fprintf(stderr, "replay: after t = %g s: a row that does not fit the names\n", last);
    return said != DCT_OK || row < 0;
}

/* Writes all parameters with what was learnt; 0: that failed. */
static int write_next(const char *path)
{
    int32_t said = dct_take_over(&vehicle, &settings, &estimate);
    FILE *file = said == DCT_OK ? fopen(path, "w") : NULL;
    if (!file) {
        fprintf(stderr, "replay: --next %s: cannot be written, or nothing was learnt\n", path);
        return 0;
    }
    for (size_t k = 0; k < COUNT(parameters); k++) {
        const named *row = &parameters[k];
        fprintf(file, "%s=%.17g\n", row->name, row->real ? *row->real : (double)*row->integer);
    }
    for (size_t k = 0; k < COUNT(arrays); k++)
        for (int i = 0; i < arrays[k].count; i++)
            fprintf(file, "%s[%d]=%.17g\n", arrays[k].name, i + 1, arrays[k].first[i]);
    return fclose(file) == 0;
}

int main(int words, char **word)
{
    const char *next_start = NULL;
    dct_table_1(&vehicle, &settings);
    sample.gear[0] = 1;
    sample.gear[1] = 2;
    for (int k = 1; k < words; k++) {
        if (strcmp(word[k], "--next") == 0 && k + 1 < words) {
            next_start = word[++k];
        } else if (!take(word[k])) {
            fprintf(stderr, "replay: no parameter '%s'\n", word[k]);
            return 2;
        }
    }
    if (!read_header()) {
        fprintf(stderr, "replay: the first line has to name the columns, `time` first\n");
        return 2;
    }
    int failed = replay();
    if (!failed && next_start)
        failed = !write_next(next_start);
    return failed;
}
