from mien.viewer.moving_page import ALIVE, moving_page
from studio_things import nodding


def test_a_performance_is_one_page_that_plays():
    page = moving_page(nodding(3), "perf.glb", opening=ALIVE)
    assert f'MIEN_OPENING = "{ALIVE}"' in page
    assert "MIEN_SCENE" in page
    assert 'src="' not in page
    assert 'rel="stylesheet"' not in page
