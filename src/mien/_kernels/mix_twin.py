"""Numpy twin of `mix`."""


def products(rows, row):
    """Inner products (s,) of rows (s, n) with row (n,)."""
    return rows.astype(float) @ row


def combine(rows, mix):
    """mix' rows, (k, n)."""
    return mix.T @ rows
