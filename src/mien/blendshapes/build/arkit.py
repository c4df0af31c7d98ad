"""All 52 ARKit shapes from a few captures: deformation transfer, pulled to the captures (after Li et al. 2010).

Li et al. solve for the deformation gradients of all shapes so that their mix gives each example. Rig and examples share
their vertices here, so the same least squares are solved for displacements: min sum_j |E_j - sum_i a_ji B_i|^2 + sum_i
|B_i - B*_i|^2 / s_i^2, vertex by vertex, with s_i the prior's own motion there. Weights a and shapes B in turn.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import lsq_linear

from ...faces.arkit import ARKIT_NAMES
from ...faces.bundled import BundledFace
from ...mesh import Mesh, mass
from ...rig import Rig
from ...rig.transfer import transfer_deltas

OF_EYES = ("eyeBlink", "eyeLook", "eyeSquint")
"""Shapes that are fitted to a person's own eyes (`BundledFace.fitted_deltas`), by the beginnings of their names."""


LEAST_AREA = 1e-6
"""Of a vertex, mm^2: so that one in no triangle has a weight."""


@dataclass(frozen=True)
class CompleteConfig:
    """How the bundled expressions are pulled to the captures."""

    rounds: int = 2
    """Times that weights and shapes are found in turn. 0: deformation transfer alone."""
    least_mm: float = 0.15
    """A shape may change by so much where the bundled one does not move at all, mm."""
    exact: float = 0.02
    """Misfit that is left to a capture, as a share: small is close to the capture."""
    steady: float = 0.3
    """Weight of no motion when a capture's mix is found."""


@dataclass(frozen=True)
class CompletedShapes:
    """The 52 shapes and how the captures are mixed of them."""

    deltas: Float[np.ndarray, "52 n 3"]
    mixes: Float[np.ndarray, "captures 52"]


def transferred(face: BundledFace, neutral: Mesh) -> Float[np.ndarray, "52 n 3"]:
    """The bundled expressions on another neutral of its topology, eyes and lids fitted to it."""
    deltas = transfer_deltas(face.rig.neutral, face.rig.deltas, neutral)
    fitted = face.fitted_deltas(neutral.vertices)
    eyes = [i for i, name in enumerate(face.rig.names) if name.startswith(OF_EYES)]
    deltas[eyes] = fitted[eyes]
    return deltas


def completed_rig(
    rig: Rig,
    face: BundledFace,
    correspondence: Int[np.ndarray, " faces"] | None,
    config: CompleteConfig = CompleteConfig(),
) -> Rig:
    """Any person's few shapes completed to the 52, in front; shapes of other names stay behind them.

    correspondence: the bundled triangle that rules each of the rig's; None where the two have the same triangles.
    """
    prior = transfer_deltas(face.rig.neutral, face.rig.deltas, rig.neutral, correspondence)
    areas = mass(rig.neutral.vertices, rig.neutral.faces) + LEAST_AREA
    found = complete_arkit(prior, rig.names, rig.deltas, areas, config)
    others = [i for i, name in enumerate(rig.names) if name not in ARKIT_NAMES]
    names = (*ARKIT_NAMES, *(rig.names[i] for i in others))
    return Rig(rig.neutral, np.concatenate([found.deltas, rig.deltas[others]]), names, rig.texture)


def complete_arkit(
    prior: Float[np.ndarray, "52 n 3"],
    names: tuple[str, ...],
    examples: Float[np.ndarray, "captures n 3"],
    areas: Float[np.ndarray, " n"],
    config: CompleteConfig = CompleteConfig(),
) -> CompletedShapes:
    """Shapes whose mixes give the captures, as near to the prior as they can be.

    A capture that bears an ARKit name is that shape, whole; the others are mixes that are found.
    """
    shapes = prior.copy()
    mixes = np.zeros((len(names), len(ARKIT_NAMES)))
    for _ in range(config.rounds):
        mixes = find_mixes(shapes, names, examples, areas, config.steady)
        shapes = pulled(prior, mixes, examples, config)
    return CompletedShapes(shapes, mixes)


def find_mixes(
    shapes: Float[np.ndarray, "52 n 3"],
    names: tuple[str, ...],
    examples: Float[np.ndarray, "captures n 3"],
    areas: Float[np.ndarray, " n"],
    steady: float,
) -> Float[np.ndarray, "captures 52"]:
    """Weights in 0..1 that bring the shapes nearest to each capture; one that has an ARKit name is that shape."""
    mixes = np.zeros((len(names), len(shapes)))
    root = np.sqrt(areas / areas.mean())[:, None]
    rows = (shapes * root).reshape(len(shapes), -1).T
    gram = rows.T @ rows
    size = np.sqrt(np.trace(gram) / len(gram))
    damped = np.linalg.cholesky(gram + (0.05 * steady * size) ** 2 * np.eye(len(gram))).T
    for j, name in enumerate(names):
        if name in ARKIT_NAMES:
            mixes[j, ARKIT_NAMES.index(name)] = 1.0
            continue
        right = np.linalg.solve(damped.T, rows.T @ (examples[j] * root).ravel())
        mixes[j] = lsq_linear(damped, right, (0, 1)).x
    return mixes


def pulled(
    prior: Float[np.ndarray, "52 n 3"],
    mixes: Float[np.ndarray, "captures 52"],
    examples: Float[np.ndarray, "captures n 3"],
    config: CompleteConfig,
) -> Float[np.ndarray, "52 n 3"]:
    """The shapes nearest to the prior whose mixes are the captures, vertex by vertex."""
    if not len(examples):
        return prior
    freedom = (prior**2).sum(2).T + config.least_mm**2
    misfit = np.moveaxis(examples - np.tensordot(mixes, prior, axes=1), 1, 0)
    gram = np.einsum("ji,vi,ki->vjk", mixes, freedom, mixes)
    level = config.exact * np.trace(gram, axis1=1, axis2=2) / len(mixes)
    gram = gram + level[:, None, None] * np.eye(len(mixes))
    solved = np.linalg.solve(gram, misfit)
    return prior + np.einsum("vi,ji,vjd->ivd", freedom, mixes, solved)
