"""Marker take and scans to a high-resolution rig (Huang 2011): select, register, reconstruct."""
