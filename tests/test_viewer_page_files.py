import base64
import gzip

from mien.viewer.page_files import PAGE, export_page, static
from mien.viewer.studio_scene import Film


def test_the_bundle_is_small_and_asks_nothing_of_the_network():
    script = static("studio.js").decode()
    assert len(script) < 1_000_000
    assert "three.js" in script.lower() or "threejs" in script.lower()
    assert b"MIT" in static("studio.LICENSE")
    for name in PAGE:
        assert "//cdn" not in static(name).decode()


def test_a_written_page_holds_the_scene_and_the_films(tmp_path):
    film = tmp_path / "clip.mp4"
    film.write_bytes(b"film")
    size = export_page(tmp_path / "page", b"scene", [Film("clip.mp4", film)])
    text = (tmp_path / "page" / "scene.js").read_text()
    assert gzip.decompress(base64.b64decode(text.split('"')[1])) == b"scene"
    assert 'src="scene.js"' in (tmp_path / "page" / "index.html").read_text()
    assert (tmp_path / "page" / "media" / "0.mp4").read_bytes() == b"film"
    assert size > 500_000
