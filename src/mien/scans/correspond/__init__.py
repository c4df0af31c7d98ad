"""Scans in one topology and one pose of the head (Huang et al. 2011, sec. 6)."""
