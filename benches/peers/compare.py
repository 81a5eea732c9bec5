"""Runs the peers and sets them beside the criterion benches: a line a measurement, with the ratio.

    pip install -r benches/peers/requirements.txt
    cargo bench -p trackfail-benches              # leaves estimates in target/criterion
    python3 benches/peers/compare.py [PEER...]

A peer is a script in this folder that prints JSON lines with `bench`, `size`, `peer` and `seconds`; it is
compared with target/criterion/<bench>/<size>. Both sides are one thread and their fastest repetition
(criterion: the sample with the least time an iteration). Without estimates the ratio stays empty.
"""

import json
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
CRITERION = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent.parent / "target")) / "criterion"
PEERS = [
    "signals_numpy.py",
    "arma_statsmodels.py",
    "color_particle_filter.py",
    "gamma_mixture.py",
    "reconstructed_trackers.py",
    "opencv_trackers.py",
]


def ours(bench, size):
    """Seconds an iteration, or None without a benchmark of that name."""
    path = CRITERION / bench / str(size) / "new" / "sample.json"
    if not path.is_file():
        return None
    sample = json.loads(path.read_text())
    return min(t / n for t, n in zip(sample["times"], sample["iters"])) * 1e-9


def main():
    one_thread = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    print(f"{'bench':<22}{'size':>6}  {'peer':<18}{'peer ms':>10}{'ours ms':>10}{'ratio':>8}")
    failed = False
    for peer in sys.argv[1:] or PEERS:
        run = subprocess.run(
            [sys.executable, HERE / peer], env=os.environ | one_thread, stdout=subprocess.PIPE, text=True
        )
        failed |= run.returncode != 0
        for line in run.stdout.splitlines():
            m = json.loads(line)
            own = ours(m["bench"], m["size"])
            mine = f"{own * 1e3:10.3f}{m['seconds'] / own:8.1f}" if own else f"{'-':>10}{'-':>8}"
            print(f"{m['bench']:<22}{m['size']:>6}  {m['peer']:<18}{m['seconds'] * 1e3:10.3f}{mine}")
    sys.exit(failed)


if __name__ == "__main__":
    main()
