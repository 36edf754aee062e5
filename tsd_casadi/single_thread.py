"""One thread for linear algebra.

The matrices of a tick and of a fit have tens of rows: more threads gain nothing, and
where the cores are taken they wait for each other (a fit of the loop's response took
4.1 s instead of 0.3 s).
"""

import os

# what numpy's and SciPy's builds of BLAS ask, OpenBLAS, MKL and those that use OpenMP
VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


def use_single_thread() -> None:
    """Let BLAS compute in the thread that asks, unless the environment sets one of them.

    To be called by a program, before numpy is imported: that is when it is asked for.
    """
    if not any(variable in os.environ for variable in VARIABLES):
        os.environ.update(dict.fromkeys(VARIABLES, "1"))
