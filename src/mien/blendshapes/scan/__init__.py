"""A held expression before an RGB-D sensor becomes one map of the face (Casas et al. 2016, sec. 3)."""
