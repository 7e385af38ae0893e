"""Runs each block of Python in docs/python.md, and the programs of docs/examples/python."""
import contextlib
import io
import os
import re
import runpy
import signal
import subprocess
import sys
import unittest
from fractions import Fraction

import numpy

import altiro3d
from support import CALIBRATION, PHOTO, SOURCE, Case, random_photo, small_display

DOCUMENT = SOURCE / "docs/python.md"
EXAMPLES = SOURCE / "docs/examples/python"


def write_clip(file):
    """A short video: a part of the photo that moves."""
    photo = altiro3d.read_photo(PHOTO)[300:780:2, :640:2]
    options = altiro3d.VideoWriterOptions(size=(256, 240), time_base=Fraction(1, 10), frame_rate=10)
    with altiro3d.VideoWriter(file, options) as writer:
        for number in range(4):
            writer.write(photo[:, number:number + 256], number)


class Documents(Case):
    def setUp(self):
        super().setUp()
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        (self.folder / "holiday.jpg").write_bytes(PHOTO.read_bytes())
        (self.folder / "visual.json").write_bytes(CALIBRATION.read_bytes())

    def test_each_block_runs_and_writes_what_it_names(self):
        write_clip(self.folder / "clip.mp4")
        (self.folder / "renderings").mkdir()
        for view in range(45):
            altiro3d.write_image(self.folder / f"renderings/{view}.png", random_photo(480, 360, view))
        blocks = re.findall(r"^```python\n(.*?)^```$", DOCUMENT.read_text(), re.M | re.S)
        self.assertGreaterEqual(len(blocks), 8)
        for block in blocks:
            with self.subTest(block.splitlines()[-1]):
                program = compile(block.replace("/dev/video0", "clip.mp4"), str(DOCUMENT), "exec")
                with contextlib.redirect_stdout(io.StringIO()):
                    exec(program, {"__name__": "document"})
                for name in re.findall(r'(?:write_image\(|sheet.write\(|output=)"([^"]+)"', block):
                    self.assertGreater((self.folder / name).stat().st_size, 1000, name)
                    (self.folder / name).unlink()
        self.assertTrue((self.folder / "scene_qs9x5a0.75.png").exists())

    def test_a_network_is_a_source(self):
        example = runpy.run_path(str(EXAMPLES / "network_depth.py"), run_name="example")
        shapes = []

        def network(tensor):
            shapes.append((tensor.dtype, tensor.shape, tensor.min() >= 0, tensor.max() <= 1))
            return 7 + tensor[:, :1].mean(axis=3, keepdims=True).repeat(tensor.shape[3], axis=3)

        source = example["NetworkDepth"](network, lambda array: array)
        example["make_native"]("visual.json", source, "holiday.jpg", "native.png")
        self.assertEqual(shapes, [(numpy.float32, (1, 3, 384, 288), True, True)])
        native = altiro3d.read_photo("native.png")
        self.assertEqual(native.shape, (2048, 1536, 3))
        plain = example["NetworkDepth"](lambda tensor: tensor[:, 0], lambda array: array)
        red = altiro3d.read_photo("holiday.jpg")[..., 0]
        low = plain.read(altiro3d.read_photo("holiday.jpg"))
        self.assertAlmostEqual(float(low.mean()), red.mean() / 255, places=2)

    def test_cameras_in_a_row_meet_in_the_plane_of_focus(self):
        example = runpy.run_path(str(EXAMPLES / "blender_quilt.py"), run_name="example")
        angle, distance = 0.9, 5.0
        row = list(example["camera_row"](45, 40, distance, angle))
        self.assertAlmostEqual(row[-1][0] - row[0][0], 2 * distance * numpy.tan(numpy.radians(20)))
        for right, shift in row:
            # a point of the plane, by the pinhole camera: in longer sides from the picture's middle
            for x in (-1.0, 0.0, 2.0):
                seen = (x - right) / (2 * distance * numpy.tan(angle / 2)) - shift
                self.assertAlmostEqual(seen, x / (2 * distance * numpy.tan(angle / 2)))

    def test_renderings_become_quilt_and_native(self):
        example = runpy.run_path(str(EXAMPLES / "blender_quilt.py"), run_name="example")
        display = small_display()
        files = []
        for view in range(6):
            files.append(self.folder / f"view{view}.png")
            altiro3d.write_image(files[-1], random_photo(32, 24, view))
        quilt_file, native_file = example["make_pictures"](files, display, self.folder)
        quilt = altiro3d.read_photo(quilt_file)
        self.equal(quilt[32:, :24], random_photo(32, 24, 0))
        self.equal(quilt[:32, 48:], random_photo(32, 24, 5))
        lut = altiro3d.NativeLut(display.calibration, display.quilt)
        green = lut.channel(1)
        self.equal(altiro3d.read_photo(native_file)[..., 1], quilt[green[..., 1], green[..., 0], 1])

    def test_a_folder_is_watched_until_ctrl_c(self):
        for name in ("photos", "natives"):
            (self.folder / name).mkdir()
        (self.folder / "photos/broken.png").write_bytes(b"\x89PNG")
        with open(self.folder / "errors", "w") as errors:  # Debian's ONNX Runtime fills a pipe
            program = subprocess.Popen(
                [sys.executable, EXAMPLES / "watch_folder.py", "visual.json", "photos", "natives"],
                stdout=subprocess.PIPE, stderr=errors, text=True)
        self.addCleanup(program.kill)
        (self.folder / "photos/a.jpg").write_bytes(PHOTO.read_bytes())
        self.assertEqual(program.stdout.readline(), "natives/a.png\n")
        program.send_signal(signal.SIGINT)
        program.communicate(timeout=30)
        errors = (self.folder / "errors").read_text()
        self.assertEqual(program.returncode, 0, errors)
        self.assertIn("photos/broken.png: ", errors)
        self.assertTrue(altiro3d.is_marked_native(self.folder / "natives/a.png"))


if __name__ == "__main__":
    unittest.main()
