"""A person's rig from their calm face: merged depth, or colour alone (Li et al. 2013, sec. 3)."""
