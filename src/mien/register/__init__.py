"""Bringing surfaces into correspondence: rigid, by points and by surfaces; nonrigid, template to scan."""

from .correspond import Correspondences, Rejection, Surface
from .morph import LinearModel, MorphConfig, MorphResult, fit_model
from .nonrigid import Anchors, NonrigidConfig, NonrigidResult, Template, register_surface
from .rigid import IcpConfig, IcpResult, ProcrustesResult, icp, procrustes, procrustes_frames

__all__ = [
    "Anchors",
    "Correspondences",
    "IcpConfig",
    "IcpResult",
    "LinearModel",
    "MorphConfig",
    "MorphResult",
    "NonrigidConfig",
    "NonrigidResult",
    "ProcrustesResult",
    "Rejection",
    "Surface",
    "Template",
    "fit_model",
    "icp",
    "procrustes",
    "procrustes_frames",
    "register_surface",
]
