/* What the parts of the tick share. The sizes come from problem.h. */
#ifndef TSD_TICK_H
#define TSD_TICK_H

#include "problem.h"

#define N_Y (N_X - N_EQUALITIES) /* where no equality follows from others */
#define MOST_Y N_X
#define N_INEQUALITIES (N_GENERAL - N_EQUALITIES)
#define N_REDUCED (N_TAU + N_INEQUALITIES)
#define N_ROWS (N_V + N_GENERAL)

struct posture_work {
  double G[N_J * N_J], Y[N_J * N_V];
  double J[N_J * N_V], root[N_J]; /* rows in order, roots of their levels */
  double N[N_V * N_V], WN[N_V * N_V], P[N_V * N_V];
};

/* The QP in y, (n_y,), where x = x_0 + Z y satisfies the equalities. */
struct elimination {
  double ET[N_X * N_EQUALITIES], v[(N_EQUALITIES + 1) * N_X], beta[N_EQUALITIES];
  int dependent[N_EQUALITIES];      /* does the row follow from others, or nearly so? */
  int n_pivots, row[N_EQUALITIES];  /* of E, of each reflection; the last are of rows that */
  double held[N_EQUALITIES];        /* are held by this share only, and have a y each */
  int n_y;
  double x_0[N_X], Z[N_X * MOST_Y];
  double HZ[N_X * MOST_Y], Hx_g[N_X];
  double H[MOST_Y * MOST_Y], g[MOST_Y];
  double U[MOST_Y * MOST_Y], v_g[MOST_Y]; /* U^T U = H, v_g = U^-T g */
  double AZ[MOST_Y * N_REDUCED], scale;
  double A[N_REDUCED * MOST_Y], lower[N_REDUCED], upper[N_REDUCED];
};

/* What velocity and position ask of the joints' accelerations: infinite where they are
 * switched off, and beyond the acceleration limit where they ask for more than there is. */
struct joint_limits {
  double velocity_lower[N_TAU], velocity_upper[N_TAU];
  double position_lower[N_TAU], position_upper[N_TAU];
};

/* Who has yielded to the other limits, in this order. */
enum yielding { YIELDING_NOTHING, YIELDING_VELOCITY, YIELDING_POSITION };

/* Bounds of the joints' accelerations by what has not yielded; as joint_acceleration.py. */
void bound_accelerations(const struct joint_limits* s, const double* limit, enum yielding yielding,
                         double* lower, double* upper);

/* What the reply says of a joint's row, which is at a bound (-1, 1) or not (0). */
double state_of_joint(const struct joint_limits* s, const double* request, int i, double qdd,
                      double lower, double upper, double at);

/* What the reply says of a joint's torque, which is at a bound (-1, 1) or not (0): whether the
 * speed v makes it, as torque_speed.py. */
double state_of_torque(double at, double v, double limit, double stall, double no_load);

/* each limit from above and from below */
#define N_SIDES (2 * N_REDUCED)
/* bounds beyond this are none, as in explanation/reduced_rows.py */
#define UNBOUNDED 1e29

/* What has become of a column. */
enum column_state { FREE, USED, BANNED };

/* Non-negative least squares under way; columns are sides of limits. */
struct least_squares {
  double E[(N_X + 1) * N_SIDES], e[N_X + 1];
  double length[N_SIDES], scale[N_SIDES], sign[N_SIDES];
  int row[N_SIDES];
  unsigned char state[N_SIDES];
  int n_rows, n_columns, n_used, used[N_X + 1];
  double u[N_X + 1]; /* of those in use */
};

struct conflict_work {
  struct least_squares now, before;
};

/* Limits that cannot hold together where x = x_0 + Z y, Z (N_X, n_y): conflict gets by how much
 * each of them would have to give way alone, negative at a lower bound, the other rows are left as
 * they are. A (N_GENERAL, N_X) by columns. Returns 1, or 0 if they can hold together. */
int find_conflict(int n_y, const double* x_0, const double* Z, const double* A,
                  const double* lower, const double* upper, struct conflict_work* work,
                  double* conflict);

/* H_qdd (N_V, N_V) and g_qdd gain the posture; J (N_J, N_V) by columns, its rows zero where
 * their level, from 0 to 1, is 0.
 * Returns 0, or -1 if the numbers are not finite. */
int add_posture(const double* J, const double* level, const double* W_q, const double* qdd_des,
                struct posture_work* work, double* H_qdd, double* g_qdd);

/* x_0 and Z from the first rows of A (N_GENERAL, N_X, by columns) and their
 * right-hand side e, and which rows depend on others. Returns 0, or -1 if the numbers
 * are too large. */
int eliminate(const double* A, const double* e, struct elimination* s);

/* H and g in y. */
void reduce_cost(const double* H_qdd, const double* H_lambda, const double* g,
                 struct elimination* s);

/* The optimum without inequalities. Returns 0, or -1 if H is not positive
 * definite. */
int solve_unconstrained(struct elimination* s, double* x);

/* x = x_0 + Z y */
void expand(const struct elimination* s, const double* y, double* x);

/* Inequalities and their bounds in u = (U y + v_g) / scale, where the cost is
 * |u|^2: N_TAU joint accelerations, then the rows of A after the equalities.
 * Comes after solve_unconstrained. */
void reduce_rows(const double* A, const double* lower, const double* upper,
                 struct elimination* s);

/* x of a point u */
void expand_metric(const struct elimination* s, const double* u, double* x);

#endif
