#include "altiro3D/native_lut.hpp"

#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"

#include <cstring>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

Calibration panel() {
    Calibration c = stripePanel(31, 23);
    c.serial = "LKG-PORT-00001";
    return c;
}

std::uint32_t u32(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) {
        value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    }
    return value;
}

// Bitwise CRC-32 as in PNG and zip, written from its definition.
std::uint32_t slowCrc(const std::string& bytes) {
    std::uint32_t crc = 0xffffffffU;
    for (char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320U : 0U);
    }
    return ~crc;
}

class NativeLutFile : public FileTest {
  protected:
    NativeLutFile() {
        lut.save(file);
        bytes = slurp(file);
    }

    // Error of loading other bytes.
    std::string errorWith(const std::string& contents) {
        spill(file, contents);
        return errorOf([&] { NativeLut::load(file); });
    }

    // Header with a field changed and its checksum made right again: a hostile file.
    std::string forged(std::size_t at, std::uint32_t value) const {
        std::string contents = bytes;
        std::memcpy(&contents[at], &value, 4);
        const std::uint32_t crc = slowCrc(contents.substr(0, 124));
        std::memcpy(&contents[124], &crc, 4);
        return contents;
    }

    std::filesystem::path file = directory / "a.map";
    NativeLut lut{panel(), {8, 6, {42, 56}, 47}};
    std::string bytes;
};

TEST_F(NativeLutFile, HasThePublishedLayout) {
    EXPECT_EQ(bytes.substr(0, 8), "ALTIRO3D");
    const std::uint32_t kExpected[] = {1, 128, 31, 23, 8 * 42, 6 * 56, 8, 6, 47};
    for (std::size_t i = 0; i < 9; ++i)
        EXPECT_EQ(u32(bytes, 8 + 4 * i), kExpected[i]) << i;
    ASSERT_EQ(bytes.size(), 128U + 12 * 31 * 23);
    EXPECT_EQ(bytes.substr(64, 15), std::string("LKG-PORT-00001") + '\0');
    EXPECT_EQ(u32(bytes, 120), slowCrc(bytes.substr(128)));
    EXPECT_EQ(u32(bytes, 124), slowCrc(bytes.substr(0, 124)));
    // R, G, B, each rows x columns x (X, Y)
    const std::size_t green = 128 + 4 * 31 * 23 + 4 * (7 * 31 + 5);
    const auto at = lut.channel(1).at<cv::Vec<std::uint16_t, 2>>(7, 5);
    EXPECT_EQ(u32(bytes, green), at[0] | static_cast<std::uint32_t>(at[1]) << 16);
}

TEST_F(NativeLutFile, ComesBackAsItWas) {
    const NativeLut loaded = NativeLut::load(file);
    EXPECT_EQ(loaded.quilt(), lut.quilt());
    EXPECT_EQ(loaded.panelSize(), lut.panelSize());
    EXPECT_EQ(loaded.serial(), "LKG-PORT-00001");
    EXPECT_EQ(loaded.calibrationFingerprint(), fingerprint(panel()));
    EXPECT_TRUE(loaded.inverted());
    for (int k = 0; k < 3; ++k)
        EXPECT_TRUE(samePicture(loaded.channel(k), lut.channel(k)));
}

TEST_F(NativeLutFile, AnyChangedByteIsNoticed) {
    for (std::size_t at = 0; at < bytes.size(); at += at < 128 ? 1 : 97) {
        std::string broken = bytes;
        broken[at] = static_cast<char>(broken[at] ^ 0x10);
        EXPECT_NE(errorWith(broken), "(no error)") << "byte " << at;
    }
}

TEST_F(NativeLutFile, TruncatedForeignAndOversizeFilesAreRefusedWithASentence) {
    EXPECT_TRUE(holds(errorWith(""), "is not a look-up table"));
    EXPECT_TRUE(holds(errorWith("hello, this is some text"), "is not a look-up table"));
    EXPECT_NE(errorWith(bytes.substr(0, 60)), "(no error)");
    EXPECT_TRUE(
        holds(errorWith(bytes.substr(0, 1000)), "is cut off: it has 1000 bytes, expected 8684"));
    EXPECT_TRUE(holds(errorWith(bytes + "x"), "is too long"));
    EXPECT_TRUE(holds(errorOf([&] { NativeLut::load(directory / "none.map"); }), "does not exist"));
    EXPECT_TRUE(
        holds(errorOf([&] { NativeLut::load(directory.path()); }), "is not a regular file"));
}

TEST_F(NativeLutFile, ForgedHeadersAreRefusedBeforeAllocation) {
    EXPECT_TRUE(holds(errorWith(forged(8, 2)), "format version 2"));
    EXPECT_TRUE(holds(errorWith(forged(16, 4000000000U)), "names a panel"));
    EXPECT_TRUE(holds(errorWith(forged(16, 16384)), "is cut off"));
    EXPECT_TRUE(holds(errorWith(forged(32, 0)), "names a quilt"));
    EXPECT_TRUE(holds(errorWith(forged(24, 70000)), "names a quilt"));
    EXPECT_TRUE(holds(errorWith(forged(40, 49)), "names a quilt"));
    EXPECT_TRUE(holds(errorWith(forged(44, 1)), "view filter 1"));
}

TEST_F(NativeLutFile, CoordinatesOutsideTheQuiltAreRefused) {
    std::string broken = bytes;
    broken[129] = '\xff'; // X of the first red sub-pixel
    const std::uint32_t crc = slowCrc(broken.substr(128));
    std::memcpy(&broken[120], &crc, 4);
    const std::uint32_t headerCrc = slowCrc(broken.substr(0, 124));
    std::memcpy(&broken[124], &headerCrc, 4);
    EXPECT_EQ(errorWith(broken), file.string() +
                                     ": is corrupt: it names px outside of its quilt, expected px "
                                     "of 336 x 336");
    broken[129] = '\0'; // only the checksum is wrong
    EXPECT_TRUE(holds(errorWith(broken),
                      "its checksum does not match, expected a table that is built anew"));
}

TEST_F(NativeLutFile, AnExistingMapSurvivesAFailedSave) {
    EXPECT_NE(errorOf([&] { lut.save(directory / "missing" / "b.map"); }), "(no error)");
    EXPECT_EQ(slurp(file), bytes);
}

TEST_F(NativeLutFile, AnotherDisplaysCalibrationIsNamed) {
    EXPECT_EQ(errorOf([&] { requireSameDisplay(lut, "a.map", panel(), "visual.json"); }),
              "(no error)");
    Calibration other = panel();
    other.serial = "LKG-PORT-00002";
    other.center = 0.1;
    const std::string error =
        errorOf([&] { requireSameDisplay(lut, "a.map", other, "visual.json"); });
    for (const char* part : {"a.map: ", "LKG-PORT-00001", "visual.json", "LKG-PORT-00002"}) {
        EXPECT_TRUE(holds(error, part));
    }
}

} // namespace
} // namespace altiro3D::test
