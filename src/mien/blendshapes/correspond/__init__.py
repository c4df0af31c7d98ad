"""Which point of an expression's map is which of the neutral's (Casas et al. 2016, sec. 4)."""
