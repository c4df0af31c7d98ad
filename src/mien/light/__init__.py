"""Active-light captures become detailed scans (Ma et al. 2008, section 3).

A projector throws patterns on a face, two cameras watch; the patterns give points, gradients of light give normals, and
the two are fused. `pipeline` reads like the paper; the files in between are its steps.
"""
