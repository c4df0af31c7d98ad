"""From maps in correspondence to a rig whose textures blend with its shapes (Casas et al. 2016, sec. 5)."""
