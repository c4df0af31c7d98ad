"""Markers alone to an animated face."""
