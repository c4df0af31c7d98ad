"""Displacement maps from markers: how exact, how fast (Ma et al. 2008). `python benchmarks/detail.py --help`."""

import argparse
import time
from dataclasses import replace

import numpy as np

from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.polynomial import PolynomialConfig
from mien.detail.synthesize import SynthesisConfig, Synthesizer
from mien.experiments.detail_stage import DetailStageConfig, detail_errors, detail_stage, kept_in_memory
from mien.stage.seeds import REPORTING_SEEDS

PAPER = {"medium": (0.397, 0.303, 0.296), "fine": (0.00554, 0.00396, 0.00370)}
"""Fitting errors of figure 5, mm: linear, biquadratic, bicubic."""
PAPER_ENERGIES = (76.84, 92.52, 98.46, 99.76, 100.0)
"""Table 1, per cent."""


def clock(work, least: int = 5) -> float:
    """Median seconds of processor time of one call."""
    work()
    spent = []
    for _ in range(least):
        before = time.process_time()
        work()
        spent.append(time.process_time() - before)
    return float(np.median(spent))


def accuracy(stage, config: DetailConfig) -> None:
    """Orders, held-out clips, offsets against strain alone."""
    for order, name in ((1, "linear"), (2, "biquadratic"), (3, "bicubic")):
        with_order = replace(config, medium=PolynomialConfig(order), fine=PolynomialConfig(order))
        before = time.process_time()
        model = fit_detail(stage.training, with_order)
        spent = time.process_time() - before
        medium, fine = (np.nanmean(m.error_mm[~m.unreliable]) for m in (model.medium, model.fine))
        ours = f"medium {medium:.4f} (paper {PAPER['medium'][order - 1]}), fine {fine:.5f} ({PAPER['fine'][order - 1]})"
        print(f"{name:12} rms on training, mm: {ours}; fitted in {spent:.1f} s")
        table(model, stage)
    strain = replace(config.domain, offsets=False)
    table(fit_detail(stage.training, replace(config, domain=strain)), stage, "strain alone, biquadratic")


def table(model, stage, title: str = "") -> None:
    """Errors of every clip, mm."""
    if title:
        print(title)
    print(f"  {'clip':12} {'frozen':>8} {'shell':>8} {'medium':>8} {'+ fine':>8}")
    for part in (stage.training, stage.unseen):
        for name, errors in detail_errors(model, part).items():
            print(f"  {name:12} {errors.line()}")


def speed(model) -> None:
    """Frames a second in memory, and the evaluation beside a copy of its coefficients."""
    markers = model.head.aligned(model.reference[None] * [1, 0.98, 1])[0]
    for levels in (0, 2):
        synthesizer = Synthesizer(model, SynthesisConfig(levels=levels, fine_vertices=levels > 0))
        spent = clock(lambda s=synthesizer: s.frame(markers))
        vertices = len(synthesizer.mesh.vertices)
        print(
            f"{vertices:8,} vertices, both maps: {1 / spent:6.1f} frames/s on one core (paper: 20 with a GPU, 10,000)"
        )
    detail = model.fine
    parameters = detail.field.parameters(np.full((len(model.reference), 5), 0.3))
    evaluated = clock(lambda: detail.polynomial.evaluate(parameters), 21)
    copied = clock(lambda: detail.polynomial.coefficients.copy(), 21)
    print(f"evaluation of {len(parameters):,} texels {1e3 * evaluated:.2f} ms, memcpy {1e3 * copied:.2f} ms, "
          f"ratio {evaluated / copied:.2f}")  # fmt: skip
    print("energies, %:", " ".join(f"{100 * e:.2f}" for e in model.domain.energies), " paper:", *PAPER_ENERGIES)


def main() -> None:
    """One subject."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=REPORTING_SEEDS[0])
    parser.add_argument("--levels", type=int, default=3, help="of the skin; 2 is quick")
    parser.add_argument("--frames", type=int, default=20, help="of a training clip")
    given = parser.parse_args()
    stage = detail_stage(given.seed, DetailStageConfig(levels=given.levels, frames=given.frames))
    stage = replace(stage, training=kept_in_memory(stage.training), unseen=kept_in_memory(stage.unseen))
    print(f"{len(stage.training)} frames of {len(stage.training.mesh.vertices):,} vertices, seed {given.seed}")
    config = DetailConfig()
    accuracy(stage, config)
    speed(fit_detail(stage.training, config))


if __name__ == "__main__":
    main()
