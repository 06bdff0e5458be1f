/* What shell.c needs of a peer: five inputs (references 0..4), five outputs (5..9), a start, a step. */
#ifndef MODEL_H
#define MODEL_H

enum { INPUTS = 5, OUTPUTS = 5, STATES = 6 };

typedef struct {
    double u[INPUTS];
    double y[OUTPUTS];
    double x[STATES];
} Model;

void model_start(Model *m);
void model_step(Model *m, double h);

#endif
