"""Shapes of a rig relearnt from what the picture shows: how skin slips along the tracked face."""
