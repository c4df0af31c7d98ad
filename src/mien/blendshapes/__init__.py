"""Textured blendshapes from RGB-D captures and textured scans (Casas et al. 2016)."""
