"""Scans of clips in one texture space: what displacement maps are learnt from (Ma et al. 2008, end of sec. 3)."""
