/* Exact elimination of the equalities E x = e.
 *
 * Householder reflections make Q^T E^T = [R; 0]. The first columns of Q carry a
 * particular solution x_0, the others a basis Z of the null space of E:
 *
 *   x = x_0 + Z y,   H_y = Z^T H Z,   g_y = Z^T (H x_0 + g).
 */
#include <string.h>

#include "dense.h"
#include "problem.h"
#include "tick.h"

/* below this, relative to the first, a diagonal of R counts as zero */
#define RANK_TOLERANCE 1e-10

/* Apply reflection k, I - beta v v^T, to the m columns of B (N_X, m). */
static inline void reflect(int k, const struct elimination* s, int m, double* restrict B) {
  double w[N_X];
  memset(w, 0, (size_t)m * sizeof(double));
  const double* restrict v = s->v + k * N_X;
  for (int r = k; r < N_X; r++) add_multiple(m, v[r], B + r * m, w);
  for (int r = k; r < N_X; r++) add_multiple(m, -s->beta[k] * v[r], w, B + r * m);
}

int eliminate(const double* A, const double* e, struct elimination* s) {
  /* A comes by columns: row r of E^T is column r of A */
  for (int r = 0; r < N_X; r++)
    memcpy(s->ET + r * N_EQUALITIES, A + r * N_GENERAL, N_EQUALITIES * sizeof(double));
  double largest = 0.0;
  for (int k = 0; k < N_EQUALITIES; k++) {
    double* restrict v = s->v + k * N_X;
    double norm = 0.0;
    for (int r = k; r < N_X; r++) {
      v[r] = s->ET[r * N_EQUALITIES + k];
      norm += v[r] * v[r];
    }
    norm = sqrt(norm);
    if (k == 0) largest = norm;
    if (!(norm > RANK_TOLERANCE * largest)) return -1;
    const double alpha = v[k] > 0.0 ? -norm : norm;
    v[k] -= alpha;
    s->beta[k] = 1.0 / (norm * fabs(v[k])); /* 2 / v^T v */
    reflect(k, s, N_EQUALITIES, s->ET);
  }
  /* R^T u = e, with R in the first rows of the reflected E^T */
  memset(s->x_0, 0, sizeof s->x_0);
  for (int i = 0; i < N_EQUALITIES; i++) {
    double sum = e[i];
    for (int j = 0; j < i; j++) sum -= s->ET[j * N_EQUALITIES + i] * s->x_0[j];
    s->x_0[i] = sum / s->ET[i * N_EQUALITIES + i];
  }
  memset(s->Z, 0, sizeof s->Z);
  for (int j = 0; j < N_Y; j++) s->Z[(N_EQUALITIES + j) * N_Y + j] = 1.0;
  for (int k = N_EQUALITIES - 1; k >= 0; k--) {
    reflect(k, s, 1, s->x_0);
    reflect(k, s, N_Y, s->Z);
  }
  return 0;
}

void reduce_cost(const double* H_qdd, const double* H_lambda, const double* g,
                 struct elimination* s) {
  memset(s->HZ, 0, sizeof s->HZ);
  memcpy(s->Hx_g, g, sizeof s->Hx_g);
  add_transposed_product(N_V, N_V, N_Y, 1.0, H_qdd, s->Z, s->HZ); /* H_qdd is symmetric */
  for (int r = 0; r < N_V; r++) add_multiple(N_V, s->x_0[r], H_qdd + r * N_V, s->Hx_g);
  for (int r = N_V; r < N_X; r++) {
    add_multiple(N_Y, H_lambda[r - N_V], s->Z + r * N_Y, s->HZ + r * N_Y);
    s->Hx_g[r] += H_lambda[r - N_V] * s->x_0[r];
  }
  memset(s->H, 0, sizeof s->H);
  memset(s->g, 0, sizeof s->g);
  add_transposed_product(N_X, N_Y, N_Y, 1.0, s->Z, s->HZ, s->H);
  for (int r = 0; r < N_X; r++) add_multiple(N_Y, s->Hx_g[r], s->Z + r * N_Y, s->g);
}

int solve_unconstrained(struct elimination* s, double* x) {
  memcpy(s->U, s->H, sizeof s->U);
  if (cholesky(N_Y, s->U)) return -1;
  memcpy(s->v_g, s->g, sizeof s->v_g);
  solve_transposed(N_Y, s->U, 1, s->v_g);
  double y[N_Y];
  for (int i = 0; i < N_Y; i++) y[i] = -s->v_g[i];
  solve_upper(N_Y, s->U, y);
  expand(s, y, x);
  return 0;
}

void expand(const struct elimination* s, const double* y, double* x) {
  for (int r = 0; r < N_X; r++) {
    double sum = s->x_0[r];
    for (int j = 0; j < N_Y; j++) sum += s->Z[r * N_Y + j] * y[j];
    x[r] = sum;
  }
}

void reduce_rows(const double* A, const double* lower, const double* upper,
                 struct elimination* s) {
  /* the cost's scale, so that the rows have a size that DAQP can judge */
  double largest = 0.0;
  for (int i = 0; i < N_Y; i++) largest = fmax(largest, s->H[i * N_Y + i]);
  s->scale = sqrt(largest);

  /* A Z by columns: the joints' simple bounds, then the general inequalities */
  double offset[N_REDUCED];
  memset(offset, 0, sizeof offset);
  memset(s->AZ, 0, sizeof s->AZ);
  memcpy(offset, s->x_0 + N_V - N_TAU, N_TAU * sizeof(double));
  for (int j = 0; j < N_Y; j++) {
    double* column = s->AZ + j * N_REDUCED;
    for (int i = 0; i < N_TAU; i++) column[i] = s->Z[(N_V - N_TAU + i) * N_Y + j];
    for (int r = 0; r < N_X; r++)
      add_multiple(N_INEQUALITIES, s->Z[r * N_Y + j], A + r * N_GENERAL + N_EQUALITIES,
                   column + N_TAU);
  }
  for (int r = 0; r < N_X; r++)
    add_multiple(N_INEQUALITIES, s->x_0[r], A + r * N_GENERAL + N_EQUALITIES, offset + N_TAU);

  /* in the metric of the cost, u = (U y + v_g) / scale */
  solve_transposed(N_Y, s->U, N_REDUCED, s->AZ);
  for (int j = 0; j < N_Y; j++)
    add_multiple(N_REDUCED, -s->v_g[j], s->AZ + j * N_REDUCED, offset);
  for (int i = 0; i < N_REDUCED; i++) {
    for (int j = 0; j < N_Y; j++) s->A[i * N_Y + j] = s->scale * s->AZ[j * N_REDUCED + i];
    const int row = i < N_TAU ? N_V - N_TAU + i : N_V + N_EQUALITIES + i - N_TAU;
    s->lower[i] = lower[row] - offset[i];
    s->upper[i] = upper[row] - offset[i];
  }
}

void expand_metric(const struct elimination* s, const double* u, double* x) {
  double y[N_Y];
  for (int i = 0; i < N_Y; i++) y[i] = s->scale * u[i] - s->v_g[i];
  solve_upper(N_Y, s->U, y);
  expand(s, y, x);
}
