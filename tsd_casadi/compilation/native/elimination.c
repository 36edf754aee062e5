/* Exact elimination of the equalities E x = e.
 *
 * Householder reflections make Q^T E^T = [R; 0], a row of E at a time. The first
 * columns of Q carry a particular solution x_0, the others a basis Z of the null
 * space of E:
 *
 *   x = x_0 + Z y,   H_y = Z^T H Z,   g_y = Z^T (H x_0 + g).
 *
 * A row that follows from those before it makes no reflection; one that nearly does
 * makes the last ones and keeps a column in Z: see dependent_rows.py. So y has N_Y
 * numbers in nearly every tick, and the loops are compiled for that, and once more for
 * any other number.
 */
#include <string.h>

#include "dense.h"
#include "problem.h"
#include "tick.h"

/* every body below is compiled twice */
#define FOR_ANY_SIZE static inline __attribute__((always_inline))
#define CALL(function, s, ...) \
  ((s)->n_y == N_Y ? function(N_Y, s, __VA_ARGS__) : function((s)->n_y, s, __VA_ARGS__))

/* Apply reflection k, I - beta v v^T, to the m columns of B (N_X, m). */
static inline void reflect(int k, const struct elimination* s, int m, double* restrict B) {
  double w[N_X];
  memset(w, 0, (size_t)m * sizeof(double));
  const double* restrict v = s->v + k * N_X;
  for (int r = k; r < N_X; r++) add_multiple(m, v[r], B + r * m, w);
  for (int r = k; r < N_X; r++) add_multiple(m, -s->beta[k] * v[r], w, B + r * m);
}

/* Make reflection k of row i of E and apply it to E^T. */
static inline void pivot(int k, int i, double norm, struct elimination* s) {
  double* restrict v = s->v + k * N_X;
  const double alpha = v[k] > 0.0 ? -norm : norm;
  v[k] -= alpha;
  s->beta[k] = 1.0 / (norm * fabs(v[k])); /* 2 / v^T v */
  s->row[k] = i;
  reflect(k, s, N_EQUALITIES, s->ET);
}

/* What row i of E has beside the first k reflections, into the place of the next one. */
static inline double rest_of_row(int k, int i, struct elimination* s) {
  double* restrict v = s->v + k * N_X;
  double norm = 0.0;
  for (int r = k; r < N_X; r++) {
    v[r] = s->ET[r * N_EQUALITIES + i];
    norm += v[r] * v[r];
  }
  return sqrt(norm);
}

FOR_ANY_SIZE int make_basis(int n_y, struct elimination* s, const double* e) {
  /* R^T u = e, with R in the first rows of the reflected E^T */
  memset(s->x_0, 0, sizeof s->x_0);
  for (int k = 0; k < s->n_pivots; k++) {
    const int i = s->row[k];
    double sum = e[i];
    for (int j = 0; j < k; j++) sum -= s->ET[j * N_EQUALITIES + i] * s->x_0[j];
    s->x_0[k] = sum / s->ET[k * N_EQUALITIES + i];
  }
  memset(s->Z, 0, (size_t)(N_X * n_y) * sizeof(double));
  for (int j = 0; j < n_y; j++) s->Z[(N_X - n_y + j) * n_y + j] = 1.0;
  for (int j = 0; j < s->n_pivots - (N_X - n_y); j++)
    s->Z[(N_X - n_y + j) * n_y + j] = sqrt(1.0 - s->held[j]);
  for (int k = s->n_pivots - 1; k >= 0; k--) {
    reflect(k, s, 1, s->x_0);
    reflect(k, s, n_y, s->Z);
  }
  return 0;
}

int eliminate(const double* A, const double* e, struct elimination* s) {
  /* A comes by columns: row r of E^T is column r of A */
  double norms[N_EQUALITIES];
  memset(norms, 0, sizeof norms);
  for (int r = 0; r < N_X; r++) {
    const double* restrict row = A + r * N_GENERAL;
    memcpy(s->ET + r * N_EQUALITIES, row, N_EQUALITIES * sizeof(double));
    for (int i = 0; i < N_EQUALITIES; i++) norms[i] += row[i] * row[i];
  }
  int k = 0, n_near = 0, near[N_EQUALITIES];
  for (int i = 0; i < N_EQUALITIES; i++) {
    const double norm = rest_of_row(k, i, s), whole = sqrt(norms[i]);
    if (!(whole < INFINITY)) return -1;
    s->dependent[i] = !(norm >= INDEPENDENT * whole);
    if (!s->dependent[i])
      pivot(k++, i, norm, s);
    else
      near[n_near++] = i;
  }
  s->n_y = N_X - k;
  for (int j = 0; j < n_near; j++) {
    const double norm = rest_of_row(k, near[j], s);
    const double held = (norm / sqrt(norms[near[j]]) - DEPENDENT) / (INDEPENDENT - DEPENDENT);
    if (!(held > 0.0)) continue;
    s->held[k - (N_X - s->n_y)] = fmin(held, 1.0);
    pivot(k++, near[j], norm, s);
  }
  s->n_pivots = k;
  return CALL(make_basis, s, e);
}

FOR_ANY_SIZE void reduce_cost_to(int n_y, struct elimination* s, const double* H_qdd,
                                 const double* H_lambda, const double* g) {
  memset(s->HZ, 0, (size_t)(N_X * n_y) * sizeof(double));
  memcpy(s->Hx_g, g, sizeof s->Hx_g);
  add_transposed_product(N_V, N_V, n_y, 1.0, H_qdd, s->Z, s->HZ); /* H_qdd is symmetric */
  for (int r = 0; r < N_V; r++) add_multiple(N_V, s->x_0[r], H_qdd + r * N_V, s->Hx_g);
  for (int r = N_V; r < N_X; r++) {
    add_multiple(n_y, H_lambda[r - N_V], s->Z + r * n_y, s->HZ + r * n_y);
    s->Hx_g[r] += H_lambda[r - N_V] * s->x_0[r];
  }
  memset(s->H, 0, (size_t)(n_y * n_y) * sizeof(double));
  memset(s->g, 0, (size_t)n_y * sizeof(double));
  add_transposed_product(N_X, n_y, n_y, 1.0, s->Z, s->HZ, s->H);
  for (int r = 0; r < N_X; r++) add_multiple(n_y, s->Hx_g[r], s->Z + r * n_y, s->g);
  for (int j = 0; j < s->n_pivots - (N_X - n_y); j++)
    s->H[j * n_y + j] += HOLDING_WEIGHT * s->held[j] * s->held[j] * s->held[j];
}

void reduce_cost(const double* H_qdd, const double* H_lambda, const double* g,
                 struct elimination* s) {
  CALL(reduce_cost_to, s, H_qdd, H_lambda, g);
}

FOR_ANY_SIZE void expand_from(int n_y, const struct elimination* s, const double* y, double* x) {
  for (int r = 0; r < N_X; r++) {
    double sum = s->x_0[r];
    for (int j = 0; j < n_y; j++) sum += s->Z[r * n_y + j] * y[j];
    x[r] = sum;
  }
}

void expand(const struct elimination* s, const double* y, double* x) {
  CALL(expand_from, s, y, x);
}

FOR_ANY_SIZE int solve_unconstrained_in(int n_y, struct elimination* s, double* x) {
  memcpy(s->U, s->H, (size_t)(n_y * n_y) * sizeof(double));
  if (cholesky(n_y, s->U)) return -1;
  memcpy(s->v_g, s->g, (size_t)n_y * sizeof(double));
  solve_transposed(n_y, s->U, 1, s->v_g);
  double y[MOST_Y];
  for (int i = 0; i < n_y; i++) y[i] = -s->v_g[i];
  solve_upper(n_y, s->U, y);
  expand_from(n_y, s, y, x);
  return 0;
}

int solve_unconstrained(struct elimination* s, double* x) {
  return CALL(solve_unconstrained_in, s, x);
}

FOR_ANY_SIZE void reduce_rows_to(int n_y, struct elimination* s, const double* A,
                                 const double* lower, const double* upper) {
  /* the cost's scale, so that the rows have a size that DAQP can judge */
  double largest = 0.0;
  for (int i = 0; i < n_y; i++) largest = fmax(largest, s->H[i * n_y + i]);
  s->scale = sqrt(largest);

  /* A Z by columns: the joints' simple bounds, then the general inequalities */
  double offset[N_REDUCED];
  memset(offset, 0, sizeof offset);
  memset(s->AZ, 0, (size_t)(n_y * N_REDUCED) * sizeof(double));
  memcpy(offset, s->x_0 + N_V - N_TAU, N_TAU * sizeof(double));
  for (int j = 0; j < n_y; j++) {
    double* column = s->AZ + j * N_REDUCED;
    for (int i = 0; i < N_TAU; i++) column[i] = s->Z[(N_V - N_TAU + i) * n_y + j];
    for (int r = 0; r < N_X; r++)
      add_multiple(N_INEQUALITIES, s->Z[r * n_y + j], A + r * N_GENERAL + N_EQUALITIES,
                   column + N_TAU);
  }
  for (int r = 0; r < N_X; r++)
    add_multiple(N_INEQUALITIES, s->x_0[r], A + r * N_GENERAL + N_EQUALITIES, offset + N_TAU);

  /* in the metric of the cost, u = (U y + v_g) / scale */
  solve_transposed(n_y, s->U, N_REDUCED, s->AZ);
  for (int j = 0; j < n_y; j++)
    add_multiple(N_REDUCED, -s->v_g[j], s->AZ + j * N_REDUCED, offset);
  for (int i = 0; i < N_REDUCED; i++) {
    for (int j = 0; j < n_y; j++) s->A[i * n_y + j] = s->scale * s->AZ[j * N_REDUCED + i];
    const int row = i < N_TAU ? N_V - N_TAU + i : N_V + N_EQUALITIES + i - N_TAU;
    s->lower[i] = lower[row] - offset[i];
    s->upper[i] = upper[row] - offset[i];
  }
}

void reduce_rows(const double* A, const double* lower, const double* upper,
                 struct elimination* s) {
  CALL(reduce_rows_to, s, A, lower, upper);
}

void expand_metric(const struct elimination* s, const double* u, double* x) {
  double y[MOST_Y];
  for (int i = 0; i < s->n_y; i++) y[i] = s->scale * u[i] - s->v_g[i];
  solve_upper(s->n_y, s->U, y);
  expand(s, y, x);
}
