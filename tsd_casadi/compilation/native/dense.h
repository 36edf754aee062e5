/* Small dense linear algebra with sizes known at compile time.
 *
 * Matrices are stored row by row. Every inner loop runs along a row and adds a
 * multiple of it, so that compilers vectorise without reordering sums.
 */
#ifndef TSD_DENSE_H
#define TSD_DENSE_H

#include <math.h>

/* y += a x */
static inline void add_multiple(int n, double a, const double* restrict x, double* restrict y) {
  for (int i = 0; i < n; i++) y[i] += a * x[i];
}

/* A pivot below these shares of its own and of the largest diagonal is rounding,
 * not information. */
#define OWN_PIVOT_TOLERANCE 1e-11
#define PIVOT_TOLERANCE 1e-11

/* Upper triangular U with U^T U = G, in place of G's upper triangle. Returns 0,
 * or -1 if G is not positive definite (or has NaN). */
static inline int cholesky(int n, double* restrict G) {
  double least[n], largest = 0.0;
  for (int k = 0; k < n; k++) largest = fmax(largest, G[k * n + k]);
  for (int k = 0; k < n; k++)
    least[k] = fmax(OWN_PIVOT_TOLERANCE * G[k * n + k], PIVOT_TOLERANCE * largest);
  for (int k = 0; k < n; k++) {
    double* restrict row = G + k * n;
    if (!(row[k] > 0.0 && row[k] >= least[k])) return -1;
    const double inverse = 1.0 / sqrt(row[k]);
    for (int j = k; j < n; j++) row[j] *= inverse;
    for (int i = k + 1; i < n; i++) add_multiple(n - i, -row[i], row + i, G + i * n + i);
  }
  return 0;
}

/* B <- U^-T B for B with m columns. */
static inline void solve_transposed(int n, const double* restrict U, int m,
                                    double* restrict B) {
  for (int k = 0; k < n; k++) {
    const double inverse = 1.0 / U[k * n + k];
    for (int j = 0; j < m; j++) B[k * m + j] *= inverse;
    for (int i = k + 1; i < n; i++) add_multiple(m, -U[k * n + i], B + k * m, B + i * m);
  }
}

/* b <- U^-1 b */
static inline void solve_upper(int n, const double* restrict U, double* restrict b) {
  for (int i = n - 1; i >= 0; i--) {
    double sum = b[i];
    for (int j = i + 1; j < n; j++) sum -= U[i * n + j] * b[j];
    b[i] = sum / U[i * n + i];
  }
}

/* C <- C + a A^T B for A (k, n) and B (k, m). */
static inline void add_transposed_product(int k, int n, int m, double a,
                                          const double* restrict A, const double* restrict B,
                                          double* restrict C) {
  for (int i = 0; i < n; i++)
    for (int r = 0; r < k; r++) add_multiple(m, a * A[r * n + i], B + r * m, C + i * m);
}

#endif
