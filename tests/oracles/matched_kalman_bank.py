"""Oracle for detector::matched_kalman_bank, from SciPy.

    python3 tests/oracles/matched_kalman_bank.py > tests/oracles/matched_kalman_bank.json

Made with NumPy 2.4.6, SciPy 1.17.1. There is no Kalman filter here: a hypothesis is a list of jump frames and
a prior, and in every frame everything about it is computed anew from all samples so far, which are jointly
normal with a dense covariance matrix: its weight is the prior times their density, its level and the error of
its last forecast are conditional means. Only which hypothesis splits and which is cut is decided step by step.
"""

import json

import numpy as np
from scipy.stats import multivariate_normal

EDGE = [0.10, 0.12, 0.09, 0.11, 0.13, 0.10, 0.08, 0.12, 0.11, 0.10, 0.09, 0.12, 0.11, 0.50, 0.62, 0.58, 0.55,
        0.61, 0.57, 0.12, 0.10, 0.11, 0.09, 0.10, 0.12]


class Hypothesis:
    def __init__(self, jumps, prior):
        self.jumps, self.prior = jumps, prior

    def judge(self, y, x0, p0, r1, r2):
        t = np.arange(len(y))
        prior = np.full((len(y), len(y)), p0)
        for jump in self.jumps:
            after = t >= jump
            prior += r1 * np.outer(after, after)
        cov = prior + np.diag(r2)
        self.log_weight = self.prior + multivariate_normal.logpdf(y, np.full(len(y), x0), cov)
        self.level = x0 + prior[-1] @ np.linalg.solve(cov, y - x0)
        forecast = x0
        if len(y) > 1:
            forecast += prior[-1, :-1] @ np.linalg.solve(cov[:-1, :-1], y[:-1] - x0)
        self.error = y[-1] - forecast
        if self.jumps and self.jumps[-1] == len(y) - 1:
            self.before = forecast  # the level of the hypothesis it was split from


def bank(y, q, models, life, p0, r1, r2, x0, f, least, start):
    """For each frame: last jump of the most probable hypothesis, its level, the level its jump left."""
    noise = [start if r2 is None else r2]
    all_, told = [Hypothesis([], 0.0)], []
    for t in range(len(y)):
        if t > 0:
            best = max(all_, key=lambda h: h.log_weight)
            new = Hypothesis([*best.jumps, t], best.prior + np.log(q))
            best.prior += np.log1p(-q)
            all_.append(new)
        for h in all_:
            h.judge(y[: t + 1], x0, p0, r1, noise)
        if len(all_) > models:
            old = [h for h in all_ if not h.jumps or t - h.jumps[-1] >= life]
            all_.remove(min(old, key=lambda h: h.log_weight))
        best = max(all_, key=lambda h: h.log_weight)
        told.append((best.jumps[-1], best.before) if best.jumps else (None, None))
        told[-1] += (best.level,)
        last = noise[-1]
        noise.append(last if r2 is not None else max(f * last + (1 - f) * best.error**2, least))
    return told


def detect(y, q=0.01, models=5, life=1, p0=10.0, r1=1.0, r2=None, x0=None, f=0.97, least=1e-8, window=25, merge=2):
    y = np.asarray(y)
    x0 = y[0] if x0 is None else x0

    def run(samples, past):
        start = max(np.var(past, ddof=1), least) if len(past) > 1 else least
        return bank(samples, q, models, life, p0, r1, r2, x0, f, least, start)

    told = run(y, y[:window])
    if r2 is None:
        for t in range(min(window - 1, len(y))):
            told[t] = run(y[: t + 1], y[: t + 1])[-1]
    reported, changes = [], []
    for jump, before, level in told:
        new = jump is not None and all(abs(jump - r) >= merge for r in reported)
        changes.append(int(np.sign(level - before)) if new else 0)
        if new:
            reported.append(jump)
    return [t[0] for t in told], [float(t[2]) for t in told], changes


def lattice(n, seed):
    """Reproducible noise in [0, 1) that needs no generator."""
    return np.array([((t + seed) * 7919 + (t * t % 97) * 104729) % 1000 / 1000 for t in range(n)])


def main():
    steps = lattice(60, 3) * 0.2 + np.repeat([0.1, 0.9, 0.4, 1.6, 1.5, 0.0], 10)
    spiky = lattice(50, 11) ** 4 * 3
    cases = [
        ("edge", EDGE, dict(r1=0.1, p0=1.0, r2=0.0004, x0=0.0)),
        ("edge, adaptive", EDGE, {}),
        ("steps", steps, {}),
        ("steps, long life", steps, dict(models=6, life=4, window=10, f=0.8, q=0.1)),
        ("steps, nothing merged", steps, dict(merge=1, r1=0.2, r2=0.003, models=3)),
        ("spiky", spiky, dict(window=12)),
        ("spiky, fixed", spiky, dict(r2=0.05, merge=3, life=0, models=2)),
    ]
    names = dict(q="jump_probability", models="models", life="life", p0="start_variance", r1="jump_variance",
                 r2="noise_variance", x0="start_level", f="forgetting", window="start_window", merge="merge")
    out = []
    for name, y, params in cases:
        jumps, levels, changes = detect(y, **params)
        out.append(dict(name=name, params={names[k]: v for k, v in params.items()}, signal=[float(v) for v in y],
                        levels=levels, changes=changes))
        if name == "edge":
            assert jumps[:13] == [None] * 13 and set(jumps[13:19]) == {13, 14} and set(jumps[19:]) == {19}, jumps
    lines = ",\n".join(json.dumps(case) for case in out)
    print(f"[\n{lines}\n]")


main()
