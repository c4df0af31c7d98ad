"""Faces fitted to what was measured: the morphable model, the shrink-wrap, single scans."""
