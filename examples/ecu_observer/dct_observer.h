/* Torque observer of a dual-clutch driveline for a control unit: both clutch torques and the
 * drive-shaft torque from the signals of a production car.
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
#define DCT_OBSERVER_DOUBLES 512 /* room of dct_observer; the library does not compile if it is short */

/* What a call says. */
enum {
    DCT_OK = 0,
    DCT_NULL = 1,    /* a pointer is null: nothing was done */
    DCT_VEHICLE = 2, /* a value of the vehicle or the settings makes no sense: nothing was done */
    DCT_SAMPLE = 3   /* a sample or a step that is no number or out of range: the state stays as it was */
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
    double gear_ratio[2][DCT_GEARS_PER_SHAFT];         /* i_t: gears 1 3 5 7, then 2 4 6 8; 0: not fitted */
    double final_drive_ratio[2];                       /* i_f1, i_f2 */
    double mass;                                       /* M_v [kg] */
    double wheel_radius;                               /* r_w [m] */
    double air_density;                                /* [kg/m3] */
    double frontal_area;                               /* [m2] */
    double drag_coefficient;                           /* C_D */
    double rolling_resistance;                         /* C_rr */
    dct_clutch clutch[2];
} dct_vehicle;

/* How it estimates. */
typedef struct {
    double nominal_friction[2]; /* mu_n, where the adaptation starts */
    int32_t adaptation;         /* 0: the friction is not adapted */
    int32_t load_method;        /* load torque: 1 grade, 2 engine, 3 momentum */
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
    int32_t gear[2];        /* preselected on the odd and the even shaft; 0: neutral */
} dct_sample;

/* What is estimated for the same instant. */
typedef struct {
    double clutch_torque[2];      /* [N m] */
    double drive_shaft_torque;    /* [N m] */
    double load_torque;           /* [N m] */
    double friction[2];           /* mu learnt while slipping */
    int32_t engaged[2];           /* 1: the clutch is taken as engaged */
    int32_t valid;                /* 0: do not use this estimate */
} dct_estimate;

/* Room for one observer. */
typedef struct {
    double room[DCT_OBSERVER_DOUBLES];
} dct_observer;

/* Fills in the paper's test bench, Table 1, and its friction case 1: a start to change. */
int32_t dct_table_1(dct_vehicle *vehicle, dct_settings *settings);

/* Starts from measurements. Both shafts need a gear. Call it before dct_observer_step. */
int32_t dct_observer_start(dct_observer *observer, const dct_vehicle *vehicle,
                           const dct_settings *settings, const dct_sample *sample,
                           dct_estimate *estimate);

/* Advances by `step` [s], > 0 and <= 0.1. A constant step is the fast one. */
int32_t dct_observer_step(dct_observer *observer, const dct_sample *sample, double step,
                          dct_estimate *estimate);

#ifdef __cplusplus
}
#endif

#endif
