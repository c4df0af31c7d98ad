"""Numpy twin of `boxls`: the same active set, with a fresh dense solve at every step."""

import numpy as np


def boxls(gram, linear, lower, upper, warm, tolerance):
    """min 1/2 w'Gw - b'w, lower <= w <= upper, for every frame; arguments and results as the kernel's."""
    frames = len(linear)
    solved = [_one(gram[t % len(gram)], linear[t], lower, upper, warm[t] if len(warm) else 0 * lower, tolerance)
              for t in range(frames)]
    values, breach, steps = zip(*solved, strict=True)
    return np.array(values), np.array(breach), np.array(steps)


def _one(gram, linear, lower, upper, start, tolerance):
    w = np.clip(start, lower, upper)
    free = (w > lower) & (w < upper)
    scale = max(np.abs(linear).max(), np.abs(linear - gram @ w).max(), 1e-300)
    steps = 0
    while steps < 100 * len(w) + 100:
        w, free = _minimise_free(gram, linear, lower, upper, w, free)
        down = linear - gram @ w
        off = np.where(((down > 0) & (w < upper)) | ((down < 0) & (w > lower)), np.abs(down), 0.0)
        if off.max() <= tolerance * scale:
            break
        free[np.argmax(np.where(free, 0.0, off))] = True
        steps += 1
    return w, off.max() / scale, steps


def _minimise_free(gram, linear, lower, upper, w, free):
    w, free = w.copy(), free.copy()
    while free.any():
        step = np.zeros_like(w)
        step[free] = np.linalg.lstsq(gram[np.ix_(free, free)], (linear - gram @ w)[free], rcond=1e-12)[0]
        goal = w + step
        out = free & ((goal < lower) | (goal > upper))
        if not out.any():
            return goal, free
        bound = np.where(step < 0, lower, upper)
        reach = np.where(out, (bound - w) / np.where(out, step, 1.0), np.inf)
        met = np.argmin(reach)
        w += reach[met] * step
        w[met], free[met] = bound[met], False
    return w, free
