"""Pictures from and to files and memory."""
import unittest

import numpy

import altiro3d
from support import PHOTO, Case, random_photo


class Images(Case):
    def test_a_file_is_written_and_read_back(self):
        photo = random_photo(11, 7)
        deep = random_photo(11, 7).astype(numpy.uint16) * 257
        grey = photo[..., 0].copy()
        for picture, name in ((photo, "a.png"), (photo, "a.tif"), (deep, "b.png"), (photo, "a.bmp")):
            altiro3d.write_image(self.folder / name, picture)
            self.equal(altiro3d.read_image(self.folder / name), picture)
        altiro3d.write_image(self.folder / "grey.png", grey)
        self.equal(altiro3d.read_photo(self.folder / "grey.png"),
                   numpy.repeat(grey[..., None], 3, axis=2))

    def test_memory_holds_the_bytes_of_the_file(self):
        photo = random_photo(11, 7)
        for name in ("a.png", "a.jpg", "a.ppm"):
            altiro3d.write_image(self.folder / name, photo)
            data = altiro3d.encode_picture(photo, name=name)
            self.assertEqual(data, (self.folder / name).read_bytes())
            self.equal(altiro3d.read_photo(altiro3d.PhotoFile(data, "memory")),
                       altiro3d.read_photo(self.folder / name))
        self.fails(altiro3d.ErrorCode.BadFormat, "cut.png",
                   lambda: altiro3d.read_photo(altiro3d.PhotoFile(data[:20], "cut.png")))
        self.fails(altiro3d.ErrorCode.Unsupported, "a.gif",
                   lambda: altiro3d.encode_picture(photo, name="a.gif"))

    def test_natives_are_marked(self):
        photo = random_photo(3, 5)
        plain = altiro3d.encode_picture(photo)
        marked = altiro3d.encode_picture(photo, mark=altiro3d.ImageMark.Native)
        self.assertFalse(altiro3d.is_marked_native(altiro3d.PhotoFile(plain, "a.png")))
        self.assertTrue(altiro3d.is_marked_native(altiro3d.PhotoFile(marked, "a.png")))

    def test_remarks_are_appended(self):
        whole = altiro3d.encode_picture(random_photo(64, 64), name="a.jpg")
        notes = ["before"]
        altiro3d.read_photo(altiro3d.PhotoFile(whole[:-700], "cut.jpg"), notes=notes)
        self.assertEqual(notes[1].code, altiro3d.NoteCode.CutOff)
        self.assertEqual(str(notes[1]), notes[1].text)

    def test_depth_images_keep_their_numbers(self):
        depth = numpy.arange(12, dtype=numpy.uint16).reshape(3, 4) * 5000
        altiro3d.write_image(self.folder / "d.png", depth)
        self.equal(altiro3d.read_depth_image(self.folder / "d.png"), depth.astype(numpy.float32))

    def test_a_photo_holds_its_depth(self):
        photo = random_photo(60, 80)
        depth = numpy.tile(numpy.linspace(0, 1, 80, dtype=numpy.float32), (60, 1))
        file = self.folder / "both.jpg"
        altiro3d.write_photo_with_depth(file, photo, depth)
        found = altiro3d.read_embedded_depth(file)
        self.assertLess(numpy.abs(found - depth).max(), 0.03)  # JPEG, percentiles
        self.assertIsNone(altiro3d.read_embedded_depth(PHOTO))

    def test_files_are_listed_in_natural_order(self):
        for name in ("view10.png", "view9.png", "notes.txt"):
            (self.folder / name).touch()
        self.assertEqual(altiro3d.list_images(self.folder),
                         [self.folder / "view9.png", self.folder / "view10.png"])


if __name__ == "__main__":
    unittest.main()
