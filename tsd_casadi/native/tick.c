/* One control tick: request vector -> reply vector.
 *
 * The QP's data come from the functions that CasADi generated (qp, safe_torque);
 * DAQP solves it. All memory is in the context: a tick allocates nothing, keeps
 * nothing from the tick before and may run in several threads with one context
 * each. The sizes below are written to problem.h together with the functions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "api.h"
#include "utils.h"

#include "problem.h"

#define N_ROWS (N_BOUNDS + N_GENERAL)
#define TRIANGLE (N_X * (N_X + 1) / 2)

enum status {
  STATUS_OK = 0,
  STATUS_INFEASIBLE = 1,
  STATUS_ITERATION_LIMIT = 2,
  STATUS_SINGULAR = 3,
  STATUS_NOT_FINITE = 4
};

struct tick {
  double lower_accepted[N_REQUEST], upper_accepted[N_REQUEST];
  /* outputs of qp, in its order */
  double H[N_X * N_X], g[N_X], A[N_GENERAL * N_X], lower[N_ROWS], upper[N_ROWS];
  double h_a[N_TAU], error[N_ERROR], feedback[N_ERROR];
  double A_rows[N_GENERAL * N_X];
  const double* arguments[QP_SZ_ARG];
  double* results[QP_SZ_RES];
  casadi_int iw[QP_SZ_IW];
  double w[QP_SZ_W];
  int sense[N_ROWS];
  DAQPProblem problem;
  DAQPSettings settings;
  DAQPWorkspace work;
};

static double microseconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

void tick_free(struct tick* t) {
  if (t == NULL) return;
  t->work.settings = NULL; /* lies in the context */
  free_daqp_ldp(&t->work);
  free_daqp_workspace(&t->work);
  free(t);
}

struct tick* tick_create(const double* lower_accepted, const double* upper_accepted) {
  struct tick* t = calloc(1, sizeof *t);
  if (t == NULL) return NULL;
  memcpy(t->lower_accepted, lower_accepted, sizeof t->lower_accepted);
  memcpy(t->upper_accepted, upper_accepted, sizeof t->upper_accepted);
  for (int i = 0; i < N_EQUALITIES; i++) t->sense[N_BOUNDS + i] = ACTIVE | IMMUTABLE;

  t->problem = (DAQPProblem){.n = N_X,
                             .m = N_ROWS,
                             .ms = N_BOUNDS,
                             .H = t->H,
                             .f = t->g,
                             .A = t->A_rows,
                             .bupper = t->upper,
                             .blower = t->lower,
                             .sense = t->sense};
  daqp_default_settings(&t->settings);
  t->settings.primal_tol = PRIMAL_TOLERANCE;
  t->settings.iter_limit = ITERATION_LIMIT;

  DAQPWorkspace* work = &t->work;
  work->settings = &t->settings;
  allocate_daqp_workspace(work, N_X, 0);
  work->qp = &t->problem;
  work->n = N_X;
  work->m = N_ROWS;
  work->ms = N_BOUNDS;
  work->scaling = malloc(N_ROWS * sizeof(double));
  work->M = malloc(N_GENERAL * N_X * sizeof(double));
  work->dupper = malloc(N_ROWS * sizeof(double));
  work->dlower = malloc(N_ROWS * sizeof(double));
  work->sense = malloc(N_ROWS * sizeof(int));
  work->Rinv = malloc(TRIANGLE * sizeof(double));
  work->RinvD = NULL;
  work->v = malloc(N_X * sizeof(double));
  if (!work->scaling || !work->M || !work->dupper || !work->dlower || !work->sense ||
      !work->Rinv || !work->v) {
    tick_free(t);
    return NULL;
  }
  return t;
}

/* 0, or 1 + the position of the first value that is not accepted. Written so
 * that NaN fails. */
static int first_refused(const struct tick* t, const double* request) {
  for (int i = 0; i < N_REQUEST; i++)
    if (!(request[i] >= t->lower_accepted[i] && request[i] <= t->upper_accepted[i]))
      return 1 + i;
  for (int i = 0; i < N_SWITCHES; i++) {
    const double x = request[switches[i]];
    if (x != 0.0 && x != 1.0) return 1 + switches[i];
  }
  for (int i = 0; i < N_QUATERNIONS; i++) {
    const double* x = request + quaternions[i];
    const double norm = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    if (fabs(norm - 1.0) > QUATERNION_TOLERANCE) return 1 + quaternions[i];
  }
  return 0;
}

static int all_finite(const double* x, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) sum += x[i] - x[i]; /* 0, or NaN */
  return sum == 0.0;
}

static void evaluate_qp(struct tick* t, const double* request) {
  double* results[] = {t->H, t->g, t->A, t->lower, t->upper, t->h_a, t->error, t->feedback};
  t->arguments[0] = request;
  memcpy(t->results, results, sizeof results);
  qp(t->arguments, t->results, t->iw, t->w, 0);
  /* CasADi stores columns, DAQP reads rows */
  for (int j = 0; j < N_X; j++)
    for (int i = 0; i < N_GENERAL; i++) t->A_rows[i * N_X + j] = t->A[j * N_GENERAL + i];
}

/* The set-up of DAQP: Cholesky of H, transformed rows, equalities activated. */
static int factorize(DAQPWorkspace* work) {
  /* DAQP leaves the scaling of zero rows unwritten */
  for (int i = 0; i < N_ROWS; i++) work->scaling[i] = 1.0;
  const int flag = update_ldp(
      UPDATE_Rinv | UPDATE_M | UPDATE_v | UPDATE_d | UPDATE_sense, work);
  return flag < 0 ? flag : activate_constraints(work);
}

static enum status status_of(int flag) {
  switch (flag) {
    case EXIT_OPTIMAL:
    case EXIT_SOFT_OPTIMAL:
      return STATUS_OK;
    case EXIT_INFEASIBLE:
    case EXIT_OVERDETERMINED_INITIAL:
      return STATUS_INFEASIBLE;
    case EXIT_NONCONVEX:
    case EXIT_UNBOUNDED:
      return STATUS_SINGULAR;
    default: /* cycling and the limit itself */
      return STATUS_ITERATION_LIMIT;
  }
}

static void recover(const struct tick* t, double* reply) {
  const double* x = t->work.x;
  const double* A_tau = t->A_rows + (N_GENERAL - N_TAU) * N_X;
  for (int i = 0; i < N_TAU; i++) {
    double tau = t->h_a[i];
    for (int j = 0; j < N_X; j++) tau += A_tau[i * N_X + j] * x[j];
    reply[REPLY_TAU + i] = tau;
  }
  memcpy(reply + REPLY_QDD, x, N_X * sizeof(double)); /* qdd, then wrenches */
  double* active = reply + REPLY_ACTIVE;
  for (int i = 0; i < t->work.n_active; i++) {
    const int row = t->work.WS[i];
    active[row] = (t->work.sense[row] & LOWER) ? -1.0 : 1.0;
  }
  for (int i = 0; i < N_EQUALITIES; i++) active[N_BOUNDS + i] = 2.0;
}

static void answer_safely(struct tick* t, const double* request, double* reply) {
  memset(reply + REPLY_QDD, 0, N_X * sizeof(double));
  memset(reply + REPLY_ACTIVE, 0, N_ROWS * sizeof(double));
  t->arguments[0] = request;
  t->results[0] = reply + REPLY_TAU;
  safe_torque(t->arguments, t->results, t->iw, t->w, 0);
  if (!all_finite(reply + REPLY_TAU, N_TAU))
    memset(reply + REPLY_TAU, 0, N_TAU * sizeof(double));
}

/* Returns 0 and fills the reply, or 1 + the position in the request of a value
 * that is not accepted, and leaves the reply as it is. */
int tick_run(struct tick* t, const double* request, double* reply) {
  const int refused = first_refused(t, request);
  if (refused) return refused;

  const double start = microseconds();
  evaluate_qp(t, request);
  const double evaluated = microseconds();
  double factorized = evaluated, solved = evaluated;
  enum status status = STATUS_NOT_FINITE;
  int iterations = 0;
  memset(reply, 0, N_REPLY * sizeof(double));
  if (all_finite(t->H, N_X * N_X) && all_finite(t->A_rows, N_GENERAL * N_X) &&
      all_finite(t->g, N_X) && all_finite(t->lower, N_ROWS) && all_finite(t->upper, N_ROWS)) {
    int flag = factorize(&t->work);
    factorized = solved = microseconds();
    if (flag >= 0) {
      flag = daqp_ldp(&t->work);
      if (flag > 0) ldp2qp_solution(&t->work);
      iterations = t->work.iterations;
      solved = microseconds();
    }
    status = status_of(flag < 0 ? flag : flag == 0 ? EXIT_CYCLE : flag);
    if (status == STATUS_OK) {
      recover(t, reply);
      if (!all_finite(reply + REPLY_TAU, N_TAU + N_X)) status = STATUS_NOT_FINITE;
    }
  }
  if (status != STATUS_OK) answer_safely(t, request, reply);
  if (all_finite(t->error, N_ERROR) && all_finite(t->feedback, N_ERROR)) {
    memcpy(reply + REPLY_ERROR, t->error, N_ERROR * sizeof(double));
    memcpy(reply + REPLY_FEEDBACK, t->feedback, N_ERROR * sizeof(double));
  }
  reply[REPLY_STATUS] = (double)status;
  reply[REPLY_ITERATIONS] = (double)iterations;
  reply[REPLY_DATA_TIME] = evaluated - start;
  reply[REPLY_FACTORIZATION_TIME] = factorized - evaluated;
  reply[REPLY_SOLVE_TIME] = solved - factorized;
  return 0;
}
