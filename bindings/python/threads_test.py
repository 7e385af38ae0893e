"""Objects that threads share, names in messages, and interpreters that cannot load the module."""
import os
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy

import altiro3d
from support import PHOTO, Brightness, Clip, moving_frames, random_photo, small_display

THREADS = 4


def in_threads(work, arguments):
    """work() of each argument, in threads at the same time."""
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(work, arguments))


class Threads(Clip):
    def test_sources_give_each_thread_its_own_photo(self):
        estimated = altiro3d.estimated_depth()
        photos = [numpy.ascontiguousarray(altiro3d.read_photo(PHOTO)[n::16, ::16]) for n in range(4)]
        for source in (estimated, altiro3d.stored_depth_or(estimated), altiro3d.depth_from_rgbd()):
            expected = [source.read(photo) for photo in photos]
            for depth, alone in zip(in_threads(source.read, photos), expected):
                self.equal(depth, alone)
        self.assertEqual(len(set(in_threads(lambda n: estimated.description(), range(8)))), 1)

    def test_a_source_is_shared_with_those_that_fall_back_on_it(self):
        estimated = altiro3d.estimated_depth()
        photo = numpy.ascontiguousarray(altiro3d.read_photo(PHOTO)[::16, ::16])
        expected = estimated.read(photo)
        sources = [estimated, *(altiro3d.stored_depth_or(estimated) for _ in range(3))]
        for depth in in_threads(lambda source: source.read(photo), sources):
            self.equal(depth, expected)

    def test_each_frame_goes_to_one_thread(self):
        reader = altiro3d.VideoReader(self.clip)
        found = in_threads(lambda n: [(frame.pts, frame.picture) for frame in reader], range(THREADS))
        frames = sorted(sum(found, []), key=lambda frame: frame[0])
        self.assertEqual(len(frames), 10)
        for (_, picture), expected in zip(frames, self.frames):
            self.equal(picture, expected)
        self.assertEqual(in_threads(lambda n: reader.counts().frames, range(8)), [10] * 8)

    def test_steady_depth_and_writers_take_one_call_after_the_other(self):
        source = Brightness()
        depth = altiro3d.VideoDepth(altiro3d.stored_depth_or(source).read,
                                    options=altiro3d.VideoDepthOptions(every=1))
        steps = in_threads(depth.next, moving_frames(24))
        self.assertEqual((len(steps), source.calls), (24, 24))
        options = altiro3d.VideoWriterOptions(size=(64, 48), codec=altiro3d.VideoCodec.Ffv1)
        writer = altiro3d.VideoWriter(self.folder / "out.mkv", options)

        def write(number):
            try:
                writer.write(self.frames[0], number)
                return 1
            except altiro3d.Error as error:  # a later frame was first
                self.assertIn("expected more than the last one's", str(error))
                return 0

        written = sum(in_threads(write, range(1, 33)))
        in_threads(lambda n: writer.notes(), range(8))
        writer.finish()
        self.assertEqual(len(list(altiro3d.VideoReader(self.folder / "out.mkv"))), written)

    def test_immutable_objects_give_the_same_result_in_all_threads(self):
        display = small_display()
        maker = altiro3d.NativeMaker(display)
        quilts = altiro3d.Depth2Quilt(display.quilt)
        natives = altiro3d.Quilt2Native(display.calibration, display.quilt)
        scene = altiro3d.Scene(random_photo(32, 24), numpy.full((32, 24), 0.5, numpy.float32))
        quilt = quilts.render(scene)
        eye = altiro3d.eye_at_angle(display.calibration, 3)
        altiro3d.write_image(self.folder / "quilt.png", quilt)
        file = altiro3d.PhotoFile(self.folder / "quilt.png")
        calls = [lambda: maker.make_native(scene), lambda: quilts.render(scene),
                 lambda: natives.render(quilt),
                 lambda: altiro3d.simulate_view(natives.render(quilt), display.calibration, eye),
                 lambda: altiro3d.read_image(file)]
        for call in calls:
            expected = call()
            for result in in_threads(lambda n: call(), range(8)):
                self.equal(result, expected)

    def test_options_may_change_while_they_are_used(self):
        display = small_display()

        def make(number):
            for _ in range(20):
                altiro3d.NativeLut(display.calibration, display.quilt)
                display.calibration.serial = "LKG-P" + "0" * (number * 10)
                display.calibration.subpixel_cells = [altiro3d.SubpixelCell()] * (number % 3)
                display.calibration.subpixel_cells = []

        try:
            in_threads(make, range(8))
        except altiro3d.Error as error:
            self.assertIn("subpixelCells", str(error))  # of another thread
        maker = altiro3d.NativeMaker(display)
        maker.options.views.focus = 0.25
        altiro3d.find_display_model(display.calibration).name = "other"
        self.assertEqual(maker.options.views.focus, altiro3d.ViewOptions().focus)
        self.assertNotEqual(altiro3d.find_display_model(display.calibration).name, "other")

    def test_a_program_may_end_while_its_threads_work(self):
        program = """import sys, threading, time
import altiro3d, support
display, scene = support.small_display(768, 1024), support.random_scene(1024, 768)
def work():
    while True: altiro3d.NativeMaker(display).make_native(scene)
threading.Thread(target=work, daemon=True).start()
time.sleep(.2)
"""
        run = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=60,
                             cwd=Path(__file__).parent, text=True)
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_a_call_from_within_a_call_fails_and_does_not_wait(self):
        depth = altiro3d.VideoDepth(lambda photo: depth.next(photo)[0])
        text = self.fails(altiro3d.ErrorCode.InvalidArgument, "VideoDepth",
                          lambda: depth.next(self.frames[0]))
        self.assertIn("is in use by another call", text)

        class Asks(altiro3d.DepthSource):
            def read(self, photo):
                return whole.read(photo)

        whole = altiro3d.stored_depth_or(Asks())
        self.fails(altiro3d.ErrorCode.InvalidArgument, "DepthSource",
                   lambda: whole.read(self.frames[0]))

        class Tells(Brightness):
            def read(self, photo):  # in another thread than that of run()
                converter.notes()

        conversion = altiro3d.VideoConversion(input=self.clip, output=self.folder / "out.mkv",
                                              display=small_display(), depth=Tells())
        converter = altiro3d.VideoConverter(conversion)
        self.fails(altiro3d.ErrorCode.InvalidArgument, "VideoConverter", converter.run)


class Names(Clip):
    def test_names_that_are_not_utf8_stand_in_messages(self):
        missing = os.fsdecode(os.fsencode(self.folder) + b"/caf\xe9_nope.png")
        self.fails(altiro3d.ErrorCode.NotFound, missing, lambda: altiro3d.read_photo(missing))
        self.fails(altiro3d.ErrorCode.NotFound, missing, lambda: altiro3d.VideoReader(missing))
        photo = os.fsdecode(os.fsencode(self.folder) + b"/caf\xe9.png")
        depth = os.fsdecode(os.fsencode(self.folder) + b"/caf\xe9-depth.png")
        self.assertIn("\\udce9", repr(altiro3d.PhotoFile(photo)))
        altiro3d.write_image(photo, random_photo(32, 24))
        altiro3d.write_image(depth, random_photo(32, 24)[..., 0])
        found = altiro3d.stored_depth_or(Brightness()).read_photo(photo)
        self.assertIn(depth, found.text)
        with open(os.fsencode(depth), "r+b") as stream:
            stream.truncate(60)
        notes = []
        altiro3d.stored_depth_or(Brightness()).read_photo(photo, notes=notes)
        self.assertTrue(notes[0].text.startswith(depth), notes)
        self.assertEqual(str(notes[0]), notes[0].text)

    def test_what_an_interpreter_lacks_is_told(self):
        def fails_to_import(package):
            run = subprocess.run([sys.executable, "-c", "import altiro3d"], text=True,
                                 capture_output=True, cwd=self.folder,
                                 env=dict(os.environ, PYTHONPATH=str(package)))
            self.assertEqual(run.returncode, 1)
            self.assertIn(sys.executable, run.stderr.splitlines()[-1])
            return run.stderr.splitlines()[-1]

        module = Path(altiro3d.__file__).parent
        (self.folder / "numpy.py").write_text("raise ModuleNotFoundError('No module named numpy')")
        text = fails_to_import(f"{self.folder}:{module.parent}")
        self.assertIn("ImportError: altiro3d: NumPy is not installed for ", text)
        self.assertIn("-m pip install numpy", text)
        (self.folder / "numpy.py").unlink()
        (self.folder / "altiro3d").mkdir()
        other = module / "__init__.py", self.folder / "altiro3d/__init__.py"
        other[1].write_bytes(other[0].read_bytes())
        (self.folder / "altiro3d/__init__.cpython-30-x.so").touch()
        text = fails_to_import(self.folder)
        self.assertIn("ImportError: altiro3d: is not built for ", text)
        self.assertIn("the Python of __init__.cpython-30-x.so", text)


if __name__ == "__main__":
    unittest.main()
