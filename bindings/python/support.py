"""What the tests of the module share."""
import os
import subprocess
import tempfile
import unittest
from fractions import Fraction
from pathlib import Path

import numpy

import altiro3d

SOURCE = Path(__file__).resolve().parents[2]
TOOLS = os.environ.get("ALTIRO3D_TOOLS")  # folder of the command-line tools, if they are built
CALIBRATION = SOURCE / "calibration/portrait-sample.json"
PHOTO = SOURCE / "docs/examples/sample.jpg"
DEPTH = SOURCE / "docs/examples/sample-depth.png"


class Case(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def fails(self, code, subject, work):
        """The text of the Error that work() raises."""
        with self.assertRaises(altiro3d.Error) as caught:
            work()
        self.assertEqual((caught.exception.code, caught.exception.subject), (code, subject))
        self.assertTrue(str(caught.exception).startswith(subject + ": "), caught.exception)
        return str(caught.exception)

    def equal(self, array, expected):
        """Checks that arrays are equal, in type as well."""
        self.assertEqual((array.dtype, array.shape), (expected.dtype, expected.shape))
        different = numpy.flatnonzero(numpy.asarray(array) != expected)
        self.assertEqual(different.size, 0, f"{different.size} values differ, first {different[:3]}")


def run_tool(name, *arguments):
    """Runs a command-line tool of the same build."""
    if not TOOLS:
        raise unittest.SkipTest("the tools are not built")
    subprocess.run([Path(TOOLS) / name, *map(str, arguments)], check=True, capture_output=True)


def random_photo(rows, columns, seed=1):
    """uint8 [rows x columns x 3]"""
    return numpy.random.default_rng(seed).integers(0, 256, (rows, columns, 3), dtype=numpy.uint8)


def small_display(columns=96, rows=128):
    """A display with a panel of few px, for quick tests."""
    display = altiro3d.read_display(CALIBRATION)
    display.calibration.screen_w = columns
    display.calibration.screen_h = rows
    display.quilt = altiro3d.QuiltLayout(columns=3, rows=2, tile_size=(24, 32), view_count=6)
    return display


def sample_scene():
    """The sample photo and its depth."""
    source = altiro3d.depth_from_file(DEPTH)
    return source.read_scene(source.read_photo(PHOTO))


def random_scene(rows, columns):
    """A photo and depth of noise."""
    depth = numpy.random.default_rng(2).random((rows, columns), dtype=numpy.float32)
    return altiro3d.Scene(random_photo(rows, columns), depth)


def moving_frames(count, rows=48, columns=64):
    """Frames of a picture that moves by a px each."""
    wide = numpy.repeat(numpy.repeat(random_photo(rows // 8, 30), 8, axis=0), 8, axis=1)
    return [wide[:, n:n + columns].copy() for n in range(count)]


class Brightness(altiro3d.DepthSource):
    """Takes the brightness for depth, and counts the calls."""

    calls = 0

    def read(self, photo):
        self.calls += 1
        return photo.mean(axis=2, dtype=numpy.float32)


class Clip(Case):
    """A test with a video of ten frames."""

    def setUp(self):
        super().setUp()
        self.clip = self.folder / "clip.mkv"
        self.frames = moving_frames(10)
        options = altiro3d.VideoWriterOptions(size=(64, 48), codec=altiro3d.VideoCodec.Ffv1,
                                              time_base=Fraction(1, 25), frame_rate=25)
        with altiro3d.VideoWriter(self.clip, options) as writer:
            for number, frame in enumerate(self.frames):
                writer.write(frame, number)
