"""The papers' figures and tables on the synthetic stage."""
