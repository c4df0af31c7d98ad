"""Solvers that know nothing of faces."""

from .boxls import BoxResult, box_least_squares
from .incremental_pca import IncrementalPca, IncrementalPcaConfig
from .kalman import KalmanConfig, KalmanState
from .nnls import NnlsResult, nnls
from .smooth import smooth_box_least_squares

__all__ = [
    "BoxResult",
    "IncrementalPca",
    "IncrementalPcaConfig",
    "KalmanConfig",
    "KalmanState",
    "NnlsResult",
    "box_least_squares",
    "nnls",
    "smooth_box_least_squares",
]
