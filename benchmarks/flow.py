"""Optical flow with known truth, beside OpenCV's DIS and scikit-image's TV-L1; prints a table and JSON.

    python benchmarks/flow.py [--json out.json] [--size 512] [--repeats 3]

Textures are functions that can be read anywhere, so that the truth is exact: smooth noise of several scales, sparse
ridges on a zero background, and the mean curvature of the bundled face. The target is brightened by 10 % and a ramp;
both images get noise of 2 % of the texture's spread. Rows of OpenCV or scikit-image are left out where these are
missing.
"""

import argparse
import json
import os
import time
from collections.abc import Callable

import numpy as np
from scipy import ndimage

from mien.faces import load_face
from mien.flow import optical_flow
from mien.mesh import Mesh, curvature_features, loop_subdivide, mean_curvature, submesh, unroll_face

PAD = 64
"""Texture beyond the image, pixels."""


def smooth_noise(rng: np.random.Generator, sigma: float, size: int) -> Callable:
    """Band-limited noise of unit spread as a function of x and y: order-5 splines over periodic noise."""
    noise = ndimage.gaussian_filter(rng.standard_normal((size + 2 * PAD,) * 2), sigma, mode="wrap")
    spline = ndimage.spline_filter(noise / noise.std(), 5, mode="grid-wrap")
    read = {"order": 5, "prefilter": False, "mode": "grid-wrap"}
    return lambda x, y: ndimage.map_coordinates(spline, [y + PAD, x + PAD], **read)


def natural(rng: np.random.Generator, size: int) -> Callable:
    """Noise with the spectrum of a natural image, roughly."""
    scales = [(smooth_noise(rng, sigma, size), weight) for sigma, weight in ((1.2, 0.5), (3, 1), (8, 1.5), (25, 2))]
    return lambda x, y: sum(weight * noise(x, y) for noise, weight in scales)


def ridges(rng: np.random.Generator, size: int) -> Callable:
    """Thin ridges along the zero lines of smooth noise, in patches, values under 0.05 set to zero."""
    fine, broad, patches = (smooth_noise(rng, sigma, size) for sigma in (14, 22, 30))

    def read(x, y):
        patch = patches(x, y)
        strength = 0.25 * np.exp(-((fine(x, y) / 0.18) ** 2)) * np.maximum(patch, 0)
        strength += 0.3 * np.exp(-((broad(x, y) / 0.1) ** 2)) * np.maximum(-patch, 0)
        return np.where(strength < 0.05, 0, strength)

    return read


def face(rng: np.random.Generator, size: int) -> Callable:
    """Mean curvature of the bundled face, unrolled, blurred to what pixels can hold."""
    del rng
    neutral = load_face().rig.neutral
    skin, S = loop_subdivide(Mesh(neutral.vertices, neutral.faces))
    shown = S @ load_face().regions["face"]
    skin, _ = submesh(skin, (shown[skin.faces] > 0.05).all(axis=1))
    flat = unroll_face(skin, pixel_mm=0.45)
    drawn = np.nan_to_num(flat.image().draw(np.clip(curvature_features(mean_curvature(skin, 2.5)), -0.3, 0.3)))
    spline = ndimage.spline_filter(ndimage.gaussian_filter(drawn, 1.0), 5)
    left, top = (drawn.shape[1] - size) / 2, (drawn.shape[0] - size) / 2
    return lambda x, y: ndimage.map_coordinates(spline, [y + top, x + left], order=5, prefilter=False)


def true_flows(size: int) -> dict[str, np.ndarray]:
    """Flows (h, w, 2), pixels: a shift, a turn with zoom, waves, a large move, two halves that part like lips."""
    y, x = np.mgrid[:size, :size].astype(float)
    cx, cy, turn = x - size / 2, y - size / 2, 2 * np.pi
    c, s = 1.03 * np.cos(0.06), 1.03 * np.sin(0.06)
    parting = 4 * np.tanh(cy) * np.exp(-((cx / 120) ** 2) - (cy / 80) ** 2)
    flows = {
        "shift": (np.full_like(x, 3.3), np.full_like(x, -1.7)),
        "turn and zoom": (c * cx - s * cy - cx, s * cx + c * cy - cy),
        "waves": (3 * np.sin(turn * y / 128) * np.cos(turn * x / 200), 2.5 * np.sin(turn * x / 150)),
        "large": (22 + 3 * np.sin(turn * y / 180), -14 + 3 * np.cos(turn * x / 160)),
        "lips": (0.5 * np.sin(turn * x / 150), parting),
    }
    return {name: np.stack(flow, -1) for name, flow in flows.items()}


def pair(texture: Callable, flow: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Source and target images with target(p + flow(p)) = source(p), lit differently and noisy."""
    y, x = np.mgrid[: len(flow), : len(flow)].astype(float)
    source, target = texture(x + flow[..., 0], y + flow[..., 1]), texture(x, y)
    spread = target.std()
    target = 1.1 * target + 0.15 * spread * (1 + x / len(flow))
    return tuple(image + 0.02 * spread * rng.standard_normal(image.shape) for image in (source, target))


def mien(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    return optical_flow(source, target).flow


def dis(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    import cv2

    low, high = min(source.min(), target.min()), max(source.max(), target.max())
    images = [np.uint8(255 * (image - low) / (high - low)) for image in (source, target)]
    return cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM).calc(*images, None)


def tv_l1(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    from skimage.registration import optical_flow_tvl1

    low, high = min(source.min(), target.min()), max(source.max(), target.max())
    v, u = optical_flow_tvl1((source - low) / (high - low), (target - low) / (high - low))
    return np.stack([u, v], -1)


def available(method: Callable) -> bool:
    """Whether the packages of a method are there; warms it up."""
    try:
        method(np.eye(64), np.eye(64))
    except ImportError:
        return False
    return True


def measure(method: Callable, texture: Callable, flow: np.ndarray, repeats: int) -> dict:
    """Mean endpoint error, all over and where the source shows something, pixels; and the least seconds."""
    source, target = pair(texture, flow, np.random.default_rng(1))
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter(), time.process_time()
        found = method(source, target)
        seconds.append((time.perf_counter() - begin[0], time.process_time() - begin[1]))
    y, x = np.mgrid[: len(flow), : len(flow)]
    x, y = x + flow[..., 0], y + flow[..., 1]
    seen = (x >= 0) & (x <= len(flow) - 1) & (y >= 0) & (y <= len(flow) - 1)
    error = np.linalg.norm(found - flow, axis=-1)
    shows = ndimage.gaussian_gradient_magnitude(source, 2)
    strong = seen & (shows > np.quantile(shows, 0.8))
    return {
        "error_px": float(error[seen].mean()),
        "error_on_features_px": float(error[strong].mean()),
        "seconds": min(s for s, _ in seconds),
        "cpu_s": min(c for _, c in seconds),
    }


def three_channels(size: int) -> dict:
    """Three ridge images that move alike, against each of them alone: mean endpoint errors and seconds."""
    rng = np.random.default_rng(7)
    flow = true_flows(size)["waves"]
    pairs = [pair(ridges(rng, size), flow, rng) for _ in range(3)]
    source, target = (np.stack(images, -1) for images in zip(*pairs, strict=True))
    optical_flow(source, target)
    begin = time.perf_counter(), time.process_time()
    found = optical_flow(source, target).flow
    seconds, cpu = time.perf_counter() - begin[0], time.process_time() - begin[1]
    alone = [np.linalg.norm(optical_flow(*p).flow - flow, axis=-1).mean() for p in pairs]
    error = np.linalg.norm(found - flow, axis=-1).mean()
    return {"error_px": float(error), "alone_px": [float(e) for e in alone], "seconds": seconds, "cpu_s": cpu}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    methods = [method for method in (mien, dis, tv_l1) if available(method)]
    rng = np.random.default_rng(0)
    rows = []
    print(f"{'texture':9} {'flow':14}" + "".join(f"{m.__name__:>7} px   s " for m in methods), flush=True)
    for make in (natural, ridges, face):
        name, texture = make.__name__, make(rng, options.size)
        for motion, flow in true_flows(options.size).items():
            found = {m.__name__: measure(m, texture, flow, 1 if m is tv_l1 else options.repeats) for m in methods}
            rows.append({"texture": name, "flow": motion, "methods": found})
            cells = "".join(f"{r['error_px']:8.3f} {r['seconds']:5.2f}" for r in found.values())
            print(f"{name:9} {motion:14}{cells}", flush=True)
    channels = three_channels(options.size)
    print(f"three channels: {channels['error_px']:.3f} px in {channels['seconds']:.2f} s; alone {channels['alone_px']}")
    report = {"size": options.size, "load": os.getloadavg()[0], "rows": rows, "three_channels": channels}
    text = json.dumps(report, indent=1)
    if options.json:
        with open(options.json, "w") as file:
            file.write(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
