/* The posture's share of the cost, posture.py in C:
 *
 *   P_null = I - J^T (J J^T + delta I)^-1 J,   H += P_null^T W_q P_null,
 *   g -= P_null^T W_q P_null qdd_des.
 *
 * With G = J J^T + delta I = U^T U and Y = U^-T J, P_null = I - Y^T Y.
 */
#include <string.h>

#include "dense.h"
#include "problem.h"
#include "tick.h"

int add_posture(const double* J, const double* W_q, const double* qdd_des,
                struct posture_work* work, double* H_qdd, double* g_qdd) {
  /* J comes by columns: column k of J is row k of J^T */
  memset(work->G, 0, sizeof work->G);
  add_transposed_product(N_V, N_J, N_J, 1.0, J, J, work->G);
  for (int i = 0; i < N_J; i++) work->G[i * N_J + i] += POSTURE_DAMPING;
  if (cholesky(N_J, work->G)) return -1;
  for (int i = 0; i < N_J; i++)
    for (int k = 0; k < N_V; k++) work->Y[i * N_V + k] = J[k * N_J + i];
  solve_transposed(N_J, work->G, N_V, work->Y);

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
