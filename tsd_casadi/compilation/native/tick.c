/* One control tick: request vector -> reply vector.
 *
 * CasADi's generated functions give the terms of the QP. The equalities are
 * eliminated, the optimum without inequalities is checked against every limit,
 * and only if one is violated DAQP solves the reduced problem: the result is
 * the same and most ticks need no active-set iteration.
 *
 * All memory is in the context: a tick allocates nothing, keeps nothing from
 * the tick before and may run in several threads with one context each.
 */
#include "tick.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "api.h"
#include "dense.h"
#include "utils.h"

enum status {
  STATUS_OK = 0,
  STATUS_INFEASIBLE = 1,
  STATUS_ITERATION_LIMIT = 2,
  STATUS_SINGULAR = 3,
  STATUS_NOT_FINITE = 4
};

/* beside DAQP's: solved, but a limit does not hold */
#define PASSED (-100)
/* the equalities are too large for their squares */
#define NOT_REPRESENTABLE (-101)

struct tick {
  double lower_accepted[N_REQUEST], upper_accepted[N_REQUEST];
  /* outputs of terms, in its order; matrices by columns */
  double H_qdd[N_V * N_V], H_lambda[N_X - N_V], g[N_X], A[N_GENERAL * N_X];
  double lower[N_ROWS], upper[N_ROWS];
  double h_a[N_TAU], error[N_ERROR], feedback[N_ERROR];
  double J[N_J * N_V], level[N_J], W_q[N_V], qdd_des[N_V];
  struct joint_limits limits;
  const double* arguments[SZ_ARG];
  double* results[SZ_RES];
  casadi_int iw[SZ_IW];
  double w[SZ_W];

  struct posture_work posture;
  struct elimination reduced;
  struct conflict_work conflict;
  double x[N_X], rows[N_GENERAL];
  double least[N_TAU], most[N_TAU]; /* bounds of the joints that did not yield */
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

  /* no H and no f: the rows come in the metric of the cost */
  t->problem = (DAQPProblem){.m = N_REDUCED,
                             .A = t->reduced.A,
                             .bupper = t->reduced.upper,
                             .blower = t->reduced.lower};
  daqp_default_settings(&t->settings);
  t->settings.primal_tol = PRIMAL_TOLERANCE;
  t->settings.iter_limit = ITERATION_LIMIT;

  DAQPWorkspace* work = &t->work;
  work->settings = &t->settings;
  allocate_daqp_workspace(work, MOST_Y, N_TAU); /* joints may be soft */
  work->qp = &t->problem;
  work->m = N_REDUCED;
  work->ms = 0;
  work->scaling = malloc(N_REDUCED * sizeof(double));
  work->M = malloc(N_REDUCED * MOST_Y * sizeof(double));
  work->dupper = malloc(N_REDUCED * sizeof(double));
  work->dlower = malloc(N_REDUCED * sizeof(double));
  work->sense = malloc(N_REDUCED * sizeof(int));
  work->Rinv = work->RinvD = work->v = NULL;
  if (!work->scaling || !work->M || !work->dupper || !work->dlower || !work->sense) {
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

/* x - x is 0, or NaN; eight sums side by side, because a compiler may not
 * reorder one. */
static int all_finite(const double* x, int n) {
  double sum[8] = {0.0}, rest = 0.0;
  int i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; k++) sum[k] += x[i + k] - x[i + k];
  for (; i < n; i++) rest += x[i] - x[i];
  for (int k = 0; k < 8; k++) rest += sum[k];
  return rest == 0.0;
}

/* Returns 0, or -1 if the data are not finite. */
static int evaluate_data(struct tick* t, const double* request) {
  double* results[] = {t->H_qdd, t->H_lambda, t->g,        t->A, t->lower, t->upper,
                       t->h_a,   t->error,    t->feedback, t->J, t->level, t->W_q, t->qdd_des,
                       t->limits.velocity_lower,  t->limits.velocity_upper,
                       t->limits.position_lower,  t->limits.position_upper};
  t->arguments[0] = request;
  memcpy(t->results, results, sizeof results);
  terms(t->arguments, t->results, t->iw, t->w, 0);
  if (!(all_finite(t->A, N_GENERAL * N_X) && all_finite(t->lower, N_ROWS) &&
        all_finite(t->upper, N_ROWS) && all_finite(t->h_a, N_TAU)))
    return -1;
  if (add_posture(t->J, t->level, t->W_q, t->qdd_des, &t->posture, t->H_qdd, t->g)) return -1;
  return all_finite(t->H_qdd, N_V * N_V) && all_finite(t->g, N_X) ? 0 : -1;
}

/* Is the value between its bounds, up to a share of 1 + |bound|? NaN is not. */
static int is_between(double value, double lower, double upper, double tolerance) {
  return value >= lower - tolerance * (1.0 + fabs(lower)) &&
         value <= upper + tolerance * (1.0 + fabs(upper));
}

static int is_inside(const struct tick* t, double tolerance) {
  for (int i = 0; i < N_TAU; i++)
    if (!is_between(t->x[N_V - N_TAU + i], t->least[i], t->most[i], tolerance)) return 0;
  for (int i = N_EQUALITIES; i < N_GENERAL; i++)
    if (!is_between(t->rows[i], t->lower[N_V + i], t->upper[N_V + i], tolerance)) return 0;
  return 1;
}

static void evaluate_rows(struct tick* t) {
  memset(t->rows, 0, sizeof t->rows);
  for (int r = 0; r < N_X; r++) add_multiple(N_GENERAL, t->x[r], t->A + r * N_GENERAL, t->rows);
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
    case NOT_REPRESENTABLE:
      return STATUS_NOT_FINITE;
    default: /* cycling and the limit itself */
      return STATUS_ITERATION_LIMIT;
  }
}

static int is_narrower(const struct tick* t, int i) {
  return t->lower[N_V - N_TAU + i] > t->least[i] || t->upper[N_V - N_TAU + i] < t->most[i];
}

/* The reduced problem for DAQP. What asks more of a joint than least and most is soft. */
static int prepare_inequalities(struct tick* t) {
  t->problem.n = t->work.n = t->reduced.n_y;
  /* the cost is scale^2 |u|^2 / 2 */
  t->settings.rho_soft = t->reduced.scale * t->reduced.scale / YIELDING_WEIGHT;
  /* DAQP leaves the scaling of zero rows unwritten */
  for (int i = 0; i < N_REDUCED; i++) t->work.scaling[i] = 1.0;
  const int flag = update_ldp(UPDATE_M | UPDATE_d | UPDATE_sense, &t->work);
  for (int i = 0; i < N_TAU; i++)
    if (is_narrower(t, i)) t->work.sense[i] |= SOFT;
  /* rows whose bounds coincide were marked active by the set-up */
  return flag < 0 ? flag : activate_constraints(&t->work);
}

/* One step of iterative refinement with DAQP's own factors, M M^T = L D L^T of
 * the active rows. They are updated at each of up to 40 iterations, and feet at
 * the edges of their cones make them nearly dependent: without this step the
 * rounding that gathers can exceed LIMIT_TOLERANCE. */
static void refine(DAQPWorkspace* work) {
  const int n = work->n_active, n_y = work->n;
  double r[MOST_Y + N_TAU + 1];
  for (int i = 0; i < n; i++) {
    const int row = work->WS[i];
    const double* m = work->M + row * n_y;
    r[i] = (work->sense[row] & LOWER) ? work->dlower[row] : work->dupper[row];
    for (int j = 0; j < n_y; j++) r[i] -= m[j] * work->u[j];
    if (work->sense[row] & SOFT) /* what it lacks, in DAQP's scale of the row */
      r[i] += work->settings->rho_soft * work->scaling[row] * work->scaling[row] * work->lam_star[i];
    for (int j = 0; j < i; j++) r[i] -= work->L[ARSUM(i) + j] * r[j];
  }
  for (int i = n - 1; i >= 0; i--) {
    r[i] /= work->D[i];
    for (int k = i + 1; k < n; k++) r[i] -= work->L[ARSUM(k) + i] * r[k];
    add_multiple(n_y, r[i], work->M + work->WS[i] * n_y, work->u);
    work->lam_star[i] -= r[i]; /* u = -M^T lam_star */
  }
}

/* Soft rows add what they lack to the multipliers, and rounding with it. */
#define REFINEMENTS 4

static int solve_inequalities(struct tick* t) {
  const int flag = daqp_ldp(&t->work);
  if (flag > 0) {
    for (int i = 0; i < (flag == EXIT_OPTIMAL ? 1 : REFINEMENTS); i++) refine(&t->work);
    expand_metric(&t->reduced, t->work.u, t->x);
    evaluate_rows(t);
    /* DAQP judges rows in the metric of the cost; what counts is newtons */
    if (!is_inside(t, LIMIT_TOLERANCE)) return PASSED;
  }
  return flag;
}

static int solve_from_the_start(struct tick* t) {
  return prepare_inequalities(t) < 0 ? EXIT_INFEASIBLE : solve_inequalities(t);
}

/* A joint keeps only what has not yielded. */
static void let_go(struct tick* t, int i) {
  const int row = N_V - N_TAU + i;
  t->reduced.lower[i] += t->least[i] - t->lower[row];
  t->reduced.upper[i] += t->most[i] - t->upper[row];
  t->lower[row] = t->least[i];
  t->upper[row] = t->most[i];
}

/* Let those go that pass a bound that has not yielded. Returns how many. */
static int let_passing_go(struct tick* t) {
  int passing = 0;
  for (int i = 0; i < N_TAU; i++) {
    if (!is_narrower(t, i) ||
        is_between(t->x[N_V - N_TAU + i], t->least[i], t->most[i], LIMIT_TOLERANCE))
      continue;
    let_go(t, i);
    passing++;
  }
  return passing;
}

static int count_narrower(const struct tick* t) {
  int count = 0;
  for (int i = 0; i < N_TAU; i++) count += is_narrower(t, i);
  return count;
}

/* Solve; where that fails let the bounds by velocity yield, then those by position: see
 * joint_acceleration.py. */
static int solve_in_order(struct tick* t, const double* request) {
  int flag = solve_from_the_start(t), iterations = t->work.iterations;
  for (enum yielding y = YIELDING_VELOCITY; flag < 0 && y <= YIELDING_POSITION; y++) {
    bound_accelerations(&t->limits, request + REQUEST_ACCELERATION, y, t->least, t->most);
    if (count_narrower(t) == 0) continue; /* the same problem again */
    do {
      flag = solve_from_the_start(t);
      iterations += t->work.iterations;
    } while (flag == PASSED && let_passing_go(t));
  }
  if (flag < 0 && count_narrower(t)) {
    for (int i = 0; i < N_TAU; i++) let_go(t, i);
    flag = solve_from_the_start(t);
    iterations += t->work.iterations;
  }
  t->work.iterations = iterations;
  return flag;
}

static void fill_solution(const struct tick* t, const double* request, int n_active,
                          double* reply) {
  for (int i = 0; i < N_TAU; i++)
    reply[REPLY_TAU + i] = t->h_a[i] + t->rows[N_GENERAL - N_TAU + i];
  memcpy(reply + REPLY_QDD, t->x, N_V * sizeof(double));
  /* what a contact does not carry stays zero */
  for (int i = 0; i < N_FORCE_PLACES; i++)
    reply[REPLY_WRENCHES + force_places[i]] = t->x[N_V + i];
  double* active = reply + REPLY_ACTIVE;
  for (int i = 0; i < N_EQUALITIES; i++) active[N_V + i] = t->reduced.dependent[i] ? 9.0 : 2.0;
  for (int i = 0; i < n_active; i++) {
    const int row = t->work.WS[i];
    const int named = row < N_TAU ? N_V - N_TAU + row : N_V + N_EQUALITIES + row - N_TAU;
    active[named] = (t->work.sense[row] & LOWER) ? -1.0 : 1.0;
  }
  for (int i = 0; i < N_TAU; i++) {
    const int row = N_V - N_TAU + i;
    active[row] = state_of_joint(&t->limits, request, i, t->x[row], t->lower[row],
                                 t->upper[row], active[row]);
    double* torque = active + N_ROWS - N_TAU + i;
    *torque = state_of_torque(*torque, request[REQUEST_V + row], request[REQUEST_TORQUE + i],
                              request[REQUEST_STALL_TORQUE + i],
                              request[REQUEST_NO_LOAD_SPEED + i]);
  }
}

static void answer_safely(struct tick* t, const double* request, double* reply) {
  memset(reply + REPLY_QDD, 0, (N_V + N_WRENCHES) * sizeof(double));
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

  memset(reply, 0, N_REPLY * sizeof(double));
  const double start = microseconds();
  const int finite = evaluate_data(t, request) == 0;
  const double evaluated = microseconds();

  enum status status = STATUS_NOT_FINITE;
  double factorized = evaluated;
  int n_active = 0;
  if (finite) {
    int flag = NOT_REPRESENTABLE;
    if (eliminate(t->A, t->lower + N_V, &t->reduced) == 0) {
      reduce_cost(t->H_qdd, t->H_lambda, t->g, &t->reduced);
      flag = EXIT_NONCONVEX;
      if (solve_unconstrained(&t->reduced, t->x) == 0) {
        evaluate_rows(t);
        memcpy(t->least, t->lower + N_V - N_TAU, sizeof t->least);
        memcpy(t->most, t->upper + N_V - N_TAU, sizeof t->most);
        flag = EXIT_OPTIMAL;
        if (!is_inside(t, 0.0)) {
          reduce_rows(t->A, t->lower, t->upper, &t->reduced);
          flag = 0;
        }
      }
    }
    factorized = microseconds();
    if (flag == 0) {
      flag = solve_in_order(t, request);
      reply[REPLY_ITERATIONS] = (double)t->work.iterations;
      n_active = t->work.n_active;
    }
    status = status_of(flag);
    const int asked = request[REQUEST_EXPLAIN] != 0.0;
    if (status == STATUS_ITERATION_LIMIT || (flag == EXIT_INFEASIBLE && asked)) {
      /* DAQP gives up on some problems without a solution, some 5 % of G1's */
      double* conflict = reply + REPLY_CONFLICT;
      if (find_conflict(t->reduced.n_y, t->reduced.x_0, t->reduced.Z, t->A, t->lower, t->upper,
                        &t->conflict, conflict))
        status = STATUS_INFEASIBLE;
      if (!asked) memset(conflict, 0, N_ROWS * sizeof(double));
    }
  }
  if (status == STATUS_OK) {
    fill_solution(t, request, n_active, reply);
    if (!all_finite(reply + REPLY_TAU, N_TAU + N_V + N_WRENCHES)) status = STATUS_NOT_FINITE;
  }
  const double solved = microseconds();
  if (status != STATUS_OK) answer_safely(t, request, reply);
  if (all_finite(t->error, N_ERROR) && all_finite(t->feedback, N_ERROR)) {
    memcpy(reply + REPLY_ERROR, t->error, N_ERROR * sizeof(double));
    memcpy(reply + REPLY_FEEDBACK, t->feedback, N_ERROR * sizeof(double));
  }
  reply[REPLY_STATUS] = (double)status;
  reply[REPLY_DATA_TIME] = evaluated - start;
  reply[REPLY_FACTORIZATION_TIME] = factorized - evaluated;
  reply[REPLY_SOLVE_TIME] = solved - factorized;
  return 0;
}
