"""Calibrations, displays, layouts of quilts."""
import json
import pathlib
import unittest

import altiro3d
from support import CALIBRATION, Case


class Displays(Case):
    def test_a_display_has_the_values_of_its_file(self):
        file = json.loads(CALIBRATION.read_text())
        value = {name: entry["value"] if isinstance(entry, dict) else entry
                 for name, entry in file.items()}
        display = altiro3d.read_display(str(CALIBRATION))
        calibration = display.calibration
        self.assertEqual(calibration.pitch, value["pitch"])
        self.assertEqual(calibration.slope, value["slope"])
        self.assertEqual(calibration.center, value["center"])
        self.assertEqual(calibration.dpi, value["DPI"])
        self.assertEqual(display.panel_size(), (value["screenW"], value["screenH"]))
        self.assertEqual(display.aspect(), value["screenW"] / value["screenH"])
        self.assertEqual(altiro3d.find_display_model(calibration).name, "Looking Glass Portrait")

    def test_paths_are_text_or_path_like(self):
        for path in (CALIBRATION, str(CALIBRATION), bytes(CALIBRATION)):
            self.assertEqual(len(altiro3d.read_calibrations(path)), 1)
        with self.assertRaises(TypeError):
            altiro3d.read_calibrations(7)

    def test_a_calibration_may_be_changed_and_is_checked(self):
        calibration = altiro3d.read_display(CALIBRATION).calibration
        before = altiro3d.fingerprint(calibration)
        calibration.slope += 0.01
        self.assertNotEqual(altiro3d.fingerprint(calibration), before)
        calibration.screen_w = 3
        text = self.fails(altiro3d.ErrorCode.BadFormat, "calibration", calibration.validate)
        self.assertIn("screenW", text)
        self.fails(altiro3d.ErrorCode.BadFormat, "mine",
                   lambda: altiro3d.parse_calibrations("{}", "mine"))
        self.fails(altiro3d.ErrorCode.NotFound, "no.json", lambda: altiro3d.read_display("no.json"))

    def test_cells_are_lists_of_values(self):
        cell = altiro3d.SubpixelCell(x=[-0.3, 0, 0.3], y=(0, 0.1, 0))
        calibration = altiro3d.Calibration(subpixel_cells=[cell])
        self.assertEqual(calibration.subpixel_cells[0].x, [-0.3, 0, 0.3])

    def test_a_mounted_volume_is_found(self):
        volume = self.folder / "media/me/LKG-P1/LKG_calibration"
        volume.mkdir(parents=True)
        (volume / "visual.json").write_bytes(CALIBRATION.read_bytes())
        found = altiro3d.find_mounted_calibrations(self.folder)
        self.assertEqual([(one.file, one.volume) for one in found],
                         [(volume / "visual.json", "LKG-P1")])
        self.assertIsInstance(found[0].file, pathlib.Path)


class Layouts(Case):
    layout = altiro3d.QuiltLayout(columns=3, rows=2, tile_size=(10, 20), view_count=5)

    def test_view_zero_is_the_bottom_left_tile(self):
        self.assertEqual(self.layout.size(), (30, 40))
        self.assertEqual([self.layout.tile(view) for view in range(5)],
                         [(0, 20, 10, 20), (10, 20, 10, 20), (20, 20, 10, 20), (0, 0, 10, 20),
                          (10, 0, 10, 20)])
        self.assertEqual([altiro3d.view_position(view, 5) for view in range(5)],
                         [-1, -0.5, 0, 0.5, 1])

    def test_what_is_wrong_is_refused(self):
        code = altiro3d.ErrorCode.InvalidArgument
        self.fails(code, "view", lambda: self.layout.tile(6))
        self.fails(code, "view", lambda: self.layout.tile(-1))
        with self.assertRaises(altiro3d.Error):
            altiro3d.QuiltLayout(columns=0).validate()

    def test_names_of_quilts(self):
        name = altiro3d.quilt_file_name("a/photo.png", self.layout, 0.75)
        self.assertEqual(name, pathlib.Path("a/photo_qs3x2a0.75.png"))
        parsed = altiro3d.parse_quilt_name(name)
        self.assertEqual(parsed.grid, altiro3d.QuiltGrid(columns=3, rows=2))
        self.assertEqual(parsed.aspect, 0.75)
        self.assertIsNone(altiro3d.parse_quilt_name("photo.png"))


if __name__ == "__main__":
    unittest.main()
