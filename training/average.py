"""Averages the weights of two exported networks, of which one was trained further from the other.

Usage: average.py FIRST.onnx SECOND.onnx OUT.onnx
"""
import hashlib
import sys

import onnx
from onnx import numpy_helper


def main():
    first, second, out = sys.argv[1:]
    mean, other = onnx.load(first), onnx.load(second)
    others = {weights.name: numpy_helper.to_array(weights) for weights in other.graph.initializer}
    for weights in mean.graph.initializer:
        own = numpy_helper.to_array(weights)
        if own.dtype.kind == "f" and own.size > 0:
            average = (0.5 * own + 0.5 * others[weights.name]).astype(own.dtype)
            weights.CopyFrom(numpy_helper.from_array(average, weights.name))
    onnx.save(mean, out)
    with open(out, "rb") as stream:
        data = stream.read()
    print(f"{out}: {len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")


if __name__ == "__main__":
    main()
