"""Bringing surfaces into correspondence: rigid, by points and by surfaces; nonrigid, template to scan."""

from .correspond import Correspondences, Rejection, Surface
from .nonrigid import Anchors, NonrigidConfig, NonrigidResult, Template, register_surface
from .rigid import ProcrustesResult, procrustes, procrustes_frames, procrustes_robust
from .rigid_icp import IcpConfig, IcpResult, icp

__all__ = [
    "Anchors",
    "Correspondences",
    "IcpConfig",
    "IcpResult",
    "NonrigidConfig",
    "NonrigidResult",
    "ProcrustesResult",
    "Rejection",
    "Surface",
    "Template",
    "icp",
    "procrustes",
    "procrustes_frames",
    "procrustes_robust",
    "register_surface",
]
