/* Which limits contradict each other; explanation/conflict.py in C, which has the reasons.
 *
 * Non-negative least squares, min |E u - e| over u >= 0 with the columns [G^T; h^T] of E and
 * e = [0; -1], by Lawson and Hanson's active set (Solving Least Squares Problems, 1974,
 * chapter 23). Householder reflections keep the columns in use triangular. Rows
 * of E run along the limits, so that a reflection of all columns vectorises.
 */
#include <string.h>

#include "dense.h"
#include "problem.h"
#include "tick.h"

/* as in least_distance.py */
#define FARTHEST 1e7
#define NO_COEFFICIENTS 1e-9
#define NEGLIGIBLE 1e-12
#define STEPS 30
/* as in conflict.py */
#define UNIT 1e3
#define PREFERRED 100.0
/* of a column's length: what is left of it counts as rounding, and so does its gradient */
#define ROUNDING 1e-12

/* Apply I - beta v v^T to rows k.. of all columns and of e. */
static void reflect_columns(int k, const double* v, double beta, struct least_squares* s) {
  double w[N_SIDES], sum = 0.0;
  memset(w, 0, (size_t)s->n_columns * sizeof(double));
  for (int r = k; r < s->n_rows; r++) {
    add_multiple(s->n_columns, v[r], s->E + r * N_SIDES, w);
    sum += v[r] * s->e[r];
  }
  for (int r = k; r < s->n_rows; r++) {
    add_multiple(s->n_columns, -beta * v[r], w, s->E + r * N_SIDES);
    s->e[r] -= beta * v[r] * sum;
  }
}

/* Take a column in as the last one in use. Returns 0 if it depends on those before, or if its
 * multiplier would not be positive. */
static int take(int column, struct least_squares* s) {
  const int k = s->n_used;
  double v[N_X + 1], norm = 0.0, along = 0.0;
  for (int r = k; r < s->n_rows; r++) {
    v[r] = s->E[r * N_SIDES + column];
    norm += v[r] * v[r];
    along += v[r] * s->e[r];
  }
  norm = sqrt(norm);
  if (!(norm > ROUNDING * s->length[column]) || !(along > 0.0)) return 0;
  v[k] += v[k] > 0.0 ? norm : -norm;
  reflect_columns(k, v, 1.0 / (norm * fabs(v[k])), s);
  s->used[k] = column;
  s->u[k] = 0.0;
  s->state[column] = USED;
  s->n_used++;
  return 1;
}

/* Take the k-th column in use out; rotations make the others triangular again. */
static void drop(int k, struct least_squares* s) {
  s->state[s->used[k]] = FREE;
  s->n_used--;
  for (int i = k; i < s->n_used; i++) {
    s->used[i] = s->used[i + 1];
    s->u[i] = s->u[i + 1];
    double* restrict upper = s->E + i * N_SIDES;
    double* restrict lower = upper + N_SIDES;
    const double a = upper[s->used[i]], b = lower[s->used[i]], norm = hypot(a, b);
    const double c = a / norm, d = b / norm;
    for (int j = 0; j < s->n_columns; j++) {
      const double x = upper[j], y = lower[j];
      upper[j] = c * x + d * y;
      lower[j] = c * y - d * x;
    }
    const double x = s->e[i], y = s->e[i + 1];
    s->e[i] = c * x + d * y;
    s->e[i + 1] = c * y - d * x;
  }
}

/* Go to the least squares of the columns in use; whichever would turn negative on the way is
 * dropped. */
static void settle(struct least_squares* s) {
  for (;;) {
    double z[N_X + 1], share = 1.0;
    int first = -1;
    for (int i = s->n_used - 1; i >= 0; i--) {
      double sum = s->e[i];
      for (int j = i + 1; j < s->n_used; j++) sum -= s->E[i * N_SIDES + s->used[j]] * z[j];
      z[i] = sum / s->E[i * N_SIDES + s->used[i]];
    }
    for (int i = 0; i < s->n_used; i++) {
      if (z[i] > 0.0) continue;
      const double way = s->u[i] / (s->u[i] - z[i]);
      if (first < 0 || way < share) {
        share = way;
        first = i;
      }
    }
    for (int i = 0; i < s->n_used; i++) s->u[i] += share * (z[i] - s->u[i]);
    if (first < 0) return;
    drop(first, s);
  }
}

static double residual(const struct least_squares* s) {
  double sum = 0.0;
  for (int r = s->n_used; r < s->n_rows; r++) sum += s->e[r] * s->e[r];
  return sqrt(sum);
}

/* The free column along which the residual shrinks most, -1 if there is none. */
static int steepest(const struct least_squares* s, const unsigned char* refused) {
  double w[N_SIDES], most = 0.0;
  int column = -1;
  memset(w, 0, (size_t)s->n_columns * sizeof(double));
  for (int r = s->n_used; r < s->n_rows; r++)
    add_multiple(s->n_columns, s->e[r], s->E + r * N_SIDES, w);
  for (int j = 0; j < s->n_columns; j++)
    if (s->state[j] == FREE && !refused[j] && w[j] > most && w[j] > ROUNDING * s->length[j]) {
      most = w[j];
      column = j;
    }
  return column;
}

/* Go on from what is in use. Returns whether the limits that are not banned contradict each
 * other: then u proves it. */
static int prove(struct least_squares* s) {
  unsigned char refused[N_SIDES];
  memset(refused, 0, sizeof refused);
  settle(s);
  for (int step = 0; step < STEPS * s->n_columns; step++) {
    if (residual(s) * FARTHEST < 1.0) return 1;
    const int column = steepest(s, refused);
    if (column < 0) return 0;
    if (take(column, s)) {
      settle(s);
      memset(refused, 0, sizeof refused);
    } else {
      refused[column] = 1;
    }
  }
  return 0;
}

/* E of one side of a limit, g y <= h; its length is 1 but for h, or PREFERRED. */
static void add_side(int row, double sign, const double* g, double norm, double h,
                     struct least_squares* s) {
  const int column = s->n_columns++, last = s->n_rows - 1;
  const double weight = row < N_V ? PREFERRED : 1.0;
  const double scale = weight / (norm > 0.0 ? norm : 1.0), bound = scale * h / UNIT;
  for (int j = 0; j < last; j++) s->E[j * N_SIDES + column] = norm > 0.0 ? sign * scale * g[j] : 0.0;
  s->E[last * N_SIDES + column] = bound;
  s->length[column] = sqrt((norm > 0.0 ? weight * weight : 0.0) + bound * bound);
  s->scale[column] = scale;
  s->row[column] = row;
  s->sign[column] = sign;
  s->state[column] = FREE;
}

/* Sides that are there, upper ones first. */
static void add_sides(int n_y, const double* x_0, const double* Z, const double* A,
                      const double* lower, const double* upper, struct least_squares* s) {
  double G[N_REDUCED * (N_X + 1)], there[N_REDUCED], norm[N_REDUCED], largest = 0.0;
  for (int i = 0; i < N_REDUCED; i++) {
    double* restrict g = G + i * n_y;
    memset(g, 0, (size_t)n_y * sizeof(double));
    there[i] = 0.0;
    for (int r = 0; r < N_X; r++) {
      const double a = i < N_TAU ? (r == N_V - N_TAU + i) : A[r * N_GENERAL + N_EQUALITIES + i - N_TAU];
      if (a == 0.0) continue;
      add_multiple(n_y, a, Z + r * n_y, g);
      there[i] += a * x_0[r];
    }
    double sum = 0.0;
    for (int j = 0; j < n_y; j++) sum += g[j] * g[j];
    norm[i] = sqrt(sum);
    largest = fmax(largest, norm[i]);
  }
  for (int side = 1; side >= -1; side -= 2)
    for (int i = 0; i < N_REDUCED; i++) {
      const int row = i < N_TAU ? N_V - N_TAU + i : N_V + N_EQUALITIES + i - N_TAU;
      const double bound = side > 0 ? upper[row] : lower[row];
      if (!(side * bound < UNBOUNDED)) continue;
      add_side(row, side, G + i * n_y, norm[i] > NO_COEFFICIENTS * largest ? norm[i] : 0.0,
               side * (bound - there[i]), s);
    }
}

/* Of what is in use and neither a limit of an acceleration nor known to be needed, the one with
 * the smallest multiplier; -1 if there is none. */
static int least_needed(const struct least_squares* s, const unsigned char* needed) {
  int place = -1;
  for (int k = 0; k < s->n_used; k++)
    if (s->row[s->used[k]] >= N_V && !needed[s->used[k]] && (place < 0 || s->u[k] < s->u[place]))
      place = k;
  return place;
}

/* Only limits of accelerations stay at hand besides those in use. */
static void ban_others(struct least_squares* s) {
  for (int j = 0; j < s->n_columns; j++)
    if (s->state[j] == FREE && s->row[j] >= N_V) s->state[j] = BANNED;
}

static void drop_negligible(struct least_squares* s) {
  double most = 0.0;
  for (int k = 0; k < s->n_used; k++) most = fmax(most, s->u[k]);
  for (int k = s->n_used - 1; k >= 0; k--)
    if (s->u[k] < NEGLIGIBLE * most) drop(k, s);
}

int find_conflict(int n_y, const double* x_0, const double* Z, const double* A,
                  const double* lower, const double* upper, struct conflict_work* work,
                  double* conflict) {
  struct least_squares* s = &work->now;
  unsigned char needed[N_SIDES];
  memset(needed, 0, sizeof needed);
  s->n_rows = n_y + 1;
  s->n_columns = s->n_used = 0;
  memset(s->e, 0, sizeof s->e);
  s->e[n_y] = -1.0;
  add_sides(n_y, x_0, Z, A, lower, upper, s);
  if (!prove(s)) return 0;
  drop_negligible(s);
  for (int k; (k = least_needed(s, needed)) >= 0;) {
    const int column = s->used[k];
    ban_others(s);
    work->before = *s;
    drop(k, s);
    s->state[column] = BANNED;
    if (prove(s)) {
      drop_negligible(s);
    } else {
      *s = work->before;
      needed[column] = 1;
    }
  }
  for (int k = 0; k < s->n_used; k++) {
    const int column = s->used[k];
    conflict[s->row[column]] = s->sign[column] * UNIT / (s->scale[column] * s->u[k]);
  }
  return 1;
}
