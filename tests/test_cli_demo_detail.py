from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from detail_patch import painted, training
from mien.cli.demo_detail import CAPTIONS, draw_figures, play_unseen, report
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments import detail_figures

SMALL = DetailConfig(medium_size=48, fine_size=96, high_pass_mm=4.0)


@pytest.fixture(scope="module")
def subject():
    """The patch in place of a face, its clips under the names of the stage's."""
    whole = painted(training())
    seen = tuple(replace(clip, name=name) for clip, name in zip(whole.clips, ("happy", "anger"), strict=True))
    other = tuple(replace(clip, name=name) for clip, name in zip(whole.clips, ("asymmetric", "speech"), strict=True))
    model = fit_detail(whole, SMALL)
    models = dict.fromkeys(("linear", "biquadratic", "bicubic", "strain"), model)
    return SimpleNamespace(training=replace(whole, clips=seen), unseen=replace(whole, clips=other)), models


def test_every_figure_is_drawn_and_stands_in_the_report(subject, tmp_path, monkeypatch):
    monkeypatch.setattr(detail_figures, "PIXELS", 48)
    stage, models = subject
    play_unseen(tmp_path / "page", stage, models["biquadratic"])
    assert (tmp_path / "page" / "data.js").stat().st_size > 10_000
    figures = draw_figures(stage, models)
    assert set(figures) == set(CAPTIONS)
    assert all(np.ptp(picture) > 50 for picture in figures.values())
    errors = report(tmp_path, stage, models, figures, {"60 other markers": [0.2, 0.1]})
    assert [row[0] for row in errors] == ["happy", "anger", "asymmetric", "speech"]
    page = (tmp_path / "report.html").read_text()
    assert all(f"Figure {number}" in page for number in "345678")
    assert "Reflectance" in page
    assert "60 other markers" in page
    assert (tmp_path / "figure_8.png").is_file()
