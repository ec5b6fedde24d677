/* Friction resolved over yielding asperities through element cycles, against values of another code: the header
   reference.h is made from a file of them. Prints what is wrong and returns 1, or prints the largest error and returns 0. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "contact_laws.h"
#include "reference.h"

int main(void) {
    char message[200];
    cl_law *law = cl_resolved_law(1, gaps, densities, N_BINS, 1, NULL, radius, youngs_modulus, poisson_ratio,
                                  yield_strength, tangent_modulus, CL_YIELD_PUBLISHED, &mu, 1, CL_HISTORY_END_POINT,
                                  CL_CONE_BOX, CL_LIMIT_COULOMB, 0, message, sizeof message);
    if (law == NULL) {
        printf("%s\n", message);
        return 1;
    }
    const size_t n_state = cl_law_n_state(law);
    double *state = calloc(n_state, sizeof *state);
    double worst = 0;
    for (int cycle = 0; cycle < N_CYCLES; cycle++) {
        double deepest = 0, largest = 0, zero = 0, t[3];
        for (size_t i = 0; i < n_state; i++) {
            state[i] = 0;
        }
        for (int step = 0; step < N_STEPS; step++) {
            deepest = fmax(deepest, u[cycle][2][step]);
            for (int q = 0; q < 3; q++) {
                largest = fmax(largest, fabs(expected[cycle][q][step]));
            }
        }
        /* The yield of the largest interference is committed first. */
        for (int step = -1; step < N_STEPS; step++) {
            const double *x = step < 0 ? &zero : &u[cycle][0][step], *y = step < 0 ? &zero : &u[cycle][1][step];
            const double *n = step < 0 ? &deepest : &u[cycle][2][step];
            if (cl_law_evaluate(law, 0, 1, CL_STICKING_COULOMB, x, y, n, state, state, 1, &t[0], &t[1], &t[2], NULL,
                                NULL, NULL, message, sizeof message) != CL_SUCCESS) {
                printf("%s\n", message);
                return 1;
            }
            for (int q = 0; q < 3 && step >= 0; q++) {
                worst = fmax(worst, fabs(t[q] - expected[cycle][q][step]) / largest);
            }
        }
    }
    free(state);
    cl_law_free(law);
    printf("%.3e\n", worst);
    return 0;
}
