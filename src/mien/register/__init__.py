"""Bringing surfaces into correspondence: rigid, by points and by surfaces; nonrigid, template to scan."""

from .correspond import Correspondences, Rejection, Surface
from .rigid import IcpConfig, IcpResult, ProcrustesResult, icp, procrustes, procrustes_frames

__all__ = [
    "Correspondences",
    "IcpConfig",
    "IcpResult",
    "ProcrustesResult",
    "Rejection",
    "Surface",
    "icp",
    "procrustes",
    "procrustes_frames",
]
