"""Writes the averaged network of a checkpoint as ONNX and checks it in OpenCV.

Usage: export.py CHECKPOINT OUT.onnx
"""
import argparse
import hashlib
import os

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("checkpoint")
parser.add_argument("out", metavar="OUT.onnx")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np
import torch

from network import DepthNet


def main():
    checkpoint, out = args.checkpoint, args.out
    net = DepthNet()
    net.load_state_dict(torch.load(checkpoint, map_location="cpu")["mean"])
    net.eval()
    part = out + ".part"
    # opset 11: the first whose Resize says how it samples, so that all engines agree
    torch.onnx.export(net, torch.zeros(1, 3, 256, 256), part, opset_version=11,
                      input_names=["photo"], output_names=["depth"],
                      dynamic_axes={"photo": {2: "height", 3: "width"},
                                    "depth": {2: "height", 3: "width"}})
    opencv = cv2.dnn.readNetFromONNX(part)
    for height, width in ((256, 256), (192, 256), (384, 256), (224, 384)):
        x = torch.rand(1, 3, height, width) * 2 - 1
        opencv.setInput(x.numpy())
        with torch.no_grad():
            expected = net(x).numpy()
        error = np.abs(opencv.forward() - expected).max() / np.ptp(expected)
        print(f"{width} x {height}: OpenCV differs by {error:.1e} of the range")
        assert error < 1e-4
    os.replace(part, out)
    with open(out, "rb") as stream:
        data = stream.read()
    print(f"{out}: {len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")


if __name__ == "__main__":
    main()
