/* Replays measurements through the observer: samples from standard input, estimates to standard output.
 *
 * A line in:  time, engine torque, engine speed, clutch speeds 1 2, wheel speed, positions 1 2, grade (SI)
 * A line out: clutch torques 1 2, drive-shaft torque, frictions 1 2, engaged 1 2, valid
 * The first line is the instant of the start. Gears 1 and 2 are in.
 *
 *     replay NOMINAL_FRICTION_1 NOMINAL_FRICTION_2 WHEEL_INERTIA EFFECTIVE_RADIUS_2 < in > out
 */
#include "dct_observer.h"
#include <stdio.h>
#include <stdlib.h>

/* All memory that the observer ever uses. */
static dct_observer observer;

static int next(dct_sample *s, double *time)
{
    return scanf("%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", time, &s->engine_torque,
                 &s->engine_speed, &s->clutch_speed[0], &s->clutch_speed[1], &s->wheel_speed,
                 &s->position[0], &s->position[1], &s->road_grade) == 9;
}

static void show(const dct_estimate *e)
{
    printf("%.17g,%.17g,%.17g,%.17g,%.17g,%d,%d,%d\n", e->clutch_torque[0], e->clutch_torque[1],
           e->drive_shaft_torque, e->friction[0], e->friction[1], (int)e->engaged[0],
           (int)e->engaged[1], (int)e->valid);
}

/* A difference of times without its rounding: equal steps are equal to the bit, as in the FMU. */
static double picoseconds(double step) {
    return (double)(int64_t)(step * 1e12 + 0.5) / 1e12;
}

int main(int count, char **words)
{
    dct_vehicle vehicle;
    dct_settings settings;
    dct_sample sample = {.gear = {1, 2}};
    dct_estimate estimate;
    double time, last;

    if (count != 5) {
        fprintf(stderr, "replay: give two frictions, a wheel inertia and a radius\n");
        return 2;
    }
    dct_table_1(&vehicle, &settings);
    settings.nominal_friction[0] = atof(words[1]);
    settings.nominal_friction[1] = atof(words[2]);
    vehicle.wheel_inertia = atof(words[3]);
    vehicle.clutch[1].effective_radius = atof(words[4]);
    if (!next(&sample, &last)) {
        fprintf(stderr, "replay: no sample\n");
        return 2;
    }
    int32_t said = dct_observer_start(&observer, &vehicle, &settings, &sample, &estimate);
    while (said == DCT_OK) {
        show(&estimate);
        if (!next(&sample, &time)) {
            return 0;
        }
        said = dct_observer_step(&observer, &sample, picoseconds(time - last), &estimate);
        last = time;
    }
    fprintf(stderr, "replay: the observer says %d\n", (int)said);
    return 1;
}
