"""Oracles for num::arma, from SciPy and statsmodels.

    python3 tests/oracles/arma.py > tests/oracles/arma.json

Made with NumPy 2.4.6, SciPy 1.17.1, statsmodels 0.15.0. Nothing here shares code or method with the crate:
the objective is written out term by term with the constant as one more unknown, and is minimised by
differential evolution over (c, phi, theta), several populations each, polished by L-BFGS-B and Nelder-Mead.
"""

import json
import warnings

import numpy as np
from scipy.optimize import differential_evolution, minimize
from scipy.signal import lfilter, lfiltic
from statsmodels.tsa.ar_model import AutoReg
from statsmodels.tsa.arima.model import ARIMA
from statsmodels.tsa.statespace.tools import constrain_stationary_univariate

warnings.simplefilter("ignore")
LIMIT = 1 - 1e-6


def innovations(y, c, phi, theta, start):
    """Innovations of y[1..n] (0-based list), presample innovations 0."""
    y, n, p, q = list(y), len(y), len(phi), len(theta)
    before = []  # y[0], y[-1], ...
    if start == "backcast":
        r = y[::-1]
        a = [0.0] * n
        for t in range(p, n):
            a[t] = r[t] - c
            a[t] -= sum(phi[i] * r[t - 1 - i] for i in range(p))
            a[t] -= sum(theta[j] * a[t - 1 - j] for j in range(q) if t - 1 - j >= 0)
        future = r[:]
        for k in range(p):
            t = n + k
            v = c + sum(phi[i] * future[t - 1 - i] for i in range(p))
            v += sum(theta[j] * a[t - 1 - j] for j in range(q) if t - 1 - j < n)
            future.append(v)
        before = future[n:]
    e = []
    for t in range(0 if start == "backcast" else p, n):
        v = y[t] - c
        for i in range(p):
            s = t - 1 - i
            v -= phi[i] * (y[s] if s >= 0 else before[-1 - s])
        first = 0 if start == "backcast" else p
        for j in range(q):
            s = t - 1 - j
            if s >= first:
                v -= theta[j] * e[s - first]
        e.append(v)
    return e


def coefficients(r, p):
    """Partial autocorrelations in (-1, 1) to AR and MA coefficients, by statsmodels, which maps r / sqrt(1 - r^2)."""
    r = np.clip(np.asarray(r, float), -LIMIT, LIMIT)
    u = r / np.sqrt(1 - r**2)
    phi = constrain_stationary_univariate(u[:p]) if p else np.zeros(0)
    theta = -constrain_stationary_univariate(u[p:]) if len(r) > p else np.zeros(0)
    return list(phi), list(theta)


def global_fit(y, p, q, start, seed):
    z = (np.array(y) - np.mean(y)) / np.std(y)

    def cost(x):
        phi, theta = coefficients(x[1:], p)
        e = innovations(z, x[0], phi, theta, start)
        return float(np.dot(e, e))

    bounds = [(-4.0, 4.0)] + [(-LIMIT, LIMIT)] * (p + q)

    def evolve(objective, box, k):
        return differential_evolution(
            objective, box, seed=100 * seed + k, popsize=30, mutation=(0.5, 1.2), tol=1e-10, atol=0, maxiter=600,
            polish=False,
        )

    # The minimum is often a thin valley: several populations, and one on each border, where those in the
    # inside rarely arrive. The best of all is polished.
    tries = [evolve(cost, bounds, k) for k in range(2)]
    if p + q > 1:
        for axis in range(1, 1 + p + q):
            for border in (-LIMIT, LIMIT):
                face = evolve(
                    lambda x, a=axis, b=border: cost(np.insert(x, a, b)), bounds[:axis] + bounds[axis + 1 :], 9
                )
                face.x = np.insert(face.x, axis, border)
                tries.append(face)
    best = min(tries, key=lambda r: r.fun)
    for method in ("L-BFGS-B", "Nelder-Mead"):
        options = {"maxiter": 4000}
        if method == "Nelder-Mead":
            options |= {"xatol": 1e-10, "fatol": 1e-15}
        polished = minimize(cost, best.x, method=method, bounds=bounds, options=options)
        if polished.fun < best.fun:
            best = polished
    c, (phi, theta) = best.x[0], coefficients(best.x[1:], p)
    path, e = list(z), innovations(z, c, phi, theta, start)
    for k in range(1, 6):
        v = c + sum(phi[i] * path[-1 - i] for i in range(p))
        v += sum(theta[j] * e[len(e) + k - 2 - j] for j in range(q) if k - 2 - j < 0)
        path.append(v)
    m, s = np.mean(y), np.std(y)
    return {
        "constant": float(s * c + m * (1 - sum(phi))),
        "ar": [float(v) for v in phi],
        "ma": [float(v) for v in theta],
        "sse": float(best.fun * s * s),
        "forecast": [float(m + s * v) for v in path[len(z) :]],
    }


def simulate(rng, phi, theta, n, mean=0.04, deviation=0.004):
    e = rng.standard_normal(n + 200)
    y = lfilter([1.0, *theta], [1.0, *(-np.array(phi))], e)[200:]
    return [round(float(v), 6) for v in mean + deviation * y / np.std(y)]


def series(rng):
    """Windows as a bounded quality score gives them: smooth, with steps, with drifts, with noise."""
    yield "section13", [0.52, 0.47, 0.55, 0.61, 0.58, 0.66, 0.60, 0.49, 0.44, 0.40,
                        0.43, 0.38, 0.45, 0.51, 0.47, 0.54, 0.57, 0.50, 0.46, 0.49]
    yield "arma(.8,-.3)", simulate(rng, [0.8], [-0.3], 20)
    yield "arma(.5,.6)", simulate(rng, [0.5], [0.6], 20)
    yield "arma(-.6,.2)", simulate(rng, [-0.6], [0.2], 20)
    yield "noise", simulate(rng, [], [], 20)
    yield "walk", [round(float(v), 6) for v in 0.04 + 0.001 * np.cumsum(rng.standard_normal(20))]
    step = 0.045 + 0.001 * rng.standard_normal(20)
    step[13:] -= 0.015
    yield "step", [round(float(v), 6) for v in step]
    drift = 0.05 - 0.0008 * np.arange(20) + 0.0005 * rng.standard_normal(20)
    yield "drift", [round(float(v), 6) for v in drift]
    yield "ten", simulate(rng, [0.7], [0.2], 10)
    yield "forty", simulate(rng, [0.7], [0.4], 40)


def main():
    rng = np.random.default_rng(2016)
    fits, windows = [], list(series(rng))
    for k, (name, y) in enumerate(windows):
        for start in ("backcast", "drop-first"):
            orders = [(1, 1), (1, 0), (0, 1)] if k < 6 else [(1, 1)]
            for p, q in orders:
                fits.append({"name": name, "y": y, "order": [p, q], "start": start, **global_fit(y, p, q, start, k)})
    for name, y in (windows[0], windows[1], windows[-1]):
        for p, q in ((2, 1), (1, 2)):
            fits.append({"name": name, "y": y, "order": [p, q], "start": "backcast", **global_fit(y, p, q, "backcast", 7)})

    # Conditional least squares of an AR(p) is a linear regression: statsmodels AutoReg does exactly that.
    autoreg = []
    for p in (1, 2, 3):
        y = simulate(rng, [0.5, -0.3, 0.2][:p], [], 60)
        r = AutoReg(y, lags=p, trend="c").fit()
        autoreg.append({
            "y": y, "order": [p, 0], "constant": float(r.params[0]), "ar": [float(v) for v in r.params[1:]],
            "sse": float(np.sum(r.resid**2)), "forecast": [float(v) for v in r.predict(len(y), len(y) + 4)],
        })

    # Forecasts with given parameters. The Kalman filter of statsmodels starts from the stationary law; over 400
    # values its memory of the start is below 1e-15, so the forecasts are those of the conditional recursion.
    # ARIMA's "const" is the mean: c = mean (1 - sum phi).
    predictions = []
    for phi, theta in (([0.6], [0.3]), ([0.5, -0.2], [0.4]), ([0.4], [0.3, 0.2, -0.1]), ([], [0.5, 0.3])):
        y = simulate(rng, phi, theta, 400)
        mean = 0.0413
        model = ARIMA(y, order=(len(phi), 0, len(theta)), trend="c")
        result = model.filter([mean, *phi, *theta, 1.0])
        predictions.append({
            "y": y, "constant": mean * (1 - sum(phi)), "ar": phi, "ma": theta,
            "forecast": [float(v) for v in result.forecast(6)],
        })

    # Innovations with given parameters and known past: a linear filter, scipy.signal.lfilter with lfiltic.
    filters = []
    for phi, theta in (([0.6], [0.3]), ([0.5, -0.2], [0.4, 0.3]), ([], [0.9])):
        y = simulate(rng, phi, theta, 30)
        c, p = 0.013, len(phi)
        z = np.array(y) - c / (1 - sum(phi))
        state = lfiltic([1.0, *(-np.array(phi))], [1.0, *theta], y=np.zeros(len(theta)), x=z[:p][::-1])
        e, _ = lfilter([1.0, *(-np.array(phi))], [1.0, *theta], z[p:], zi=state)
        filters.append({"y": y, "constant": c, "ar": phi, "ma": theta, "innovations": [float(v) for v in e]})

    print(json.dumps({"fits": fits, "autoreg": autoreg, "predictions": predictions, "filters": filters}))


main()
