"""mien: facial performance capture. Marker mocap, 3D scans, RGB-D video in; an animated face with a rig out."""

__version__ = "0.1.0"
