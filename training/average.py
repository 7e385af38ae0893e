"""Averages the weights of exported networks that were trained further from one another.

Usage: average.py OUT.onnx FILE.onnx... [--shares SHARE...]     equal shares by default
"""
import argparse
import hashlib

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("out")
parser.add_argument("files", nargs="+")
parser.add_argument("--shares", type=float, nargs="+", help="of the files, in their order; any sum")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import onnx
from onnx import numpy_helper


def main():
    shares = args.shares or [1] * len(args.files)
    if len(shares) != len(args.files):
        parser.error(f"--shares: {len(shares)} shares, expected {len(args.files)}, one for each file")

    models = [onnx.load(file) for file in args.files]
    values = [{w.name: numpy_helper.to_array(w) for w in model.graph.initializer} for model in models]
    for weights in models[0].graph.initializer:
        own = values[0][weights.name]
        if own.dtype.kind == "f" and own.size > 0:
            mean = sum(share / sum(shares) * v[weights.name].astype("float64") for share, v in zip(shares, values))
            weights.CopyFrom(numpy_helper.from_array(mean.astype(own.dtype), weights.name))
    onnx.save(models[0], args.out)
    with open(args.out, "rb") as stream:
        data = stream.read()
    print(f"{args.out}: {len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")


if __name__ == "__main__":
    main()
