"""Keeps all arithmetic of this process on one thread, as on a robot. Call it before numpy is imported, whose libraries read it once."""

import os

_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM")


def stay_on_one_thread() -> None:
    """Tell OpenCV and the BLAS libraries to start no threads."""
    os.environ.update(dict.fromkeys(_SETTINGS, "1"))
