"""Markers on a scan of the same expression: marker mesh registration (Huang et al. 2011, sec. 5, eq. 4-6).

What is ours, where the paper is silent: the start, from the shape alone; markers stand off the skin by a distance
that is found; bad closest points are left out; the mix of expressions is held near the one that was asked for, as far
as actors usually miss it, since a closest point says nothing of where along the skin a marker is.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..mesh import Attachment, ClosestPoint
from ..mesh.cluster import clustered
from ..progress import SILENT, Progress
from ..register import Rejection, Surface
from ..register.align import AlignConfig, Alignment, align
from ..transforms import Transform, rotation_from_vector


@dataclass(frozen=True)
class OnScanConfig:
    """How markers are laid on scans. Millimetres throughout."""

    start_cell: float = 6.0
    """The scan is thinned to about this spacing while the start is looked for."""
    clear: float = 0.6
    """A start is sure where its cost is at most this share of the next different one's."""
    most_start: float = 3.0
    """... and no more than this."""
    rounds: int = 30
    """Closest-point rounds of the rigid step."""
    nonrigid_rounds: int = 15
    """... and of the nonrigid step."""
    outlier: float = 3.0
    """Distances beyond this many times their robust spread count for less and less."""
    noise: float = 0.15
    """Markers' and scan's noise across the surface."""
    performed: float = 1.0
    """How far the performed expression is expected to be from the one asked for, rms at a marker."""
    standoff_most: float = 8.0
    """Marker centres are on the skin or up to so far above it."""
    standoff_rounds: int = 2
    """Rounds in which each marker finds its own stand-off from all scans."""


@dataclass(frozen=True)
class MarkersOnScan:
    """Where the markers are on one scan."""

    T_head_scan: Transform
    """Rigid: the scan's frame -> head frame of the take, mm."""
    attachment: Attachment
    """On the scan's mesh: the points of the skin under the markers."""
    markers: Float[np.ndarray, "markers 3"]
    """The frame's markers after the nonrigid step, head frame, mm."""
    mix: Float[np.ndarray, " expressions"]
    """w of eq. 6; 1 for the scan's own frame and 0 elsewhere is the expression that was asked for."""
    off: Float[np.ndarray, " markers"]
    """What is left between marker and skin beyond the stand-off, mm; positive above it."""
    rigid_rms: float
    """The same after the rigid step alone, rms, mm."""
    covered: Bool[np.ndarray, " markers"]
    """False where the scan has no surface under a marker: hair, a hole, beyond the rim."""


@dataclass(frozen=True)
class MarkersOnScans:
    """All markers on all scans."""

    scans: tuple[MarkersOnScan, ...]
    standoff: Float[np.ndarray, " markers"]
    """Height of each marker's centre above the skin, mm, the same on all scans."""


def register_markers(
    expressions: Float[np.ndarray, "expressions markers 3"],
    surfaces: list[Surface],
    config: OnScanConfig = OnScanConfig(),
    progress: Progress = SILENT,
    names: list[str] | None = None,
) -> MarkersOnScans:
    """Every selected frame's markers on the scan of the same expression.

    Args:
        expressions: the selected frames, head frame, mm; the i-th was scanned as the i-th of `surfaces`.
        names: what messages call the scans.

    Raises:
        BadInput: a scan on which the markers do not fit, or fit in several ways.
    """
    names = names or [f"scan {i}" for i in range(len(surfaces))]
    nowhere = np.zeros(expressions.shape[1])
    rigid = []
    for i, surface in enumerate(surfaces):
        start = find_start(expressions[i], surface, names[i], config)
        rigid.append(rigid_fit(expressions[i], surface, start, nowhere, config, rise=True))
        progress.update("markers to scans", i + 1, len(surfaces))
    standoff = nowhere + np.median([rise for _, rise in rigid])
    poses = [T for T, _ in rigid]
    found = _both_steps(expressions, surfaces, poses, standoff, config)
    for _ in range(config.standoff_rounds):
        standoff = _own_standoff(found, standoff)
        found = _both_steps(expressions, surfaces, [f.T_head_scan.inverse() for f in found], standoff, config)
    return MarkersOnScans(tuple(found), standoff)


def _both_steps(expressions, surfaces, poses, standoff, config) -> list[MarkersOnScan]:
    found = []
    for i, (surface, T) in enumerate(zip(surfaces, poses, strict=True)):
        T, _ = rigid_fit(expressions[i], surface, T, standoff, config)
        found.append(nonrigid_fit(expressions, i, surface, T, standoff, config))
    return found


def _own_standoff(found: list[MarkersOnScan], standoff: np.ndarray) -> Float[np.ndarray, " markers"]:
    """Each marker's stand-off moved by what it is off on the average scan, as far as the scans are many."""
    off = np.stack([np.where(f.covered, f.off, 0.0) for f in found])
    count = np.stack([f.covered for f in found]).sum(axis=0)
    return np.maximum(standoff + off.sum(axis=0) / (count + 1), 0.0)


def find_start(
    markers: Float[np.ndarray, "markers 3"], surface: Surface, name: str, config: OnScanConfig = OnScanConfig()
) -> Transform:
    """T_scan_head from the shape alone: trimmed closest points from each principal axis in many turns.

    Raises:
        BadInput: no start fits, or two fit alike.
    """
    thin = ClosestPoint(clustered(surface.mesh, config.start_cell))
    found: list[Alignment] = align(markers, thin, AlignConfig(scale_range=0.0, distinct_mm=15.0))
    if not found or found[0].cost_mm > config.most_start:
        left = f"{found[0].cost_mm:.1f} mm are left" if found else "no start was found"
        raise BadInput(f"{name}: the markers of its frame do not fit the scan ({left}); is it the right scan and unit?")
    if len(found) > 1 and found[0].cost_mm > config.clear * found[1].cost_mm:
        raise BadInput(
            f"{name}: the markers fit the scan in two ways ({found[0].cost_mm:.1f} and {found[1].cost_mm:.1f} mm); "
            "crop the scan to the face"
        )
    return found[0].T_face_head


def rigid_fit(
    markers: Float[np.ndarray, "markers 3"],
    surface: Surface,
    start: Transform,
    standoff: Float[np.ndarray, " markers"],
    config: OnScanConfig = OnScanConfig(),
    rise: bool = False,
) -> tuple[Transform, float]:
    """T_scan_head of eq. 5 by point-to-plane ICP; with `rise` also what all stand-offs lack, mm (else 0)."""
    T, more, free = start, 0.0, 6 + rise
    for _ in range(config.rounds):
        x = T.apply(markers)
        normals, weights, rest = _pairs(x, surface, standoff + more, config)
        J = np.column_stack([np.cross(x - T.translation, normals), normals, -np.ones(len(x))])[:, :free]
        A = J.T @ (weights[:, None] * J) + 1e-9 * len(x) * np.eye(free)
        step = -np.linalg.solve(A, J.T @ (weights * rest))
        T = Transform(rotation_from_vector(step[:3]) @ T.rotation, T.translation + step[3:6])
        more = float(np.clip(more + step[6:].sum(), 0.0, config.standoff_most))
        if np.abs(step).max() < 1e-4:
            break
    return T, more


def nonrigid_fit(
    expressions: Float[np.ndarray, "expressions markers 3"],
    own: int,
    surface: Surface,
    T_scan_head: Transform,
    standoff: Float[np.ndarray, " markers"],
    config: OnScanConfig = OnScanConfig(),
) -> MarkersOnScan:
    """Eq. 6: the mix of the selected expressions whose markers meet the scan, by closest points.

    Minimises |distances across the surface|^2 / noise^2 + |mix - own|^2 / performed^2, the latter at the markers; the
    mix adds up to 1, since the rigid step has settled the size.
    """
    reference = expressions[own]
    modes = np.delete(expressions, own, axis=0) - reference
    k, m = len(modes), len(reference)
    turned = T_scan_head.rotate(modes.reshape(k * m, 3)).reshape(k, m, 3)
    flat = modes.reshape(k, 3 * m)
    prior = (flat @ flat.T) / config.performed**2 + 1e-9 * np.eye(k)
    rigid = _rms(_pairs(T_scan_head.apply(reference), surface, standoff, config))
    mix = np.zeros(k)
    for _ in range(config.nonrigid_rounds):
        x = T_scan_head.apply(reference + np.tensordot(mix, modes, axes=1))
        normals, weights, rest = _pairs(x, surface, standoff, config)
        J = np.einsum("kmd,md->mk", turned, normals)
        w = weights / config.noise**2
        step = np.linalg.solve(J.T @ (w[:, None] * J) + prior, -(J.T @ (w * rest)) - prior @ mix)
        mix = mix + step
        if np.abs(np.tensordot(step, modes, axes=1)).max(initial=0.0) < 1e-3:
            break
    moved = reference + np.tensordot(mix, modes, axes=1)
    found = surface.correspond(T_scan_head.apply(moved), rejection=Rejection())
    across = _signed(T_scan_head.apply(moved), found) - standoff
    return MarkersOnScan(
        T_head_scan=T_scan_head.inverse(),
        attachment=found.attachment(),
        markers=moved,
        mix=np.insert(mix, own, 1 - mix.sum()),
        off=across,
        rigid_rms=rigid,
        covered=found.accepted & (np.abs(across) < 3.0),
    )


def _pairs(x: np.ndarray, surface: Surface, height: np.ndarray, config: OnScanConfig):
    """The skin's normals under the markers, weights, and distances beyond the stand-off."""
    found = surface.correspond(x, rejection=Rejection())
    rest = _signed(x, found) - height
    spread = 1.4826 * np.median(np.abs(rest[found.accepted])) if found.accepted.any() else 1.0
    scale = config.outlier * max(spread, config.noise)
    weights = found.accepted / (1 + (rest / scale) ** 2) ** 2
    return found.normals, weights, rest


def _signed(x: np.ndarray, found) -> Float[np.ndarray, " markers"]:
    """Distance of each marker from the skin, positive outside."""
    return np.einsum("md,md->m", x - found.points, found.normals)


def _rms(pairs) -> float:
    _, weights, rest = pairs
    return float(np.sqrt((rest[weights > 0] ** 2).mean())) if (weights > 0).any() else float("nan")


def packed(found: MarkersOnScans) -> dict[str, np.ndarray]:
    """As arrays, to be stored."""
    arrays = {
        "rotation": np.stack([f.T_head_scan.rotation for f in found.scans]),
        "translation": np.stack([f.T_head_scan.translation for f in found.scans]),
        "faces": np.stack([f.attachment.faces for f in found.scans]),
        "barycentric": np.stack([f.attachment.barycentric for f in found.scans]),
        "standoff": found.standoff,
    }
    names = ("markers", "mix", "off", "covered", "rigid_rms")
    return arrays | {name: np.stack([getattr(f, name) for f in found.scans]) for name in names}


def unpacked(arrays: dict[str, np.ndarray]) -> MarkersOnScans:
    """What `packed` took apart."""
    a = arrays
    scans = tuple(
        MarkersOnScan(
            T_head_scan=Transform(a["rotation"][i], a["translation"][i]),
            attachment=Attachment(a["faces"][i], a["barycentric"][i]),
            markers=a["markers"][i],
            mix=a["mix"][i],
            off=a["off"][i],
            rigid_rms=float(a["rigid_rms"][i]),
            covered=a["covered"][i],
        )
        for i in range(len(a["mix"]))
    )
    return MarkersOnScans(scans, a["standoff"])
