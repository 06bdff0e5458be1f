/* What shell.c needs of a peer: its inputs (references 0..) with their rates, then its outputs, a
 * start, a step. */
#ifndef MODEL_H
#define MODEL_H

enum { INPUTS = 5, OUTPUTS = 21 };

typedef struct {
    double u[INPUTS];
    double u_rate[INPUTS]; /* fmi2SetRealInputDerivatives */
    double y[OUTPUTS];
    double x[12];
} Model;

void model_start(Model *m);
void model_step(Model *m, double h);

#endif
