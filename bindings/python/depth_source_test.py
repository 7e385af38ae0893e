"""Sources of depth: the library's, and classes of Python."""
import gc
import threading
import unittest

import numpy

import altiro3d
from support import DEPTH, PHOTO, Case, random_photo


class Ramp(altiro3d.DepthSource):
    """Depth that rises to the right."""

    def read(self, photo):
        self.photo = photo
        return numpy.tile(numpy.arange(photo.shape[1], dtype=numpy.float32), (photo.shape[0], 1))


class Tensor:
    """What NumPy takes for an array, as tensors of PyTorch are."""

    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None):
        return self.array if dtype is None else self.array.astype(dtype)


class Sources(Case):
    def test_one_method_makes_a_source(self):
        photo = random_photo(20, 30)
        source = Ramp()
        scene = source.read_scene(photo)
        self.equal(source.photo, photo)
        self.equal(scene.photo, photo)
        ramp = numpy.tile(numpy.arange(30) / 29, (20, 1))
        low, high = numpy.percentile(ramp, 0.5), numpy.percentile(ramp, 99.5)
        self.assertLess(numpy.abs(scene.depth - numpy.clip((ramp - low) / (high - low), 0, 1)).max(),
                        1e-6)
        self.assertEqual((source.description(), source.kind()),
                         ("Ramp", altiro3d.DepthKind.NearWhite))

    def test_a_source_gives_what_its_depth_as_a_file_gives(self):
        photo = random_photo(20, 30)
        ramp = Ramp().read(photo)
        altiro3d.write_image(self.folder / "ramp.png", ramp.astype(numpy.uint16))
        altiro3d.write_image(self.folder / "photo.png", photo)
        file = altiro3d.depth_from_file(self.folder / "ramp.png")
        expected = file.read_scene(file.read_photo(self.folder / "photo.png"))
        source = altiro3d.stored_depth_or(Ramp())
        scene = source.read_scene(source.read_photo(self.folder / "photo.png"))
        self.equal(scene.depth, expected.depth)
        self.equal(scene.photo, expected.photo)

    def test_the_meaning_of_the_numbers_may_be_stated(self):
        class Distance(Ramp):
            def kind(self):
                return altiro3d.DepthKind.Metric

            def description(self):
                return "laser"

        depth = Distance().read_scene(random_photo(20, 30)).depth
        self.assertTrue((numpy.diff(depth[0]) <= 0).all())
        self.assertEqual(depth[0, 0], depth[0, 1])  # unknown, takes its neighbour's
        self.assertEqual(Distance().description(), "laser")

    def test_what_numpy_takes_for_an_array_is_depth(self):
        for number in ("u1", "u2", "f4", "f8"):
            class Any(altiro3d.DepthSource):
                def read(self, photo):
                    return Tensor(numpy.eye(9, 13, dtype=number))

            self.equal(Any().read_scene(random_photo(20, 30)).depth, numpy.eye(9, 13, dtype="f4"))

    def test_errors_of_a_source_arrive_where_it_was_called(self):
        class Broken(altiro3d.DepthSource):
            def read(self, photo):
                raise KeyError("no model")

        class Wrong(altiro3d.DepthSource):
            def read(self, photo):
                return photo

        class Empty(altiro3d.DepthSource):
            pass

        photo = random_photo(4, 4)
        with self.assertRaisesRegex(KeyError, "no model"):
            altiro3d.stored_depth_or(Broken()).read_scene(photo)
        code = altiro3d.ErrorCode.InvalidArgument
        text = self.fails(code, "depth of read()", lambda: Wrong().read_scene(photo))
        self.assertIn("is uint8 of shape (4, 4, 3), expected uint8 of shape (rows, columns) or", text)
        self.fails(code, "Empty", lambda: Empty().read_scene(photo))

    def test_a_source_lives_as_long_as_the_library_uses_it(self):
        source = altiro3d.stored_depth_or(altiro3d.stored_depth_or(Ramp()))
        gc.collect()
        self.assertEqual(source.read_scene(random_photo(4, 300)).depth[0, -1], 1)

    def test_threads_may_release_a_source(self):
        sources = [altiro3d.stored_depth_or(Ramp()) for _ in range(50)]
        thread = threading.Thread(target=sources.clear)
        thread.start()
        thread.join()

    def test_depth_beside_a_photo_is_taken(self):
        source = altiro3d.stored_depth_or(altiro3d.estimated_depth())
        found = source.read_photo(PHOTO)
        self.equal(found.photo, altiro3d.read_photo(PHOTO))
        self.equal(found.raw_depth.astype("f4"), altiro3d.read_depth_image(DEPTH))
        none = altiro3d.PhotoDepthOptions(use_depth=False)
        source = altiro3d.stored_depth_or(Ramp(), options=none)
        self.assertIsNone(source.read_photo(PHOTO).raw_depth)

    def test_the_network_is_found_and_estimates(self):
        names = [network.profile.name for network in altiro3d.installed_networks()]
        self.assertIn("altiro3d", names)
        source = altiro3d.estimated_depth()
        source.load()
        depth = source.read_scene(altiro3d.read_photo(PHOTO)[::4, ::4]).depth
        self.assertLess(depth[: len(depth) // 4].mean(), depth[-len(depth) // 4 :].mean())

    def test_halves_are_split(self):
        photo = random_photo(8, 10)
        depth = numpy.tile(numpy.linspace(0, 1, 10, dtype=numpy.float32), (8, 1))
        both = altiro3d.join_rgbd(photo, depth)
        scene = altiro3d.depth_from_rgbd().read_scene(both)
        self.equal(scene.photo, photo)
        self.assertLess(numpy.abs(scene.depth - depth).max(), 1 / 255)

    def test_pairs_are_matched(self):
        noise = numpy.repeat(numpy.repeat(random_photo(60, 120), 4, axis=0), 4, axis=1)
        left, right = noise[:, 8:408], noise[:, 16:416]  # all 8 px
        altiro3d.write_image(self.folder / "left.png", left)
        altiro3d.write_image(self.folder / "right.png", right)
        pair = altiro3d.StereoInput(right=self.folder / "right.png")
        found = altiro3d.depth_from_stereo(pair, Ramp()).read_photo(self.folder / "left.png")
        self.equal(found.photo, left)
        self.assertAlmostEqual(float(numpy.median(found.raw_depth)), 8 / 400, places=3)


if __name__ == "__main__":
    unittest.main()
