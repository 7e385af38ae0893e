"""Views and quilts of a photo, against NumPy."""
import unittest

import numpy

import altiro3d
from support import Case, random_photo, random_scene


class Views(Case):
    layout = altiro3d.QuiltLayout(columns=3, rows=2, tile_size=(24, 32), view_count=5)

    def test_a_view_of_method_fast_is_the_formula(self):
        photo = random_photo(1, 400)
        depth = numpy.ones((1, 400), numpy.float32)
        options = altiro3d.ViewOptions(method=altiro3d.ViewMethod.Fast, strength_percent=10, focus=0.5)
        maker = altiro3d.Depth2Quilt(self.layout, options=options)
        view = maker.render_view(altiro3d.Scene(photo, depth), 1)  # by 400 * 10 % / 2 * 0.5 = 10 px
        self.equal(view[:, :390], photo[:, 10:])

    def test_a_quilt_holds_the_views_in_its_tiles(self):
        scene = random_scene(32, 24)
        maker = altiro3d.Depth2Quilt(self.layout)
        quilt = maker.render(scene)
        self.assertEqual(quilt.shape, (64, 72, 3))
        for view in range(5):
            x, y, width, height = self.layout.tile(view)
            position = altiro3d.view_position(view, 5)
            self.equal(quilt[y:y + height, x:x + width], maker.render_view(scene, position))
        self.assertFalse(quilt[:32, 48:].any())  # an unused tile

    def test_progress_is_told_and_stops(self):
        scene = random_scene(64, 60)
        maker = altiro3d.Depth2Quilt(self.layout)
        shares = []
        quilt = maker.render(scene, go_on=shares.append)
        self.equal(quilt, maker.render(scene))
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 1)
        self.assertIsNone(maker.render(scene, go_on=lambda share: False))
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            maker.render(scene, go_on=lambda share: 1 / 0)

    def test_both_eyes_are_the_outermost_views(self):
        scene = random_scene(30, 40)
        options = altiro3d.ViewOptions(strength_percent=2.5)
        left, right = altiro3d.render_eyes(scene, options)
        maker = altiro3d.Depth2Quilt(self.layout, options=options)
        self.equal(left, maker.render_view(scene, -1))
        self.equal(right, maker.render_view(scene, 1))
        both = altiro3d.join_eyes(left, right, altiro3d.EyesPicture.SideBySide)
        self.equal(both, numpy.concatenate((left, right), axis=1))
        again = altiro3d.split_stereo_pair(both, altiro3d.StereoLayout.LeftRight,
                                           halves=altiro3d.StereoHalves.Full)
        self.equal(again[0], left)
        self.equal(again[1], right)
        grey = altiro3d.join_eyes(left, right, altiro3d.EyesPicture.AnaglyphGrey)
        self.assertTrue((grey[..., 1] == grey[..., 2]).all())  # cyan is the right eye's


if __name__ == "__main__":
    unittest.main()
