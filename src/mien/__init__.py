"""mien: facial performance capture. Marker mocap, 3D scans, RGB-D video in; an animated face with a rig out.

The names of `dir(mien)` are the ones to begin with; each is imported when it is first used. Every step below them is a
plain function on arrays in the room that its paper's system has (`mien.takes`, `mien.scans`, `mien.tracking`, ...).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:  # what editors see
    from .camera import Camera as Camera
    from .clip import Markers as Markers
    from .depth import RGBDFrame as RGBDFrame
    from .errors import BadInput as BadInput
    from .faces.bundled import load_face as load_face
    from .fitting.register_scan import register_scan as register_scan
    from .fitting.register_scan import registered_rig as registered_rig
    from .io.livelink import read_live_link as read_live_link
    from .io.livelink import write_live_link as write_live_link
    from .io.markers import read_markers as read_markers
    from .io.markers import write_c3d as write_c3d
    from .io.meshes import read_scan as read_scan
    from .io.meshes import write_mesh as write_mesh
    from .io.performances import read_any_performance as read_performance
    from .io.performances import write_any_performance as write_performance
    from .io.rigs import read_any_rig as read_rig
    from .io.rigs import write_any_rig as write_rig
    from .markers.pipeline import solve_take as solve_markers
    from .mesh import Attachment as Attachment
    from .mesh import Mesh as Mesh
    from .mesh import Scan as Scan
    from .pictures.notebook import show as show
    from .rgbd import read_rgbd as read_rgbd
    from .rgbd import write_rgbd as write_rgbd
    from .rig import Performance as Performance
    from .rig import Rig as Rig
    from .rig.retarget import retarget as retarget
    from .scans.pipeline import register_scans as register_scans
    from .scans.reconstruct import solve_on_scans as solve_on_scans
    from .scans.scan_files import match_scans as match_scans
    from .scans.scan_files import read_scans as read_scans
    from .scans.select.take_selection import select_take as select_frames
    from .tracking.person.personalize import personalize as personalize
    from .tracking.pipeline import track_take as track
    from .transforms import Transform as Transform

_PLACES = {
    "Attachment": "mesh",
    "BadInput": "errors",
    "Camera": "camera",
    "Markers": "clip",
    "Mesh": "mesh",
    "Performance": "rig",
    "RGBDFrame": "depth",
    "Rig": "rig",
    "Scan": "mesh",
    "Transform": "transforms",
    "load_face": "faces.bundled",
    "match_scans": "scans.scan_files",
    "personalize": "tracking.person.personalize",
    "read_live_link": "io.livelink",
    "read_markers": "io.markers",
    "read_performance": "io.performances:read_any_performance",
    "read_rgbd": "rgbd",
    "read_rig": "io.rigs:read_any_rig",
    "read_scan": "io.meshes",
    "read_scans": "scans.scan_files",
    "register_scan": "fitting.register_scan",
    "register_scans": "scans.pipeline",
    "registered_rig": "fitting.register_scan",
    "retarget": "rig.retarget",
    "select_frames": "scans.select.take_selection:select_take",
    "show": "pictures.notebook",
    "solve_markers": "markers.pipeline:solve_take",
    "solve_on_scans": "scans.reconstruct",
    "track": "tracking.pipeline:track_take",
    "write_c3d": "io.markers",
    "write_live_link": "io.livelink",
    "write_mesh": "io.meshes",
    "write_performance": "io.performances:write_any_performance",
    "write_rgbd": "rgbd",
    "write_rig": "io.rigs:write_any_rig",
}
"""Public name -> its module, and after a colon its name there where that is another."""


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'mien' has no attribute {name!r}")
    module, _, there = _PLACES[name].partition(":")
    value = getattr(import_module(f".{module}", __name__), there or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*_PLACES, "__version__"]
