"""Wrinkles and pores from markers by polynomial displacement maps (Ma et al. 2008)."""
