#include "altiro3D/file_io.hpp"
#include "altiro3D/splats.hpp"

#include "support/files.hpp"
#include "support/splat_reference.hpp"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace {

constexpr double kDc = 0.28209479177387814;
constexpr const char* kFields[] = {"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                   "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                   "rot_0",  "rot_1",   "rot_2",   "rot_3"};
using Row = std::vector<double>;
const Row kRow = {1, 2, 3, 0.5, -0.5, 0, 0, -1, -2, -3, 2, 0, 0, 0};

std::string header(const std::string& format, std::size_t count, const std::string& properties = "",
                   const std::string& others = "") {
    std::string text = "ply\r\nformat " + format +
                       " 1.0\r\ncomment made by hand\r\nelement vertex " + std::to_string(count) +
                       "\r\n" + properties;
    if (properties.empty())
        for (const char* const field : kFields)
            text += "property float " + std::string(field) + "\n";
    return text + others + "end_header\n";
}

std::string bytesOf(const Row& row, bool isSwapped = false) {
    std::string bytes;
    for (const double value : row) {
        const auto number = static_cast<float>(value);
        char raw[4];
        std::memcpy(raw, &number, 4);
        if (isSwapped) std::reverse(raw, raw + 4);
        bytes.append(raw, 4);
    }
    return bytes;
}

std::string plyOf(const std::vector<Row>& rows) {
    std::string text = header("binary_little_endian", rows.size());
    for (const Row& row : rows)
        text += bytesOf(row);
    return text;
}

void expectRow(const Splat& splat) {
    EXPECT_EQ(splat.centre, cv::Vec3f(1, 2, 3));
    EXPECT_NEAR(static_cast<double>(splat.colour[0]), 0.5 + kDc * 0.5, 1e-6);
    EXPECT_NEAR(static_cast<double>(splat.colour[1]), 0.5 - kDc * 0.5, 1e-6);
    EXPECT_NEAR(static_cast<double>(splat.opacity), 0.5, 1e-6);
    EXPECT_NEAR(static_cast<double>(splat.radii[2]), std::exp(-3), 1e-6);
    EXPECT_EQ(splat.rotation, cv::Vec4f(1, 0, 0, 0)); // made a unit one
}

std::string refusal(const std::string& bytes, const char* name = "a.ply") {
    return errorOf([&] { (void)parseSplats(bytes, name); });
}

// The largest differences of two scenes of the same splats.
void expectAlike(const SplatScene& a, const SplatScene& b, double place, double radius,
                 double rest) {
    ASSERT_EQ(a.splats.size(), b.splats.size());
    ASSERT_EQ(a.degree, b.degree);
    for (std::size_t i = 0; i < a.splats.size(); ++i) {
        const Splat& p = a.splats[i];
        const Splat& q = b.splats[i];
        EXPECT_LE(cv::norm(p.centre, q.centre, cv::NORM_INF), place) << i;
        for (int k = 0; k < 3; ++k) { // the ranges of .spz
            const auto logOf = [k](const Splat& s) {
                return std::max(std::log(s.radii[k]), -10.0F);
            };
            const auto colourOf = [k](const Splat& s) {
                return std::clamp(s.colour[k], -0.44F, 1.44F);
            };
            EXPECT_NEAR(logOf(p), logOf(q), radius) << i;
            EXPECT_NEAR(colourOf(p), colourOf(q), rest) << i;
        }
        EXPECT_NEAR(static_cast<double>(p.opacity), static_cast<double>(q.opacity), 0.003) << i;
        EXPECT_GE(std::abs(p.rotation.dot(q.rotation)), 0.995F) << i; // 8 bits in .spz 2
    }
}

} // namespace

TEST(SplatFile, PlyIsReadInAllItsForms) {
    expectRow(parseSplats(plyOf({kRow}), "a.ply").splats.at(0));
    expectRow(
        parseSplats(header("binary_big_endian", 1) + bytesOf(kRow, true), "a.ply").splats.at(0));
    std::string text = header("ascii", 1);
    for (const double value : kRow)
        text += std::to_string(value) + " ";
    expectRow(parseSplats(text + "\n", "a.ply").splats.at(0));
    // any order and type, further fields and elements before and after
    std::string properties = "property double rot_0\nproperty uchar label\n";
    std::string bytes;
    const double two = 2;
    bytes.append(reinterpret_cast<const char*>(&two), 8).append(1, '\7');
    for (std::size_t i = 14; i-- > 0;) {
        if (i == 10) continue;
        properties += "property float " + std::string(kFields[i]) + "\n";
        bytes += bytesOf({kRow[i]});
    }
    const std::string before =
        "ply\nformat binary_little_endian 1.0\nelement note 1\nproperty list "
        "uchar int codes\nelement vertex 1\n";
    expectRow(parseSplats(before + properties + "element last 2\nproperty float v\nend_header\n" +
                              std::string("\1\0\0\0\0", 5) + bytes + "12345678",
                          "a.ply")
                  .splats.at(0));
}

TEST(SplatFile, HarmonicsOfPlyHaveAllOfRedFirst) {
    std::string further;
    Row row = kRow;
    for (int i = 0; i < 9; ++i) {
        further += "property float f_rest_" + std::to_string(i) + "\n";
        row.push_back(i);
    }
    const SplatScene scene =
        parseSplats(header("binary_little_endian", 1, "", further) + bytesOf(row), "a.ply");
    EXPECT_EQ(scene.degree, 1);
    EXPECT_EQ(scene.harmonics, std::vector<float>({0, 3, 6, 1, 4, 7, 2, 5, 8}));
}

TEST(SplatFile, SplatsThatMakeNoSenseAreLeftOutAndCounted) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::vector<Row> rows(9, kRow);
    rows[1][0] = kNan;
    rows[2][6] = kNan;
    rows[3][7] = 50; // a radius of 5e21
    rows[4][10] = 0; // no rotation
    rows[5][3] = kInfinity;
    rows[6][6] = kInfinity;  // valid: opaque
    rows[7][7] = -kInfinity; // valid: flat
    Notes notes;
    const SplatScene scene = parseSplats(plyOf(rows), "a.ply", SplatAxes::Auto, &notes);
    EXPECT_EQ(scene.splats.size(), 4U);
    EXPECT_EQ(scene.splats[1].opacity, 1);
    EXPECT_EQ(scene.splats[2].radii[0], 0);
    EXPECT_TRUE(holds(textOf(notes), "5 of 9 splats are left out, as their numbers make no sense"));
    EXPECT_TRUE(holds(refusal(plyOf({rows[1]})), "has no splat whose numbers make sense"));
}

TEST(SplatFile, WhatIsNoSceneOfSplatsOrEndsEarlyIsRefused) {
    const std::string points = "property float x\nproperty float y\nproperty float z\n";
    const std::string face = "element face 1\nproperty list uchar int v\n";
    const std::string numbers = "1 2 3 4 5 6 7 8 9 10 11 12 13 ";
    const std::string whole = plyOf({kRow, kRow, kRow});
    const std::string binary = "binary_little_endian";
    const std::tuple<std::string, const char*, const char*> kRefused[] = {
        {header("ascii", 3, points, face) + "0 0 0 1 0 0 0 1 0 3 0 1 2", "a.ply",
         "is a mesh, expected Gaussian splats"},
        {header("ascii", 1, points) + "1 2 3", "a.ply", "is a cloud of points"},
        {"PK\3\4", "a.sog", "format SOG, expected .ply, .splat or .spz"},
        {"x", "a.ksplat", "format ksplat"},
        {"glTF", "a.glb", "is a mesh"},
        {"", "a.ply", "is empty"},
        {"hello", "a.ply", "is not a scene of splats"},
        {"ply\nformat ascii 1.0\nend_header\n", "a.ply", "has no vertices"},
        {"ply\nfor", "a.ply", "has no end of its header"},
        {"ply\nformat vax 1.0\nend_header\n", "a.ply", "has no known format line"},
        {header("ascii", 1) + numbers + "three", "a.ply", "has \"three\" among its numbers"},
        {header("ascii", 0), "a.ply", "has no splats"},
        {"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "a.ply", "\"-1\""},
        {whole.substr(0, whole.size() - 1), "a.ply", "ends after 2 of 3 splats"},
        // before memory is taken
        {header(binary, 60'000'000) + bytesOf(kRow), "a.ply", "ends after 1 of 60000000"},
        {header(binary, 18'446'744'073'709'551'615U), "a.ply", "expected at most"},
        {header("ascii", 2) + numbers + "14 " + numbers, "a.ply", "ends after 1 of 2 splats"},
        {std::string(33, '\1'), "a.splat", "ends within splat 2"}};
    for (const auto& [bytes, name, sentence] : kRefused)
        EXPECT_TRUE(holds(refusal(bytes, name), sentence));
}

TEST(SplatFile, TheCameraOfSharpIsRead) {
    const std::string others =
        "element extrinsic 16\nproperty float extrinsic\nelement intrinsic 9\nproperty float "
        "intrinsic\n"
        "element image_size 2\nproperty uint image_size\nelement frame 2\nproperty int frame\n"
        "element disparity 2\nproperty float disparity\n";
    const std::uint32_t sizes[] = {640, 480, 1, 1};
    const std::string bytes = header("binary_little_endian", 1, "", others) + bytesOf(kRow) +
                              bytesOf({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}) +
                              bytesOf({500, 0, 320, 0, 510, 240, 0, 0, 1}) +
                              std::string(reinterpret_cast<const char*>(sizes), 16) +
                              bytesOf({0.1, 0.4});
    const SplatScene scene = parseSplats(bytes, "a.ply");
    ASSERT_TRUE(scene.camera);
    EXPECT_EQ(scene.camera->size, cv::Size(640, 480));
    EXPECT_NEAR(scene.camera->intrinsics.fy, 510, 1e-3);
    EXPECT_NEAR(scene.camera->intrinsics.cx, 319.5, 1e-3); // (0, 0) is the centre of a px
    EXPECT_NEAR(scene.focusDistance, 4, 1e-5);
    // our own files have it as well
    const TemporaryDirectory directory;
    writeSplats(directory / "b.ply", scene);
    const SplatScene back = readSplats(directory / "b.ply");
    ASSERT_TRUE(back.camera);
    EXPECT_NEAR(back.camera->intrinsics.cx, 319.5, 1e-3);
    EXPECT_NEAR(back.focusDistance, 4, 1e-5);
    expectAlike(back, scene, 1e-6, 1e-6, 1e-6);
}

TEST(SplatFile, TheMiddleOneOfTheCamerasBesideAFileIsTaken) {
    const TemporaryDirectory directory;
    writeFile(directory / "a.ply", plyOf({kRow}));
    const auto camera = [](int id) {
        return R"({"id":)" + std::to_string(id) + R"(,"width":800,"height":600,"position":[1,2,)" +
               std::to_string(id) + R"(],"rotation":[[0,0,1],[0,1,0],[-1,0,0]],"fx":700,"fy":710})";
    };
    writeFile(directory / "cameras.json",
              "[" + camera(0) + "," + camera(1) + "," + camera(2) + "]");
    const SplatScene scene = readSplats(directory / "a.ply");
    ASSERT_TRUE(scene.camera);
    EXPECT_EQ(scene.camera->eye, cv::Vec3d(1, 2, 1));
    EXPECT_EQ(scene.camera->axes.row(2), cv::Matx13d(1, 0, 0)); // the third column of the file
    // where the training puts it
    std::filesystem::create_directories(directory / "out/point_cloud/iteration_7000");
    writeFile(directory / "out/point_cloud/iteration_7000/point_cloud.ply", plyOf({kRow}));
    writeFile(directory / "out/cameras.json", "[" + camera(5) + "]");
    EXPECT_TRUE(readSplats(directory / "out/point_cloud/iteration_7000/point_cloud.ply").camera);
    writeFile(directory / "cameras.json", "[{}]");
    Notes notes;
    EXPECT_FALSE(readSplats(directory / "a.ply", SplatAxes::Auto, &notes).camera);
    EXPECT_TRUE(holds(textOf(notes), "cameras.json beside it is not used"));
}

TEST(SplatFile, SpzIsWrittenAndReadWithinItsSteps) {
    SplatScene scene = randomSplats(500, 3);
    for (Splat& splat : scene.splats)
        splat.centre *= 18; // to some 90
    for (float& value : scene.harmonics)
        value *= 4.5F;
    const TemporaryDirectory directory;
    writeSplats(directory / "a.spz", scene);
    const SplatScene back = readSplats(directory / "a.spz");
    expectAlike(back, scene, 0.5 / 4096 + 1e-5, 0.5 / 16 + 1e-5, 0.5 / 255 / 0.15 * kDc + 1e-5);
    for (std::size_t i = 0; i < scene.harmonics.size(); ++i)
        EXPECT_NEAR(back.harmonics[i], scene.harmonics[i], i / 3 % 15 < 3 ? 0.04F : 0.07F);
    scene.splats[0].centre[1] = 3000;
    EXPECT_TRUE(holds(errorOf([&] { writeSplats(directory / "a.spz", scene); }),
                      "expected places of -2048..2048"));
    EXPECT_EQ(readSplats(directory / "a.spz").splats.size(), 500U); // the old one
    const std::string packed = readFile(directory / "a.spz", 1 << 20);
    EXPECT_TRUE(
        holds(refusal(packed.substr(0, packed.size() / 2), "a.spz"), "bytes of its 500 splats"));
    EXPECT_TRUE(
        holds(refusal(std::string("NGSP\3\0\0\0", 8), "a.spz"), "is not a scene of splats"));
    // a record of version 4 whose length leads back to itself
    const std::string endless("NGSP\4\0\0\0\1\0\0\0\0\14\2\0\377\0\0\0"
                              "\0\0\0\0\0\0\0\0\0\0\0\0"
                              "\1\0\0\0\370\377\377\377",
                              40);
    EXPECT_TRUE(holds(refusal(endless + std::string(300, '\0'), "a.spz"), "a.spz: "));
    EXPECT_TRUE(
        holds(errorOf([&] { writeSplats(directory / "a.obj", scene); }), "ends in .ply or .spz"));
}

TEST(SplatFile, ScenesThatMakeNoSenseAreNotWritten) {
    const TemporaryDirectory directory;
    const SplatScene good = randomSplats(5, 3);
    for (const char* name : {"a.ply", "a.spz"}) {
        const auto said = [&](const std::function<void(SplatScene&)>& change) {
            SplatScene scene = good;
            change(scene);
            return errorOf([&] { writeSplats(directory / name, scene); });
        };
        for (const int degree : {-1, 1, 4, std::numeric_limits<int>::max()})
            EXPECT_TRUE(holds(said([&](SplatScene& s) { s.degree = degree; }), "harmonics: "));
        EXPECT_TRUE(holds(said([](SplatScene& s) { s.harmonics.pop_back(); }), "harmonics: "));
        EXPECT_TRUE(holds(said([](SplatScene& s) { s.splats[3].radii[0] = std::nanf(""); }),
                          "scene: has a splat, number 3, whose numbers make no sense"));
        EXPECT_TRUE(holds(said([](SplatScene& s) { s.harmonics[4] = HUGE_VALF; }), "number 0"));
        EXPECT_FALSE(std::filesystem::exists(directory / name));
    }
}

TEST(SplatFile, SpzOfVersion1HasHalfFloats) {
    const std::string raw("NGSP\1\0\0\0\1\0\0\0\0\14\0\0" // one splat
                          "\0\x3C\0\xC0\0\x38"            // 1, -2, 0.5
                          "\377\200\200\200\240\220\260\200\200\200",
                          32);
    std::string packed("\x1F\x8B\10\0\0\0\0\0\0\3\1\40\0\337\377", 15); // stored
    const Splat splat = parseSplats(packed + raw, "a.spz").splats.at(0);
    EXPECT_EQ(splat.centre, cv::Vec3f(1, 2, -0.5F)); // y and z turned
    EXPECT_EQ(splat.opacity, 1);
    EXPECT_NEAR(splat.radii[0], 1, 1e-6F);
    EXPECT_NEAR(splat.radii[1], std::exp(-1.0F), 1e-6F);
    EXPECT_NEAR(splat.radii[2], std::exp(1.0F), 1e-6F);
    EXPECT_GT(splat.rotation[0], 0.999F);
}

TEST(SplatFile, NegativeRadiiAreLeftOut) {
    std::string bytes;
    for (const float radius : {0.5F, -0.5F}) {
        const float numbers[] = {1, 2, 3, radius, 1, 1};
        bytes.append(reinterpret_cast<const char*>(numbers), 24);
        bytes += "\xFF\x80\x01\xFF\xFF\x80\x80\x80";
    }
    Notes notes;
    const SplatScene scene = parseSplats(bytes, "a.splat", SplatAxes::Auto, &notes);
    ASSERT_EQ(scene.splats.size(), 1U);
    EXPECT_EQ(scene.splats[0].radii[0], 0.5F);
    EXPECT_EQ(scene.splats[0].colour[0], 1);
    EXPECT_TRUE(holds(textOf(notes), "1 of 2 splats are left out"));
}

TEST(SplatFile, AxesTurnByHalfATurn) {
    const SplatScene plain = parseSplats(plyOf({kRow}), "a.ply");
    const SplatScene turned = parseSplats(plyOf({kRow}), "a.ply", SplatAxes::Rub);
    EXPECT_EQ(turned.splats[0].centre, cv::Vec3f(1, -2, -3));
    EXPECT_EQ(plain.splats[0].centre, cv::Vec3f(1, 2, 3));
}

// The same scenes in several formats, written by other programs.
TEST(SplatFile, RealFilesOfAllFormatsAgree) {
    ALTIRO3D_REQUIRE_DATA("splats");
    const std::filesystem::path folder = dataPath("splats");
    const auto read = [&](const char* name) { return readSplats(folder / name); };
    expectAlike(read("train3_v3.spz"), read("train3.ply"), 2e-4, 0.04, 0.02);
    EXPECT_EQ(read("train3_v3.spz").degree, 3);
    expectAlike(read("lastchance_v2.spz"), read("lastchance.splat"), 2e-4, 0.04, 0.01);
    expectAlike(read("playbot_lod4_v3.spz"), read("playbot_lod4_sh2.ply"), 2e-4, 0.04, 0.01);
    const SplatScene exact = read("playbot_lod4_sh2.ply");
    const SplatScene rounded = read("playbot_lod4_v3.spz");
    double worst = 0;
    for (std::size_t i = 0; i < exact.harmonics.size(); ++i) {
        if (std::abs(exact.harmonics[i]) > 0.8F) continue; // beyond the range of .spz
        worst = std::max(worst,
                         std::abs(static_cast<double>(exact.harmonics[i] - rounded.harmonics[i])));
    }
    EXPECT_LE(worst, 0.07); // signs of the half turn are right
    EXPECT_EQ(read("minimal4_v2.spz").splats.size(), 4U);
    const std::string error =
        errorOf([&] { EXPECT_EQ(read("minimal4_v4.spz").splats.size(), 4U); });
    EXPECT_TRUE(error == "(no error)" || holds(error, "lacks libzstd"));
    EXPECT_EQ(read("axes16_sh3.ply").degree, 3);
    const SplatScene biker = read("biker.compressed.ply");
    EXPECT_EQ(biker.splats.size(), 152'746U);
    cv::Vec3f low = biker.splats[0].centre;
    cv::Vec3f high = low;
    for (const Splat& splat : biker.splats)
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], splat.centre[k]);
            high[k] = std::max(high[k], splat.centre[k]);
        }
    EXPECT_LE(cv::norm(low, cv::Vec3f(-0.62F, -3.18F, -0.53F), cv::NORM_INF), 0.006);
    EXPECT_LE(cv::norm(high, cv::Vec3f(0.41F, 0, 0.61F), cv::NORM_INF), 0.006);
    const SplatScene sharp = read("sharp_header_plant.ply");
    ASSERT_TRUE(sharp.camera);
    EXPECT_EQ(sharp.camera->size, cv::Size(1080, 1440));
    EXPECT_EQ(sharp.splats.size(), 14'007U);
}

} // namespace altiro3D::test
