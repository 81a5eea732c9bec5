"""Oracles for num::{gamma_mixture, accumulation, distribution, kolmogorov}, from NumPy and SciPy.

    python3 tests/oracles/avu.py > tests/oracles/avu.json

Made with NumPy 2.4.6, SciPy 1.17.1. Mixtures are fitted by quasi-Newton on all parameters at once and on the
samples themselves, not by EM and not on cells. The sums are those that have a closed form. Takes three minutes.
"""

import json

import numpy as np
from scipy import stats
from scipy.optimize import fmin, minimize
from scipy.special import logsumexp

MIXTURE = [(0.5, 0.8, 0.1), (0.35, 2.5, 0.2), (0.15, 9.0, 0.2)]


def draw(rng, mixture, n):
    w, a, s = np.array(mixture).T
    k = rng.choice(len(w), size=n, p=w)
    return np.maximum(np.round(rng.gamma(a[k], s[k]), 5), 1e-4)


def log_density(x, w, a, s):
    return logsumexp(np.log(w)[:, None] + stats.gamma.logpdf(x[None, :], a[:, None], scale=s[:, None]), axis=0)


def unpack(p):
    k = (len(p) + 1) // 3
    u = np.append(p[: k - 1], 0.0)
    return np.exp(u - logsumexp(u)), np.exp(p[k - 1 : 2 * k - 1]), np.exp(p[2 * k - 1 :])


def fit(x, k, rng, starts=60):
    best = None
    for _ in range(starts):
        centres = np.sort(rng.choice(x, k, replace=False))
        shape = np.exp(rng.uniform(-0.5, 2.5, k))
        p = np.concatenate([rng.normal(0, 0.5, k - 1), np.log(shape), np.log(centres / shape)])
        box = [(-8, 8)] * (k - 1) + [(-4, np.log(1e4))] * k + [(-15, 8)] * k
        r = minimize(lambda p: -log_density(x, *unpack(p)).sum(), p, method="L-BFGS-B", bounds=box,
                     options={"maxiter": 3000, "maxfun": 100000, "ftol": 1e-14, "gtol": 1e-8})
        if best is None or r.fun < best.fun:
            best = r
    w, a, s = unpack(best.x)
    order = np.argsort(a * s)
    return {"k": k, "log_likelihood": -float(best.fun),
            "components": [[float(w[i]), float(a[i]), float(s[i])] for i in order]}


def mixtures(rng):
    out = []
    for mixture, n, orders in ((MIXTURE, 400, (1, 2, 3)), ([(0.7, 0.6, 0.3), (0.3, 20.0, 0.1)], 250, (1, 2))):
        x = draw(rng, mixture, n)
        out.append({"x": x.tolist(), "fits": [fit(x, k, rng) for k in orders]})
    return out


def functions():
    w, a, s = np.array(MIXTURE).T
    rows = []
    for v in (1e-4, 0.05, 0.3, 1.0, 2.5, 6.0, 20.0):
        rows.append([v, *(float(np.dot(w, f(v, a, scale=s))) for f in (stats.gamma.pdf, stats.gamma.cdf, stats.gamma.sf))])
    mean = float(np.dot(w, a * s))
    return {"components": MIXTURE, "rows": rows, "mean": mean,
            "variance": float(np.dot(w, a * s * s + (a * s) ** 2) - mean**2)}


def sums():
    """Quantiles of sums of L Gamma variables of one scale: closed form."""
    out = []
    for shape, scale in ((2.0, 0.1), (0.7, 0.5), (5.0, 0.2)):
        for length in (1, 2, 5, 20, 60):
            law = stats.gamma(length * shape, scale=scale)
            out.append({"shape": shape, "scale": scale, "length": length,
                        "quantiles": [[alpha, float(law.isf(alpha))] for alpha in (0.001, 0.005, 0.01, 0.05, 0.5)]})
    return out


def precise(f, start, args=(), disp=0):
    """SciPy's own optimiser with tolerances below its 1e-4."""
    return fmin(f, start, args=args, disp=disp, xtol=1e-10, ftol=1e-12)


def families(rng):
    out = []
    for name, x in (("gamma", draw(rng, [(1.0, 0.9, 0.4)], 300)), ("mixture", draw(rng, MIXTURE, 300))):
        shape, _, scale = stats.gamma.fit(x, floc=0)
        sigma, _, median = stats.lognorm.fit(x, floc=0)
        power, _, width = stats.weibull_min.fit(x, floc=0, optimizer=precise)
        laws = {
            "normal": stats.norm(*stats.norm.fit(x)),
            "exponential": stats.expon(*stats.expon.fit(x, floc=0)),
            "rayleigh": stats.rayleigh(*stats.rayleigh.fit(x, floc=0)),
            "log-normal": stats.lognorm(sigma, scale=median),
            "weibull": stats.weibull_min(power, scale=width),
            "gamma": stats.gamma(shape, scale=scale),
        }
        points = [0.01, 0.2, 0.7, 2.0]
        out.append({"name": name, "x": x.tolist(), "points": points, "families": {
            key: {"pdf": law.pdf(points).tolist(), "cdf": law.cdf(points).tolist(),
                  "log_likelihood": float(law.logpdf(x).sum()),
                  "ks": float(stats.ks_1samp(x, law.cdf).statistic)} for key, law in laws.items()}})
    return out


def two_samples(rng):
    out = []
    for n, m, shift, digits in ((40, 25, 0.0, 6), (60, 80, 0.3, 1), (7, 3, 1.0, 6)):
        a, b = np.round(rng.normal(0, 1, n), digits), np.round(rng.normal(shift, 1, m), digits)
        out.append({"a": a.tolist(), "b": b.tolist(), "statistic": float(stats.ks_2samp(a, b).statistic)})
    return out


def main():
    rng = np.random.default_rng(2015)
    print(json.dumps({"mixtures": mixtures(rng), "functions": functions(), "sums": sums(),
                      "families": families(rng), "two_samples": two_samples(rng)}))


main()
