"""Natives, against the tools and against NumPy."""
import unittest

import numpy

import altiro3d
from support import CALIBRATION, DEPTH, PHOTO, Case, random_photo, random_scene, run_tool, sample_scene, small_display


class Natives(Case):
    def test_a_native_is_that_of_the_tool(self):
        run_tool("photo2native", "-c", CALIBRATION, "-d", "--quick", "--fit", "cover", "--focus", 0.5,
                 "--strength", 10, PHOTO, DEPTH, self.folder / "native.png")
        maker = altiro3d.NativeMaker(altiro3d.read_display(CALIBRATION))
        native = maker.make_native(sample_scene())
        self.equal(native, altiro3d.read_photo(self.folder / "native.png"))

    def test_quilt_and_its_native_are_those_of_the_tool(self):
        display = altiro3d.read_display(CALIBRATION)
        maker = altiro3d.NativeMaker(display)
        placed = altiro3d.place_scene(sample_scene(), display.aspect(), maker.quilt_size(),
                                      maker.options)
        quilt = maker.make_quilt(placed.scene)
        native = altiro3d.Quilt2Native(display.calibration, display.quilt).render(quilt)
        self.equal(native, maker.make_native(placed))
        name = altiro3d.quilt_file_name(self.folder / "quilt.png", display.quilt, display.aspect())
        altiro3d.write_image(name, quilt)
        run_tool("quilt2native", "-c", CALIBRATION, "--sampling", "nearest", name,
                 self.folder / "native.png")
        self.equal(native, altiro3d.read_photo(self.folder / "native.png"))

    def test_both_orders_hold_the_same_colours(self):
        display = small_display()
        scene = random_scene(100, 90)
        maker = altiro3d.NativeMaker(display)
        over = altiro3d.NativeMaker(altiro3d.NativeLut(display.calibration, display.quilt))
        placed = altiro3d.place_scene(scene, display.aspect(), maker.quilt_size(),
                                      maker.options)
        for make, argument in ((maker.make_native, scene), (maker.make_native, placed),
                               (over.make_native, placed), (maker.make_quilt, placed.scene)):
            red_first = make(argument)
            self.equal(make(argument, order="bgr"), red_first[..., ::-1])
            self.equal(make(argument, out=numpy.empty_like(red_first)), red_first)
        self.equal(over.make_native(scene), maker.make_native(scene))
        quilt = maker.make_quilt(placed.scene)
        renderer = altiro3d.Quilt2Native(display.calibration, display.quilt)
        self.equal(renderer.render(quilt), maker.make_native(placed))
        self.equal(renderer.render(quilt[..., ::-1], order="bgr"), maker.make_native(placed, order="bgr"))

    def test_the_table_says_which_pixel_is_shown(self):
        display = small_display()
        lut = altiro3d.NativeLut(display.calibration, display.quilt)
        quilt = random_photo(64, 72)
        native = altiro3d.Quilt2Native(lut).render(quilt)
        for colour in range(3):
            table = lut.channel(colour)
            self.equal(native[..., colour], quilt[table[..., 1], table[..., 0], colour])
        lut.save(self.folder / "a.map")
        again = altiro3d.NativeLut.load(self.folder / "a.map")
        self.equal(again.channel(2), lut.channel(2))
        self.assertEqual(again.calibration_fingerprint(),
                         altiro3d.fingerprint(display.calibration))
        display.calibration.pitch += 1
        self.assertNotEqual(again.calibration_fingerprint(),
                            altiro3d.fingerprint(display.calibration))
        made = altiro3d.NativeMaker(again).make_native(random_scene(32, 24))
        self.assertEqual(made.shape, (128, 96, 3))

    def test_options_are_those_of_the_library(self):
        options = altiro3d.NativeOptions()
        options.show_live()
        self.assertEqual(options.views.method, altiro3d.ViewMethod.Fast)
        self.assertEqual(options.refine.flaws, altiro3d.DepthFlaws())
        options.show_as(altiro3d.Detail.Panel)
        self.assertTrue(options.lens_filter)
        maker = altiro3d.NativeMaker(small_display(), options=options)
        self.assertEqual(maker.work_size(), maker.panel_size())
        self.assertEqual(maker.path(), altiro3d.NativePath.Direct)
        other = maker.with_views(altiro3d.ViewOptions(focus=0.25))
        self.assertEqual((other.options.views.focus, maker.options.views.focus), (0.25, 0.5))
        linear = altiro3d.NativeOptions()
        linear.sampling.views = altiro3d.ViewFilter.Linear
        self.assertIn("blended", altiro3d.NativeMaker.obstacle(maker.layout, linear))


if __name__ == "__main__":
    unittest.main()
