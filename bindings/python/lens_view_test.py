"""What an eye sees through the lenses."""
import unittest

import numpy

import altiro3d
from support import CALIBRATION, Case, run_tool, sample_scene, small_display


class Lens(Case):
    def test_an_eye_sees_what_the_tool_shows(self):
        maker = altiro3d.NativeMaker(altiro3d.read_display(CALIBRATION))
        native = maker.make_native(sample_scene())
        altiro3d.write_image(self.folder / "native.png", native, mark=altiro3d.ImageMark.Native)
        run_tool("native2view", "-c", CALIBRATION, "--angle", 10, self.folder / "native.png",
                 self.folder / "view.png")
        calibration = altiro3d.read_display(CALIBRATION).calibration
        eye = altiro3d.eye_at_angle(calibration, 10)
        blurs = (0, altiro3d.eye_blur(calibration))
        seen = []
        for blur in blurs:
            eye.blur = blur
            seen.append(altiro3d.simulate_view(native, calibration, eye))
        tool = altiro3d.read_photo(self.folder / "view.png")
        self.assertTrue(any(numpy.array_equal(tool, picture) for picture in seen))

    def test_a_native_of_one_colour_per_view_is_seen_as_such(self):
        display = small_display()
        quilt = numpy.empty((64, 72, 3), numpy.uint8)
        for view in range(6):
            x, y, width, height = display.quilt.tile(view)
            quilt[y:y + height, x:x + width] = 40 * view
        native = altiro3d.Quilt2Native(display.calibration, display.quilt).render(quilt)
        for view in range(6):
            eye = altiro3d.eye_at_view(view, 6)
            seen = altiro3d.simulate_view(native, display.calibration, eye, out=native.copy())
            self.assertEqual(numpy.unique(seen).tolist(), [40 * view])


if __name__ == "__main__":
    unittest.main()
