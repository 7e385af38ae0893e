"""Arrays as arguments and results: order, memory, errors."""
import gc
import subprocess
import sys
import unittest

import numpy

import altiro3d
from support import Case, random_photo


def tiny_scene(photo, order="rgb"):
    depth = numpy.full(photo.shape[:2], 0.5, numpy.float32)
    return altiro3d.Scene(photo, depth, order=order)


class Arrays(Case):
    def test_red_comes_first_unless_asked_otherwise(self):
        photo = numpy.zeros((3, 5, 3), numpy.uint8)
        photo[...] = (200, 100, 50)
        file = self.folder / "a.ppm"
        altiro3d.write_image(file, photo)
        self.assertEqual(file.read_bytes()[-3:], bytes((200, 100, 50)))  # PPM holds red first
        altiro3d.write_image(file, photo, order="bgr")
        self.assertEqual(file.read_bytes()[-3:], bytes((50, 100, 200)))
        self.equal(altiro3d.read_image(file, order="bgr"), photo)
        self.equal(altiro3d.read_image(file), photo[..., ::-1])

    def test_each_layout_of_memory_is_the_same_picture(self):
        photo = random_photo(7, 11)
        wide = numpy.zeros((7, 30, 3), numpy.uint8)
        wide[:, 3:14] = photo
        layouts = {
            "contiguous": photo,
            "columns first": numpy.asfortranarray(photo),
            "a part of a picture": wide[:, 3:14],
            "reversed rows": photo[::-1].copy()[::-1],
            "a view of blue first": photo[..., ::-1].copy()[..., ::-1],
            "every second column": numpy.repeat(photo, 2, axis=1)[:, ::2],
            "read-only": numpy.frombuffer(photo.tobytes(), numpy.uint8).reshape(photo.shape),
            "nested lists": None,
        }
        for name, array in layouts.items():
            for order in ("rgb", "bgr"):
                with self.subTest(name, order=order):
                    if array is None:
                        array = memoryview(photo)
                    file = self.folder / "a.png"
                    altiro3d.write_image(file, array, order=order)
                    self.equal(altiro3d.read_image(file, order=order), photo)

    def test_numbers_of_another_byte_order_keep_their_values(self):
        raw = numpy.arange(1, 13, dtype=">u2").reshape(3, 4) * 257
        self.equal(altiro3d.normalize_depth(raw), altiro3d.normalize_depth(raw.astype("u2")))

    def test_a_scene_shares_contiguous_memory_and_copies_the_rest(self):
        blue_first = random_photo(6, 4)
        depth = numpy.full((6, 4), 0.25, numpy.float32)
        scene = altiro3d.Scene(blue_first, depth, order="bgr")
        blue_first[2, 3] = (1, 2, 3)
        depth[5, 0] = 0.75
        self.assertEqual(tuple(scene.photo[2, 3]), (3, 2, 1))
        self.assertTrue(numpy.shares_memory(scene.depth, depth))
        scene = altiro3d.Scene(blue_first[..., ::-1], depth[:, ::-1])
        blue_first[0, 0] = (9, 8, 7)
        depth[0, 3] = 0.125
        self.assertEqual(tuple(scene.photo[0, 0]), (7, 8, 9))  # a view of blue first is not copied
        self.assertEqual(scene.depth[0, 0], 0.25)

    def test_a_scene_keeps_its_arrays_alive(self):
        scene = tiny_scene(random_photo(50, 40))
        kept = altiro3d.Scene(random_photo(50, 40), scene.depth, order="bgr")
        expected = random_photo(50, 40)
        del scene
        gc.collect()
        numpy.zeros((50, 40, 3), numpy.uint8)  # would take the memory
        self.equal(kept.photo, expected[..., ::-1])
        self.assertEqual(kept.depth.min(), 0.5)

    def test_results_own_their_memory(self):
        maker = altiro3d.Depth2Quilt(altiro3d.QuiltLayout(columns=1, rows=1, tile_size=(40, 50),
                                                          view_count=1))
        photo = random_photo(50, 40)
        quilt = maker.render(tiny_scene(photo))
        self.assertTrue(quilt.flags.c_contiguous and quilt.flags.writeable)
        again = maker.render(tiny_scene(255 - photo))
        self.equal(quilt, photo)  # depth is the focus: the view is the photo
        self.equal(again, 255 - photo)
        del maker
        gc.collect()
        self.equal(quilt, photo)

    def test_out_receives_the_result(self):
        layout = altiro3d.QuiltLayout(columns=1, rows=1, tile_size=(40, 50), view_count=1)
        maker = altiro3d.Depth2Quilt(layout)
        photo = random_photo(50, 40)
        out = numpy.empty((50, 40, 3), numpy.uint8)
        for order in ("rgb", "bgr"):
            result = maker.render(tiny_scene(photo, order), out=out, order=order)
            self.assertIs(result, out)
            self.equal(out, photo)
        depth = numpy.empty((3, 4), numpy.float32)
        self.assertIs(altiro3d.normalize_depth(numpy.eye(3, 4), out=depth), depth)
        self.equal(depth, numpy.eye(3, 4, dtype=numpy.float32))

    def test_an_out_that_does_not_fit_is_refused(self):
        layout = altiro3d.QuiltLayout(columns=1, rows=1, tile_size=(40, 50), view_count=1)
        render = altiro3d.Depth2Quilt(layout).render
        scene = tiny_scene(random_photo(50, 40))
        code = altiro3d.ErrorCode
        text = self.fails(code.Mismatch, "out",
                          lambda: render(scene, out=numpy.empty((40, 50, 3), numpy.uint8)))
        self.assertIn("uint8 of shape (40, 50, 3), expected uint8 of shape (50, 40, 3)", text)
        for out in (numpy.empty((50, 40, 4), numpy.uint8), [1], numpy.empty((50, 40, 3), "u2"),
                    numpy.empty((50, 80, 3), numpy.uint8)[:, ::2],
                    numpy.frombuffer(bytes(6000), numpy.uint8).reshape(50, 40, 3)):
            self.fails(code.InvalidArgument, "out", lambda out=out: render(scene, out=out))

    def test_wrong_arguments_are_named_with_what_is_expected(self):
        photo = random_photo(4, 5)
        depth = numpy.zeros((4, 5), numpy.float32)
        wrong = altiro3d.ErrorCode.InvalidArgument
        text = self.fails(wrong, "photo", lambda: altiro3d.Scene(photo.astype(float), depth))
        self.assertEqual(text, "photo: is float64 of shape (4, 5, 3), "
                               "expected uint8 of shape (rows, columns, 3)")
        self.fails(wrong, "photo", lambda: altiro3d.Scene(photo[..., 0], depth))
        self.fails(wrong, "photo", lambda: altiro3d.Scene(photo[:0], depth))
        self.fails(wrong, "photo", lambda: altiro3d.Scene("photo.jpg", depth))
        self.fails(wrong, "depth", lambda: altiro3d.Scene(photo, depth.astype("f8")))
        self.fails(wrong, "depth", lambda: altiro3d.Scene(photo, photo))
        text = self.fails(wrong, "depth", lambda: altiro3d.Scene(photo, depth + 3))
        self.assertIn("3..3, expected 0..1", text)
        self.assertIn("normalize_depth()", text)
        self.fails(wrong, "order", lambda: altiro3d.Scene(photo, depth, order="rbg"))
        with self.assertRaises(TypeError):
            altiro3d.Scene(photo, depth, "bgr")  # options are named

    def test_notebooks_show_pictures_and_depth(self):
        layout = altiro3d.QuiltLayout(columns=1, rows=1, tile_size=(40, 50), view_count=1)
        photo = random_photo(50, 40)
        quilt = altiro3d.Depth2Quilt(layout).render(tiny_scene(photo))
        self.assertIsInstance(quilt, altiro3d.Picture)
        for shown, expected in ((quilt, photo), (quilt[10:20, 5:9], photo[10:20, 5:9])):
            self.equal(altiro3d.read_photo(altiro3d.PhotoFile(shown._repr_png_(), "a.png")), expected)
        ramp = numpy.tile(numpy.linspace(0, 1, 300), (2, 1))
        depth = altiro3d.normalize_depth(ramp)
        png = altiro3d.PhotoFile(depth._repr_png_(), "depth.png")
        self.equal(altiro3d.read_depth_image(png), numpy.rint(depth * 65535).astype("f4"))
        self.assertIsNone(quilt[0, 0]._repr_png_())
        self.assertIsNone(quilt[..., :2]._repr_png_())


    def test_what_is_computed_of_a_picture_is_a_plain_array(self):
        depth = altiro3d.normalize_depth(numpy.eye(3, 4))
        self.assertIs(type(depth[1:]), altiro3d.Picture)
        self.assertIs(type(depth * 2), numpy.ndarray)
        self.assertIs(type(depth.mean()), numpy.float32)
        self.assertIs(type(depth.max(axis=0)), numpy.ndarray)


class Values(Case):
    def test_repr_shows_all_fields_and_gives_the_value_back(self):
        layout = altiro3d.QuiltLayout(columns=5, tile_size=(7, 9))
        self.assertEqual(repr(layout),
                         "QuiltLayout(columns=5, rows=6, tile_size=(7, 9), view_count=48)")
        options = altiro3d.NativeOptions(depth_curve=1.5)
        options.views.strength_percent = 7
        options.refine.flaws = altiro3d.DepthFlaws(shift_pixels=(1, -2))
        again = eval(repr(options), vars(altiro3d))
        self.assertEqual(again, options)
        self.assertEqual(again.refine.flaws.shift_pixels, (1, -2))
        self.assertNotEqual(again, altiro3d.NativeOptions())
        self.assertNotEqual(altiro3d.QuiltGrid(), altiro3d.QuiltLayout())

    def test_a_recipe_is_saved_with_the_words_of_the_command_line(self):
        recipe = altiro3d.Recipe(depth_curve=1.5)
        recipe.views.method = altiro3d.ViewMethod.Fast
        recipe.choices.focus = True
        text = altiro3d.recipe_text(recipe)
        for part in ('"depth-curve":1.5', '"method":"fast"', '"focus":"auto"'):
            self.assertIn(part, text)
        self.assertEqual(altiro3d.parse_recipe(text), recipe)
        self.assertIsInstance(recipe, altiro3d.NativeOptions)
        with self.assertRaisesRegex(altiro3d.Error, "^mine: method: is \"slow\", expected layered"):
            altiro3d.parse_recipe('{"method": "slow"}', source="mine")

    def test_copies_are_independent(self):
        import copy
        options = altiro3d.NativeOptions()
        other = copy.copy(options)
        deep = copy.deepcopy(options)
        options.views.focus = 0.25
        self.assertEqual((other.views.focus, deep.views.focus), (0.5, 0.5))

    def test_wrong_fields_are_named(self):
        with self.assertRaisesRegex(TypeError, "^pitch: is 'x', expected float$"):
            altiro3d.Calibration(pitch="x")
        with self.assertRaisesRegex(TypeError, "^tile_size: is .1, 2, 3., expected Tuple"):
            altiro3d.QuiltLayout(tile_size=(1, 2, 3))
        with self.assertRaisesRegex(TypeError, "^pich: is not a field of Calibration$"):
            altiro3d.Calibration(pich=1)
        with self.assertRaisesRegex(TypeError, "expected altiro3d.Detail"):
            altiro3d.NativeOptions().detail = 1

    def test_signatures_show_the_defaults(self):
        doc = altiro3d.NativeOptions.__init__.__doc__
        self.assertIn("views: altiro3d.ViewOptions = ViewOptions()", doc)
        self.assertIn("depth_curve: float = 1.0", doc)
        self.assertIn("options: altiro3d.NativeOptions = NativeOptions()",
                      altiro3d.NativeMaker.__init__.__doc__)

    def test_the_import_is_quick(self):
        program = "import time, {}; print(time.process_time())"
        def least(module):
            return min(float(subprocess.run([sys.executable, "-c", program.format(module)],
                                            check=True, text=True, capture_output=True).stdout)
                       for _ in range(5))
        self.assertLess(least("altiro3d"), 3 * least("numpy"))

    def test_everything_has_a_docstring(self):
        for name, item in vars(altiro3d).items():
            if not name.startswith("_"):
                self.assertTrue((item.__doc__ or "").strip(), name)

    def test_errors_of_memory_are_memory_errors(self):
        layout = altiro3d.QuiltLayout(columns=1, rows=1, tile_size=(65535, 65535), view_count=1)
        with self.assertRaises((MemoryError, altiro3d.Error)):
            altiro3d.crop_quilt(random_photo(2, 2), layout)


if __name__ == "__main__":
    unittest.main()
