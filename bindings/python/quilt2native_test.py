"""Quilts: their layouts and their size."""
import unittest

import numpy

import altiro3d
from support import PHOTO, Case, random_photo, small_display


class Quilts(Case):
    def test_a_layout_is_found(self):
        layout = altiro3d.QuiltLayout(columns=4, rows=5, tile_size=(120, 160), view_count=20)
        photo = altiro3d.read_photo(PHOTO)[::4, ::4]
        quilt = numpy.empty((800, 480, 3), numpy.uint8)
        for view in range(20):
            x, y, width, height = layout.tile(view)
            quilt[y:y + height, x:x + width] = photo[60:220, 40 + 2 * view:160 + 2 * view]
        found = altiro3d.find_quilt_layout(quilt)
        self.assertEqual((found.verdict, found.layout.columns, found.layout.rows),
                         (altiro3d.QuiltVerdict.Quilt, 4, 5))
        self.assertEqual(altiro3d.check_quilt_layout(quilt, layout), [])
        note, = altiro3d.check_quilt_layout(quilt[::-1], layout)
        self.assertEqual(note.code, altiro3d.NoteCode.Doubtful)

    def test_quilts_are_cropped_and_fitted_to_whole_pixels(self):
        layout = altiro3d.QuiltLayout(columns=3, rows=2, tile_size=(24, 32), view_count=6)
        quilt = random_photo(65, 74)
        self.equal(altiro3d.crop_quilt(quilt, layout), quilt[1:, :72])
        self.assertEqual(altiro3d.fit_quilt(quilt, layout).shape, (64, 72, 3))
        shape = altiro3d.QuiltShape("a_qs3x2a0.5.png", layout, small_display())
        self.assertEqual((shape.fit(), shape.aspect()), (altiro3d.FitMode.Contain, 0.5))
        self.assertEqual(shape.apply(quilt).shape, (64, 72, 3))


if __name__ == "__main__":
    unittest.main()
