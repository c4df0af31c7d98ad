"""Terms of the blendshape fit: what features, the picture and prior knowledge say of the coefficients."""
