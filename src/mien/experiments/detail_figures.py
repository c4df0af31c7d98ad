"""Figures 3 to 8 of Ma et al. 2008 redrawn on the stage."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int, UInt8

from ..detail.fields import parameter_field
from ..detail.fit import DetailConfig, DetailModel, HighPass
from ..detail.sampling import Sampler
from ..detail.synthesize import SynthesisConfig, Synthesizer, coloured, vertex_attachment
from ..detail.texture_space import Texels, texel_mm
from ..detail.training import Aligned, Clip, HeadMarkers, TrainingSet
from ..mesh import Mesh, loop_subdivide
from ..pictures import Renderer, View, colors_of, contact_sheet, frontal_camera
from ..pictures.color import to_bytes, to_srgb
from ..pictures.render import Look
from .detail_stage import evaluated, layers

PIXELS = 300
"""Side of a face in a figure."""
FIELD_MM = 2.0
"""Figure 3's colours reach from -2 to 2."""
DENSE = 1
"""Rounds of subdivision under a synthesis that is looked at."""
LOOK = Look(occlusion=12)
"""Few rays: a demo is to be over soon."""
CLOSE_MM = 16.0
"""Half the side of a close-up."""

Picture = UInt8[np.ndarray, "h w 3"]


def last_frame(training: TrainingSet, clip: Clip, head: HeadMarkers | None = None) -> Aligned:
    """A clip's extreme with the head's motion taken out."""
    T = (head or training.head).pose(clip.markers[-1:]).inverse()[0]
    *_, frame = clip.frames()
    return Aligned(T.apply(clip.markers[-1]), T.apply(frame.vertices.astype(float)), frame.colors)


def vectors_of(model: DetailModel, aligned: Aligned) -> Float[np.ndarray, "k 5"]:
    """A frame's deformation vectors."""
    return model.domain.vectors(aligned.markers[None])[0]


def deformation_fields(model: DetailModel, training: TrainingSet) -> Picture:
    """Figure 3: every expression's extreme, and d1 and d2 over it."""
    dense, S = loop_subdivide(model.base, 1)
    field = parameter_field(model.domain, model.base, model.attachment, vertex_attachment(dense, model, S))
    heat = Renderer(dense, Look(occlusion=0, colormap="diverging", limits=(-FIELD_MM, FIELD_MM)))
    skin, view = Renderer(Mesh(training.mesh.vertices, training.mesh.faces), LOOK), frontal_camera(model.base, PIXELS)
    rows, names = [[], [], []], []
    for clip in training.clips:
        aligned = last_frame(training, clip)
        d = field.parameters(vectors_of(model, aligned)).astype(float)
        rows[0].append(skin.draw(*view, vertices=aligned.vertices))
        rows[1].append(heat.draw(*view, values=d[:, 0]))
        rows[2].append(heat.draw(*view, values=d[:, 1]))
        names.append(clip.name)
    captions = [*names, *(f"d1 {n}" for n in names), *(f"d2 {n}" for n in names)]
    return contact_sheet([*rows[0], *rows[1], *rows[2]], captions, columns=len(names))


def synthesized(model: DetailModel, aligned: Aligned, medium: bool = True, fine: bool = True) -> Mesh:
    """A frame in dense triangles."""
    config = SynthesisConfig(levels=DENSE, medium=medium, fine_vertices=fine, fine_map=False)
    made = Synthesizer(model, config)
    return made.mesh.with_vertices(made.frame(aligned.markers).vertices.astype(float))


def layers_sheet(model: DetailModel, frames: dict[str, tuple[TrainingSet, Aligned]]) -> Picture:
    """Figure 8: shell, + medium, + fine, truth; one row a frame."""
    view, pictures, captions = frontal_camera(model.base, PIXELS), [], []
    for name, (training, aligned) in frames.items():
        made = [
            synthesized(model, aligned, medium=False, fine=False),
            synthesized(model, aligned, fine=False),
            synthesized(model, aligned),
            shown_mesh(aligned.vertices, training.mesh.faces),
        ]
        pictures += [Renderer(mesh, LOOK).draw(*view) for mesh in made]
        captions += [f"{name}: {layer}" for layer in ("shell", "+ medium", "+ fine", "truth")]
    return contact_sheet(pictures, captions, columns=4)


def shown_mesh(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Mesh:
    """A frame's surface without triangles at vertices that it does not show (NaN)."""
    seen = np.asarray(np.isfinite(vertices).all(axis=1))
    return Mesh(np.nan_to_num(vertices), faces[seen[faces].all(axis=1)])


def strain_sheet(with_offsets: DetailModel, strain: DetailModel, training: TrainingSet, aligned: Aligned) -> Picture:
    """Figure 4: strain only, truth, offsets too."""
    view = frontal_camera(with_offsets.base, PIXELS)
    meshes = (
        synthesized(strain, aligned),
        Mesh(aligned.vertices, training.mesh.faces),
        synthesized(with_offsets, aligned),
    )
    captions = ["2D strain only", "truth", "with offsets"]
    return contact_sheet([Renderer(mesh, LOOK).draw(*view) for mesh in meshes], captions, columns=3)


def error_sheet(models: dict[str, DetailModel]) -> Picture:
    """Figure 5: what each order leaves of the training data, in texture space; one scale a row."""
    pictures, captions = [], []
    for layer in ("fine", "medium"):
        maps = {name: getattr(model, layer) for name, model in models.items()}
        top = max(float(np.nanquantile(m.error, 0.95)) for m in maps.values())
        for name, detail in maps.items():
            pictures.append(_painted(detail.texels, detail.error, (0.0, top), "heat"))
            captions.append(f"{layer}, {name}: 0 to {top:.2g} mm")
    return contact_sheet(pictures, captions, columns=len(models))


def map_sheet(model: DetailModel, medium: Sampler, fine: Sampler, aligned: Aligned) -> Picture:
    """Figure 6: synthesised maps over true ones: medium along the normal, and what it leaves."""
    assert model.fine is not None
    vectors = vectors_of(model, aligned)
    true_medium = medium.displacement(aligned)[:, 2]
    left = fine.displacement(aligned)[:, 2] - layers(model, fine, vectors)[0][:, 2]
    width = DetailConfig().high_pass_mm / texel_mm(model.base, fine.texels.size)
    true_fine = HighPass(fine.texels, width)(left)
    made_medium = model.medium.texels.of_image(evaluated(model.medium, vectors))[:, 2]
    made_fine = model.fine.texels.of_image(evaluated(model.fine, vectors))[:, 0]
    pictures, captions = [], []
    for grid, made, truth, name in (
        (medium.texels, made_medium, true_medium, "medium"), (fine.texels, made_fine, true_fine, "fine")
    ):  # fmt: skip
        reach = float(np.nanquantile(np.abs(made), 0.98))
        pictures += [_painted(grid, values, (-reach, reach), "diverging") for values in (made, truth)]
        captions += [f"{name}, synthesised: {reach:.2g} mm", f"{name}, truth"]
    return contact_sheet(pictures, captions, columns=2)


def _painted(grid: Texels, values: np.ndarray, limits: tuple[float, float], colormap: str) -> Picture:
    image = grid.image(values.astype(float))
    rows = np.arange(PIXELS) * grid.size // PIXELS
    return to_bytes(colors_of(image[rows][:, rows], limits, colormap))


def pore_sheet(model: DetailModel, training: TrainingSet, aligned: Aligned, at: Float[np.ndarray, " 3"]) -> Picture:
    """Figure 7: a cheek under the neutral's static map, the truth, and the polynomial map."""
    view = close_up(aligned.vertices, at)
    still = synthesized(frozen(model), aligned)
    meshes = (still, Mesh(aligned.vertices, training.mesh.faces), synthesized(model, aligned))
    captions = ["static map", "truth", "polynomial map"]
    return contact_sheet([Renderer(mesh, LOOK).draw(*view) for mesh in meshes], captions, columns=3)


def color_sheet(model: DetailModel, training: TrainingSet, aligned: Aligned) -> Picture:
    """Reflectance: what was photographed, dots and all; the neutral's colours; those of the frame."""
    assert aligned.colors is not None
    view = frontal_camera(model.base, PIXELS)
    photographed = replace(shown_mesh(aligned.vertices, training.mesh.faces), colors=to_srgb(aligned.colors))
    meshes = [photographed]
    for learnt in (frozen(model), model):
        made = Synthesizer(learnt, SynthesisConfig(levels=DENSE, fine_vertices=True, fine_map=False))
        frame = made.frame(aligned.markers)
        meshes.append(coloured(made.mesh.with_vertices(frame.vertices.astype(float)), frame))
    captions = ["photographed", "static map", "polynomial map"]
    return contact_sheet([Renderer(mesh, LOOK).draw(*view) for mesh in meshes], captions, columns=3)


def close_up(vertices: Float[np.ndarray, "n 3"], at: Float[np.ndarray, " 3"]) -> View:
    """A camera before a spot of the face, from the side that it looks to."""
    near = vertices[np.linalg.norm(vertices - at, axis=1) < CLOSE_MM]
    yaw = float(np.arctan2(at[0], np.ptp(vertices[:, 2]) / 2))
    return frontal_camera(Mesh(vertices, np.zeros((0, 3), np.int64)), PIXELS, yaw=yaw, frame=near, margin=0.0)


def frozen(model: DetailModel) -> DetailModel:
    """The neutral's static maps: the constant terms alone."""
    parts = {}
    for layer in ("medium", "fine", "reflectance"):
        detail = getattr(model, layer)
        if detail is None:
            continue
        coefficients = detail.polynomial.coefficients.copy()
        coefficients[:, :-1] = 0
        parts[layer] = replace(detail, polynomial=replace(detail.polynomial, coefficients=coefficients))
    return replace(model, **parts)
