"""Conversions of videos."""
import os
import signal
import threading
import time
import unittest

import numpy

import altiro3d
from support import Brightness, Clip, small_display


class Conversions(Clip):
    def conversion(self, **fields):
        return altiro3d.VideoConversion(input=self.clip, output=self.folder / "native.mkv",
                                        display=small_display(), depth=Brightness(), **fields)

    def test_a_conversion_makes_what_its_steps_make(self):
        conversion = self.conversion()
        conversion.encoding.codec = altiro3d.VideoCodec.Ffv1
        conversion.depth_options.every = 1
        conversion.recipe.refine.flaws = altiro3d.DepthFlaws()
        progress = []
        converter = altiro3d.VideoConverter(conversion)
        result = converter.run(go_on=lambda step: progress.append((step.frames, step.finishing)))
        self.assertEqual((result.frames, result.inferences, result.cancelled), (10, 10, False))
        self.assertEqual(progress[-1], (10, True))
        self.assertEqual(conversion.depth.calls, 10)
        maker = altiro3d.NativeMaker(small_display(), options=conversion.recipe)
        depth = altiro3d.VideoDepth(Brightness().read, options=conversion.depth_options)
        natives = altiro3d.VideoReader(self.folder / "native.mkv")
        for frame, native in zip(altiro3d.VideoReader(self.clip), natives):
            scene = altiro3d.Scene(frame.picture, depth.next(frame.picture)[0])
            expected = maker.make_native(scene).astype(int)
            self.assertLess(numpy.abs(native.picture - expected).max(), 4)  # FFV1 is YUV 4:4:4

    def test_a_conversion_may_be_used_twice(self):
        conversion = self.conversion()
        for _ in range(2):
            self.assertEqual(altiro3d.VideoConverter(conversion).run().frames, 10)
        self.assertIs(type(conversion.depth), Brightness)

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
        class Slow(Brightness):
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
