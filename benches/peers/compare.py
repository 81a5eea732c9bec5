"""Runs peers and our benchmarks in turn and prints one table of ratios, in Markdown.

    pip install -r benches/peers/requirements.txt
    python3 benches/peers/compare.py [--rounds N] [PEER...]

A peer is a script in this folder that prints JSON lines with `bench`, `size`, `peer` and `seconds`. It is compared
with the benchmark `<bench>/<size>` of `cargo bench -p trackfail-benches`. Both sides have one thread, and a round
takes the fastest repetition of each (criterion: the sample with the least time an iteration). The table has the
median of the rounds, and the least and the largest ratio: what else the machine does changes both sides alike. A
benchmark may also print such a JSON line itself. Where both sides have an `auc`, a second table shows it. Benchmarks on
real sequences need TRACKFAIL_DATA, a path list of data roots.
"""

import argparse
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CRITERION = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "criterion"
PEERS = [
    "signals_numpy.py",
    "opencv_flow.py",
    "arma_statsmodels.py",
    "color_particle_filter.py",
    "gamma_mixture.py",
    "score_got10k.py",
    "reconstructed_trackers.py",
    "opencv_trackers.py",
    "opencv_sequences.py",
]
SHORT = ["--noplot", "--sample-size", "10", "--warm-up-time", "0.5", "--measurement-time", "2"]
ONE_THREAD = {
    name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
}


def benchmarks():
    """Builds our benchmarks; returns the program that has each, by name."""
    command = ["cargo", "bench", "-p", "trackfail-benches", "--no-run", "--message-format", "json"]
    built = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    programs = {}
    for line in built.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and "bench" in message["target"]["kind"]:
            program = message["executable"]
            listed = subprocess.run([program, "--bench", "--list"], stdout=subprocess.PIPE, text=True, check=True)
            names = (name.removesuffix(": benchmark") for name in listed.stdout.splitlines())
            programs.update({name: program for name in names})
    return programs


def ours(programs, name):
    """A measurement with seconds an iteration; an empty one without a benchmark of that name."""
    if name not in programs:
        return {}
    command = [programs[name], "--bench", f"^{re.escape(name)}$", *SHORT]
    run = subprocess.run(command, cwd=ROOT, env=os.environ | ONE_THREAD, stdout=subprocess.PIPE, text=True, check=True)
    printed = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    if printed:
        return printed[0]
    sample = json.loads((CRITERION / name / "new" / "sample.json").read_text())
    return {"seconds": min(t / n for t, n in zip(sample["times"], sample["iters"])) * 1e-9}


def theirs(peer):
    """Measurements of a peer, and whether it ended well."""
    command = [sys.executable, HERE / peer]
    run = subprocess.run(command, env=os.environ | ONE_THREAD, stdout=subprocess.PIPE, text=True)
    return [json.loads(line) for line in run.stdout.splitlines()], run.returncode == 0


def duration(seconds):
    return f"{seconds:.3g} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("peers", nargs="*", default=PEERS, metavar="PEER")
    arguments = arguments.parse_args()
    programs = benchmarks()
    rounds, well = {}, True
    for _ in range(arguments.rounds):
        for peer in arguments.peers:
            measured, ended = theirs(peer)
            well &= ended
            names = {f"{m['bench']}/{m['size']}" for m in measured}
            own = {name: ours(programs, name) for name in sorted(names)}
            for m in measured:
                name = f"{m['bench']}/{m['size']}"
                rounds.setdefault((name, m["peer"]), []).append((m, own[name]))
    print(f"{platform.machine()}, {os.cpu_count()} cores, {arguments.rounds} rounds\n")
    print("| bench | ours | peer | its time | ratio | least to largest |\n|---|--:|---|--:|--:|--:|")
    for (name, peer), pairs in rounds.items():
        its = duration(statistics.median(m["seconds"] for m, _ in pairs))
        if not pairs[0][1]:
            print(f"| {name} | | {peer} | {its} | | |")
            continue
        ratios = [m["seconds"] / own["seconds"] for m, own in pairs]
        own = duration(statistics.median(own["seconds"] for _, own in pairs))
        spread = f"{min(ratios):.3g} to {max(ratios):.3g}"
        print(f"| {name} | {own} | {peer} | {its} | {statistics.median(ratios):.3g} | {spread} |")
    scores = {key: pairs[0] for key, pairs in rounds.items() if all("auc" in side for side in pairs[0])}
    if scores:
        print("\n| bench | our AUC | peer | its AUC |\n|---|--:|---|--:|")
        for (name, peer), (m, own) in scores.items():
            print(f"| {name} | {own['auc']:.3f} | {peer} | {m['auc']:.3f} |")
    sys.exit(not well)


if __name__ == "__main__":
    main()
