/* The C interface as a caller in C sees it: a loading cycle with a commit at every reversal, laws against known values,
   and every kind of refusal. Prints what is wrong and returns 1, or prints "passed" and returns 0. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "contact_laws.h"

static int failures = 0;

#define EXPECT(condition)                                                                                              \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("line %d: %s\n", __LINE__, #condition);                                                             \
            failures += 1;                                                                                             \
        }                                                                                                              \
    } while (0)

static int near(double found, double expected, double tolerance) {
    return fabs(found - expected) <= tolerance * fabs(expected);
}

/* One point of elastic dry friction through a closed loop: its area is known. */
static void loading_cycle(void) {
    const double k_n = 2e12, k_x = 1.5e12, k_y = 1e12, mu = 0.3, u_n = 1e-6, amplitude = 1e-6;
    const double limit = mu * k_n * u_n;
    char message[200];
    cl_law *law =
        cl_elastic_dry_friction_law(1, &k_n, &k_x, &k_y, 1, &mu, 1, CL_HISTORY_INCREMENTAL, message, sizeof message);
    EXPECT(law != NULL);
    EXPECT(cl_law_n_points(law) == 1);
    EXPECT(cl_law_n_state(law) == 5);
    EXPECT(cl_law_n_parameters(law) == 4);
    EXPECT(strcmp(cl_law_name(law), "elastic dry friction") == 0);
    EXPECT(strlen(cl_law_reference(law)) > 0);
    EXPECT(strcmp(cl_law_state_name(law, 4), "t_y") == 0 && strcmp(cl_law_state_unit(law, 4), "Pa") == 0);
    EXPECT(strcmp(cl_law_parameter_name(law, 3), "mu") == 0 && strcmp(cl_law_parameter_unit(law, 3), "1") == 0);
    EXPECT(cl_law_state_name(law, 5) == NULL && cl_law_parameter_unit(law, 4) == NULL);

    double begin[5] = {0, 0, u_n, 0, 0}, end[5];
    const double turns[4] = {0, amplitude, -amplitude, amplitude};
    double t_x = 0, t_y, t_n, area = 0;
    size_t slipping = 0;
    for (int stroke = 1; stroke <= 3; stroke++) {
        const int steps = 20;
        for (int step = 1; step <= steps; step++) {
            const double from = turns[stroke - 1], to = turns[stroke];
            const double u_x = from + (to - from) * step / steps, u_y = 0, before = t_x;
            cl_counts counts;
            EXPECT(cl_law_evaluate(law, 0, 1, CL_STICKING_COULOMB, &u_x, &u_y, &u_n, begin, end, 1, &t_x, &t_y, &t_n,
                                   NULL, NULL, &counts, message, sizeof message) == CL_SUCCESS);
            EXPECT(near(t_n, k_n * u_n, 1e-15));
            EXPECT(fabs(t_x) <= limit * (1 + 1e-15) && t_y == 0);
            EXPECT(counts.stick + counts.slip == 1 && counts.open == 0 && counts.invalid == 0);
            slipping += counts.slip;
            if (stroke > 1) {
                area += 0.5 * (t_x + before) * (to - from) / steps;
            }
        }
        EXPECT(near(fabs(t_x), limit, 1e-15));
        memcpy(begin, end, sizeof end);
    }
    EXPECT(slipping > 0);
    /* The corners of the loop lie on steps: the trapezoidal rule is exact. */
    EXPECT(near(area, 4 * limit * (amplitude - limit / k_x), 1e-12));
    cl_law_free(law);
}

/* Three points, slipping, sticking and open, of the law of Balaji, Chen and Brake (2020), DOI
   10.1016/j.ymssp.2020.106615, as evaluated by its authors' public code (to within 1e-12 of mu t_n and t_n). */
static void authors_points(void) {
    enum { N = 3 };
    const double gap[N] = {2.5936479527021017e-07, 3.537840239532589e-07, 1.8310788727219874e-07};
    const double mu[N] = {0.35906621186652987, 0.5287056034453513, 0.27859117168561165};
    const double normal[5][N] = {
        {43.3185989786087, 42.14889999994835, 43.2339480315565},
        {2.199176551653819, 1.9277694449884983, 1.9975456559241571},
        {-0.9178019332310183, 0.6764085192114531, -0.12329481275731458},
        {14.371613167724533, 13.167954586824708, 13.307490154666372},
        {0.8284932734322841, 1.3287262059984257, 1.3517685776352852},
    };
    const double tangential_x[4][N] = {
        {29.623504830756968, 29.702365082461533, 28.468064446888423},
        {0.591812006662134, 1.2699711027626899, 0.6447070866038465},
        {-13.15823338596239, -13.167784624122332, -13.009376760967243},
        {0.9621918548654054, 1.1755314813903568, 0.9362675099538449},
    };
    const double tangential_y[4][N] = {
        {28.386295954792615, 28.227152344453003, 29.076867282349887},
        {1.114891084734581, 0.8361241746400292, 1.3542848988342602},
        {-13.365942421046814, -13.148030013110562, -13.763094777592109},
        {0.4247360373974014, 1.1124039359137545, 0.4329780829840886},
    };
    const double u_ref[N] = {1, 1, 1};
    const double jump[2][N] = {
        {7.209400411292881e-07, -4.090089014146151e-07, -1.0688479839287101e-06},
        {5.071790018227237e-07, -2.3529973716255013e-06, -8.249288248994165e-08},
    };
    const double u_n[N] = {9.183903405080794e-07, 1.988763648942867e-06, -2.5157155143214873e-07};
    const double u_n_begin[N] = {2.2780521596224685e-06, 2.429880496409366e-06, 2.6545767730555568e-06};
    double begin[5][N] = {
        {-1.8853900590958057e-07, -5.0258151166183183e-08, 2.5939081639851594e-08},
        {1.1647201741763737e-07, -3.245426468559766e-08, -5.38687433942181e-08},
        {0, 0, 0},
        {-91765.82703122035, -19865.442179895457, -21377.463323553882},
        {-196239.3439868191, 57361.03394370908, -39493.3763953299},
    };
    const double traction[3][N] = {
        {23969.301365859807, -1276730.576061706, 0},
        {-2421.7539299825207, -2648567.0135510825, 0},
        {67094.40117568761, 27654470.4686542, 0},
    };
    /* xx, xy, xn, yx, yy, yn, nn */
    const double tangent[7][N] = {
        {233246594.78019083, 3847348000684.698, 0},  {194299468.55213776, 0.0, 0},
        {87755753054.94922, -3738073252329.2227, 0}, {2308557386.293713, 0.0, 0},
        {1923078335.620252, 1171293258023.7595, 0},  {2125702139.5104427, -3778254428944.833, 0},
        {242566837293.62955, 33610295624169.35, 0},
    };
    const int32_t regime[N] = {CL_REGIME_SLIP, CL_REGIME_STICK, CL_REGIME_OPEN};
    const int entry[7] = {0, 1, 2, 3, 4, 5, 8};

    char message[200];
    cl_law *law = cl_rough_law(N, normal[0], tangential_x[0], tangential_y[0], u_ref, NULL, N, CL_ENDS_CONSTANT, mu, N,
                               CL_HISTORY_PAPER, message, sizeof message);
    EXPECT(law != NULL);
    double jump_n[N], end[5][N], t[3][N], j[9][N];
    double *j_rows[9];
    int32_t regimes[N];
    cl_counts counts;
    for (int i = 0; i < N; i++) {
        jump_n[i] = u_n[i] - gap[i];
        begin[2][i] = u_n_begin[i] - gap[i];
    }
    for (int row = 0; row < 9; row++) {
        j_rows[row] = j[row];
    }
    EXPECT(cl_law_evaluate(law, 0, N, CL_STICKING_COULOMB, jump[0], jump[1], jump_n, begin[0], end[0], N, t[0], t[1],
                           t[2], j_rows, regimes, &counts, message, sizeof message) == CL_SUCCESS);
    EXPECT(counts.slip == 1 && counts.stick == 1 && counts.open == 1 && counts.invalid == 0);
    for (int i = 0; i < N; i++) {
        double largest = 0;
        for (int e = 0; e < 7; e++) {
            largest = fmax(largest, fabs(tangent[e][i]));
        }
        EXPECT(regimes[i] == regime[i]);
        for (int q = 0; q < 3; q++) {
            const double scale = (q < 2 ? mu[i] : 1) * traction[2][i];
            EXPECT(fabs(t[q][i] - traction[q][i]) <= 1e-12 * scale);
        }
        for (int e = 0; e < 7; e++) {
            EXPECT(fabs(j[entry[e]][i] - tangent[e][i]) <= 1e-12 * largest);
        }
        EXPECT(j[6][i] == 0 && j[7][i] == 0);
        EXPECT(end[0][i] == jump[0][i] && end[2][i] == jump_n[i] && end[3][i] == t[0][i]);
    }

    /* The last two points alone, in place, and stuck: no tangential traction is limited. */
    double state[5][N], one_x[2], one_y[2], one_n[2];
    memcpy(state, begin, sizeof state);
    EXPECT(cl_law_evaluate(law, 1, 2, CL_STICKING_FULL, jump[0] + 1, jump[1] + 1, jump_n + 1, state[0] + 1,
                           state[0] + 1, N, one_x, one_y, one_n, NULL, NULL, NULL, NULL, 0) == CL_SUCCESS);
    EXPECT(one_x[0] == t[0][1] && one_y[0] == t[1][1] && one_n[0] == t[2][1] && one_n[1] == 0);
    EXPECT(state[3][0] == begin[3][0] && state[3][1] == one_x[0] && state[3][2] == 0);
    cl_law_free(law);
}

/* Gaps spread evenly from 0 to w: below w the normal traction is n_A (2/3) E/(1-nu^2) sqrt(R) u^(5/2) / (5/2 w), and
   the tangential stiffness is 2 (1-nu)/(2-nu) times the normal one. */
static void asperity_table(void) {
    const double probabilities[2] = {0, 1}, gaps[2] = {0, 2e-5}, mu = 0.2;
    const double density = 1.4e6, radius = 1.4e-3, youngs = 192.85e9, nu = 0.29;
    char message[200];
    cl_law *law = cl_asperity_table_law(2, probabilities, gaps, 2, density, radius, radius, youngs, nu,
                                        CL_READING_MINDLIN, 1e-8, 1e-4, &mu, 1, CL_HISTORY_INCREMENTAL, message,
                                        sizeof message);
    EXPECT(law != NULL);
    const double u_x[2] = {1e-9, -1e-9}, u_y[2] = {0, 0}, u_n[2] = {3e-6, 1e-5};
    const double begin[5][2] = {{0, 0}, {0, 0}, {3e-6, 1e-5}, {0, 0}, {0, 0}};
    double end[5][2], t[3][2], j[9][2];
    double *j_rows[9] = {j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[7], j[8]};
    cl_counts counts;
    EXPECT(cl_law_evaluate(law, 0, 2, CL_STICKING_COULOMB, u_x, u_y, u_n, begin[0], end[0], 2, t[0], t[1], t[2], j_rows,
                           NULL, &counts, message, sizeof message) == CL_SUCCESS);
    EXPECT(counts.stick == 2);
    for (int i = 0; i < 2; i++) {
        const double factor = density * 2 / 3 * youngs / (1 - nu * nu) * sqrt(radius);
        EXPECT(near(t[2][i], factor * pow(u_n[i], 2.5) / (2.5 * gaps[1]), 2e-5));
        EXPECT(near(j[0][i], 2 * (1 - nu) / (2 - nu) * j[8][i], 1e-3));
        EXPECT(near(t[0][i], j[0][i] * u_x[i], 1e-12));
    }
    cl_law_free(law);
}

/* Constructors: NULL and a message that names parameter, value and place. */
static void refused_laws(void) {
    const double good = 1e12, bad = -1e12, mu[2] = {0.2, NAN}, zero = 0, one = 1;
    char message[200];
#define REFUSED(law, text)                                                                                             \
    do {                                                                                                               \
        strcpy(message, "untouched");                                                                                  \
        EXPECT((law) == NULL);                                                                                         \
        if (strstr(message, text) == NULL) {                                                                           \
            printf("line %d: message \"%s\" lacks \"%s\"\n", __LINE__, message, text);                                 \
            failures += 1;                                                                                             \
        }                                                                                                              \
    } while (0)
#define ELASTIC(n, k_n, sets, mu, n_mu, history)                                                                       \
    cl_elastic_dry_friction_law(n, k_n, &good, &good, sets, mu, n_mu, history, message, sizeof message)
    REFUSED(ELASTIC(1, &bad, 1, mu, 1, CL_HISTORY_INCREMENTAL), "k_n = -1e12 Pa/m");
    REFUSED(ELASTIC(2, &good, 1, mu, 2, CL_HISTORY_INCREMENTAL), "mu = NaN (no unit) at point 1");
    REFUSED(ELASTIC(1, NULL, 1, mu, 1, CL_HISTORY_INCREMENTAL), "k_n is NULL");
    REFUSED(ELASTIC(1, &good, 1, NULL, 1, CL_HISTORY_INCREMENTAL), "mu is NULL");
    REFUSED(ELASTIC(1, &good, 1, mu, 1, 1000), "history = 1000: must be CL_HISTORY_INCREMENTAL, ");
    REFUSED(ELASTIC(0, &good, 1, mu, 1, CL_HISTORY_INCREMENTAL), "n_points = 0");
    REFUSED(ELASTIC(SIZE_MAX, &good, 1, mu, 1, CL_HISTORY_INCREMENTAL), "n_points = ");
    REFUSED(ELASTIC(3, &good, 1, mu, 2, CL_HISTORY_INCREMENTAL), "n_mu = 2");
    REFUSED(ELASTIC(3, &good, 2, mu, 1, CL_HISTORY_INCREMENTAL), "n_sets = 2");

    const double normal[10] = {15, 15, 2, 2, 0, 0, 0, 0, 1, -1}, tangential[8] = {29, 29, 1, 1, 0, 0, 1, 1};
    const double u_ref[2] = {1e-6, 1e-6};
#define ROUGH(x, ranges, ends)                                                                                         \
    cl_rough_law(2, normal, x, tangential, u_ref, ranges, 2, ends, mu, 1, CL_HISTORY_PAPER, message, sizeof message)
    REFUSED(ROUGH(tangential, NULL, CL_ENDS_CONSTANT), "set 1 (counted from 0): normal e = -1e0");
    REFUSED(ROUGH(NULL, NULL, CL_ENDS_CONSTANT), "tangential_x is NULL");
    REFUSED(ROUGH(tangential, NULL, 3), "ends = 3");

    const double steps[2] = {0, 1}, falling[2] = {1e-5, 0};
#define TABLE(probabilities, gaps, n, reading, upper)                                                                  \
    cl_asperity_table_law(1, probabilities, gaps, n, 1e6, 1e-3, 1e-3, 2e11, 0.3, reading, 1e-8, upper, mu, 1,          \
                          CL_HISTORY_PAPER, message, sizeof message)
    REFUSED(TABLE(steps, falling, 2, CL_READING_MINDLIN, 1e-4), "asperity gap = 0e0 m at entry 1");
    REFUSED(TABLE(&zero, &one, 1, CL_READING_MINDLIN, 1e-4), "probabilities of the asperity gaps has 1 entries");
    REFUSED(TABLE(steps, steps, 2, 5, 1e-4), "reading = 5");
    REFUSED(TABLE(steps, steps, 2, CL_READING_MINDLIN, 1e-9), "upper end");
    REFUSED(TABLE(steps, steps, SIZE_MAX / 4, CL_READING_MINDLIN, 1e-4), "beyond the memory");

    /* Two bins in two sets, of which the last point uses the second. */
    const double gaps[4] = {0, 0, 1e-6, 2e-6}, densities[4] = {1e5, 1e5, 1e5, 1e5}, negative[4] = {1e5, 1e5, 1e5, -1};
    const uint32_t sets[2] = {0, 1}, missing[2] = {0, 2};
#define RESOLVED(gaps, densities, n_bins, n_sets, sets, strength, tangent, history, cone, limit, n_radii)                     \
    cl_resolved_law(2, gaps, densities, n_bins, n_sets, sets, 1e-3, 2e11, 0.3, strength, tangent, 0, mu, 1, history,   \
                    cone, limit, n_radii, message, sizeof message)
    REFUSED(RESOLVED(gaps, densities, 2, 3, NULL, 0, 0, 3, 0, 0, 0), "n_sets = 3: must be 1 or the number of points, 2");
    REFUSED(RESOLVED(gaps, densities, 2, 2, missing, 0, 0, 3, 0, 0, 0), "point 1 asks for parameter set 2, but there are 2");
    REFUSED(RESOLVED(gaps, densities, 2, 0, sets, 0, 0, 3, 0, 0, 0), "point 0 asks for parameter set 0, but there are 0");
    REFUSED(RESOLVED(NULL, densities, 2, 2, sets, 0, 0, 3, 0, 0, 0), "gaps is NULL");
    REFUSED(RESOLVED(gaps, NULL, 2, 2, sets, 0, 0, 3, 0, 0, 0), "densities is NULL");
    REFUSED(RESOLVED(gaps, densities, 0, 2, sets, 0, 0, 3, 0, 0, 0), "set 0 (counted from 0): bins = 0e0");
    REFUSED(RESOLVED(gaps, densities, SIZE_MAX, 2, sets, 0, 0, 3, 0, 0, 0), "gaps would reach beyond the memory");
    REFUSED(RESOLVED(gaps, negative, 2, 2, sets, 0, 0, 3, 0, 0, 0), "set 1 (counted from 0): bin_density = -1e0");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, -1, 0, 3, 0, 0, 0), "yield_strength = -1e0");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 3e8, 2e11, 3, 0, 0, 0), "tangent_modulus = 2e11");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 3e8, 0, CL_HISTORY_POTENTIAL, 0, 0, 0), "asperities that yield");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 0, 0, -1, 0, 0, 0), "history = -1");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 0, 0, 3, 2, 0, 0), "cone = 2");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 3e8, 0, 3, 0, 3, 0), "limit = 3");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 0, 0, 3, 0, CL_LIMIT_CEB, 0), "elastic asperities");
    REFUSED(RESOLVED(gaps, densities, 2, 2, sets, 0, 0, 3, 0, 0, 257), "annuli = 2.57e2");
    REFUSED(cl_resolved_law(2, gaps, densities, 2, 2, sets, 1e-3, 2e11, 0.3, 3e8, 0, 2, mu, 1, 3, 0, 0, 0, message,
                            sizeof message),
            "yield_curves = 2");
    double many[128] = {0};
    REFUSED(RESOLVED(many, many, 64, 2, sets, 0, 0, 3, 0, 0, 16), "2051 state components per point");
    cl_law *resolved = RESOLVED(gaps, densities, 2, 2, sets, 3e8, 1e9, CL_HISTORY_END_POINT, CL_CONE_BOX, 0, 4);
    EXPECT(resolved != NULL && cl_law_n_state(resolved) == 3 + 2 * (2 * 4 + 2));
    EXPECT(strcmp(cl_law_state_name(resolved, 3), "f_x_1_1") == 0 && strcmp(cl_law_state_unit(resolved, 12), "N") == 0);
    cl_law_free(resolved);

    /* Messages are cut to the buffer; no buffer is fine. */
    memset(message, '#', sizeof message);
    EXPECT(cl_elastic_dry_friction_law(1, &bad, &good, &good, 1, mu, 1, 0, message, 6) == NULL);
    EXPECT(strcmp(message, "param") == 0 && message[6] == '#');
    EXPECT(cl_elastic_dry_friction_law(1, &bad, &good, &good, 1, mu, 1, 0, message + 6, 0) == NULL);
    EXPECT(message[6] == '#');
    EXPECT(cl_elastic_dry_friction_law(1, &bad, &good, &good, 1, mu, 1, 0, NULL, 0) == NULL);
    EXPECT(cl_law_n_points(NULL) == 0 && cl_law_n_state(NULL) == 0 && cl_law_n_parameters(NULL) == 0);
    EXPECT(cl_law_name(NULL) == NULL && cl_law_reference(NULL) == NULL && cl_law_state_name(NULL, 0) == NULL);
    cl_law_free(NULL);
}

/* Evaluation: refusals write nothing but the message; points that are not finite are counted. */
static void refused_calls(void) {
    enum { N = 4 };
    const double k = 1e12, mu = 0.2;
    cl_law *law = cl_elastic_dry_friction_law(N, &k, &k, &k, 1, &mu, 1, CL_HISTORY_INCREMENTAL, NULL, 0);
    EXPECT(law != NULL);
    const double zeros[N] = {0}, u_n[N] = {1e-6, 2e-6, 3e-6, 4e-6}, begin[5 * N] = {0};
    double end[5 * N], t[3][N], j[9][N];
    double *j_rows[9] = {j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[7], j[8]};
    double *j_holes[9] = {j[0], j[1], j[2], j[3], NULL, j[5], j[6], j[7], j[8]};
    double *j_twice[9] = {j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[3] + 2, j[8]};
    int32_t regimes[N];
    cl_counts counts;
    char message[200];

    memset(end, 0x55, sizeof end);
    memset(t, 0x55, sizeof t);
    memset(j, 0x55, sizeof j);
    memset(regimes, 0x55, sizeof regimes);
    memset(&counts, 0x55, sizeof counts);
#define CALL(law, first, count, sticking, x, begin, end, stride, t_x, tangent)                                         \
    cl_law_evaluate(law, first, count, sticking, x, zeros, u_n, begin, end, stride, t_x, t[1], t[2], tangent, regimes, \
                    &counts, message, sizeof message)
#define REJECTED(call, text)                                                                                           \
    do {                                                                                                               \
        strcpy(message, "untouched");                                                                                  \
        EXPECT((call) == CL_ERROR);                                                                                    \
        if (strstr(message, text) == NULL) {                                                                           \
            printf("line %d: message \"%s\" lacks \"%s\"\n", __LINE__, message, text);                                 \
            failures += 1;                                                                                             \
        }                                                                                                              \
    } while (0)
    const double *odd = (const double *)(const void *)((const char *)zeros + 1);
    REJECTED(CALL(NULL, 0, N, 0, zeros, begin, end, N, t[0], j_rows), "law is NULL");
    REJECTED(CALL(law, 0, N + 1, 0, zeros, begin, end, N + 1, t[0], j_rows), "5 points from point 0 on: the law has 4");
    REJECTED(CALL(law, 3, 2, 0, zeros, begin, end, N, t[0], j_rows), "2 points from point 3");
    REJECTED(CALL(law, SIZE_MAX, 2, 0, zeros, begin, end, N, t[0], j_rows), "the law has 4 points");
    REJECTED(CALL(law, 0, N, 3, zeros, begin, end, N, t[0], j_rows), "sticking = 3");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, N - 1, t[0], j_rows), "stride = 3");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, SIZE_MAX, t[0], j_rows), "stride would reach beyond the memory");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, SIZE_MAX / 32, t[0], j_rows), "begin would reach beyond the memory");
    REJECTED(CALL(law, 0, N, 0, NULL, begin, end, N, t[0], j_rows), "jump_x is NULL");
    REJECTED(CALL(law, 0, N - 1, 0, odd, begin, end, N, t[0], j_rows), "jump_x is not aligned");
    REJECTED(CALL(law, 0, N, 0, zeros, NULL, end, N, t[0], j_rows), "begin is NULL");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, NULL, N, t[0], j_rows), "end is NULL");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, N, NULL, j_rows), "traction_x is NULL");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, N, t[1], j_rows), "traction_x and traction_y overlap");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, N, t[0], j_holes), "tangent[4] (yy) is NULL");
    REJECTED(CALL(law, 0, N, 0, zeros, begin, end, N, t[0], j_twice), "tangent[3] (yx) and tangent[7] (ny) overlap");
    REJECTED(CALL(law, 0, N, 0, t[0], begin, end, N, t[0], j_rows), "jump_x and traction_x overlap");

    const unsigned char *written[5] = {(unsigned char *)end, (unsigned char *)t, (unsigned char *)j,
                                       (unsigned char *)regimes, (unsigned char *)&counts};
    const size_t sizes[5] = {sizeof end, sizeof t, sizeof j, sizeof regimes, sizeof counts};
    for (int array = 0; array < 5; array++) {
        for (size_t i = 0; i < sizes[array]; i++) {
            EXPECT(written[array][i] == 0x55);
        }
    }

    /* No point needs no array. */
    EXPECT(cl_law_evaluate(law, N, 0, 0, NULL, NULL, NULL, NULL, NULL, 0, NULL, NULL, NULL, NULL, NULL, &counts, NULL,
                           0) == CL_SUCCESS);
    EXPECT(counts.stick + counts.slip + counts.open + counts.invalid == 0);

    /* Arrays that are only read may be one; a NaN and an infinity spoil their points alone. */
    const double spoilt[N] = {0, NAN, 0, -INFINITY};
    strcpy(message, "untouched");
    EXPECT(cl_law_evaluate(law, 0, N, 0, spoilt, spoilt, u_n, begin, end, N, t[0], t[1], t[2], j_rows, regimes, &counts,
                           message, sizeof message) == CL_INVALID_POINTS);
    EXPECT(strcmp(message, "untouched") == 0);
    EXPECT(counts.invalid == 2 && counts.stick == 2 && counts.slip == 0 && counts.open == 0);
    for (int i = 0; i < N; i++) {
        const int bad = i % 2;
        EXPECT(regimes[i] == (bad ? CL_REGIME_INVALID : CL_REGIME_STICK));
        EXPECT(bad ? isnan(t[2][i]) && isnan(j[0][i]) : t[2][i] == k * u_n[i] && j[8][i] == k);
    }
    cl_law_free(law);
}

int main(void) {
    loading_cycle();
    authors_points();
    asperity_table();
    refused_laws();
    refused_calls();
    if (failures == 0) {
        printf("passed\n");
    }
    return failures > 0;
}
