"""How a video asks to be turned."""

import numpy as np

from mien.rgbd.display_matrix import turned


def test_display_matrices_by_hand():
    image = np.arange(6, dtype=np.uint8).reshape(2, 3, 1).repeat(3, 2)
    shown = {m: turned(image, np.reshape(m, (2, 2)))[..., 0].tolist() for m in [
        (1, 0, 0, 1), (0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0), (-1, 0, 0, 1), (0, 1, 1, 0)]}  # fmt: skip
    assert shown[1, 0, 0, 1] == [[0, 1, 2], [3, 4, 5]]
    assert shown[0, 1, -1, 0] == [[3, 0], [4, 1], [5, 2]]
    assert shown[-1, 0, 0, -1] == [[5, 4, 3], [2, 1, 0]]
    assert shown[0, -1, 1, 0] == [[2, 5], [1, 4], [0, 3]]
    assert shown[-1, 0, 0, 1] == [[2, 1, 0], [5, 4, 3]]
    assert shown[0, 1, 1, 0] == [[0, 3], [1, 4], [2, 5]]
