"""A laser scanner: its own sampling of the skin, noise, holes, a ragged hair line, its own frame; and the truth."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ...errors import BadInput
from ...mesh import Attachment, Mesh, Scan, connected_parts, face_normals, vertex_normals
from ...pictures.raycast import RayCaster
from ...transforms import Transform, rotation_from_vector
from ..people.fields import smooth_field
from ..people.performer import Performer
from ..people.skin import Skin
from .scan_photo import PhotoConfig, photographed
from .worn import beard_hair

AXIS_TO_FACE = 90.0
"""Usual distance of the face from the scanner's axis, mm."""


@dataclass(frozen=True)
class ScanConfig:
    """A scanner that goes round the head (as Cyberware's did), and what goes wrong."""

    vertices: int = 100_000
    """About how many the scan has."""
    noise: float = 0.06
    """Standard deviation along the ray, mm. 0: none."""
    ripple: float = 0.03
    """Rms of slow errors of calibration, mm. 0: none."""
    grazing: float = 0.22
    """Surface is lost where the cosine of ray to normal is below this. 0: nothing is lost."""
    shiny: float = 0.15
    """Share of the eyeballs' samples that are lost; the rest there has 4 times the noise."""
    hair_line: float = 68.0
    """Height above the eyes where hair begins, mm; ragged by some 3 mm."""
    neck: float = 40.0
    """How far below the chin the scan goes, mm."""
    sides: float = 1.75
    """How far round it goes to either side, radians."""
    turn: float = 0.08
    """Standard deviation of the scanner frame's rotation against face space, radians a component. 0: aligned."""
    shift: float = 40.0
    """Standard deviation of the frame's offset, mm a coordinate."""
    performance_sigma: float = 0.5
    """Mean distance of the performed expression from the one that was asked for, over the face, mm. 0: the same."""
    noise_varies: float = 0.0
    """Standard deviation of the logarithm of one scan's noise. 0: all scans alike."""
    beard: float = 0.0
    """Length of a beard that the scanner takes for skin, mm. 0: none."""
    colour: bool = True
    """Colours on the vertices."""
    photo: PhotoConfig = PhotoConfig()
    """How they were taken."""


HARD_SCAN = ScanConfig(noise_varies=0.35, photo=PhotoConfig(exposure=0.35, white_balance=0.05, shading=0.35, noise=4.0))
"""Scans as an afternoon gives them: no two of the same noise, exposure, white balance or light."""


@dataclass(frozen=True)
class ScanTruth:
    """What really was before the scanner. For scores alone."""

    actor: Skin | Performer
    weights: Float[np.ndarray, " shapes"]
    """The expression that was performed."""
    asked: Float[np.ndarray, " shapes"]
    """The expression that was asked for."""
    T_scan_face: Transform
    material: Attachment
    """Of each scan vertex: the point of the actor's skin that it saw, noise apart."""
    vertices: Float[np.ndarray, "n 3"]
    """The actor's true vertices, in the scan's frame, mm."""

    @property
    def bundled(self) -> Float[np.ndarray, "coarse 3"]:
        """Where each vertex of the bundled topology truly is on this scan, mm, scan frame; NaN where cut off."""
        if isinstance(self.actor, Performer):
            return self.vertices
        out = np.full((len(self.actor.bundled), 3), np.nan)
        there = self.actor.bundled >= 0
        out[there] = self.vertices[self.actor.bundled[there]]
        return out

    def points(self, attachment: Attachment) -> Float[np.ndarray, "p 3"]:
        """Where points fixed on the actor's mesh (markers, say) truly are on this scan, mm, scan frame."""
        return attachment.points(self.actor.neutral.with_vertices(self.vertices))


@dataclass(frozen=True)
class StagedScan:
    """A scan and the truth behind it."""

    scan: Scan
    """The only thing that a solver may see."""
    truth: ScanTruth


def scan(
    actor: Skin | Performer,
    weights: Float[np.ndarray, " shapes"],
    config: ScanConfig | None = None,
    seed: int = 0,
    name: str = "scan",
) -> StagedScan:
    """Scan the actor, who tries to hold the expression `weights`; the same seed gives the same scan.

    Raises:
        BadInput: weights of the wrong number, or a density that no scanner has.
    """
    config = config or ScanConfig()
    if weights.shape != (len(actor.names),):
        raise BadInput(f"weights: expected {len(actor.names)}, one a unit, got {len(weights)}")
    if not 500 <= config.vertices <= 2_000_000:
        raise BadInput(f"vertices: expected 500 to 2,000,000, got {config.vertices}")
    rng = np.random.default_rng([seed, 8])
    performed = perform_nearly(actor, weights, config.performance_sigma, rng)
    mesh = actor.mesh(performed)
    grid, material = _sweep(actor, mesh, config, rng)
    faces = _triangulate(grid, config, rng)
    faces, kept = _clean(faces, len(grid.points), rng)
    off = _noise(actor, mesh, grid, material, config, rng)
    hair = beard_hair(actor, material.points(actor.neutral), config.beard, np.random.default_rng([seed, 20]))
    points = (grid.points + (off - hair)[:, None] * grid.rays)[kept]
    T = Transform(rotation_from_vector(rng.normal(size=3) * config.turn), rng.normal(size=3) * config.shift)
    material = Attachment(material.faces[kept], material.barycentric[kept])
    colors = None
    if config.colour and mesh.colors is not None:
        paint = material.points(replace(mesh, vertices=mesh.colors))
        normals = material.points(replace(mesh, vertices=vertex_normals(mesh.vertices, mesh.faces)))
        colors = photographed(paint, normals, hair[kept], config.photo, np.random.default_rng([seed, 21]))
    truth = ScanTruth(actor, performed, weights, T, material, T.apply(mesh.vertices))
    return StagedScan(Scan(Mesh(T.apply(points), faces, colors=colors), name=name), truth)


def perform_nearly(
    actor: Skin | Performer, weights: Float[np.ndarray, " shapes"], distance: float, rng: np.random.Generator
) -> Float[np.ndarray, " shapes"]:
    """Weights whose face is about `distance` mm (mean over the front of the face) from the one that was asked for."""
    if distance <= 0:
        return weights
    performer = actor.performer if isinstance(actor, Skin) else actor
    front = np.flatnonzero(performer.skin & (performer.neutral.vertices[:, 2] > 45))
    steady = ("eyeBlink", "eyeLook", "tongue", "mouthClose")
    moving = np.array([not name.startswith(steady) for name in performer.names])
    aside = rng.normal(size=len(weights)) * (0.12 * weights + 0.03) * moving
    asked = performer.vertices(weights[None])[0, front]
    low, high = 0.0, 6.0
    for _ in range(12):
        middle = (low + high) / 2
        off = performer.vertices(np.clip(weights + middle * aside, 0, 1)[None])[0, front] - asked
        low, high = (middle, high) if np.linalg.norm(off, axis=1).mean() < distance else (low, middle)
    return np.clip(weights + low * aside, 0, 1)


@dataclass(frozen=True)
class _Grid:
    """Samples of the sweep that hit, and where they are in its image."""

    points: np.ndarray
    rays: np.ndarray
    """Unit directions of the rays (p, 3)."""
    index: np.ndarray
    """(rows, columns): which sample, -1 for none."""
    spacing: float


def _sweep(
    actor: Skin | Performer, mesh: Mesh, config: ScanConfig, rng: np.random.Generator
) -> tuple[_Grid, Attachment]:
    """Rays from all round towards a vertical axis, jittered within their cells."""
    performer = actor.performer if isinstance(actor, Skin) else actor
    eyes = (performer.eyes["Left"].centre + performer.eyes["Right"].centre) / 2
    chin = float(mesh.vertices[:, 1][mesh.vertices[:, 2] > 60].min())
    bottom, top = chin - config.neck, eyes[1] + config.hair_line + 12
    spacing = float(np.sqrt(2 * config.sides * AXIS_TO_FACE * (top - bottom) * 0.72 / config.vertices))
    y = np.arange(bottom, top, spacing)
    theta = np.arange(-config.sides, config.sides, spacing / AXIS_TO_FACE)
    Y, A = np.meshgrid(y, theta, indexing="ij")
    Y = Y + rng.uniform(-0.3, 0.3, Y.shape) * spacing
    A = A + rng.uniform(-0.3, 0.3, A.shape) * spacing / AXIS_TO_FACE
    out = np.stack([np.sin(A), np.zeros_like(A), np.cos(A)], axis=-1).reshape(-1, 3)
    origins = out * 400.0 + np.stack([np.zeros(Y.size), Y.ravel(), np.zeros(Y.size)], axis=1)
    hits = RayCaster(mesh).cast(origins, -out)
    good = hits.hit & ~np.isnan(hits.distances)
    good[good] &= _seen(actor, mesh, hits.faces[good], -out[good], config, rng)
    points = origins[good] - out[good] * hits.distances[good, None]
    inside = _inside(points, eyes, bottom, config, rng)
    good[np.flatnonzero(good)[~inside]] = False
    index = np.full(Y.size, -1)
    index[good] = np.arange(good.sum())
    return (
        _Grid(points[inside], -out[good], index.reshape(Y.shape), spacing),
        Attachment(hits.faces[good], hits.barycentric[good]),
    )


def _seen(
    actor: Skin | Performer, mesh: Mesh, faces: np.ndarray, rays: np.ndarray, config: ScanConfig,
    rng: np.random.Generator,
) -> Bool[np.ndarray, " p"]:
    """Not at grazing angles, not from behind, and not everywhere on the eyes."""
    used, which = np.unique(faces, return_inverse=True)
    normals = face_normals(mesh.vertices, mesh.faces[used])[which]
    facing = -(normals * rays).sum(axis=1)
    lost = _on_eye(actor, mesh.faces[faces]) & (rng.random(len(faces)) < config.shiny)
    return np.asarray(facing > config.grazing) & ~lost


def _on_eye(actor: Skin | Performer, corners: np.ndarray) -> Bool[np.ndarray, " p"]:
    return ~np.asarray(actor.skin[corners].all(axis=1))


def _inside(points: np.ndarray, eyes: np.ndarray, bottom: float, config: ScanConfig, rng) -> Bool[np.ndarray, " p"]:
    """Below the ragged hair line, above the collar, in front of the ears."""
    ragged = 3.0 * smooth_field(rng, (4.0, 30.0), waves=32).at(points)[:, 0]
    side = np.abs(np.arctan2(points[:, 0], points[:, 2]))
    hair = eyes[1] + config.hair_line - 55 * np.clip((side - 0.75) / 0.8, 0, 1) ** 1.5
    height = points[:, 1] + ragged
    return (height < hair) & (height > bottom + 4) & (side + 0.02 * ragged < config.sides - 0.05)


def _triangulate(grid: _Grid, config: ScanConfig, rng: np.random.Generator) -> Int[np.ndarray, "m 3"]:
    """Neighbouring samples joined, diagonals at random; no triangle over a jump."""
    a, b, c, d = grid.index[:-1, :-1], grid.index[:-1, 1:], grid.index[1:, 1:], grid.index[1:, :-1]
    quads = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
    flip = rng.random(len(quads)) < 0.5
    quads[flip] = np.roll(quads[flip], 1, axis=1)
    missing = (quads < 0).sum(axis=1)
    whole, torn = quads[missing == 0], quads[missing == 1]
    order = ((torn < 0).argmax(axis=1)[:, None] + [1, 2, 3]) % 4
    three = np.concatenate([whole[:, [0, 1, 2]], whole[:, [0, 2, 3]], np.take_along_axis(torn, order, axis=1)])
    corners = grid.points[three]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    normals = face_normals(grid.points, three)
    facing = -(normals * grid.rays[three[:, 0]]).sum(axis=1)
    return three[(longest < 6 * grid.spacing) & (facing > 0.6 * config.grazing)]


def _clean(faces: np.ndarray, n: int, rng: np.random.Generator) -> tuple[Int[np.ndarray, "m 3"], Int[np.ndarray, " k"]]:
    """Without specks; vertices and triangles in random order, so that order tells nothing."""
    piece = connected_parts(faces, n)
    size = np.bincount(piece)
    faces = faces[size[piece[faces[:, 0]]] > 200]
    kept = rng.permutation(np.unique(faces))
    new = np.full(n, -1)
    new[kept] = np.arange(len(kept))
    return new[faces[rng.permutation(len(faces))]], kept


def _noise(actor, mesh: Mesh, grid: _Grid, material: Attachment, config: ScanConfig, rng) -> Float[np.ndarray, " p"]:
    """Along each ray, mm."""
    varies = np.exp(config.noise_varies * rng.normal()) if config.noise_varies > 0 else 1.0
    fine = rng.normal(size=len(grid.points)) * config.noise * varies
    fine[_on_eye(actor, mesh.faces[material.faces])] *= 4
    return fine + config.ripple * smooth_field(rng, (15.0, 60.0)).at(grid.points)[:, 0]


