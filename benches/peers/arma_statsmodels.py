"""Time of one ARMA(1, 1) fit and five forecasts with statsmodels, on the window of benches/arma.rs.

Needs numpy and statsmodels. Prints JSON lines for compare.py, one per estimator: the default exact
likelihood (state space, L-BFGS), and Hannan-Rissanen, the quickest that statsmodels offers for a model with a
moving average part. One thread, after a warm-up, fastest of 30.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import json
import time
import warnings

import numpy as np
from statsmodels.tsa.arima.model import ARIMA

warnings.simplefilter("ignore")
WINDOW = np.array([0.52, 0.47, 0.55, 0.61, 0.58, 0.66, 0.60, 0.49, 0.44, 0.40,
                   0.43, 0.38, 0.45, 0.51, 0.47, 0.54, 0.57, 0.50, 0.46, 0.49])


def exact():
    # cov_type="none" spares statsmodels the standard errors, which nobody asks of the other side either.
    return ARIMA(WINDOW, order=(1, 0, 1), trend="c").fit(cov_type="none").forecast(5)


def hannan_rissanen():
    return ARIMA(WINDOW, order=(1, 0, 1), trend="c").fit(method="hannan_rissanen", cov_type="none").forecast(5)


def seconds(job, repeats=30):
    for _ in range(3):
        job()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        job()
        times.append(time.perf_counter() - begin)
    return min(times)


for name, job in (("exact", exact), ("hannan-rissanen", hannan_rissanen)):
    record = {"bench": "arma/fit-backcast", "size": len(WINDOW), "peer": f"statsmodels {name}", "seconds": seconds(job)}
    print(json.dumps(record))
