"""Oracle of the signals: values computed with NumPy and SciPy, from the equations.

    pip install -r tests/oracles/requirements.txt
    python3 tests/oracles/signals.py            # writes signals.json beside itself
    python3 tests/oracles/signals.py DUMP       # prints values for a dump of real frames, see below

Everything is float64 and straightforward: whole fields of every window are built and smoothed with
scipy.ndimage.correlate1d, covariances come from numpy.cov, generalised eigenvalues from
scipy.linalg.eigh, histograms from numpy.bincount. Frames come from an integer formula that the tests
repeat. Boxes are [x, y, w, h] in pixels from 0; frames count from 0.

DUMP is a folder with `boxes.txt` (x,y,w,h a line), `size.txt` (width height) and `NNNN.rgb` (raw RGB).
"""

import json
import math
import pathlib
import sys

import numpy as np
import scipy
import scipy.linalg
import scipy.ndimage


# --- frames ---------------------------------------------------------------------------------------


def frame(kind, width, height, t):
    """A frame from integers alone: gradients, a moving block and noise."""
    x = np.arange(width, dtype=np.int64)[None, :, None]
    y = np.arange(height, dtype=np.int64)[:, None, None]
    c = np.arange(3, dtype=np.int64)[None, None, :]
    if kind == "grey":
        c = c * 0
    seed = x * 7919 + y * 104729 + c * 1299709 + t * 15485863
    noise = ((seed * 1664525 + 1013904223) % 2**32) >> 27
    block = (x >= 8 + 2 * t) & (x < 20 + 2 * t) & (y >= 7 + t) & (y < 21 + t)
    value = (2 * x + 3 * y + 40 * c + t) % 180 + np.where(block, 60 - 25 * c, 0) + noise
    if kind == "harsh":
        value = np.clip(3 * value - 250, 0, 255)
    return np.clip(value, 0, 255).astype(np.uint8)


def round_half_away(v):
    return int(math.copysign(math.floor(abs(v) + 0.5), v))


def window(box, image, outside):
    """Left, top, width, height in pixels."""
    x, y = round_half_away(box[0]), round_half_away(box[1])
    w, h = max(1, round_half_away(box[2])), max(1, round_half_away(box[3]))
    if outside == "shift":
        x = min(max(x, 0), max(image.shape[1] - w, 0))
        y = min(max(y, 0), max(image.shape[0] - h, 0))
    return x, y, w, h


def patch(image, win):
    """Pixels of a window, border pixels repeated."""
    x, y, w, h = win
    rows = np.clip(np.arange(y, y + h), 0, image.shape[0] - 1)
    columns = np.clip(np.arange(x, x + w), 0, image.shape[1] - 1)
    return image[np.ix_(rows, columns)]


def cut_patch(image, box):
    """Pixels of a box that is shifted inside and cut to the frame."""
    x, y, w, h = window(box, image, "shift")
    return image[y : y + h, x : x + w], x, y


# --- distribution field (y_t) -----------------------------------------------------------------------

FIELD = dict(
    layers=32, sigma_u=1.0, sigma_v=2.0, sigma_layer=0.625, history=10, support_u=9, support_v=15,
    support_layer=5, smoothing="anisotropic", border="uniform", regions="corners", displacement="past", outside="shift",
)  # fmt: skip


def gauss(sigma, support):
    r = np.arange(support) - support // 2
    g = np.exp(-(r**2) / (2 * sigma**2))
    return g / g.sum()


def field(pixels, p, sigma_u, support_u, sigma_v, support_v):
    """d''(i, j, c, m) of a patch."""
    m = p["layers"]
    values = pixels.astype(np.float64)
    # ceil(value / (255 / M)); the product is exact in float64.
    layer = np.maximum(np.ceil(values * m / 255), 1)
    exploded = (layer[..., None] == np.arange(1, m + 1)).astype(np.float64)
    a, b = support_v // 2, support_u // 2
    sides = ((a, a), (b, b), (0, 0), (0, 0))
    if p["border"] == "replicate":
        d = np.pad(exploded, sides, mode="edge")
    else:
        d = np.pad(exploded, sides, constant_values=1 / m if p["border"] == "uniform" else 0.0)
    d = scipy.ndimage.correlate1d(d, gauss(sigma_v, support_v), axis=0, mode="constant")
    d = scipy.ndimage.correlate1d(d, gauss(sigma_u, support_u), axis=1, mode="constant")
    d = d[a : d.shape[0] - a, b : d.shape[1] - b]
    before = d.sum(axis=3, keepdims=True)
    d = scipy.ndimage.correlate1d(d, gauss(p["sigma_layer"], p["support_layer"]), axis=3, mode="constant")
    return d + (before - d.sum(axis=3, keepdims=True)) / m


def centre(box):
    return np.array([box[0] + box[2] / 2, box[1] + box[3] / 2])


def background(boxes, t, p):
    """Centre and size of B_t. Eq. 1 with frames from 1 as in the paper: x[1] ... x[t]."""
    x = [None] + [np.array(b, dtype=float) for b in boxes[: t + 1]]
    now = t + 1
    if now == 1:
        w, h = x[1][2:]
        at = centre(x[1])
    else:
        w, h = x[now - 1][2:]
        last = now if p["displacement"] == "printed" else now - 1
        k = min(p["history"], last - 1)
        steps = [centre(x[s]) - centre(x[s - 1]) for s in range(last - k + 1, last + 1)]
        at = centre(x[now - 1]) + (np.mean(steps, axis=0) if steps else 0.0)
    grow = math.ceil((w + h) / 4)
    return at, w + grow, h + grow


def y_t(image, boxes, t, p):
    (cx, cy), bw, bh = background(boxes, t, p)
    w, h = boxes[t][2:]
    bw, bh = max(bw, w), max(bh, h)
    left, right, mid_x = cx - bw / 2, cx + bw / 2 - w, cx - w / 2
    top, bottom, mid_y = cy - bh / 2, cy + bh / 2 - h, cy - h / 2
    if p["regions"] == "corners":
        places = [(left, top), (right, top), (left, bottom), (right, bottom)]
    else:
        places = [(left, mid_y), (right, mid_y), (mid_x, top), (mid_x, bottom)]
    state = patch(image, window(boxes[t], image, p["outside"]))
    if p["smoothing"] == "anisotropic":
        levels = [(p["sigma_u"], p["support_u"], p["sigma_v"], p["support_v"])]
    else:
        levels = [(p[s], p[q], p[s], p[q]) for s, q in (("sigma_u", "support_u"), ("sigma_v", "support_v"))]
    scores = []
    for level in levels:
        state_field = field(state, p, *level)
        for x, y in places:
            other = patch(image, window((x, y, w, h), image, p["outside"]))
            gap = np.abs(state.mean(axis=(0, 1)) - other.mean(axis=(0, 1)))
            if np.all(state.sum(axis=(0, 1), dtype=np.int64) == other.sum(axis=(0, 1), dtype=np.int64)):
                omega = np.full(3, 1 / 3)
            else:
                omega = gap / gap.sum()
            l1 = np.abs(state_field - field(other, p, *level)).sum(axis=(0, 1, 3))
            scores.append((omega * l1).sum() / (state.shape[0] * state.shape[1] * p["layers"]))
    return float(np.mean(scores))


# --- region covariance ------------------------------------------------------------------------------


def covariance(image, box, p):
    pixels, x, y = cut_patch(image, box)
    h, w = pixels.shape[:2]
    rows, columns = np.mgrid[y : y + h, x : x + w]
    z = np.vstack([columns.ravel(), rows.ravel(), pixels.reshape(-1, 3).T]).astype(np.float64)
    c = np.cov(z) if w * h > 1 else np.zeros((5, 5))
    grey = bool(np.all(pixels == pixels[..., :1]))
    more = p["ridge"] * np.array([w * h, w * h, 255.0**2, 255.0**2, 255.0**2])
    if grey:
        more = more + p["grey_ridge"] * np.diag(c)
    return c + np.diag(more)


def covariance_distance(image, last_image, boxes, t, p):
    if t == 0:
        return 0.0
    lam = scipy.linalg.eigh(covariance(image, boxes[t], p), covariance(last_image, boxes[t - 1], p), eigvals_only=True)
    return float(np.sqrt((np.log(lam) ** 2).sum()))


# --- histograms -------------------------------------------------------------------------------------


def weights(pixels):
    h, w = pixels.shape[:2]
    y, x = np.mgrid[0:h, 0:w] + 0.5
    return (w / 2) ** 2 + (h / 2) ** 2 + 1 - (x - w / 2) ** 2 - (y - h / 2) ** 2


def rgb_histogram(image, box, p):
    pixels, _, _ = cut_patch(image, box)
    n = p["bins"]
    b = np.floor(pixels / (256 / n)).astype(int)
    at = (b[..., 0] * n + b[..., 1]) * n + b[..., 2]
    return np.bincount(at.ravel(), weights(pixels).ravel(), n**3)


def lbp_codes(image, threshold):
    """riu2 codes of a whole frame by bilinear sampling on the unit circle, zeros around the frame."""
    grey = np.floor(image.astype(np.int64) @ np.array([2989, 5870, 1140]) / 10000 + 0.5)
    h, w = grey.shape
    g = np.pad(grey, 1)
    bits = []
    for k in range(8):
        dx, dy = math.cos(k * math.pi / 4), -math.sin(k * math.pi / 4)
        fx, fy = math.floor(dx + 1e-12), math.floor(dy + 1e-12)
        rx, ry = dx - fx, dy - fy
        value = np.zeros((h, w))
        for ox, wx in ((fx, 1 - rx), (fx + 1, rx)):
            for oy, wy in ((fy, 1 - ry), (fy + 1, ry)):
                if wx * wy > 1e-12:
                    value += wx * wy * g[1 + oy : 1 + oy + h, 1 + ox : 1 + ox + w]
        bits.append(value + 1e-6 >= grey + threshold)
    bits = np.array(bits)
    changes = (bits != np.roll(bits, 1, axis=0)).sum(axis=0)
    return np.where(changes <= 2, bits.sum(axis=0), 9)


def lbp_histogram(image, box, p):
    pixels, x, y = cut_patch(image, box)
    h, w = pixels.shape[:2]
    code = lbp_codes(image, p["lbp_threshold"])[y : y + h, x : x + w]
    keep = (code >= 2) & (code <= 6)
    n = (p["red_bins"], p["green_bins"], p["blue_bins"])
    r, g, b = (np.floor(pixels[..., c] / (256 / n[c])).astype(int) for c in range(3))
    at = ((r * n[1] + g) * n[2] + b) * 5 + code - 2
    return np.bincount(at[keep], weights(pixels)[keep], n[0] * n[1] * n[2] * 5)


def similarity(a, b):
    if a.sum() == 0 or b.sum() == 0:
        return 1.0 if a.sum() == b.sum() else 0.0
    return float(np.sqrt(a / a.sum() * (b / b.sum())).sum())


# --- motion of boxes and correlation with a template ----------------------------------------------------


def motion(measure, images, boxes):
    """The largest and smallest values, +-1000, are not reached by these tracks."""
    b = np.array(boxes, dtype=float)
    sides = np.maximum(b[:, 2:], 1)
    c, size = b[:, :2] + sides / 2, np.sqrt(sides.prod(axis=1))
    step = np.diff(c, axis=0)
    if measure == "displacement":
        v = np.linalg.norm(step, axis=1) / size[:-1]
    elif measure == "acceleration":
        v = np.concatenate([[0.0], np.linalg.norm(np.diff(step, axis=0), axis=1) / size[1:-1]])
    elif measure == "scale":
        v = np.abs(np.diff(np.log(sides.prod(axis=1))))
    elif measure == "aspect":
        v = np.abs(np.diff(np.log(sides[:, 0] / sides[:, 1])))
    else:
        room = np.array([i.shape[1::-1] for i in images]) - b[:, :2] - sides
        return (np.minimum(b[:, :2], room).min(axis=1) / size).tolist()
    return [0.0, *v.tolist()]


def template_size(w, h, side):
    longest = max(w, h)
    return (w, h) if longest <= side else tuple(max(1, math.floor(v * side / longest + 0.5)) for v in (w, h))


def template(image, box, size):
    """Means of up to 8 x 8 bilinear samples a pixel."""
    pixels, _, _ = cut_patch(image, box)
    grey = np.floor(pixels.astype(np.int64) @ np.array([2989, 5870, 1140]) / 10000 + 0.5)
    parts = [min(max(-(-n // m), 1), 8) for n, m in zip(grey.shape, size[::-1])]

    def taps(n, count):
        place = np.clip((np.arange(count) + 0.5) * n / count - 0.5, 0, n - 1)
        return np.maximum(0, 1 - np.abs(place[:, None] - np.arange(n)))

    fine = taps(grey.shape[0], parts[0] * size[1]) @ grey @ taps(grey.shape[1], parts[1] * size[0]).T
    return fine.reshape(size[1], parts[0], size[0], parts[1]).mean(axis=(1, 3)).ravel()


def template_correlation(images, boxes, p):
    first = cut_patch(images[0], boxes[0])[0]
    size = template_size(first.shape[1], first.shape[0], p["side"])
    patches = [template(i, b, size) for i, b in zip(images, boxes)]
    q, values = patches[0], [1.0]
    for now in patches[1:]:
        flat = [v.var() <= 1e-6 for v in (now, q)]
        values.append(float(all(flat)) if any(flat) else float(np.corrcoef(now, q)[0, 1]))
        if p["reference"] == "previous":
            q = now
        elif p["reference"] == "slow":
            q = (1 - p["rate"]) * q + p["rate"] * now
    return values


# --- signals over a track -----------------------------------------------------------------------------


def values(kind, params, images, boxes):
    if kind == "distribution-field":
        p = FIELD | params
        return [y_t(image, boxes, t, p) for t, image in enumerate(images)]
    if kind == "region-covariance":
        p = dict(ridge=1e-6, grey_ridge=1e-3) | params
        return [covariance_distance(image, images[t - 1], boxes, t, p) for t, image in enumerate(images)]
    if kind == "box-motion":
        return motion((dict(measure="displacement") | params)["measure"], images, boxes)
    if kind == "template-correlation":
        return template_correlation(images, boxes, dict(reference="first", side=32, rate=0.02) | params)
    if kind == "rgb-histogram":
        p = dict(bins=8, reference="previous") | params
        histograms = [rgb_histogram(i, b, p) for i, b in zip(images, boxes)]
    else:
        p = dict(red_bins=8, green_bins=8, blue_bins=1, lbp_threshold=8.0, reference="previous") | params
        histograms = [lbp_histogram(i, b, p) for i, b in zip(images, boxes)]
    before = [0 if p["reference"] == "first" else max(t - 1, 0) for t in range(len(images))]
    return [1.0 if t == 0 else similarity(histograms[t], histograms[s]) for t, s in enumerate(before)]


def tracks():
    """Name, frame kind, width, height, boxes."""
    follow = [[6.3 + 2.1 * t, 5.6 + 0.9 * t, 15 + (t % 3), 17 - (t % 2)] for t in range(12)]
    leave = [[44.4 + 3.7 * t, -6.2 - 1.3 * t, 13.5, 9.2 + t] for t in range(9)]
    # Larger than the frame in one and in both directions, one pixel, and a jump of size.
    odd = [[3, 4, 70, 9], [-9, -9, 90, 80], [10, 12, 1, 1], [10.5, 12.5, 2, 3], [8, 9, 21, 30]]
    return [
        ("follow", "colour", 64, 48, follow),
        ("leave", "colour", 61, 47, leave),
        ("grey", "grey", 50, 40, follow),
        ("harsh", "harsh", 64, 48, follow),
        ("odd", "colour", 61, 47, odd),
    ]


def settings(name):
    basic = [
        ("distribution-field", {}),
        ("region-covariance", {}),
        ("rgb-histogram", {}),
        ("rgb-lbp-histogram", {}),
        *[("box-motion", {"measure": m}) for m in ("displacement", "acceleration", "scale", "aspect", "border")],
        ("template-correlation", {}),
        ("template-correlation", {"reference": "previous", "side": 5}),
        ("template-correlation", {"reference": "slow", "side": 11, "rate": 0.3}),
    ]
    if name in ("leave", "odd"):
        return basic + [("distribution-field", {"outside": "replicate", "border": "replicate"})]
    if name == "grey":
        return basic
    if name == "harsh":
        return basic + [("distribution-field", {"layers": 7, "support_layer": 9, "sigma_layer": 1.5})]
    field_options = [
        {"border": "zero"},
        {"border": "replicate"},
        {"regions": "sides"},
        {"smoothing": "two-levels"},
        {"layers": 20},
        {"displacement": "printed", "history": 3},
        {"history": 2},
        {"layers": 256, "support_layer": 1},
        {"support_u": 1, "support_v": 3},
        {"sigma_u": 4.0, "support_u": 31, "support_v": 27, "border": "replicate"},
    ]
    return (
        basic
        + [("distribution-field", o) for o in field_options]
        + [
            ("region-covariance", {"ridge": 0.001}),
            ("rgb-histogram", {"bins": 16, "reference": "first"}),
            ("rgb-lbp-histogram", {"blue_bins": 8, "reference": "first", "lbp_threshold": 3.5}),
        ]
    )


def write(path):
    cases = []
    for name, kind, width, height, boxes in tracks():
        images = [frame(kind, width, height, t) for t in range(len(boxes))]
        signals = [
            {"kind": k, "params": p, "values": values(k, p, images, boxes)} for k, p in settings(name)
        ]
        cases.append(
            {
                "name": name, "frames": kind, "width": width, "height": height, "boxes": boxes,
                "byte_sum": int(sum(i.sum(dtype=np.int64) for i in images)), "signals": signals,
            }  # fmt: skip
        )
    versions = {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__}
    path.write_text(json.dumps({"versions": versions, "cases": cases}, indent=1) + "\n")


def show(folder):
    width, height = (int(v) for v in (folder / "size.txt").read_text().split())
    boxes = [[float(v) for v in line.split(",")] for line in (folder / "boxes.txt").read_text().split()]
    raw = [np.fromfile(folder / f"{t:04}.rgb", dtype=np.uint8) for t in range(len(boxes))]
    images = [r.reshape(height, width, 3) for r in raw]
    for kind in ("distribution-field", "region-covariance", "rgb-histogram", "rgb-lbp-histogram"):
        print(kind, " ".join(repr(v) for v in values(kind, {}, images, boxes)))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        show(pathlib.Path(sys.argv[1]))
    else:
        write(pathlib.Path(__file__).with_name("signals.json"))
