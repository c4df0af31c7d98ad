import base64
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from detail_patch import bent, marker_places, painted, patch, training
from mien.detail.base_mesh import BaseConfig
from mien.detail.drive import Drive
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.polynomial import PolynomialConfig
from mien.detail.synthesize import SynthesisConfig, Synthesizer, at_vertices
from mien.errors import BadInput
from mien.mesh import Mesh
from mien.transforms import Transform
from mien.viewer.detail_page import STATIC, base_motion, page_data, write_detail_page

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=48, fine_size=96)
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--dump-dom")


@pytest.fixture(scope="module")
def played():
    model = fit_detail(painted(training()), SMALL)
    mesh, at = patch(), marker_places(patch())
    still = np.stack([at.points(mesh.with_vertices(bent(mesh.vertices, 0.05 * i, 0.03 * i))) for i in range(5)])
    return model, Drive(model.head.aligned(still), Transform.identity(5), np.zeros(25))


def test_modes_carry_the_thin_shell(played):
    model, drive = played
    amounts, modes = base_motion(model, drive.positions - model.reference)
    shell = model.shell.vertices(drive.positions[-1] - model.reference)
    found = model.base.vertices + np.einsum("r,rnd->nd", amounts[-1], modes)
    assert np.linalg.norm(found - shell, axis=1).max() < 0.1


def test_rims_go_with_the_base_and_eyes_stay(played):
    """Three vertices at places of the base, one of them an eyeball's."""
    model, drive = played
    base, near = model.base, np.array([3, 500, 800])
    uv = np.where([[False], [False], [True]], -1.0, base.uv[near])
    parts = Mesh(base.vertices[near] + [0, 0, -2.0], np.array([[0, 1, 2]]), uv)
    plain, drawn = (page_data(m, drive, 30.0) for m in (model, replace(model, rims_and_eyes=parts)))
    n = len(base.vertices)
    assert (plain["vertices"], drawn["vertices"]) == (n, n + 3)
    assert floats(drawn["kind"]).tolist() == [0.0] * n + [1, 1, 2]
    layers = floats(drawn["modes_texture"]).reshape(3 * (drawn["modes"] + 1), -1, 3)
    np.testing.assert_allclose(layers[0, n : n + 3], parts.vertices, atol=1e-4)
    np.testing.assert_allclose(layers[1 : drawn["modes"] + 1, n : n + 2], layers[1 : drawn["modes"] + 1, near[:2]])
    assert not layers[1 : drawn["modes"] + 1, n + 2].any()
    across = np.cross(layers[drawn["modes"] + 1, n], layers[2 * drawn["modes"] + 2, n])
    normal = np.cross(*np.diff(parts.vertices, axis=0))
    assert across @ normal > 0.99 * np.linalg.norm(across) * np.linalg.norm(normal)


def floats(text):
    """A page's array."""
    return np.frombuffer(base64.b64decode(text), "<f4")


def test_the_page_is_whole_and_small(played, tmp_path):
    model, drive = played
    write_detail_page(tmp_path, model, drive, 30.0)
    assert {file.name for file in tmp_path.iterdir()} == {*STATIC.values(), "data.js"}
    assert sum((tmp_path / name).stat().st_size for name in STATIC.values()) < 1_000_000
    cubic = fit_detail(training(), DetailConfig(SMALL.base, medium_size=16, fine_size=0, medium=PolynomialConfig(3)))
    with pytest.raises(BadInput, match="biquadratic"):
        write_detail_page(tmp_path, cubic, drive, 30.0)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine (Debian: apt install chromium)")
def test_the_shader_finds_what_the_library_finds(played, tmp_path):
    """Places, fine heights and albedo of every vertex, read back from a float target, against the CPU's."""
    model, drive = played
    write_detail_page(tmp_path / "page", model, drive, 30.0)
    texels = read_back(tmp_path, "check=4")[: len(model.base.vertices)]
    made = Synthesizer(model, SynthesisConfig(fine_map=False)).frame(drive.positions[4])
    np.testing.assert_allclose(texels[:, :3], made.vertices, atol=0.1)
    assert np.sqrt(((texels[:, :3] - made.vertices) ** 2).mean()) < 0.01
    vectors = model.domain.vectors(drive.positions)[4]
    expected = at_vertices(model.fine, Synthesizer(model)._medium.field, model.base.uv).values(vectors)[:, 0]
    np.testing.assert_allclose(texels[:, 3], expected, atol=2e-3)
    colours = read_back(tmp_path, "albedo=4")[: len(model.base.vertices), :3]
    assert np.ptp(made.colors[:, 0]) > 0.05
    np.testing.assert_allclose(colours, made.colors, atol=0.02)


def read_back(folder, asked):
    """What the page's shader finds, four numbers a vertex."""
    address = f"{(folder / 'page' / 'index.html').as_uri()}#{asked}"
    profile = f"--user-data-dir={folder / 'profile'}"
    shown = subprocess.run([CHROMIUM, *FLAGS, profile, address], capture_output=True, text=True, timeout=120).stdout
    found = re.search(r'id="readback">([^<]+)<', shown)
    assert found, shown[-2000:]
    return np.frombuffer(base64.b64decode(found[1]), "<f4").reshape(-1, 4)
