/* The posture's share of the cost, posture.py in C:
 *
 *   P_null = I - J^T (J J^T + delta I)^-1 J,   H += P_null^T W_q P_null,
 *   g -= P_null^T W_q P_null qdd_des.
 *
 * With G = J J^T + delta I = U^T U and Y = U^-T J, P_null = I - Y^T Y. The first i rows of
 * Y belong to the first i of J alone. So with rows in the order of falling levels s,
 * P_null = I - Y^T diag(s) Y is what null_space_posture.py makes of rows in between.
 */
#include <string.h>

#include "dense.h"
#include "problem.h"
#include "tick.h"

/* Is a row on its way in or out? Rows that are not there are zero, wherever they stand. */
static int is_blending(const double* level) {
  int count = 0;
  for (int i = 0; i < N_J; i++) count += level[i] > 0.0 && level[i] < 1.0;
  return count > 0;
}

/* Put rows into the order of falling levels, equal ones as they were; few move, so
 * insertion is quick. */
static void put_in_order(const double* J, const double* level, struct posture_work* work) {
  int order[N_J];
  for (int i = 0; i < N_J; i++) {
    int place = i;
    for (; place > 0 && level[order[place - 1]] < level[i]; place--)
      order[place] = order[place - 1];
    order[place] = i;
  }
  for (int i = 0; i < N_J; i++) work->root[i] = sqrt(level[order[i]]);
  for (int k = 0; k < N_V; k++)
    for (int i = 0; i < N_J; i++) work->J[k * N_J + i] = J[k * N_J + order[i]];
}

int add_posture(const double* J, const double* level, const double* W_q, const double* qdd_des,
                struct posture_work* work, double* H_qdd, double* g_qdd) {
  const int blending = is_blending(level);
  if (blending) {
    put_in_order(J, level, work);
    J = work->J;
  }
  /* J comes by columns: column k of J is row k of J^T */
  memset(work->G, 0, sizeof work->G);
  add_transposed_product(N_V, N_J, N_J, 1.0, J, J, work->G);
  for (int i = 0; i < N_J; i++) work->G[i * N_J + i] += POSTURE_DAMPING;
  if (cholesky(N_J, work->G)) return -1;
  for (int i = 0; i < N_J; i++)
    for (int k = 0; k < N_V; k++) work->Y[i * N_V + k] = J[k * N_J + i];
  solve_transposed(N_J, work->G, N_V, work->Y);
  if (blending)
    for (int i = 0; i < N_J; i++)
      for (int k = 0; k < N_V; k++) work->Y[i * N_V + k] *= work->root[i];

  memset(work->N, 0, sizeof work->N);
  add_transposed_product(N_J, N_V, N_V, -1.0, work->Y, work->Y, work->N);
  for (int i = 0; i < N_V; i++) work->N[i * N_V + i] += 1.0;
  for (int i = 0; i < N_V; i++)
    for (int j = 0; j < N_V; j++) work->WN[i * N_V + j] = W_q[i] * work->N[i * N_V + j];
  memset(work->P, 0, sizeof work->P);
  add_transposed_product(N_V, N_V, N_V, 1.0, work->N, work->WN, work->P);

  for (int i = 0; i < N_V * N_V; i++) H_qdd[i] += work->P[i];
  for (int i = 0; i < N_V; i++) add_multiple(N_V, -qdd_des[i], work->P + i * N_V, g_qdd);
  return 0;
}
