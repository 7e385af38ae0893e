"""Prints for sheets of lenses."""

import copy
import unittest

import altiro3d
import numpy

from support import Case, random_scene


class Prints(Case):
    def setUp(self):
        super().setUp()
        numbers = altiro3d.LensNumbers(lpi=37.5, dpi=300, width=30, height=20, thickness=0.5,
                                       index=1.5)
        self.display = altiro3d.display_of(altiro3d.calibration_of(numbers))

    def test_the_numbers_stay_in_the_file_and_in_copies(self):
        file = self.folder / "lens.json"
        file.write_text(altiro3d.calibration_text(self.display.calibration))
        for display in (altiro3d.read_display(file), copy.deepcopy(self.display)):
            facts = altiro3d.lens_facts(display.calibration)
            self.assertAlmostEqual(facts.useful_views, 8)
            self.assertAlmostEqual(facts.sharp_depth, 2 * 8 * 0.5 / 1.5)
            self.assertEqual(altiro3d.PrintSheet(display).display.panel_size(), (472, 354))

    def test_a_print_is_its_native_with_a_border(self):
        options = altiro3d.NativeOptions()
        for marks, bleed, size in ((False, 0, (354, 236)), (True, 5, (708, 661))):
            sheet = altiro3d.PrintSheet(
                self.display, options=altiro3d.PrintOptions(has_marks=marks, bleed=bleed))
            self.assertEqual(sheet.size(), size)
            scene = random_scene(60, 40)
            sheet.write(self.folder / "print.png", scene, options=options)
            native = altiro3d.NativeMaker(sheet.display, options=options).make_native(scene)
            whole = altiro3d.read_photo(self.folder / "print.png")
            x, y, width, height = sheet.picture()
            self.assertEqual((width, height), (354, 236))
            edge = (native.shape[1] - width) // 2, (native.shape[0] - height) // 2
            self.equal(whole[y:y + height, x:x + width],
                       native[edge[1]:edge[1] + height, edge[0]:edge[0] + width])

    def test_a_pitch_sheet_is_black_and_white(self):
        altiro3d.write_pitch_sheet(self.folder / "pitch.png", self.display.calibration, around=37.6)
        sheet = altiro3d.read_image(self.folder / "pitch.png")
        self.assertEqual(sheet.shape[:2], (236, 354))
        self.assertGreater(numpy.count_nonzero(sheet == 0), 0)
        with self.assertRaises(altiro3d.Error):
            altiro3d.write_pitch_sheet(self.folder / "no.png", self.display.calibration, around=151)


if __name__ == "__main__":
    unittest.main()
