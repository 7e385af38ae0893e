"""Scenes on a display."""
import unittest

import altiro3d
from support import CALIBRATION, Case, sample_scene


class Placements(Case):
    def test_settings_follow_from_the_scene(self):
        display = altiro3d.read_display(CALIBRATION)
        options = altiro3d.NativeOptions()
        chosen = altiro3d.choose_from_scene(sample_scene(), display.aspect(), display.quilt, options,
                                            altiro3d.AutoChoices(focus=True))
        self.assertNotEqual(chosen.views.focus, options.views.focus)
        self.assertEqual(chosen.framing, options.framing)


if __name__ == "__main__":
    unittest.main()
