"""Detail on disk: a folder with the base mesh, coefficient maps as EXR with named channels, and `detail.json`."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ...errors import BadInput
from ...files import existing, whole
from ...io.exr import read_exr, write_exr
from ...io.meshes.ply import read_ply, write_ply
from ...mesh import Attachment, Mesh
from ..domain import Domain, DomainConfig, marker_strains
from ..fields import DetailMap, parameter_field
from ..fit import DetailModel
from ..marker_mesh import marker_mesh
from ..polynomial import PolynomialMap, exponents
from ..texture_space import texels, texture_gradients, with_gutter
from ..thin_shell import ShellConfig, thin_shell
from ..training import HeadMarkers

FORMAT = 1
"""Of `detail.json`; a newer one is refused."""
MEDIUM_CHANNELS, FINE_CHANNELS = ("u", "v", "n"), ("n",)
"""Components of a map's values, mm, in the base's local frame."""
REFLECTANCE_CHANNELS = ("r", "g", "b")
"""Linear albedo."""
BESIDE = "rims_and_eyes.ply"
"""What pictures show and no map covers."""
LIMITS = ("least", "greatest")
"""Value of a map in training, where it keeps between them."""


def write_detail(folder: str | Path, model: DetailModel, half: bool = False) -> None:
    """Write `base.ply`, `medium.exr`, `fine.exr`, `reflectance.exr` and, last, `detail.json`: without it, unfinished.

    Channels are `a0.u` and so on: the coefficient of eq. 1 and the component, beside the surface those of the nearest
    texel on it. `error` is the rms residual in mm. `seen` is 0 where no training frame showed the texel (coefficients
    and error are 0 there) and beside the surface; `unreliable` is 1 there. `least.r` and so on: between what the
    reflectance lies in training. No channel holds a NaN. `half` stores 16-bit coefficients.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "detail.json").unlink(missing_ok=True)
    write_ply(folder / "base.ply", model.base)
    (folder / BESIDE).unlink(missing_ok=True)
    if model.rims_and_eyes is not None:
        write_ply(folder / BESIDE, model.rims_and_eyes)
    _write_map(folder / "medium.exr", model.medium, MEDIUM_CHANNELS, half)
    if model.fine is not None:
        _write_map(folder / "fine.exr", model.fine, FINE_CHANNELS, half)
    if model.reflectance is not None:
        _write_map(folder / "reflectance.exr", model.reflectance, REFLECTANCE_CHANNELS, half)
    record = {
        "format": FORMAT,
        "frames": model.frames,
        "labels": list(model.labels),
        "reference": model.reference.tolist(),
        "steadiness": model.head.steadiness.tolist(),
        "attachment": {
            "faces": model.attachment.faces.tolist(),
            "barycentric": model.attachment.barycentric.tolist(),
        },
        "bases": model.domain.bases.tolist(),
        "energies": model.domain.energies.tolist(),
        "replaced": model.domain.replaced,
        "trained": model.domain.trained.tolist(),
        "shell": asdict(model.shell.config),
        "domain": asdict(model.domain.strains.config),
        "medium": _told(model.medium),
        "fine": _told(model.fine),
        "reflectance": _told(model.reflectance),
    }
    with whole(folder / "detail.json") as temporary:
        temporary.write_text(json.dumps(record) + "\n")


def _told(detail: DetailMap | None) -> dict[str, int | bool] | None:
    if detail is None:
        return None
    learnt = detail.polynomial
    return {"order": learnt.order, "whole_deformation": learnt.whole_deformation, "size": detail.texels.size}


def read_detail(folder: str | Path) -> DetailModel:
    """A model written by `write_detail`; the shell is factorised anew.

    Raises:
        BadInput: no such folder, an unfinished one, or files that do not belong together.
    """
    folder = existing(folder)
    record = _record(folder / "detail.json")
    base, _ = read_ply(existing(folder / "base.ply"))
    beside = read_ply(folder / BESIDE)[0] if (folder / BESIDE).is_file() else None
    try:
        attachment = Attachment(
            np.array(record["attachment"]["faces"], np.int64), np.array(record["attachment"]["barycentric"], float)
        )
        head = HeadMarkers(np.array(record["reference"], float), np.array(record["steadiness"], float))
        bases = np.array(record["bases"], float)
        shell = thin_shell(base, attachment, ShellConfig(**record["shell"]))
        coarse = marker_mesh(base, attachment)
        config = DomainConfig(**record["domain"])
        strains = marker_strains(base, attachment, head.reference, coarse, texture_gradients(base), config)
        trained = np.array(record["trained"], float).reshape(len(bases), -1, 2)
        domain = Domain(strains, coarse, bases, np.array(record["energies"], float), int(record["replaced"]), trained)
        on = (base, attachment, domain)
        medium = _read_map(folder / "medium.exr", record["medium"], MEDIUM_CHANNELS, *on)
        fine = reflectance = None
        if record["fine"] is not None:
            fine = _read_map(folder / "fine.exr", record["fine"], FINE_CHANNELS, *on)
        if record.get("reflectance") is not None:
            reflectance = _read_map(folder / "reflectance.exr", record["reflectance"], REFLECTANCE_CHANNELS, *on)
        labels, frames = tuple(map(str, record["labels"])), int(record["frames"])
    except (KeyError, TypeError, ValueError, IndexError) as error:
        told = (str(error).splitlines() or [type(error).__name__])[0]
        raise BadInput(f"{folder / 'detail.json'}: does not fit the maps beside it ({told}); fit them anew") from None
    return DetailModel(base, labels, head, attachment, shell, domain, medium, fine, frames, reflectance, beside)


def _record(path: Path) -> dict:
    if not path.is_file():
        raise BadInput(f"{path.parent}: no detail.json; give a folder that `mien detail fit` has finished")
    try:
        record = json.loads(path.read_text())
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not a JSON file ({error})") from None
    if not isinstance(record, dict) or not isinstance(record.get("format"), int) or record["format"] > FORMAT:
        raise BadInput(f"{path}: written by a newer version, or by something else")
    return record


def _write_map(path: Path, detail: DetailMap, names: tuple[str, ...], half: bool) -> None:
    grid, seen = detail.texels, detail.polynomial.seen
    learnt = detail.polynomial
    terms = _terms(learnt.order, learnt.whole_deformation)
    channels = _as_channels(grid.image(learnt.coefficients), terms, names)
    if learnt.limits is not None:
        channels |= _as_channels(grid.image(learnt.limits), LIMITS, names)
    error = np.where(seen, detail.error, 0.0)
    for name, values, beside in (("error", error, 0.0), ("seen", seen, 0.0), ("unreliable", detail.unreliable, 1.0)):
        channels[name] = np.nan_to_num(grid.image(values.astype(np.float32)), nan=beside)
    write_exr(path, channels, half)


def _terms(order: int, whole_deformation: bool) -> list[str]:
    return [f"a{m}" for m in range(len(exponents(order, whole_deformation)))]


def _as_channels(image: np.ndarray, rows: Sequence[str], names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """An image (h, w, rows, names) by channel, `row.name`, known beyond the surface's rim too."""
    filled = with_gutter(image)
    return {f"{row}.{name}": filled[..., r, c] for r, row in enumerate(rows) for c, name in enumerate(names)}


def _of_channels(channels: dict[str, np.ndarray], rows: Sequence[str], names: tuple[str, ...]) -> np.ndarray:
    return np.stack([np.stack([channels[f"{row}.{name}"] for name in names], -1) for row in rows], -2)


def _read_map(
    path: Path, record: dict, names: tuple[str, ...], base: Mesh, attachment: Attachment, domain: Domain
) -> DetailMap:
    channels, order, whole = read_exr(path), int(record["order"]), bool(record.get("whole_deformation"))
    terms = _terms(order, whole)
    limited = f"{LIMITS[0]}.{names[0]}" in channels
    wanted = [f"{row}.{name}" for row in (*terms, *(LIMITS if limited else ())) for name in names]
    missing = [name for name in wanted if name not in channels]
    size = int(record["size"])
    if missing or channels["error"].shape != (size, size):
        raise BadInput(f"{path}: not the map that detail.json tells of ({size} x {size}, order {order}); fit it anew")
    grid = texels(base, size)
    coefficients = np.ascontiguousarray(grid.of_image(_of_channels(channels, terms, names)))
    limits = np.ascontiguousarray(grid.of_image(_of_channels(channels, LIMITS, names))) if limited else None
    seen = (
        grid.of_image(channels["seen"]) > 0.5 if "seen" in channels else np.isfinite(grid.of_image(channels["error"]))
    )
    error = np.where(seen, grid.of_image(channels["error"]), np.nan)
    polynomial = PolynomialMap(np.nan_to_num(coefficients), order, seen, limits, whole)
    unreliable = grid.of_image(channels["unreliable"]) > 0.5
    return DetailMap(grid, parameter_field(domain, base, attachment, grid.attachment), polynomial, error, unreliable)
