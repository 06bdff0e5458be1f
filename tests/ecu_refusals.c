/* Calls of examples/ecu_observer that have to be refused; says which one was not. */
#include "dct_observer.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static dct_observer observer, before;
static dct_vehicle vehicle;
static dct_settings settings;
static dct_sample sample;
static dct_estimate estimate;
static int wrong;

static void expect(int32_t said, int32_t expected, const char *what)
{
    if (said != expected || memcmp(&observer, &before, sizeof observer) != 0) {
        printf("%s: %d instead of %d\n", what, (int)said, (int)expected);
        wrong = 1;
    }
}

static int32_t start(void)
{
    return dct_observer_start(&observer, &vehicle, &settings, &sample, &estimate);
}

static int32_t step(double h)
{
    return dct_observer_step(&observer, &sample, h, &estimate);
}

static void again(void)
{
    dct_table_1(&vehicle, &settings);
    sample = (dct_sample){.engine_speed = 90.0, .gear = {1, 2}};
}

static void starts(void)
{
    expect(dct_table_1(NULL, &settings), DCT_NULL, "no vehicle");
    expect(dct_observer_start(NULL, &vehicle, &settings, &sample, &estimate), DCT_NULL, "no state");
    vehicle.clutch[1].map_position[9] = vehicle.clutch[1].map_position[8];
    expect(start(), DCT_VEHICLE, "a map that stands still");
    again();
    vehicle.engine_inertia = NAN;
    expect(start(), DCT_VEHICLE, "an inertia that is no number");
    again();
    settings.load_method = 4;
    expect(start(), DCT_VEHICLE, "a load method that does not exist");
    again();
    settings.method = 6;
    expect(start(), DCT_VEHICLE, "a method that does not exist");
    again();
    settings.calibration[2] = -0.95;
    expect(start(), DCT_VEHICLE, "an inertia that is a twentieth of what it was");
    again();
    settings.calibration_deviation[7] = -1.0;
    expect(start(), DCT_VEHICLE, "a deviation below 0");
    again();
    settings.encoder_ticks[3] = -48.0;
    expect(start(), DCT_VEHICLE, "an encoder with less than no ticks");
    again();
    vehicle.gear_inertia[1][2] = -1.0;
    expect(start(), DCT_VEHICLE, "an inertia of a gear below 0");
    again();
    vehicle.damper_stiffness = 0.0;
    expect(start(), DCT_VEHICLE, "a damper without stiffness");
    again();
    sample.gear[1] = 3;
    expect(start(), DCT_SAMPLE, "an odd gear on the even shaft");
    again();
}

static void steps(void)
{
    expect(dct_observer_step(&observer, NULL, 1e-3, &estimate), DCT_NULL, "no sample");
    expect(step(0.0), DCT_SAMPLE, "no step");
    expect(step(NAN), DCT_SAMPLE, "a step that is no number");
    expect(step(0.2), DCT_SAMPLE, "a step that is too long");
    sample.wheel_speed = INFINITY;
    expect(step(1e-3), DCT_SAMPLE, "an infinite speed");
}

static void takes_over(void)
{
    const dct_vehicle kept = vehicle;
    expect(dct_take_over(&vehicle, NULL, &estimate), DCT_NULL, "no settings to take over into");
    expect(dct_take_over(&vehicle, &settings, &estimate), DCT_METHOD, "nothing to take over");
    if (memcmp(&kept, &vehicle, sizeof kept) != 0)
        wrong = 1;
}

int main(void)
{
    again();
    starts();
    if (start() != DCT_OK)
        return 1;
    before = observer;
    takes_over();
    steps();
    again();
    if (step(1e-3) != DCT_OK || memcmp(&observer, &before, sizeof observer) == 0)
        return 1;
    if (!wrong)
        puts("as promised");
    return wrong;
}
