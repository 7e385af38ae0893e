"""Steady depth of videos."""
import unittest

import altiro3d
from support import Brightness, Clip


class Depths(Clip):
    def test_depth_is_estimated_when_it_is_needed(self):
        source = Brightness()
        depth = altiro3d.VideoDepth(source.read, options=altiro3d.VideoDepthOptions(every=4))
        steps = [depth.next(frame) for frame in self.frames]
        self.assertEqual([step.inferred for _, step in steps], [n % 4 == 0 for n in range(10)])
        self.assertEqual(source.calls, 3)
        self.equal(steps[0][0], altiro3d.normalize_depth(source.read(self.frames[0])))

        def broken(photo):
            raise ZeroDivisionError("mine")

        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            altiro3d.VideoDepth(broken).next(self.frames[0])


if __name__ == "__main__":
    unittest.main()
