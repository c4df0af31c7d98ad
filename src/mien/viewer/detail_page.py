"""A page that evaluates both displacement maps, and the reflectance, on the GPU and plays a take."""

import base64
import json
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from ..detail.drive import Drive
from ..detail.fields import DetailMap, parameter_field
from ..detail.fit import DetailModel
from ..detail.synthesize import at_vertices, vertex_attachment
from ..detail.texture_space import texture_gradients, with_gutter
from ..errors import BadInput
from ..files import whole
from ..mesh import Mesh, loop_subdivide, vertex_normals

WIDTH = 512
"""Of textures that hold one vertex a texel."""
MODES = 24
"""Most modes of the base motion that a page carries."""
UP = np.array([0.08, 1.0, 0.03])
"""Not along a normal but by chance: tangents are square to it."""
CLOSE_MM = 0.02
"""The modes reach the thin shell to this rms."""
STATIC = {"detail.html": "index.html", "studio.js": "studio.js", "studio.LICENSE": "studio.LICENSE"}
"""What ships with the package, and its name beside the page's data: the one script of all pages."""


def write_detail_page(folder: str | Path, model: DetailModel, drive: Drive, rate: float) -> int:
    """`index.html`, the pages' script and `data.js` with the take: open `index.html`, no server is needed.

    The base motion is given as modes (its principal components over the take); d1 and d2 as the quadratic forms of
    `ParameterField`. Returns the number of modes.

    Raises:
        BadInput: maps that are not biquadratic, or a take without frames.
    """
    folder = Path(folder)
    maps = [m for m in (model.medium, model.fine, model.reflectance) if m is not None]
    if not all(m.polynomial.biquadratic for m in maps):
        raise BadInput("detail page: its shader evaluates biquadratic maps; fit with order 2, d1 and d2 alone")
    if not len(drive.positions):
        raise BadInput("detail page: the take has no frames")
    folder.mkdir(parents=True, exist_ok=True)
    data = page_data(model, drive, rate)
    for shipped, name in STATIC.items():
        text = files("mien.viewer").joinpath("static", shipped).read_text(encoding="utf-8")
        with whole(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    with whole(folder / "data.js") as temporary:
        temporary.write_text(f"window.DETAIL = {json.dumps(data)};\n", encoding="utf-8")
    return int(data["modes"])


def page_data(model: DetailModel, drive: Drive, rate: float) -> dict:
    """What the shader needs, arrays as base64 of little-endian numbers."""
    base, offsets = model.base, drive.positions - model.reference
    assert base.uv is not None
    _, S = loop_subdivide(base, 0)
    field = parameter_field(model.domain, base, model.attachment, vertex_attachment(base, model, S))
    amounts, modes = base_motion(model, offsets)
    rest = np.concatenate([base.vertices[None], modes])
    along_u, along_v = texture_gradients(base)
    layers = np.concatenate([rest, *(np.stack([G @ mode for mode in rest]) for G in (along_u, along_v))])
    vectors = model.domain.vectors(drive.positions)
    forms = np.stack([field.forms(frame) for frame in vectors])
    driven = at_vertices(model.medium, field, base.uv)
    field, medium = driven.field, driven.polynomial.with_limits()
    place = np.column_stack([field.triangle, field.weights.T])
    drawn = Drawn(layers, medium.transpose(1, 0, 2), place, base.uv, np.zeros(len(base.vertices)), base.faces)
    if model.rims_and_eyes is not None:
        drawn = drawn.beside(model.rims_and_eyes)
    rows = -(-len(drawn.uv) // WIDTH)
    fine = model.fine or model.medium
    return {
        "vertices": len(drawn.uv), "width": WIDTH, "rows": rows, "rate": rate, "frames": len(forms),
        "modes": amounts.shape[1], "triangles": len(field.corners),
        "middle": base.vertices.mean(axis=0).tolist(), "radius": float(np.ptp(base.vertices, axis=0).max() / 2),
        "faces": _packed(drawn.faces, np.uint32), "uv": _packed(drawn.uv), "kind": _packed(drawn.kind),
        "place": _packed(drawn.place), "modes_texture": _packed(_in_rows(drawn.layers, rows)),
        "amounts": _packed(amounts), "forms": _packed(forms),
        "coefficients": _packed(_in_rows(drawn.medium, rows)),
        "fine": _map_texture(fine, 0 if model.fine else None), "fine_size": fine.texels.size,
        "medium": _map_texture(model.medium, 2), "medium_size": model.medium.texels.size,
        "reflectance": None if model.reflectance is None else _color_texture(model.reflectance),
    }  # fmt: skip


@dataclass(frozen=True)
class Drawn:
    """The vertices of the page, and what the shader reads of each."""

    layers: Float[np.ndarray, "l n 3"]
    """Rest and modes of the position, then of dP/du, then of dP/dv."""
    medium: Float[np.ndarray, "8 n 3"]
    """Coefficients and limits."""
    place: Float[np.ndarray, "n 3"]
    """Triangle of the coarse mesh, two barycentric weights."""
    uv: Float[np.ndarray, "n 2"]
    kind: Float[np.ndarray, " n"]
    """As in the shader: 0 has detail, 1 is plain skin, 2 an eyeball."""
    faces: Int[np.ndarray, "m 3"]

    def beside(self, parts: Mesh) -> "Drawn":
        """With plain skin that goes with the vertex at its texture coordinates, and eyeballs, which stay."""
        assert parts.uv is not None
        eye = parts.uv[:, 0] < 0
        near = np.atleast_1d(KDTree(self.uv).query(parts.uv)[1])
        count = len(self.layers) // 3
        layers = np.zeros((3 * count, len(near), 3))
        layers[1:count] = np.where(eye[:, None], 0.0, self.layers[1:count, near])
        layers[0] = parts.vertices
        normals = vertex_normals(parts.vertices, parts.faces)
        layers[count] = np.cross(UP, normals)
        layers[2 * count] = np.cross(normals, layers[count])
        return Drawn(
            layers=np.concatenate([self.layers, layers], 1),
            medium=np.concatenate([self.medium, np.zeros((len(self.medium), len(near), 3))], 1),
            place=np.concatenate([self.place, self.place[near]]),
            uv=np.concatenate([self.uv, np.where(eye[:, None], 0.0, self.uv[near])]),
            kind=np.concatenate([self.kind, 1.0 + eye]),
            faces=np.concatenate([self.faces, parts.faces + len(self.uv)]),
        )


def base_motion(
    model: DetailModel, offsets: Float[np.ndarray, "t k 3"]
) -> tuple[Float[np.ndarray, "t r"], Float[np.ndarray, "r n 3"]]:
    """Amounts and modes: the thin shell's motion over a take, as few as come `CLOSE_MM` near, at least one."""
    flat = offsets.reshape(len(offsets), -1)
    U, singular, Vt = np.linalg.svd(flat, full_matrices=False)
    left = np.sqrt(np.maximum((singular**2).sum() - np.cumsum(singular**2), 0) / len(flat) / model.reference.shape[0])
    enough = int(np.argmax(left < CLOSE_MM)) + 1 if (left < CLOSE_MM).any() else len(singular)
    r = min(max(enough, 1), MODES)
    modes = np.stack([model.shell.response @ row.reshape(-1, 3) for row in Vt[:r]])
    return U[:, :r] * singular[:r], modes


def _in_rows(layers: np.ndarray, rows: int) -> np.ndarray:
    """(l, n, 3) filled up to whole rows of the texture."""
    out = np.zeros((len(layers), rows * WIDTH, 3), np.float32)
    out[:, : layers.shape[1]] = layers
    return out


def _map_texture(detail: DetailMap, channel: int | None) -> str:
    """Four coefficients a texel, then two and the limits, 16-bit; unreliable ones take what is round them. None: 0."""
    size = detail.texels.size
    planes = np.zeros((size, size, 8), np.float16)
    if channel is not None:
        known = detail.polynomial.with_limits()[:, :, channel]
        read = np.where(detail.unreliable[:, None], np.nan, known)
        read = known if np.isnan(read).all() else read
        planes = with_gutter(detail.texels.image(read)).astype(np.float16)
    return _packed(np.concatenate([planes[..., :4].ravel(), planes[..., 4:].ravel()]), np.float16)


def _color_texture(reflectance: DetailMap) -> str:
    """Six layers of red, green and blue coefficients, then least and greatest, 16-bit."""
    image = with_gutter(reflectance.texels.image(reflectance.polynomial.with_limits()))
    return _packed(image.transpose(2, 0, 1, 3), np.float16)


def _packed(values: np.ndarray, kind: type = np.float32) -> str:
    return base64.b64encode(np.ascontiguousarray(values, np.dtype(kind).newbyteorder("<")).tobytes()).decode()
