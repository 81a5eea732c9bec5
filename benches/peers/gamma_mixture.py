"""Time of one fit of three Gamma components with NumPy and SciPy, on the samples of benches/gamma_mixture.rs.

Needs numpy and scipy. Prints a JSON line for compare.py. Plain EM on all samples from groups of equal counts,
with Newton's method in the M-step, until an iteration gains less than 1e-9 a sample (the crate's tolerance, for
a cycle of four), at most 1000 iterations. One thread, once. The log-likelihood goes to stderr.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import json
import sys
import time

import numpy as np
from scipy.special import digamma, gammaln, polygamma


def uniform(i):
    """Numbers `i` of SplitMix64 from state 0, in (0, 1)."""
    with np.errstate(over="ignore"):
        z = (i + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (((z ^ (z >> np.uint64(31))) >> np.uint64(11)).astype(float) + 0.5) / 2.0**53


def samples(n):
    u = uniform(np.arange(5 * n, dtype=np.uint64)).reshape(n, 5)
    e = -np.cumsum(np.log(u[:, 1:]), axis=1)
    return np.where(u[:, 0] < 0.6, 0.1 * e[:, 0], np.where(u[:, 0] < 0.9, 0.4 * e[:, 1], 0.5 * e[:, 3]))


def fit(x, k, tolerance=1e-9, max_iterations=1000):
    ln, n = np.log(x), len(x)
    groups = np.array_split(np.sort(x), k)
    weight = np.full(k, 1 / k)
    shape = np.array([g.mean() ** 2 / g.var() for g in groups])
    scale = np.array([g.var() / g.mean() for g in groups])
    before = -np.inf
    for iteration in range(1, max_iterations + 1):
        joint = np.multiply.outer(shape - 1, ln) - np.multiply.outer(1 / scale, x)
        joint += (np.log(weight) - shape * np.log(scale) - gammaln(shape))[:, None]
        top = joint.max(axis=0)
        np.exp(joint - top, out=joint)
        total = joint.sum(axis=0)
        likelihood = float(np.sum(top + np.log(total)))
        if likelihood - before < tolerance * n:
            break
        before = likelihood
        joint /= total
        count = joint.sum(axis=1)
        weight, mean = count / n, joint @ x / count
        s = np.log(mean) - joint @ ln / count
        shape = (3 - s + np.sqrt((s - 3) ** 2 + 24 * s)) / (12 * s)
        for _ in range(5):
            shape = shape - (np.log(shape) - digamma(shape) - s) / (1 / shape - polygamma(1, shape))
        scale = mean / shape
    return likelihood, iteration, np.c_[weight, shape, scale]


x = samples(100_000)
fit(x[:1000], 3)
begin = time.perf_counter()
likelihood, iterations, components = fit(x, 3)
seconds = time.perf_counter() - begin
print(f"log-likelihood {likelihood:.4f} after {iterations} iterations\n{components}", file=sys.stderr)
print(json.dumps({"bench": "gamma_mixture/fit-3", "size": len(x), "peer": "numpy EM", "seconds": seconds}))
