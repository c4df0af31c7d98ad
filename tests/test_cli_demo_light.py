from dataclasses import replace

import numpy as np

from detail_patch import training
from mien.cli.demo_light import report, scan_sheet
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments import detail_figures
from mien.experiments.light_clips import ChainErrors


def test_the_page_holds_the_scans_the_table_and_what_was_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(detail_figures, "PIXELS", 48)
    whole = training()
    model = fit_detail(whole, DetailConfig(medium_size=48, fine_size=96, high_pass_mm=4.0))
    seen, other = replace(whole, clips=whole.clips[:1]), replace(whole, clips=whole.clips[1:])
    errors = {clip.name: ChainErrors(0.1, 0.2, 0.3, 0.4) for clip in whole.clips}
    report(tmp_path, model, seen, other, errors, ("happy, capture 3 left out: dark",))
    page = (tmp_path / "report.html").read_text()
    assert "capture 3 left out" in page
    assert all(clip.name in page for clip in whole.clips)
    assert (tmp_path / "scans.png").is_file()
    assert (tmp_path / "layers.png").is_file()


def test_what_a_scan_does_not_show_is_not_drawn():
    whole = training()
    half = np.where((whole.mesh.vertices[:, 0] > 0)[:, None], whole.mesh.vertices, np.nan)
    part = scan_sheet(replace(whole, clips=whole.clips[:1]), [whole.mesh.vertices, half])
    left, right = np.array_split(part.astype(int), 2, axis=1)
    assert np.abs(left - right).mean() > 5
