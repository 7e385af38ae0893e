"""Videos read and written."""
import unittest
from fractions import Fraction

import numpy

import altiro3d
from support import Clip


class Videos(Clip):
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


if __name__ == "__main__":
    unittest.main()
