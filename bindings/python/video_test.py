"""Videos: frames, depth, conversions."""
import os
import signal
import threading
import time
import unittest
from fractions import Fraction

import numpy

import altiro3d
from support import Case, random_photo, small_display


def moving_frames(count, rows=48, columns=64):
    """Frames of a picture that moves by a px each."""
    wide = numpy.repeat(numpy.repeat(random_photo(rows // 8, 30), 8, axis=0), 8, axis=1)
    return [wide[:, n:n + columns].copy() for n in range(count)]


class Depth(altiro3d.DepthSource):
    """The brightness, as far as the count goes."""

    calls = 0

    def read(self, photo):
        self.calls += 1
        return photo.mean(axis=2, dtype=numpy.float32)


class Videos(Case):
    def setUp(self):
        super().setUp()
        self.clip = self.folder / "clip.mkv"
        self.frames = moving_frames(10)
        options = altiro3d.VideoWriterOptions(size=(64, 48), codec=altiro3d.VideoCodec.Ffv1,
                                              time_base=Fraction(1, 25), frame_rate=25)
        with altiro3d.VideoWriter(self.clip, options) as writer:
            for number, frame in enumerate(self.frames):
                writer.write(frame, number)

    def conversion(self, **fields):
        return altiro3d.VideoConversion(input=self.clip, output=self.folder / "native.mkv",
                                        display=small_display(), depth=Depth(), **fields)

    def test_frames_come_back_as_they_were_written(self):
        reader = altiro3d.VideoReader(self.clip)
        self.assertEqual((reader.facts().size, reader.facts().average_rate), ((64, 48), Fraction(25)))
        frames = list(reader)
        self.assertEqual(len(frames), 10)
        for number, frame in enumerate(frames):
            self.assertLess(numpy.abs(frame.picture.astype(int) - self.frames[number]).max(), 4)  # YUV
            self.assertAlmostEqual(frame.seconds, number / 25)
        blue_first = next(altiro3d.VideoReader(self.clip, order="bgr"))
        self.equal(blue_first.picture, frames[0].picture[..., ::-1])
        part = altiro3d.VideoReaderOptions(from_=0.2, to=0.3)
        self.assertEqual(len(list(altiro3d.VideoReader(self.clip, options=part))), 3)
        self.assertEqual(reader.counts().frames, 10)

    def test_a_file_appears_only_when_it_is_finished(self):
        options = altiro3d.VideoWriterOptions(size=(64, 48))
        with self.assertRaisesRegex(RuntimeError, "mine"):
            with altiro3d.VideoWriter(self.folder / "no.mkv", options) as writer:
                writer.write(self.frames[0], 0)
                raise RuntimeError("mine")
        del writer
        self.assertFalse((self.folder / "no.mkv").exists())
        self.fails(altiro3d.ErrorCode.Unsupported, str(self.folder / "a.avi"),
                   lambda: altiro3d.VideoWriter(self.folder / "a.avi", options))

    def test_depth_is_estimated_when_it_is_needed(self):
        source = Depth()
        depth = altiro3d.VideoDepth(source.read, options=altiro3d.VideoDepthOptions(every=4))
        steps = [depth.next(frame) for frame in self.frames]
        self.assertEqual([step.inferred for _, step in steps], [n % 4 == 0 for n in range(10)])
        self.assertEqual(source.calls, 3)
        self.equal(steps[0][0], altiro3d.normalize_depth(source.read(self.frames[0])))

        def broken(photo):
            raise ZeroDivisionError("mine")

        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            altiro3d.VideoDepth(broken).next(self.frames[0])

    def test_a_conversion_makes_what_its_steps_make(self):
        conversion = self.conversion()
        conversion.encoding.codec = altiro3d.VideoCodec.Ffv1
        conversion.depth_options.every = 1
        conversion.native.refine.flaws = altiro3d.DepthFlaws()
        progress = []
        converter = altiro3d.VideoConverter(conversion)
        result = converter.run(go_on=lambda step: progress.append((step.frames, step.finishing)))
        self.assertEqual((result.frames, result.inferences, result.cancelled), (10, 10, False))
        self.assertEqual(progress[-1], (10, True))
        self.assertEqual(conversion.depth.calls, 10)
        maker = altiro3d.NativeMaker(small_display(), options=conversion.native)
        depth = altiro3d.VideoDepth(Depth().read, options=conversion.depth_options)
        natives = altiro3d.VideoReader(self.folder / "native.mkv")
        for frame, native in zip(altiro3d.VideoReader(self.clip), natives):
            scene = altiro3d.Scene(frame.picture, depth.next(frame.picture)[0])
            expected = maker.make_native(scene).astype(int)
            self.assertLess(numpy.abs(native.picture - expected).max(), 4)  # FFV1 is YUV 4:4:4

    def test_a_conversion_may_be_used_twice(self):
        conversion = self.conversion()
        for _ in range(2):
            self.assertEqual(altiro3d.VideoConverter(conversion).run().frames, 10)
        self.assertIs(type(conversion.depth), Depth)

    def test_a_callback_stops_a_run(self):
        result = altiro3d.VideoConverter(self.conversion()).run(go_on=lambda step: step.frames < 2)
        self.assertTrue(result.cancelled)

    def test_exceptions_in_callbacks_arrive(self):
        def broken(step):
            raise KeyError("mine")

        with self.assertRaisesRegex(KeyError, "mine"):
            altiro3d.VideoConverter(self.conversion()).run(go_on=broken)

        class Broken(altiro3d.DepthSource):
            def read(self, photo):
                raise OSError("no network")

        conversion = self.conversion(unfinished=altiro3d.UnfinishedRun.Discard)
        conversion.depth = Broken()
        with self.assertRaisesRegex(OSError, "no network"):
            altiro3d.VideoConverter(conversion).run()
        self.fails(altiro3d.ErrorCode.NotFound, "no.mp4", lambda: altiro3d.VideoConverter(
            altiro3d.VideoConversion(input="no.mp4", output="a.mkv", display=small_display())))

    def test_ctrl_c_stops_a_run(self):
        class Slow(Depth):
            def read(self, photo):
                time.sleep(0.1)
                return super().read(photo)

        conversion = self.conversion()
        conversion.depth = Slow()
        conversion.depth_options.every = 1
        started = threading.Event()
        threading.Thread(target=lambda: started.wait() and os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            altiro3d.VideoConverter(conversion).run(go_on=lambda step: started.set())


if __name__ == "__main__":
    unittest.main()
