"""Depth maps: numbers, conversions, refinement."""
import unittest

import numpy

import altiro3d
from support import DEPTH, PHOTO, Case, random_photo


class DepthMaps(Case):
    def test_a_ramp_is_normalized_by_its_percentiles(self):
        raw = numpy.linspace(3, 7, 50).reshape(5, 10)  # below 200 values: their extremes
        expected = ((raw - 3) / 4).astype(numpy.float32)
        for numbers in (raw, raw.astype(numpy.float32)):
            depth = altiro3d.normalize_depth(numbers)
            self.assertLess(numpy.abs(depth - expected).max(), 1e-6)
        far = altiro3d.DepthNormalization(kind=altiro3d.DepthKind.FarWhite)
        self.assertLess(numpy.abs(altiro3d.normalize_depth(raw, options=far) - (1 - expected)).max(),
                        1e-6)
        metric = altiro3d.DepthNormalization(kind=altiro3d.DepthKind.Metric)
        inverse = (1 / raw - 1 / 7) / (1 / 3 - 1 / 7)
        self.assertLess(numpy.abs(altiro3d.normalize_depth(raw, options=metric) - inverse).max(), 1e-6)

    def test_photo_and_depth_are_joined_and_split(self):
        photo = random_photo(4, 6)
        depth = numpy.linspace(0, 1, 24, dtype=numpy.float32).reshape(4, 6)
        for side, cut in ((altiro3d.DepthSide.Right, numpy.s_[:, 6:]),
                          (altiro3d.DepthSide.Top, numpy.s_[:4])):
            layout = altiro3d.RgbdLayout(side=side)
            both = altiro3d.join_rgbd(photo, depth, layout=layout)
            grey = numpy.rint(depth * 255)
            self.equal(both[cut], numpy.repeat(grey[..., None], 3, axis=2).astype(numpy.uint8))
            again, raw = altiro3d.split_rgbd(both, layout=layout)
            self.equal(again, photo)
            self.equal(raw, grey.astype(numpy.float32))

    def test_depth_is_converted(self):
        depth = numpy.linspace(0, 1, 20, dtype=numpy.float32).reshape(4, 5)
        self.equal(altiro3d.depth_to16_bit(depth),
                   numpy.rint(depth.astype(float) * 65535).astype(numpy.uint16))

    def test_depth_is_fitted_and_refined(self):
        photo = altiro3d.read_photo(PHOTO)[400:800, 300:700]
        depth = altiro3d.normalize_depth(altiro3d.read_depth_image(DEPTH))[400:800, 300:700]
        small = depth[::4, ::4]
        fitted = altiro3d.fit_depth(small, photo)
        self.assertEqual(fitted.shape, (400, 400))
        self.assertTrue(small.min() <= fitted.min() and fitted.max() <= small.max())
        exact = altiro3d.DepthRefineOptions(flaws=altiro3d.DepthFlaws())
        same, flaws = altiro3d.refine_depth(photo, depth, options=exact)
        self.equal(same, depth.copy())
        self.assertFalse(flaws.any())


if __name__ == "__main__":
    unittest.main()
