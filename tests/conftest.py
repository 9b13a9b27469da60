"""One thread of linear algebra per process, as the tests run side by side; the same drawn examples every time."""

import os

from hypothesis import settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

settings.register_profile("same", derandomize=True, database=None, deadline=None)
settings.load_profile("same")
