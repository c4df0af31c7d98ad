"""Marker takes (Huang 2011): stabilise, attach, solve; select, register, reconstruct."""
