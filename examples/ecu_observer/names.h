/* The FMU's names of what dct_observer.h calls fields: parameters, measurements, estimates. */
#ifndef NAMES_H
#define NAMES_H

#include "dct_observer.h"
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static dct_vehicle vehicle;
static dct_settings settings;
static dct_sample sample;
static dct_estimate estimate;

/* A number under its name: a double or an int32_t. */
typedef struct {
    const char *name;
    double *real;
    int32_t *integer;
} named;

#define REAL(name, field) {name, &(field), NULL}
#define INTEGER(name, field) {name, NULL, &(field)}
#define BOTH(suffix, field) REAL("clutch1." suffix, (field)[0]), REAL("clutch2." suffix, (field)[1])

static const named inputs[] = {
    REAL("engine.torque", sample.engine_torque),
    REAL("engine.speed", sample.engine_speed),
    BOTH("speed", sample.clutch_speed),
    REAL("wheel.speed", sample.wheel_speed),
    BOTH("position", sample.position),
    BOTH("pressure", sample.pressure),
    REAL("brake.torque", sample.brake_torque),
    REAL("road.grade", sample.road_grade),
    INTEGER("shaft1.gear", sample.gear[0]),
    INTEGER("shaft2.gear", sample.gear[1]),
};

static const named outputs[] = {
    BOTH("torque", estimate.clutch_torque),
    REAL("driveShaft.torque", estimate.drive_shaft_torque),
    REAL("load.torque", estimate.load_torque),
    BOTH("friction", estimate.friction),
    BOTH("torqueDeviation", estimate.clutch_torque_deviation),
    REAL("driveShaft.torqueDeviation", estimate.drive_shaft_torque_deviation),
    REAL("innovation.consistency", estimate.consistency),
    REAL("status.excitation", estimate.excitation),
    REAL("calibration.torqueScale", estimate.calibration[0]),
    REAL("calibration.torqueBias", estimate.calibration[1]),
    REAL("calibration.inertiaError", estimate.calibration[2]),
    REAL("calibration.wheelSpeedBias", estimate.calibration[3]),
    REAL("calibration.stiffnessError", estimate.calibration[4]),
    REAL("calibration.dampingError", estimate.calibration[5]),
    REAL("calibration.gearboxInertiaError", estimate.calibration[6]),
    REAL("calibration.vehicleInertiaError", estimate.calibration[7]),
    REAL("calibration.torqueScaleDeviation", estimate.calibration_deviation[0]),
    REAL("calibration.torqueBiasDeviation", estimate.calibration_deviation[1]),
    REAL("calibration.inertiaErrorDeviation", estimate.calibration_deviation[2]),
    REAL("calibration.wheelSpeedBiasDeviation", estimate.calibration_deviation[3]),
    REAL("calibration.stiffnessErrorDeviation", estimate.calibration_deviation[4]),
    REAL("calibration.dampingErrorDeviation", estimate.calibration_deviation[5]),
    REAL("calibration.gearboxInertiaErrorDeviation", estimate.calibration_deviation[6]),
    REAL("calibration.vehicleInertiaErrorDeviation", estimate.calibration_deviation[7]),
    REAL("calibration.vehicleMass", estimate.vehicle_mass[0]),
    REAL("calibration.vehicleMassDeviation", estimate.vehicle_mass[1]),
    REAL("clutch1.frictionMap[1]", estimate.friction_map[0][0]),
    REAL("clutch1.frictionMap[2]", estimate.friction_map[0][1]),
    REAL("clutch1.frictionMap[3]", estimate.friction_map[0][2]),
    REAL("clutch1.frictionMap[4]", estimate.friction_map[0][3]),
    REAL("clutch1.frictionMap[5]", estimate.friction_map[0][4]),
    REAL("clutch2.frictionMap[1]", estimate.friction_map[1][0]),
    REAL("clutch2.frictionMap[2]", estimate.friction_map[1][1]),
    REAL("clutch2.frictionMap[3]", estimate.friction_map[1][2]),
    REAL("clutch2.frictionMap[4]", estimate.friction_map[1][3]),
    REAL("clutch2.frictionMap[5]", estimate.friction_map[1][4]),
    REAL("clutch1.frictionMapDeviation[1]", estimate.friction_map_deviation[0][0]),
    REAL("clutch1.frictionMapDeviation[2]", estimate.friction_map_deviation[0][1]),
    REAL("clutch1.frictionMapDeviation[3]", estimate.friction_map_deviation[0][2]),
    REAL("clutch1.frictionMapDeviation[4]", estimate.friction_map_deviation[0][3]),
    REAL("clutch1.frictionMapDeviation[5]", estimate.friction_map_deviation[0][4]),
    REAL("clutch2.frictionMapDeviation[1]", estimate.friction_map_deviation[1][0]),
    REAL("clutch2.frictionMapDeviation[2]", estimate.friction_map_deviation[1][1]),
    REAL("clutch2.frictionMapDeviation[3]", estimate.friction_map_deviation[1][2]),
    REAL("clutch2.frictionMapDeviation[4]", estimate.friction_map_deviation[1][3]),
    REAL("clutch2.frictionMapDeviation[5]", estimate.friction_map_deviation[1][4]),
    INTEGER("clutch1.engaged", estimate.engaged[0]),
    INTEGER("clutch2.engaged", estimate.engaged[1]),
    INTEGER("status.phase", estimate.phase),
    INTEGER("status.valid", estimate.valid),
};

static const named parameters[] = {
    INTEGER("observer.method", settings.method),
    INTEGER("load.method", settings.load_method),
    INTEGER("adaptation.enabled", settings.adaptation),
    BOTH("nominalFriction", settings.nominal_friction),
    REAL("engine.encoderTicks", settings.encoder_ticks[0]),
    REAL("clutch1.encoderTicks", settings.encoder_ticks[1]),
    REAL("clutch2.encoderTicks", settings.encoder_ticks[2]),
    REAL("wheel.encoderTicks", settings.encoder_ticks[3]),
    REAL("calibration.torqueScaleStart", settings.calibration[0]),
    REAL("calibration.torqueBiasStart", settings.calibration[1]),
    REAL("calibration.inertiaErrorStart", settings.calibration[2]),
    REAL("calibration.wheelSpeedBiasStart", settings.calibration[3]),
    REAL("calibration.stiffnessErrorStart", settings.calibration[4]),
    REAL("calibration.dampingErrorStart", settings.calibration[5]),
    REAL("calibration.gearboxInertiaErrorStart", settings.calibration[6]),
    REAL("calibration.vehicleInertiaErrorStart", settings.calibration[7]),
    REAL("calibration.torqueScaleSigma", settings.calibration_deviation[0]),
    REAL("calibration.torqueBiasSigma", settings.calibration_deviation[1]),
    REAL("calibration.inertiaErrorSigma", settings.calibration_deviation[2]),
    REAL("calibration.wheelSpeedBiasSigma", settings.calibration_deviation[3]),
    REAL("calibration.stiffnessErrorSigma", settings.calibration_deviation[4]),
    REAL("calibration.dampingErrorSigma", settings.calibration_deviation[5]),
    REAL("calibration.gearboxInertiaErrorSigma", settings.calibration_deviation[6]),
    REAL("calibration.vehicleInertiaErrorSigma", settings.calibration_deviation[7]),
    REAL("engine.inertia", vehicle.engine_inertia),
    REAL("damper.inertia", vehicle.damper_inertia),
    BOTH("inertia", vehicle.clutch_inertia),
    REAL("output.inertia", vehicle.output_inertia),
    REAL("vehicle.wheelInertia", vehicle.wheel_inertia),
    REAL("driveShaft.stiffness", vehicle.drive_shaft_stiffness),
    REAL("driveShaft.damping", vehicle.drive_shaft_damping),
    REAL("damper.stiffness", vehicle.damper_stiffness),
    REAL("damper.damping", vehicle.damper_damping),
    REAL("shaft1.finalDriveRatio", vehicle.final_drive_ratio[0]),
    REAL("shaft2.finalDriveRatio", vehicle.final_drive_ratio[1]),
    REAL("shaft1.reverseRatio", vehicle.reverse_ratio[0]),
    REAL("shaft2.reverseRatio", vehicle.reverse_ratio[1]),
    REAL("shaft1.reverseInertia", vehicle.reverse_inertia[0]),
    REAL("shaft2.reverseInertia", vehicle.reverse_inertia[1]),
    REAL("vehicle.mass", vehicle.mass),
    REAL("wheel.radius", vehicle.wheel_radius),
    REAL("air.density", vehicle.air_density),
    REAL("vehicle.frontalArea", vehicle.frontal_area),
    REAL("vehicle.dragCoefficient", vehicle.drag_coefficient),
    REAL("vehicle.rollingResistance", vehicle.rolling_resistance),
    REAL("vehicle.rollingResistanceSpeed", vehicle.rolling_resistance_speed),
    REAL("clutch1.effectiveRadius", vehicle.clutch[0].effective_radius),
    REAL("clutch2.effectiveRadius", vehicle.clutch[1].effective_radius),
    REAL("clutch1.pistonArea", vehicle.clutch[0].piston_area),
    REAL("clutch2.pistonArea", vehicle.clutch[1].piston_area),
    REAL("clutch1.returnForce", vehicle.clutch[0].return_force),
    REAL("clutch2.returnForce", vehicle.clutch[1].return_force),
};

/* Arrays: the number in brackets counts from 1. */
static const struct {
    const char *name;
    double *first;
    int count;
} arrays[] = {
    {"shaft1.gearRatio", vehicle.gear_ratio[0], DCT_GEARS_PER_SHAFT},
    {"shaft2.gearRatio", vehicle.gear_ratio[1], DCT_GEARS_PER_SHAFT},
    {"shaft1.gearInertia", vehicle.gear_inertia[0], DCT_GEARS_PER_SHAFT},
    {"shaft2.gearInertia", vehicle.gear_inertia[1], DCT_GEARS_PER_SHAFT},
    {"clutch1.frictionMapSigma", settings.friction_deviation[0], DCT_FRICTION_POINTS},
    {"clutch2.frictionMapSigma", settings.friction_deviation[1], DCT_FRICTION_POINTS},
    {"clutch1.map.position", vehicle.clutch[0].map_position, DCT_MAP_POINTS},
    {"clutch2.map.position", vehicle.clutch[1].map_position, DCT_MAP_POINTS},
    {"clutch1.map.force", vehicle.clutch[0].map_force, DCT_MAP_POINTS},
    {"clutch2.map.force", vehicle.clutch[1].map_force, DCT_MAP_POINTS},
};

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* Writes a number where `name` says; 0: there is no such name. */
static int put(const named *table, size_t count, const char *name, double value)
{
    for (size_t k = 0; k < count; k++) {
        if (strcmp(table[k].name, name) != 0)
            continue;
        if (table[k].real)
            *table[k].real = value;
        else
            *table[k].integer = (int32_t)value;
        return 1;
    }
    return 0;
}

/* The same of a parameter, also `name[index]`. */
static int put_parameter(const char *name, double value)
{
    const char *bracket = strchr(name, '[');
    if (!bracket)
        return put(parameters, COUNT(parameters), name, value);
    size_t length = (size_t)(bracket - name);
    int index = 0;
    if (sscanf(bracket, "[%d]", &index) != 1)
        return 0;
    for (size_t k = 0; k < COUNT(arrays); k++) {
        int found = strlen(arrays[k].name) == length && memcmp(arrays[k].name, name, length) == 0;
        if (found && index >= 1 && index <= arrays[k].count) {
            arrays[k].first[index - 1] = value;
            return 1;
        }
    }
    return 0;
}

#endif
