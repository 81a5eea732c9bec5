"""Makes v2.weights and v3.weights from the ONNX files of NanoTrack.

    python weights.py SiamTrackers/NanoTrack/models

reads `nanotrackv2/nanotrack_backbone_sim.onnx`, `nanotrackv3/nanotrack_backbone.onnx` and the heads beside them (or the
same names in folders `v2` and `v3`) and needs `pip install onnx==1.23.2 numpy`.

A file is little-endian: three u32, the numbers of groups of eight f32 in its parts (backbone, template, head), and the
parts. A layer is its bias and its weights, output channels in groups of eight (filled up with zeros):

    pointwise, dense    bias[o / 8][8]    weight[o / 8][i][8]
    depthwise           bias[o / 8][8]    weight[o / 8][row][column][8]
    first convolution   bias[o / 8][8]    weight[o / 8][red, green, blue][row][column][8]

Batch norms are folded into the convolutions in the ONNX files already. Layers stand in the order in which
src/network/nanotrack.rs reads them.
"""

import sys
from pathlib import Path

import numpy as np
import onnx
from onnx import numpy_helper

FILES = {"v2": "nanotrack_{}_sim.onnx", "v3": "nanotrack_{}.onnx"}


def layers(path):
    """Bias and weight [out, in, rows, columns] of every layer with weights of its own, in order."""
    graph = onnx.load(path).graph
    tensors = {t.name: numpy_helper.to_array(t) for t in graph.initializer}
    found = []
    for node in graph.node:
        if node.op_type in ("Conv", "Gemm") and node.input[1] in tensors:
            weight = tensors[node.input[1]]
            bias = tensors[node.input[2]] if len(node.input) > 2 else np.zeros(len(weight))
            found.append((bias, weight.reshape(weight.shape + (1,) * (4 - weight.ndim))))
    return found


def packed(layer):
    bias, weight = layer
    if weight.shape[1] == 3:
        weight = weight[:, ::-1]  # the network reads blue, green, red
    groups = -(-len(bias) // 8)
    fill = 8 * groups - len(bias)
    bias = np.pad(bias, (0, fill))
    weight = np.pad(weight.reshape(len(weight), -1), ((0, fill), (0, 0)))
    weight = weight.reshape(groups, 8, -1).transpose(0, 2, 1)
    return np.concatenate([bias.ravel(), weight.ravel()]).astype("<f4")


def parts(version, head):
    """Template and head: two branches, classes and distances; the graph has the distances first."""
    if version == "v2":
        template = [head[4], head[0]]
        classes = [head[5], *head[6:8], *head[8:21]]
        distances = [head[1], *head[2:4], *head[21:34]]
    else:
        template = [head[6], head[14], head[0], head[12]]
        classes = [head[7], *head[8:12], head[15], head[17], *head[18:31]]
        distances = [head[1], *head[2:6], head[13], head[16], *head[31:44]]
    return template, classes + distances


def main(folder):
    for version, name in FILES.items():
        places = [folder / f"nanotrack{version}", folder / version]
        place = next(p for p in places if p.is_dir())
        backbone, head = (layers(place / name.format(part)) for part in ("backbone", "head"))
        sections = [backbone, *parts(version, head)]
        data = [np.concatenate([packed(layer) for layer in section]) for section in sections]
        counts = np.array([len(part) // 8 for part in data], "<u4")
        Path(__file__).with_name(f"{version}.weights").write_bytes(b"".join(a.tobytes() for a in (counts, *data)))


main(Path(sys.argv[1]))
