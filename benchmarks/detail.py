"""Displacement maps from markers: how exact, how fast, how big (Ma et al. 2008)."""

import argparse
import time
from dataclasses import replace

import numpy as np

from mien.detail.fit import DetailConfig, DetailModel, fit_detail
from mien.detail.synthesize import SynthesisConfig, Synthesizer
from mien.detail.transfer.wrinkle_shapes import wrinkle_shapes
from mien.experiments.detail_stage import DetailStage, DetailStageConfig, detail_errors, detail_stage, kept_in_memory
from mien.experiments.detail_study import (
    placement_errors,
    reflectance_errors,
    staged_performance,
    storage_bytes,
    transfer_errors,
)
from mien.stage.seeds import REPORTING_SEEDS

PAPER = {"medium": (0.397, 0.303, 0.296), "fine": (0.00554, 0.00396, 0.00370)}
"""Fitting errors of figure 5, mm: linear, biquadratic, bicubic."""
PAPER_ENERGIES = (76.84, 92.52, 98.46, 99.76, 100.0)
"""Table 1, per cent."""


def clock(work, least: int = 9) -> float:
    """Median seconds of processor time of one call."""
    work()
    spent = []
    for _ in range(least):
        before = time.process_time()
        work()
        spent.append(time.process_time() - before)
    return float(np.median(spent))


def accuracy(stage: DetailStage, config: DetailConfig, orders: list[int]) -> None:
    """Orders, held-out clips, offsets against strain alone."""
    names = {1: "linear", 2: "biquadratic", 3: "bicubic"}
    for order in orders:
        with_order = replace(
            config,
            medium=replace(config.medium, order=order),
            fine=replace(config.fine, order=order),
        )
        before = time.process_time()
        model = fit_detail(stage.training, with_order)
        spent = time.process_time() - before
        medium, fine = (np.nanmean(m.error[~m.unreliable]) for m in (model.medium, model.fine))
        ours = f"medium {medium:.4f} (paper {PAPER['medium'][order - 1]}), fine {fine:.5f} ({PAPER['fine'][order - 1]})"
        print(f"{names[order]:12} rms on training, mm: {ours}; fitted in {spent:.1f} s", flush=True)
        table(model, stage)
        if order == 2:
            print("energies, %:", *(f"{100 * e:.2f}" for e in model.domain.energies), " paper:", *PAPER_ENERGIES)
            data, maps, halves = storage_bytes(stage.training, model)
            print(f"training {data / 1e6:.0f} MB, maps {maps / 1e6:.1f} MB (16 bits: {halves / 1e6:.1f}): "
                  f"{data / maps:.0f} and {data / halves:.0f} to 1")  # fmt: skip
    strain = replace(config, domain=replace(config.domain, offsets=False))
    table(fit_detail(stage.training, strain), stage, "strain alone")
    edges = replace(config, domain=replace(config.domain, edge_strain=True))
    table(fit_detail(stage.training, edges), stage, "strain of edges")
    whole = replace(
        config,
        medium=replace(config.medium, whole_deformation=True),
        fine=replace(config.fine, whole_deformation=True),
    )
    table(fit_detail(stage.training, whole), stage, "linear in the whole deformation")


def table(model: DetailModel, stage: DetailStage, title: str = "") -> None:
    """Errors of every clip, mm."""
    if title:
        print(title)
    print(f"  {'clip':12} {'frozen':>8} {'shell':>8} {'medium':>8} {'+ fine':>8} {'of shell':>8}")
    for part in (stage.training, stage.unseen):
        for name, errors in detail_errors(model, part).items():
            print(f"  {name:12} {errors.line()} {errors.full / errors.shell:8.0%}", flush=True)


def reflectance(stage: DetailStage, staged: DetailStageConfig, config: DetailConfig) -> None:
    """Albedo on trained and held-out clips, learnt through dots and held against the skin without them."""
    dotted = detail_stage(stage.seed, replace(staged, dot_radius_mm=1.5))
    clean = detail_stage(stage.seed, replace(staged, dot_radius_mm=0.0))
    model = fit_detail(kept_in_memory(dotted.training), replace(config, fine_size=0))
    print(f"  {'albedo':12} {'static':>8} {'learnt':>8}")
    for part in (clean.training, clean.unseen):
        for name, (static, learnt) in reflectance_errors(model, part, config.base).items():
            print(f"  {name:12} {static:8.4f} {learnt:8.4f} {learnt / static:8.0%}", flush=True)


def placement(stage: DetailStage, config: DetailConfig) -> None:
    """Held-out error under markers that were glued elsewhere, and under more or fewer of them."""
    print("placement: mean error of the held-out clips, mm (shell alone, with maps)")
    model = fit_detail(stage.training, config)
    for name, shell, full in placement_errors(stage, model, config.base):
        print(f"  {name:24} {shell:8.4f} {full:8.4f}", flush=True)


def transfer(stage: DetailStage, config: DetailConfig) -> None:
    """Wrinkles of one subject on another, of whom one neutral scan is known."""
    seed = next(seed for seed in REPORTING_SEEDS if seed != stage.seed)
    other = detail_stage(seed, stage.config, like=stage)
    model = fit_detail(stage.training, config)
    print(f"wrinkles of {stage.seed} on {seed}")
    print(f"  {'clip':12} {'static':>8} {'shell':>8} {'medium':>8} {'+ fine':>8} {'of shell':>8}")
    for name, errors in transfer_errors(model, other, config):
        print(f"  {name:12} {errors.line()} {errors.full / errors.shell:8.0%}", flush=True)


def export(stage: DetailStage, config: DetailConfig) -> None:
    """Share of the detail's energy that at most eight shapes keep, played by the subject's own rig."""
    model = fit_detail(stage.training, config)
    played = staged_performance(stage)
    for most in (4, 8):
        _, wrinkles = wrinkle_shapes(model, played, SynthesisConfig(levels=1), most)
        print(f"exported wrinkles: {most} shapes keep {wrinkles.kept:.1%} of the detail's energy over "
              f"{len(played)} frames", flush=True)  # fmt: skip


def speed(stage: DetailStage, config: DetailConfig) -> None:
    """The fit, frames a second in memory, and the evaluation beside a copy of its coefficients and limits."""
    before, by_the_clock = time.process_time(), time.perf_counter()
    model = fit_detail(stage.training, config)
    spent, by_the_clock = time.process_time() - before, time.perf_counter() - by_the_clock
    sizes = f"{config.medium_size}^2 and {config.fine_size}^2"
    print(f"both maps, {sizes}, from {len(stage.training)} frames: {spent:.1f} s of processor, "
          f"{by_the_clock:.1f} s by the clock", flush=True)  # fmt: skip
    markers = model.head.aligned(model.reference[None] * [1, 0.98, 1])[0]
    for levels in (0, 2):
        dense = SynthesisConfig(levels=levels, fine_vertices=levels > 0, fine_map=levels == 0)
        synthesizer = Synthesizer(model, dense)
        spent = clock(lambda s=synthesizer: s.frame(markers))
        print(f"{len(synthesizer.mesh.vertices):8,} vertices, both maps: {1 / spent:6.1f} frames/s a core (paper: 20 "
              "with a GPU, 10,000)")  # fmt: skip
        many = np.repeat(markers[None], 60, axis=0)
        before = time.perf_counter()
        frames = sum(1 for _ in synthesizer.frames(many))
        print(f"{'':8} two frames at a time: {frames / (time.perf_counter() - before):6.1f} frames/s by the clock")
    driven = model.fine.driven
    vectors = np.full((len(model.reference), 5), 0.3)
    evaluated = clock(lambda: driven.values(vectors), 31)
    read = driven.polynomial.with_limits()
    copied = clock(lambda: read.copy(), 31)
    texels = len(driven.field.triangle)
    print(f"evaluation of {texels:,} texels {1e3 * evaluated:.2f} ms, memcpy {1e3 * copied:.2f} ms, "
          f"ratio {evaluated / copied:.2f}")  # fmt: skip


def growth(stage: DetailStage, config: DetailConfig) -> None:
    """Seconds of fitting and milliseconds of evaluation over texels, frames and markers."""
    few = replace(stage.training, clips=stage.training.clips[:3])
    for name, training, changed in (
        ("half the texels' side", few, replace(config, medium_size=256, fine_size=512)),
        ("as it is", few, config),
        ("twice the frames", stage.training, config),
    ):
        before = time.process_time()
        model = fit_detail(training, changed)
        spent = time.process_time() - before
        vectors = np.full((len(model.reference), 5), 0.3)
        evaluated = clock(lambda m=model, v=vectors: m.fine.driven.values(v))
        print(f"  {name:24} {len(training):4} frames: fit {spent:6.1f} s, evaluation {1e3 * evaluated:6.2f} ms")
    sizes = DetailStageConfig(levels=2, frames=6)
    for markers in (60, 178):
        other = detail_stage(1, replace(sizes, markers=markers)).training
        model = fit_detail(other, replace(config, medium_size=128, fine_size=0))
        synthesizer = Synthesizer(model)
        print(f"  {markers:4} markers: a frame {1e3 * clock(lambda s=synthesizer: s.frame(s.model.reference)):6.2f} ms")


def main() -> None:
    """One subject."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=REPORTING_SEEDS[0])
    parser.add_argument("--kind", choices=("muscles", "bent"), default="muscles")
    parser.add_argument("--levels", type=int, default=3, help="of the skin; 2 is quick")
    parser.add_argument("--frames", type=int, default=20, help="of a training clip")
    parser.add_argument("--clips", nargs="*", help="training clips by name; all where not given")
    parser.add_argument("--size", type=int, default=512, help="of the medium map; the fine one has twice as much")
    parser.add_argument("--orders", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--only", nargs="*", default=["accuracy", "placement", "speed", "growth"])
    given = parser.parse_args()
    before = time.process_time()
    staged = DetailStageConfig(kind=given.kind, levels=given.levels, frames=given.frames)
    stage = detail_stage(given.seed, staged)
    if given.clips:
        clips = tuple(clip for clip in stage.training.clips if clip.name in given.clips)
        stage = replace(stage, training=replace(stage.training, clips=clips))
    stage = replace(stage, training=kept_in_memory(stage.training), unseen=kept_in_memory(stage.unseen))
    vertices = len(stage.training.mesh.vertices)
    print(f"{given.kind}, seed {given.seed}: {len(stage.training)} frames of {vertices:,} vertices, "
          f"made in {time.process_time() - before:.0f} s", flush=True)  # fmt: skip
    config = DetailConfig(medium_size=given.size, fine_size=2 * given.size)
    parts = {"accuracy": lambda: accuracy(stage, config, given.orders), "placement": lambda: placement(stage, config),
             "reflectance": lambda: reflectance(stage, staged, config),
             "transfer": lambda: transfer(stage, config), "export": lambda: export(stage, config),
             "speed": lambda: speed(stage, config), "growth": lambda: growth(stage, config)}  # fmt: skip
    for name in given.only:
        parts[name]()


if __name__ == "__main__":
    main()
