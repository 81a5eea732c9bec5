"""Published tracks on UAV123 at 10 frames a second, as result files that `replay` reads.

    uav123_tracks.py ARCHIVES DATA

ARCHIVES is all_trk_results/UAV123_10fps of vision4robotics/DCFTracking4UAV @ b22a5e0; the archive of a tracker T becomes
DATA/results/uav123-10fps/T/<sequence>.txt, x,y,w,h a line, pixels counted from 1. Archives that are not there are named and
left out; one that is not the pinned one is an error. Needs numpy and scipy.
"""

import hashlib
import io
import sys
import zipfile
from pathlib import Path

import numpy as np
from scipy.io import loadmat

SHA256 = {
    "ARCF": "581538cbe971c7b86d4b4b4a36c5ff4373c927776c3d5e163ec63c5a6fe38d38",
    "ARCF_H": "c0c03a5d18ecc2e77a2090e943cbdf6544f3b6892a37de1b58a3f2d467933861",
    "AutoTrack": "b279ddb23821407bffd537112ec3afd787e48524f7497bd66e5b6c4ec88bdfca",
    "BACF": "97539dce59c003ca628467d7925fb1c2d6bdb05ae8a16731028f2c155f14fa40",
    "CN": "c9e05d9dfe4817e1ac9ddeaf3dc3bad37c285900f31bef2718ea5b5e5a5dbbbc",
    "DCF": "de29f020cfea8998bbe6a6551e1ff7195710f6c7b2195b9d0eb37af2225f1d17",
    "DSST": "13d271c9df6abe60a367d1f0c5a72c4d6bf07accfdd2847fee415e40b0370ddc",
    "ECO_HC": "20526b3de91796f8130e2c6c216b3f8b3af13dbe26e7ea6754674b81d8d1ff3d",
    "KCF": "0a586a07874127f04081fd3e209871dcd74a3b06996deeb2a697e4c7c8e4fb79",
    "LCT": "875d4f2862a3c7720f5096d92d591710876c00448bc3b53d9bd5f7d803ec704c",
    "SRDCF": "c7dbab22ae4a4d20347372112c4754f745ca44cc44ccbb4ce102f7c70b685898",
    "SRDCFdecon": "192b2600dc70844624d48ea5e653904b0eddec49c853c66b72a6462913f78cdd",
    "STRCF": "7fca3c8f4fb6d908ee66b08ce3dba6195465f1775d0911445c012150f552a50e",
    "fDSST": "49eb96543a099bb9148f7f5f3b70d89be4b41e77a0e386aa535a20abec54f57b",
}


def main(archives, data):
    for tracker, digest in SHA256.items():
        path = Path(archives) / f"{tracker}.zip"
        if not path.is_file():
            print(f"{path}: not there", file=sys.stderr)
            continue
        content = path.read_bytes()
        if hashlib.sha256(content).hexdigest() != digest:
            sys.exit(f"{path}: another file than the one whose tracks docs/fused.md rests on")
        folder = Path(data) / "results" / "uav123-10fps" / tracker
        folder.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for name in archive.namelist():
                if not name.endswith(f"_{tracker}.mat"):
                    continue
                results = loadmat(io.BytesIO(archive.read(name)), simplify_cells=True)["results"]
                results = results if isinstance(results, dict) else results[0]
                sequence = Path(name).name.removesuffix(f"_{tracker}.mat")
                np.savetxt(folder / f"{sequence}.txt", np.asarray(results["res"], float), fmt="%.10g", delimiter=",")


main(*sys.argv[1:])
