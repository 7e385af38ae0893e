"""Scenes of Gaussian splats."""

import unittest
from concurrent.futures import ThreadPoolExecutor

import altiro3d
import numpy

from support import Case, random_scene, small_display


class Splats(Case):
    def test_a_photo_becomes_splats_and_comes_back(self):
        scene = random_scene(40, 30)
        splats = altiro3d.splats_of(scene)
        self.assertGreaterEqual(len(splats), 40 * 30)
        file = self.folder / "photo.ply"
        altiro3d.write_splats(file, splats)
        back = altiro3d.read_splats(file)
        self.assertEqual((len(back), back.degree, back.has_camera), (len(splats), 0, True))
        display = small_display()
        made = altiro3d.render_splats(back, display, strength_percent=0)
        width, height = display.quilt.size()
        self.assertEqual(made["quilt"].shape, (height, width, 3))
        self.assertEqual(made["strength_percent"], 0)
        self.assertTrue(0 <= made["depth"].min() <= made["depth"].max() <= 1)
        blue_first = altiro3d.render_splats(back, display, strength_percent=0, order="bgr")
        numpy.testing.assert_array_equal(blue_first["quilt"][..., ::-1], made["quilt"])
        filtered = altiro3d.filter_for_lens(made["quilt"], display.quilt, display.calibration)
        self.assertEqual(filtered.shape, made["quilt"].shape)

    def test_threads_share_a_scene(self):
        splats = altiro3d.splats_of(random_scene(40, 30))
        display = small_display()
        with ThreadPoolExecutor(4) as pool:
            quilts = list(pool.map(lambda _: altiro3d.render_splats(splats, display)["quilt"], range(8)))
        for quilt in quilts:
            numpy.testing.assert_array_equal(quilt, quilts[0])

    def test_what_is_no_scene_is_an_error(self):
        file = self.folder / "a.ply"
        file.write_bytes(b"ply\nformat ascii 1.0\nend_header\n")
        with self.assertRaisesRegex(altiro3d.Error, "has no vertices"):
            altiro3d.read_splats(file)


if __name__ == "__main__":
    unittest.main()
