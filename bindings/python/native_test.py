"""Views, quilts, Natives, lens: against the tools and against NumPy."""
import threading
import unittest

import numpy

import altiro3d
from support import CALIBRATION, DEPTH, PHOTO, Case, random_photo, run_tool, small_display


def sample_scene():
    source = altiro3d.depth_from_file(DEPTH)
    return source.read_scene(source.read_photo(PHOTO))


def random_scene(rows, columns):
    depth = numpy.random.default_rng(2).random((rows, columns), dtype=numpy.float32)
    return altiro3d.Scene(random_photo(rows, columns), depth)


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
                                      maker.options.placement())
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
                                      maker.options.placement())
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
        altiro3d.require_same_display(again, "a.map", display.calibration, "display")
        display.calibration.pitch += 1
        self.fails(altiro3d.ErrorCode.Mismatch, "a.map", lambda: altiro3d.require_same_display(
            again, "a.map", display.calibration, "display"))
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

    def test_settings_follow_from_the_scene(self):
        display = altiro3d.read_display(CALIBRATION)
        options = altiro3d.NativeOptions().placement()
        chosen = altiro3d.choose_from_scene(sample_scene(), display.aspect(), display.quilt, options,
                                            altiro3d.AutoChoices(focus=True))
        self.assertNotEqual(chosen.views.focus, options.views.focus)
        self.assertEqual(chosen.framing, options.framing)

    def test_threads_work_at_the_same_time(self):
        display = small_display()
        scene = random_scene(100, 90)
        makers = [altiro3d.NativeMaker(display) for _ in range(2)]
        expected = makers[0].make_native(scene)
        faults = []

        def work(maker):
            for _ in range(20):
                if not numpy.array_equal(maker.make_native(scene), expected):
                    faults.append(maker)

        threads = [threading.Thread(target=work, args=(maker,)) for maker in makers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(faults, [])


class Quilts(Case):
    def test_a_layout_is_found(self):
        layout = altiro3d.QuiltLayout(columns=4, rows=5, tile_size=(120, 160), view_count=20)
        photo = altiro3d.read_photo(PHOTO)[::4, ::4]
        quilt = numpy.empty((800, 480, 3), numpy.uint8)
        for view in range(20):
            x, y, width, height = layout.tile(view)
            quilt[y:y + height, x:x + width] = photo[60:220, 40 + 2 * view:160 + 2 * view]
        found = altiro3d.find_quilt_layout(quilt)
        self.assertEqual((found.verdict, found.layout.columns, found.layout.rows),
                         (altiro3d.QuiltVerdict.Quilt, 4, 5))

    def test_quilts_are_cropped_and_fitted_to_whole_pixels(self):
        layout = altiro3d.QuiltLayout(columns=3, rows=2, tile_size=(24, 32), view_count=6)
        quilt = random_photo(65, 74)
        self.equal(altiro3d.crop_quilt(quilt, layout), quilt[1:, :72])
        self.assertEqual(altiro3d.fit_quilt(quilt, layout).shape, (64, 72, 3))
        shape = altiro3d.QuiltShape("a_qs3x2a0.5.png", layout, small_display())
        self.assertEqual((shape.fit(), shape.aspect()), (altiro3d.FitMode.Contain, 0.5))
        self.assertEqual(shape.apply(quilt).shape, (64, 72, 3))


class Lens(Case):
    def test_an_eye_sees_what_the_tool_shows(self):
        maker = altiro3d.NativeMaker(altiro3d.read_display(CALIBRATION))
        native = maker.make_native(sample_scene())
        altiro3d.write_image(self.folder / "native.png", native, mark=altiro3d.ImageMark.Native)
        run_tool("native2view", "-c", CALIBRATION, "--angle", 10, self.folder / "native.png",
                 self.folder / "view.png")
        calibration = altiro3d.read_display(CALIBRATION).calibration
        eye = altiro3d.eye_at_angle(calibration, 10)
        blurs = (0, altiro3d.eye_blur(calibration))
        seen = []
        for blur in blurs:
            eye.blur = blur
            seen.append(altiro3d.simulate_view(native, calibration, eye))
        tool = altiro3d.read_photo(self.folder / "view.png")
        self.assertTrue(any(numpy.array_equal(tool, picture) for picture in seen))

    def test_a_native_of_one_colour_per_view_is_seen_as_such(self):
        display = small_display()
        quilt = numpy.empty((64, 72, 3), numpy.uint8)
        for view in range(6):
            x, y, width, height = display.quilt.tile(view)
            quilt[y:y + height, x:x + width] = 40 * view
        native = altiro3d.Quilt2Native(display.calibration, display.quilt).render(quilt)
        for view in range(6):
            eye = altiro3d.eye_at_view(view, 6)
            seen = altiro3d.simulate_view(native, display.calibration, eye, out=native.copy())
            self.assertEqual(numpy.unique(seen).tolist(), [40 * view])


if __name__ == "__main__":
    unittest.main()
