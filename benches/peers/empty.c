/* A C FMU without a model. */
#include "model.h"

void model_start(Model *m) {
    (void)m;
}

void model_step(Model *m, double h) {
    (void)m;
    (void)h;
}
