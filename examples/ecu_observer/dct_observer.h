/* Torque observer of a dual-clutch driveline for a control unit: both clutch torques and the
 * drive-shaft torque from the signals of a production car, by one of five methods.
 *
 * No heap, no global state, no operating system: the state lives in a struct of yours, so there can
 * be any number of observers. Units are SI; arrays of two hold clutch 1 (odd gears), then clutch 2.
 * A positive torque accelerates the vehicle forward.
 */
#ifndef DCT_OBSERVER_H
#define DCT_OBSERVER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DCT_GEARS_PER_SHAFT 4
#define DCT_MAP_POINTS 10
#define DCT_PARAMETERS 8 /* that the method `calibrating` learns */
#define DCT_FRICTION_POINTS 5 /* of a friction over the position, evenly from the touch point to the end of the map */
#define DCT_OBSERVER_DOUBLES 702 /* room of dct_observer; the library does not compile if it is short */

/* What a call says. */
enum {
    DCT_OK = 0,
    DCT_NULL = 1,    /* a pointer is null: nothing was done */
    DCT_VEHICLE = 2, /* a value of the vehicle or the settings makes no sense: nothing was done */
    DCT_SAMPLE = 3,  /* a sample or a step that is no number or out of range: the state stays as it was */
    DCT_METHOD = 4   /* the library was built without this method, or it does not learn: nothing was done */
};

/* Method of estimation. */
enum {
    DCT_PAPER = 1,      /* the paper's, as printed */
    DCT_LYAPUNOV = 2,   /* the paper's with gains that carry its proof */
    DCT_ENERGY = 3,     /* physical energy as Lyapunov function */
    DCT_KALMAN = 4,     /* Kalman filter; needs no load method */
    DCT_CALIBRATING = 5 /* Kalman filter that learns errors of its parameters and sensors */
};

/* What the clutches do. */
enum { DCT_OPEN = 1, DCT_SLIPPING = 2, DCT_ENGAGED = 3, DCT_HANDOVER = 4 };

/* Why an estimate cannot be used; 0: it can. */
enum {
    DCT_NOT_FINITE = 1,  /* an input is no number */
    DCT_NO_SPEED = 2,    /* a speed reads 0 though what moves with it turns */
    DCT_FROZEN = 3,      /* a speed does not change though what moves with it does */
    DCT_SATURATED = 4,   /* a friction, or an error that is learnt, is at its physical bound */
    DCT_DIVERGED = 5,    /* the innovation is beyond what a driveline can do */
    DCT_INCONSISTENT = 6 /* the innovation is far beyond what the filter expects */
};

/* One clutch with its actuator. */
typedef struct {
    double effective_radius;              /* r_c N [m] */
    double map_position[DCT_MAP_POINTS];  /* of the actuator [m], ascending */
    double map_force[DCT_MAP_POINTS];     /* normal force [N], not descending */
    double piston_area;                   /* [m2]; 0: moved by a position, else by a pressure */
    double return_force;                  /* of the spring against the piston [N] */
} dct_clutch;

/* The vehicle that the observer believes in. */
typedef struct {
    double engine_inertia;                             /* J_e [kg m2] */
    double damper_inertia;                             /* J_d [kg m2] */
    double clutch_inertia[2];                          /* J_ct1, J_ct2 [kg m2] */
    double output_inertia;                             /* J_o [kg m2] */
    double wheel_inertia;                              /* J_v: the vehicle seen at the wheels [kg m2] */
    double drive_shaft_stiffness;                      /* k_o [N m/rad] */
    double drive_shaft_damping;                        /* c_o [N m s/rad] */
    double damper_stiffness;                           /* k_d [N m/rad] */
    double damper_damping;                             /* c_d [N m s/rad] */
    double gear_ratio[2][DCT_GEARS_PER_SHAFT];         /* i_t: gears 1 3 5 7, then 2 4 6 8; 0: not fitted */
    double reverse_ratio[2];                           /* i_t of reverse; 0: not fitted */
    double gear_inertia[2][DCT_GEARS_PER_SHAFT];       /* that a gear adds to J_ct while it is in [kg m2] */
    double reverse_inertia[2];                         /* the same of reverse [kg m2] */
    double final_drive_ratio[2];                       /* i_f1, i_f2 */
    double mass;                                       /* M_v [kg] */
    double wheel_radius;                               /* r_w [m] */
    double air_density;                                /* [kg/m3] */
    double frontal_area;                               /* [m2] */
    double drag_coefficient;                           /* C_D */
    double rolling_resistance;                         /* C_rr */
    double rolling_resistance_speed;                   /* over which it turns its sign [m/s]; 0: dry friction */
    dct_clutch clutch[2];
} dct_vehicle;

/* How it estimates. */
typedef struct {
    double nominal_friction[2];         /* mu_n, where the adaptation starts */
    double calibration[DCT_PARAMETERS]; /* DCT_CALIBRATING: what an earlier drive learnt, in the order of dct_estimate */
    double calibration_deviation[DCT_PARAMETERS]; /* its standard deviations; 0 trusts the parameter */
    double friction_deviation[2][DCT_FRICTION_POINTS]; /* DCT_CALIBRATING: of nominal_friction over the position */
    double encoder_ticks[4];            /* per revolution that the speeds of engine, input shafts and wheels are counted by
                                         * over a step; 0: is not counted, or recognised */
    int32_t adaptation;                 /* 0: the friction is not adapted */
    int32_t load_method;                /* load torque: 1 grade, 2 engine, 3 momentum */
    int32_t method;                     /* DCT_PAPER to DCT_CALIBRATING */
} dct_settings;

/* What is measured at one instant. */
typedef struct {
    double engine_torque;   /* over the step that ends here [N m] */
    double engine_speed;    /* [rad/s] */
    double clutch_speed[2]; /* of the input shafts [rad/s] */
    double wheel_speed;     /* [rad/s] */
    double position[2];     /* of the actuators over the step [m] */
    double pressure[2];     /* of wet clutches over the step [Pa] */
    double brake_torque;    /* at the wheels [N m], >= 0 */
    double road_grade;      /* [rad] */
    int32_t gear[2];        /* preselected on the odd and the even shaft; 0: neutral, -1: reverse */
} dct_sample;

/* What is estimated for the same instant. */
typedef struct {
    double clutch_torque[2];           /* [N m] */
    double drive_shaft_torque;         /* [N m] */
    double load_torque;                /* [N m] */
    double friction[2];                /* mu learnt while slipping */
    double clutch_torque_deviation[2]; /* standard deviation; of the first three methods the torque that the
                                        * correction injects [N m] */
    double drive_shaft_torque_deviation; /* the same [N m] */
    double consistency;                /* innovation^2 over what a filter expects: 1 is right; 0: expects nothing */
    double excitation;                 /* how well speeds show the friction of slipping clutches, 0 to 1 */
    double calibration[DCT_PARAMETERS]; /* DCT_CALIBRATING: scale - 1 [1] and bias [N m] of the engine torque, error of
                                         * J_e + J_d [1], bias of the wheel speed [rad/s], errors of k_o, c_o, gearbox
                                         * inertia and J_v [1]; 0 of other methods */
    double calibration_deviation[DCT_PARAMETERS]; /* their standard deviations */
    double vehicle_mass[2];            /* DCT_CALIBRATING: mass and its standard deviation [kg] */
    double friction_map[2][DCT_FRICTION_POINTS]; /* DCT_CALIBRATING: friction over the position */
    double friction_map_deviation[2][DCT_FRICTION_POINTS]; /* its standard deviations */
    int32_t engaged[2];                /* 1: the clutch is taken as engaged */
    int32_t phase;                     /* DCT_OPEN to DCT_HANDOVER */
    int32_t valid;                     /* 0: do not use this estimate */
    int32_t fault;                     /* why: DCT_NOT_FINITE to DCT_INCONSISTENT; 0: valid */
} dct_estimate;

/* Room for one observer. */
typedef struct {
    double room[DCT_OBSERVER_DOUBLES];
} dct_observer;

/* Fills in the paper's test bench, Table 1, its friction case 1 and DCT_PAPER: a start to change. */
int32_t dct_table_1(dct_vehicle *vehicle, dct_settings *settings);

/* Starts from measurements. Gears must be fitted, or neutral. Call it before dct_observer_step. */
int32_t dct_observer_start(dct_observer *observer, const dct_vehicle *vehicle,
                           const dct_settings *settings, const dct_sample *sample,
                           dct_estimate *estimate);

/* Advances by `step` [s], > 0 and <= 0.1. A constant step is the fast one. */
int32_t dct_observer_step(dct_observer *observer, const dct_sample *sample, double step,
                          dct_estimate *estimate);

/* Puts what DCT_CALIBRATING has learnt until `estimate` into vehicle and settings, those of that start: keep them in
 * memory that lasts, and start the next drive with them. Force maps take the friction over the position. */
int32_t dct_take_over(dct_vehicle *vehicle, dct_settings *settings, const dct_estimate *estimate);

#ifdef __cplusplus
}
#endif

#endif
