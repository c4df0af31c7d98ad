"""`mien detail`: wrinkles and pores from markers, by polynomial displacement maps."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..detail.fit import DetailConfig
from ..detail.synthesize import SynthesisConfig
from ..errors import BadInput
from ..files import existing
from .bar import bar
from .options import refuse_unused, verb
from .outputs import ANY, FOLDER, check_outputs


@verb
def detail(
    what: Literal["fit", "synth", "view"],
    source: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("detail"),
    maps: Path | None = None,
    unit: str | None = None,
    half: bool = False,
    rate: float | None = None,
    place: int | None = None,
    fitting: Annotated[DetailConfig, Parameter(name="*")] = DetailConfig(),
    synthesis: Annotated[SynthesisConfig, Parameter(name="*")] = SynthesisConfig(
        fine_vertices=True, fine_map=False, levels=1
    ),
) -> None:
    """Learn how a person's skin wrinkles from scanned clips (fit), and put it on their takes (synth).

    `fit` reads a folder of clips, each with its markers and one registered mesh a frame, from neutral to an expression,
    and leaves a folder of maps; meshes with colours give a map of the reflectance too. `synth` plays a marker take, or
    any animated face of the same person, with them. `view` writes a page that does so in a browser, on the GPU.

    Parameters
    ----------
    what
        fit, synth or view.
    source
        fit: the folder of clips. synth, view: a take (C3D, TRC, CSV) with the markers of the training, or a performance
        (.glb, .usd) of the same person.
    output
        fit, view: the folder for the maps or the page. synth: a folder for one .ply a frame (with --fine-map its
        displacement and normal map too), a film (.mp4), or, from a performance, a .glb or .usd whose rig has the
        wrinkles as shapes (with --fine-map a .usd has pores as displacement maps, which shapes then lack).
    maps
        synth, view: the folder that fit has left.
    unit
        fit: of the meshes; mm where not given.
    half
        fit: store 16-bit coefficients.
    rate
        synth: frames a second of a take whose file does not say.
    place
        synth: number of a frame in which the face is neutral, for a take whose markers sit elsewhere than in training.
    """
    film = what == "synth" and output.suffix.lower() == ".mp4"
    check_outputs({ANY if film else FOLDER: output}, inputs=[source, maps])
    if what == "fit":
        refuse_unused("with fit", "maps", "rate", "place", "synthesis")
        return fit_maps(existing(source), output, fitting, unit, half)
    refuse_unused(f"with {what}", "unit", "half", "fitting")
    if maps is None:
        raise BadInput(f"{what}: --maps is missing: the folder that `mien detail fit` has left")
    if what == "view":
        refuse_unused("with view", "synthesis")
        return page(existing(source), maps, output, rate, place)
    play(existing(source), maps, output, synthesis, rate, place)


def fit_maps(folder: Path, output: Path, config: DetailConfig, unit: str | None, half: bool) -> None:
    """Clips to maps."""
    import numpy as np

    from ..detail.disk.clips import read_training
    from ..detail.disk.maps import write_detail
    from ..detail.fit import fit_detail

    training, notes = read_training(folder, unit)
    with bar() as progress:
        model = fit_detail(training, config, progress)
        write_detail(output, model, half)
    for note in notes:
        print(note)
    kept = " ".join(f"{100 * energy:.1f}" for energy in model.domain.energies)
    print(f"deformation held by 1 to 5 directions: {kept} %")
    fine = "" if model.fine is None else f", fine {np.nanmedian(model.fine.error):.4f} mm"
    colours = "" if model.reflectance is None else f", albedo {np.nanmedian(model.reflectance.error):.3f}"
    print(
        f"{output}/: {len(training)} frames of {len(training.clips)} clips, {len(training.labels)} markers; residual "
        f"medium {np.nanmedian(model.medium.error):.3f} mm{fine}{colours}; "
        f"{model.medium.unreliable.mean():.0%} of the texels are not reliable"
    )


def play(
    source: Path, maps: Path, output: Path, config: SynthesisConfig, rate: float | None, place: int | None
) -> None:
    """A take with detail."""
    from ..detail.disk.frames import write_film, write_frames
    from ..detail.disk.maps import read_detail
    from ..detail.pipeline import synthesize
    from ..io.markers import read_markers
    from ..io.performances import READ, WRITTEN, read_any_performance

    model = read_detail(maps)
    is_face = source.suffix.lower() in READ
    take = read_any_performance(source) if is_face else read_markers(source, rate=rate)
    if output.suffix.lower() in WRITTEN:
        return export(model, take, output, config)
    with bar() as progress:
        synthesizer, drive, frames = synthesize(model, take, config, progress, place)
        if output.suffix.lower() == ".mp4":
            count = write_film(output, synthesizer, frames, take.rate)
        else:
            count = write_frames(output, synthesizer, drive, frames)
    guessed = int((drive.guessed > 0).sum())
    if guessed:
        print(f"{guessed} markers were filled in from their neighbours in some frames")
    print(f"{output}: {count} frames of {len(synthesizer.mesh.vertices):,} vertices")


def page(source: Path, maps: Path, output: Path, rate: float | None, place: int | None) -> None:
    """A take with detail, in a browser."""
    from ..detail.disk.maps import read_detail
    from ..detail.pipeline import drive_of
    from ..io.markers import read_markers
    from ..io.performances import READ, read_any_performance
    from ..viewer.detail_page import write_detail_page

    model = read_detail(maps)
    is_face = source.suffix.lower() in READ
    take = read_any_performance(source) if is_face else read_markers(source, rate=rate)
    drive = drive_of(model, take, place)
    modes = write_detail_page(output, model, drive, take.rate)
    size = sum(file.stat().st_size for file in output.iterdir()) / 1e6
    print(f"{output}/index.html: {len(drive.positions)} frames, {modes} modes of base motion, {size:.1f} MB")


def export(model, take, output: Path, config: SynthesisConfig) -> None:
    """A performance whose wrinkles show wherever morph targets do."""
    from ..detail.disk.frames import fine_images
    from ..detail.drive import drive_by_performance
    from ..detail.transfer.wrinkle_shapes import with_wrinkles
    from ..io import usd
    from ..io.performances import write_any_performance
    from ..rig import Performance

    if not isinstance(take, Performance):
        raise BadInput(f"{output}: wrinkles go out with a rig; give a performance (.glb), or solve the take first")
    if config.fine_map and output.suffix.lower() not in usd.SUFFIXES:
        raise BadInput(f"{output}: glTF knows no displacement maps; write .usdc or .usdz, or leave out --fine-map")
    if config.fine_map and model.fine is None:
        raise BadInput(f"{output}: the maps have no fine map; fit them with --fine-size, or leave out --fine-map")
    wrinkled, kept = with_wrinkles(model, take, config)
    count = len(wrinkled.rig.names) - len(take.rig.names)
    shapes = f"{count} wrinkle shapes that keep {kept:.0%} of the detail's energy"
    if not config.fine_map:
        write_any_performance(output, wrinkled)
        print(f"{output}: {len(wrinkled)} frames, {shapes}")
        return
    usd.write_performance(output, wrinkled, fine_images(model, drive_by_performance(model, take)))
    print(f"{output}: {len(wrinkled)} frames, {shapes}, and a displacement map a frame")
