"""NanoTrack by NumPy, OpenCV and onnxruntime: an oracle of the tracker `nanotrack`, and the time of its networks.

    nanotrack.py maps v2                        logits and distances of the pattern of network/nanotrack.rs
    nanotrack.py track v2 IMAGES X,Y,W,H [N]    x, y, width, height, score of every frame from the second on
    nanotrack.py                                JSON lines for compare.py: a frame of benches/correlation_filters.rs

NANOTRACK_MODELS is a folder with `v2` and `v3`, which hold the ONNX files of models/nanotrack/weights.py. Needs numpy,
onnx, onnxruntime and opencv-contrib-python-headless. One thread.
"""

import json
import os
import sys
from pathlib import Path

import cv2
import numpy as np
import onnx
import onnxruntime
from opencv_trackers import SIDE, frame, measure

# Files; window influence, penalty, learning rate; side of the maps.
VERSIONS = {
    "v2": ("nanotrack_{}_sim.onnx", 0.490, 0.150, 0.385, 16),
    "v3": ("nanotrack_{}.onnx", 0.455, 0.138, 0.348, 15),
}


def session(path):
    """A network on one thread, whose backbone takes crops of any size."""
    model = onnx.load(path)
    if "backbone" in path.name:
        for value in [*model.graph.input, *model.graph.output]:
            for axis in (2, 3):
                value.type.tensor_type.shape.dim[axis].dim_param = f"side{axis}"
    del model.graph.value_info[:]
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])


class Network:
    def __init__(self, models, version):
        name = VERSIONS[version][0]
        self.backbone, self.head = (session(models / version / name.format(part)) for part in ("backbone", "head"))

    def features(self, crop):
        return self.backbone.run(None, {self.backbone.get_inputs()[0].name: crop})[0]

    def maps(self, template, search):
        names = [value.name for value in self.head.get_inputs()]
        classes, distances = self.head.run(None, dict(zip(names, (template, search))))
        return classes.reshape(2, -1), distances.reshape(4, -1)


class Tracker:
    def __init__(self, models, version, image, box):
        _, self.influence, self.penalty, self.rate, side = VERSIONS[version]
        self.network = Network(models, version)
        self.window = np.outer(np.hanning(side), np.hanning(side)).ravel()
        grid = (np.arange(side) - side // 2) * 16.0
        self.x, self.y = (axis.ravel() for axis in np.meshgrid(grid, grid))
        self.size = np.array(box[2:], float)
        self.center = np.array(box[:2]) + (self.size - 1) / 2
        self.color = image.mean(axis=(0, 1)).astype(np.uint8)
        self.template = self.network.features(self.crop(image, self.side(*self.size), 127))

    @staticmethod
    def side(w, h):
        margin = (w + h) / 2
        return np.sqrt((w + margin) * (h + margin))

    def crop(self, image, side, to):
        side = round(side)
        x, y = np.floor(self.center - (side + 1) / 2 + 0.5).astype(int)
        height, width = image.shape[:2]
        patch = np.empty((side, side, 3), np.uint8)
        patch[:] = self.color
        left, right, top, bottom = max(0, x), min(width, x + side), max(0, y), min(height, y + side)
        if left < right and top < bottom:
            patch[top - y : bottom - y, left - x : right - x] = image[top:bottom, left:right]
        return cv2.resize(patch, (to, to)).transpose(2, 0, 1)[None].astype(np.float32)

    def update(self, image):
        w, h = self.size
        context = self.side(w, h)
        scale = 127 / context
        search = self.network.features(self.crop(image, context * 255 / 127, 255))
        classes, (left, top, right, bottom) = self.network.maps(self.template, search)
        score = 1 / (1 + np.exp(classes[0] - classes[1]))
        widths, heights = left + right, top + bottom

        def change(ratio):
            return np.maximum(ratio, 1 / ratio)

        scales = change(self.side(widths, heights) / self.side(w * scale, h * scale))
        penalty = np.exp(-(scales * change((w / h) / (widths / heights)) - 1) * self.penalty)
        best = np.argmax(penalty * score * (1 - self.influence) + self.window * self.influence)
        rate = penalty[best] * score[best] * self.rate
        shift = np.array([self.x + (right - left) / 2, self.y + (bottom - top) / 2])[:, best]
        room = np.array(image.shape[1::-1])
        self.center = np.clip(self.center + shift / scale, 0, room)
        found = np.array([widths[best], heights[best]]) / scale
        self.size = np.clip(self.size * (1 - rate) + found * rate, 10, room)
        return [*(self.center - self.size / 2), *self.size, score[best]]


def pattern(side):
    c, y, x = np.meshgrid(np.arange(3), np.arange(side), np.arange(side), indexing="ij")
    red_first = (x * y // 16 + 5 * x + 3 * y + 40 * c) % 256
    return red_first[::-1][None].astype(np.float32)


def main(command="time", *rest):
    models = Path(os.environ["NANOTRACK_MODELS"])
    if command == "maps":
        network = Network(models, rest[0])
        maps = network.maps(network.features(pattern(127)), network.features(pattern(255)))
        np.savetxt(sys.stdout, np.concatenate(maps).T, fmt="%.7g")
    elif command == "track":
        version, folder, box, *frames = rest
        images = sorted(Path(folder).iterdir())[: int(frames[0]) if frames else None]
        tracker = Tracker(models, version, cv2.imread(images[0]), [float(v) for v in box.split(",")])
        for image in images[1:]:
            print(" ".join(f"{v:.4f}" for v in tracker.update(cv2.imread(image))))
    else:
        cv2.setNumThreads(1)
        frames = [frame(shift) for shift in (3, 6, 9, 12, 9, 6, 3, 0)]
        for version, bench in (("v2", "nanotrack"), ("v3", "nanotrack-v3")):
            tracker = Tracker(models, version, frames[7], [288, 208, SIDE, SIDE])
            seconds = measure(tracker, frames)
            print(json.dumps({"bench": bench, "size": SIDE, "peer": "onnxruntime", "seconds": seconds}), flush=True)


main(*sys.argv[1:])
