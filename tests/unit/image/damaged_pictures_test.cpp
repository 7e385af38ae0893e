// Pictures whose decoders fill in what is lost.

#include "altiro3D/image_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"
#include "support/random_pictures.hpp"

#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

class DamagedPictures : public FileTest {
  protected:
    Notes notesOf(const std::string& name, const std::string& bytes) {
        spill(directory / name, bytes);
        Notes notes;
        picture_ = readPhoto(directory / name, &notes);
        return notes;
    }
    cv::Mat picture_;
};

// A fifth of the bytes, in the middle.
std::string withHole(std::string bytes) {
    const std::size_t size = bytes.size() / 5;
    return bytes.replace(2 * size, size, std::string(size, '\0'));
}

TEST_F(DamagedPictures, AHoleInAFileIsReported) {
    const cv::Mat noise = randomPicture({320, 240}, CV_8UC3, 4);
    for (const char* const extension : {".jpg", ".webp", ".jp2"}) {
        if (!cv::haveImageWriter(extension)) continue;
        const std::string whole = encoded(extension, noise);
        const std::string name = std::string("a") + extension;
        EXPECT_TRUE(notesOf(name, whole).empty()) << extension;
        const Note note = only(notesOf(name, withHole(whole)));
        EXPECT_EQ(note.code, NoteCode::Repaired) << extension;
        EXPECT_TRUE(holds(note.text, "the file is damaged (")) << extension;
        EXPECT_TRUE(holds(note.text, "): a part of the picture ")) << extension;
        EXPECT_EQ(picture_.size(), noise.size());
    }
    for (const char* const extension : {".png", ".tif", ".exr"}) { // have checksums or lengths
        if (!cv::haveImageWriter(extension)) continue;
        cv::Mat picture = noise;
        if (std::string(extension) == ".exr") noise.convertTo(picture, CV_32F, 1 / 255.0);
        const std::string name = std::string("a") + extension;
        EXPECT_TRUE(
            holds(errorOf([&] { notesOf(name, withHole(encoded(extension, picture))); }), name))
            << extension;
    }
}

TEST_F(DamagedPictures, ChangedBytesOfAJpegAreReported) {
    const std::string whole = encoded(".jpg", randomPicture({320, 240}, CV_8UC3, 4));
    int reported = 0;
    for (int i = 0; i < 20; ++i) {
        std::string bytes = whole;
        bytes.replace(bytes.size() / 4 + 1000 * static_cast<std::size_t>(i), 3, "\x12\x34\x56");
        if (!notesOf("a.jpg", bytes).empty()) ++reported;
    }
    EXPECT_GE(reported, 14); // Huffman codes can be wrong without a trace
}

TEST_F(DamagedPictures, PaddingOfCamerasIsNotDamage) {
    const std::string whole = encoded(".jpg", randomPicture({64, 48}, CV_8UC3, 4));
    const std::size_t end = whole.size() - 2;
    const auto with = [&](std::size_t at, const std::string& bytes) {
        return std::string(whole).insert(at, bytes);
    };
    const cv::Mat picture = decoded(whole);
    for (const std::string& padded :
         {with(end, "\1\2\3"), with(end, std::string(1000, '\0')), whole + "trailing garbage",
          with(end, std::string(9, '\xff')), with(20, "junk before a segment")}) {
        EXPECT_EQ(textOf(notesOf("a.jpg", padded)), "");
        EXPECT_TRUE(samePicture(picture_, picture));
    }
    EXPECT_TRUE(
        holds(only(notesOf("a.jpg", with(end, "what is left of lines that were lost"))).text,
              "extraneous bytes"));
}

} // namespace
} // namespace altiro3D::test
