"""OpenCV's calibration of the points in points.json, into opencv.json. Run where opencv-python is installed:

    python opencv.py

OpenCV is no dependency: the test reads what this wrote.
"""

import json
from pathlib import Path

import cv2
import numpy as np

folder = Path(__file__).parent
points = json.loads((folder / "points.json").read_text())
layout = np.array(points["layout"], np.float32)
answers = []
for board in points["boards"]:
    size = (board["width"], board["height"])
    objects = [layout[view["target"]] for view in board["views"]]
    images = [np.array(view["image"], np.float32) for view in board["views"]]
    done = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 1000, 1e-15)
    rms, matrix, terms, *_ = cv2.calibrateCamera(objects, images, size, None, None, criteria=done)
    parameters = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *terms.ravel()[:5]]
    answers.append({"rms": rms, "parameters": [float(value) for value in parameters]})
text = json.dumps({"opencv": cv2.__version__, "answers": answers}, indent=1)
(folder / "opencv.json").write_text(text + "\n")
