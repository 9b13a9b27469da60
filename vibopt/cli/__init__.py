"""The command line."""

import os

# One thread of linear algebra: the matrices are small, and a second thread only waits for the first.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
