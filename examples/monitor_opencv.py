#!/usr/bin/env python3
"""Follows a target with a tracker of OpenCV and says live whether the tracker has lost it.

    python3 monitor_opencv.py --box 160,110,60,80 clip.mp4
    python3 monitor_opencv.py --tracker csrt --box 160,110,60,80 0        # webcam 0
    python3 monitor_opencv.py --box 160,110,60,80 'img/%04d.jpg'          # numbered frames
    python3 monitor_opencv.py --redetect --box 160,110,60,80 0            # looks for a target that is lost
"""
import argparse
import time

import cv2
from trackfail_monitor import Monitor

parser = argparse.ArgumentParser()
parser.add_argument("video", help="a file, a pattern of numbered frames, or the number of a webcam")
parser.add_argument("--box", required=True, help="x,y,w,h of the target in the first frame")
parser.add_argument("--tracker", choices=["kcf", "csrt"], default="kcf")
parser.add_argument("--redetect", action="store_true", help="start again where the target's first picture is found")
parser.add_argument("--likeness", type=float, default=0.7, help="how like it a place must be, at most 1")
parser.add_argument("--program", default="trackfail")
parser.add_argument("--method", help="method of trackfail, by default the recommended one")
arguments = parser.parse_args()

video = cv2.VideoCapture(int(arguments.video) if arguments.video.isdigit() else arguments.video)
box = tuple(int(float(number)) for number in arguments.box.split(","))
trackers = {"kcf": cv2.TrackerKCF, "csrt": cv2.TrackerCSRT}
tracker = trackers[arguments.tracker].create()
method = ["--method", arguments.method] if arguments.method else []
times, before, picture = [], None, None


def found(frame):
    """The place in a frame that is most like the target's first picture, or None if none is like it."""
    _, likeness, _, (x, y) = cv2.minMaxLoc(cv2.matchTemplate(frame, picture, cv2.TM_CCOEFF_NORMED))
    height, width = picture.shape[:2]
    return (x, y, width, height) if likeness >= arguments.likeness else None


with Monitor(*method, program=arguments.program) as monitor:
    while True:
        ok, frame = video.read()
        if not ok:
            break
        place = found(frame) if arguments.redetect and before in ("lost", "absent") else None
        if before is None:
            tracker.init(frame, box)
            x, y, width, height = box
            picture = frame[y : y + height, x : x + width].copy()
        elif place:
            box, tracker = place, trackers[arguments.tracker].create()
            tracker.init(frame, box)
            print("found again at", *box)
        else:
            ok, box = tracker.update(frame)
        start = time.perf_counter()
        # A tracker that was started again is judged anew.
        answer = monitor.update(frame, box if ok else None, restart=place is not None)
        times.append(time.perf_counter() - start)
        if answer["state"] != before:
            print(answer["index"], answer["state"], answer["probability"], "; ".join(answer["reasons"]), flush=True)
        before = answer["state"]

if not times:
    parser.error(f"{arguments.video} has no frame that OpenCV can read")
times.sort()
print(f"{len(times)} frames, {1000 * times[len(times) // 2]:.1f} ms each for the monitor")
