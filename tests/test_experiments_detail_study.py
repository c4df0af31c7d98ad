from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments.detail_study import storage_bytes


def test_bytes_are_those_of_surfaces_and_coefficients():
    clips = training()
    model = fit_detail(clips, DetailConfig(base=BaseConfig(vertices=0), medium_size=24, fine_size=0))
    data, maps, halves = storage_bytes(clips, model)
    assert data == 16 * 33 * 33 * 3 * 4
    assert maps == len(model.medium.texels.pixels) * 18 * 4
    assert halves == maps // 2
