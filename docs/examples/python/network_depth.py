#!/usr/bin/env python3
"""The Native of a photo with depth from any network of PyTorch.

    network_depth.py visual.json network.pt photo.jpg native.png

network.pt is a TorchScript file that takes [1 x 3 x rows x columns], red first, 0..1, and returns
inverse depth: larger = nearer. Sides are multiples of 32.
"""
import sys

import numpy

import altiro3d


class NetworkDepth(altiro3d.DepthSource):
    """Depth of a network. `network` and `tensor` are torch.jit.load(...) and torch.from_numpy."""

    def __init__(self, network, tensor, longer_side=384):
        super().__init__()
        self.network, self.tensor, self.longer_side = network, tensor, longer_side

    def description(self):
        return f"network {type(self.network).__name__}"

    def read(self, photo):
        rows, columns = (max(32, round(side * self.longer_side / max(photo.shape) / 32) * 32)
                         for side in photo.shape[:2])
        # each pixel of the input is the nearest one of the photo; your network may want another filter
        y = (numpy.arange(rows) + 0.5) * photo.shape[0] // rows
        x = (numpy.arange(columns) + 0.5) * photo.shape[1] // columns
        small = photo[y.astype(int)[:, None], x.astype(int)]
        planes = numpy.ascontiguousarray(small.transpose(2, 0, 1)[None], dtype=numpy.float32) / 255
        depth = numpy.asarray(self.network(self.tensor(planes)))
        return depth.reshape(depth.shape[-2:])  # any size; altiro3D aligns it with the photo


def make_native(calibration, source, photo, native):
    """Makes the Native of a photo, whose depth comes from `source`."""
    options = altiro3d.NativeOptions()
    options.show_as(altiro3d.Detail.Lens)
    maker = altiro3d.NativeMaker(altiro3d.read_display(calibration), options=options)
    scene = source.read_scene(source.read_photo(photo))
    altiro3d.write_image(native, maker.make_native(scene), mark=altiro3d.ImageMark.Native)


if __name__ == "__main__":
    import torch

    with torch.no_grad():
        make_native(sys.argv[1], NetworkDepth(torch.jit.load(sys.argv[2]), torch.from_numpy),
                    *sys.argv[3:])
