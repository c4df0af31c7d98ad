"""A rig of scans and its record."""

import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.gltf import read_rig, write_rig
from mien.scans.scan_rig import marker_record, read_scan_rig, write_record
from small_scans import small_rig


def test_the_record_of_a_rig_reads_back(tmp_path):
    found = small_rig()
    write_rig(tmp_path / "face.glb", found.rig)
    write_record(tmp_path / "face.register.json", {"markers": marker_record(found)})
    back = read_scan_rig(tmp_path / "face.register.json", read_rig(tmp_path / "face.glb"))
    assert (back.labels, back.resting, back.rig.names) == (found.labels, "rest", found.rig.names)
    np.testing.assert_allclose(back.expressions, found.expressions, atol=1e-4)
    there, here = back.attachment.points(back.rig.neutral), found.attachment.points(found.rig.neutral)
    np.testing.assert_allclose(there, here, atol=1e-3)
    (tmp_path / "bad.json").write_text(json.dumps({"markers": {"labels": []}}))
    with pytest.raises(BadInput, match="does not belong"):
        read_scan_rig(tmp_path / "bad.json", found.rig)
