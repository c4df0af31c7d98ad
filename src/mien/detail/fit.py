"""From training clips to two displacement maps: medium in three dimensions, fine along the normal (sec. 4, fig. 2)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from ..errors import BadInput
from ..mesh import Attachment, Mesh, closest_point
from ..progress import SILENT, Progress
from .base_mesh import BaseConfig, BaseMesh, base_mesh, rims_and_eyes
from .domain import Domain, DomainConfig, deformation_vectors, fit_domain, marker_strains
from .fields import DetailMap, parameter_field, within_training
from .marker_mesh import marker_mesh
from .polynomial import PolynomialConfig, PolynomialFit, PolynomialMap
from .reflectance import ReflectanceConfig, coloured_clips, fit_reflectance
from .sampling import sampler
from .texture_space import Texels, resampling, texel_mm, texture_gradients
from .thin_shell import ShellConfig, ThinShell, thin_shell
from .training import HeadMarkers, TrainingSet, aligned_frames

BLUR_REACH = 3.0
"""Standard deviations of a blur that are summed."""


@dataclass(frozen=True)
class DetailConfig:
    """Everything that `mien detail fit` may be told."""

    base: BaseConfig = BaseConfig()
    shell: ShellConfig = ShellConfig()
    domain: DomainConfig = DomainConfig()
    medium: PolynomialConfig = PolynomialConfig()
    fine: PolynomialConfig = PolynomialConfig()
    reflectance: ReflectanceConfig = ReflectanceConfig()
    medium_size: int = 512
    """Side of the medium map, texels."""
    fine_size: int = 1024
    """Side of the fine map, texels; 0: no fine map."""
    high_pass_mm: float = 2.0
    """Standard deviation of the blur that is taken off the residual before the fine map is fitted, mm."""
    farthest_mm: float = 15.0
    """A displacement beyond this is no skin (a hole, a tongue): the sample is left out."""
    unreliable: float = 4.0
    """A texel whose rms residual exceeds this many times the median is marked."""


@dataclass(frozen=True)
class DetailModel:
    """A person's detail: driven by markers alone from here on."""

    base: Mesh
    """The smooth neutral, with texture coordinates; face space, mm."""
    labels: tuple[str, ...]
    head: HeadMarkers
    """The markers at the neutral, and which of them tell where the head is."""
    attachment: Attachment
    """Their places on the base."""
    shell: ThinShell
    domain: Domain
    medium: DetailMap
    """u, v, n components in the base's local frame, mm."""
    fine: DetailMap | None
    """Height along the normal, mm."""
    frames: int
    """Of training."""
    reflectance: DetailMap | None = None
    """Linear albedo on the medium map's texels, red, green and blue; None where the clips had no colours."""
    rims_and_eyes: Mesh | None = None
    """What pictures show beside the base (`base_mesh.rims_and_eyes`); face space, mm."""

    @property
    def reference(self) -> Float[np.ndarray, "k 3"]:
        """The markers at the neutral, face space, mm."""
        return self.head.reference


def fit_detail(
    training: TrainingSet, config: DetailConfig = DetailConfig(), progress: Progress = SILENT
) -> DetailModel:
    """Fit both maps (Ma et al. 2008, fig. 2): base motion, domain, medium map, then the fine map on what it leaves.

    Clips with colours give a third map, of the reflectance.

    Raises:
        BadInput: training clips that do not fit together, markers far from the mesh or that nothing joins, a mesh that
            cannot be unrolled, frames that show no skin.
    """
    base = base_mesh(training.mesh, config.base)
    attachment = _on_base(training, base.mesh, config.farthest_mm)
    shell = thin_shell(base.mesh, attachment, config.shell)
    domain = training_domain(training, base.mesh, attachment, config.domain)
    medium = _fit_medium(training, base, shell, attachment, domain, config, progress)
    fine = None
    if config.fine_size:
        fine = _fit_fine(training, base, shell, attachment, domain, medium, config, progress)
    reflectance = _fit_reflectance(training, base, domain, medium, config.reflectance, progress)
    return DetailModel(
        base=base.mesh,
        labels=training.labels,
        head=training.head,
        attachment=attachment,
        shell=shell,
        domain=domain,
        medium=medium,
        fine=fine,
        frames=len(training),
        reflectance=reflectance,
        rims_and_eyes=rims_and_eyes(training.mesh, base),
    )


def _on_base(training: TrainingSet, mesh: Mesh, farthest_mm: float) -> Attachment:
    """The feet of the neutral's markers on the base."""
    feet = closest_point(mesh, training.markers)
    usual = float(np.median(feet.distances))
    if usual > farthest_mm:
        raise BadInput(
            f"detail: the markers lie {usual:.0f} mm from the neutral's mesh (median); "
            "give markers and meshes of one frame of reference, and the meshes' unit (--unit)"
        )
    return feet.attachment()


def training_domain(
    training: TrainingSet, mesh: Mesh, attachment: Attachment, config: DomainConfig = DomainConfig()
) -> Domain:
    """Sec. 4.1: the coarse mesh over the markers, and two directions of deformation at each from all frames."""
    coarse = marker_mesh(mesh, attachment)
    strains = marker_strains(mesh, attachment, training.markers, coarse, texture_gradients(mesh), config)
    vectors = [deformation_vectors(strains, training.head.aligned(c.markers)) for c in training.clips]
    return fit_domain(strains, coarse, np.concatenate(vectors))


def _fit_medium(training, base, shell, attachment, domain, config: DetailConfig, progress: Progress) -> DetailMap:
    """Sec. 4.2: three channels, each fitted by itself."""
    at = sampler(training, base, shell, config.medium_size, config.farthest_mm)
    drive = parameter_field(domain, base.mesh, attachment, at.texels.attachment)
    fit, shown = PolynomialFit(len(at.texels.pixels), 3, config.medium), []
    for number, aligned in enumerate(aligned_frames(training), 1):
        vectors = deformation_vectors(domain.strains, aligned.markers[None])[0]
        fit.add(drive.parameters(vectors, config.medium.whole_deformation), at.displacement(aligned))
        shown.append(vectors)
        progress.update("medium map", number, len(training))
    polynomial = within_training(drive, fit.solve(), shown)
    return _with_errors(at.texels, drive, polynomial, fit, config)


def _fit_fine(
    training, base, shell, attachment, domain, medium: DetailMap, config: DetailConfig, progress: Progress
) -> DetailMap:
    """One channel along the normal, fitted to what the medium map leaves, high-passed."""
    at = sampler(training, base, shell, config.fine_size, config.farthest_mm)
    drive = parameter_field(domain, base.mesh, attachment, at.texels.attachment)
    resampled = resampling(base.mesh, medium.texels, at.texels)
    high_pass = HighPass(at.texels, config.high_pass_mm / texel_mm(base.mesh, config.fine_size))
    fit, shown = PolynomialFit(len(at.texels.pixels), 1, config.fine), []
    for number, aligned in enumerate(aligned_frames(training), 1):
        vectors = deformation_vectors(domain.strains, aligned.markers[None])[0]
        explained = medium.driven.values(vectors)[:, 2]
        left = at.displacement(aligned)[:, 2] - resampled @ explained
        fit.add(drive.parameters(vectors, config.fine.whole_deformation), high_pass(left)[:, None])
        shown.append(vectors)
        progress.update("fine map", number, len(training))
    polynomial = within_training(drive, fit.solve(), shown)
    return _with_errors(at.texels, drive, polynomial, fit, config)


def _fit_reflectance(
    training: TrainingSet, base: BaseMesh, domain: Domain, medium: DetailMap, config: ReflectanceConfig,
    progress: Progress,
) -> DetailMap | None:  # fmt: skip
    """Sec. 4.2: albedo on the medium map's texels, from the clips that have colours."""
    clips = coloured_clips(training) if config.learn else ()
    if not clips:
        return None
    seen = replace(training, clips=clips)
    return fit_reflectance(seen, training.head, domain, base, medium, config, progress)


class HighPass:
    """Values minus their Gaussian mean over known texels, `sigma` texels wide; NaN stays."""

    def __init__(self, grid: Texels, sigma: float):
        self.grid, self.sigma = grid, sigma
        self._known = np.zeros((0, 0), bool)
        self._weight = np.zeros((0, 0))

    def __call__(self, values: Float[np.ndarray, " p"]) -> Float[np.ndarray, " p"]:
        image = self.grid.image(values)
        known = np.isfinite(image)
        if not np.array_equal(known, self._known):
            self._known, self._weight = known, self._blur(known.astype(np.float32))
        total = self._blur(np.where(known, image, 0.0).astype(np.float32))
        return values - self.grid.of_image(total / np.maximum(self._weight, 1e-6))

    def _blur(self, image: np.ndarray) -> np.ndarray:
        return ndimage.gaussian_filter(image, self.sigma, truncate=BLUR_REACH)


def _with_errors(grid, drive, polynomial: PolynomialMap, fit: PolynomialFit, config: DetailConfig) -> DetailMap:
    if not polynomial.seen.any():
        raise BadInput(
            f"displacement map: no frame shows skin within {config.farthest_mm:g} mm of the base motion; "
            "give markers and meshes of the same frames, in one frame of reference"
        )
    error = fit.rms(polynomial)
    usual = np.nanmedian(error)
    return DetailMap(grid, drive, polynomial, error, np.isnan(error) | (error > config.unreliable * usual))
