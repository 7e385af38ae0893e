#include "altiro3D/image_io.hpp"
#include "support/files.hpp"

#include <gtest/gtest.h>
#include <optional>
#include <string>

namespace altiro3D::test {
namespace {

using Contents = SceneName::Contents;

TEST(SceneName, TagsOfEyesAreReadInAnyCase) {
    struct Case {
        const char* file;
        const char* tag;
        StereoLayout layout;
        StereoHalves halves;
    };
    const Case cases[] = {
        {"cat_LR.jpg", "LR", StereoLayout::LeftRight, StereoHalves::Automatic},
        {"cat_lr.jpg", "lr", StereoLayout::LeftRight, StereoHalves::Automatic},
        {"d/holiday_2x1.jpg", "2x1", StereoLayout::LeftRight, StereoHalves::Automatic},
        {"holiday_2X1_small.png", "2X1", StereoLayout::LeftRight, StereoHalves::Automatic},
        {"x_TB.png", "TB", StereoLayout::TopBottom, StereoHalves::Automatic},
        {"x_Tab-2.png", "Tab", StereoLayout::TopBottom, StereoHalves::Automatic},
        {"film.3D.HSBS.x264.mkv", "HSBS", StereoLayout::LeftRight, StereoHalves::Squeezed},
        {"a_Full_SBS.jpg", "SBS", StereoLayout::LeftRight, StereoHalves::Full},
        {"a half sbs.jpg", "sbs", StereoLayout::LeftRight, StereoHalves::Squeezed},
        {"a_LRF.jpg", "LRF", StereoLayout::LeftRight, StereoHalves::Full},
        {"a_RLF.jpg", "RLF", StereoLayout::RightLeft, StereoHalves::Full},
        {"a_fulltb.jpg", "fulltb", StereoLayout::TopBottom, StereoHalves::Full},
        {"LR_tab_LR.jpg", "LR", StereoLayout::LeftRight, StereoHalves::Automatic},
    };
    for (const Case& given : cases) {
        const std::optional<SceneName> name = parseSceneName(given.file);
        ASSERT_TRUE(name) << given.file;
        EXPECT_EQ(name->contents, Contents::Eyes) << given.file;
        EXPECT_EQ(name->tag, given.tag) << given.file;
        EXPECT_EQ(name->layout, given.layout) << given.file;
        EXPECT_EQ(name->halves, given.halves) << given.file;
    }
    for (const char* plain : {"LR.jpg", "colour.jpg", "catLR.jpg", "a_qs2x1a1.png", "a_12x1.png",
                              "tab.LR", "", "_", "a.b"})
        EXPECT_FALSE(parseSceneName(plain)) << plain;
}

TEST(SceneName, TagsOfDepthSayTheShapeOfTheHalves) {
    const auto check = [](const char* file, bool isStacked, StereoHalves halves) {
        const std::optional<SceneName> name = parseSceneName(file);
        ASSERT_TRUE(name) << file;
        EXPECT_EQ(name->contents, Contents::Rgbd) << file;
        EXPECT_EQ(name->isStacked, isStacked) << file;
        EXPECT_EQ(name->halves, halves) << file;
    };
    check("photo_rgbd.jpg", false, StereoHalves::Full);
    check("clip_RGBD_v2.mp4", false, StereoHalves::Full);
    check("photo_HRGBD.png", false, StereoHalves::Squeezed);
    check("photo_rgbd_topbottom.png", true, StereoHalves::Full);
    check("photo_TB_hrgbd.png", true, StereoHalves::Squeezed);
    check("photo_rgbd_LR.png", false, StereoHalves::Full);
}

TEST(SceneName, NamesForHeadsetsGoFirstAndRunningNumbersAreNone) {
    const TemporaryDirectory directory;
    const auto isVr = [&](const std::string& file) {
        const std::optional<SceneName> name = parseSceneName(directory / file);
        return name && name->contents == Contents::Vr;
    };
    for (const char* file : {"a_180x180_LR.jpg", "a_180.jpg", "a_360.jpg", "a_360_TB.mp4",
                             "a_LR_180.png", "a_VR180.jpg", "a-180X180-3dh.jpg"})
        EXPECT_TRUE(isVr(file)) << file;
    for (const char* file : {"180.jpg", "360_a.jpg", "IMG_0180.jpg", "IMG_1180.jpg", "a_1080.jpg"})
        EXPECT_FALSE(isVr(file)) << file;
    spill(directory / "a_360.jpg", "x");
    EXPECT_TRUE(isVr("a_180.jpg")) << "both are for headsets";
    spill(directory / "a_090.png", "x");
    EXPECT_TRUE(isVr("a_180.jpg")) << "another kind of file";
    spill(directory / "a_179.jpg", "x");
    EXPECT_FALSE(isVr("a_180.jpg"));
    EXPECT_FALSE(isVr("a_360.jpg"));
    EXPECT_TRUE(isVr("b_180.jpg"));
}

TEST(HalvesOf, WhatIsStatedGoesBeforeTheNameAndThatBeforeTheShape) {
    const double tv = 16.0 / 9;
    EXPECT_EQ(halvesOf("a_RGBD.png", StereoHalves::Squeezed, tv), StereoHalves::Squeezed);
    EXPECT_EQ(halvesOf("a_RGBD.png", StereoHalves::Automatic, tv), StereoHalves::Full);
    EXPECT_EQ(halvesOf("a_HRGBD.png", StereoHalves::Automatic, 2.5), StereoHalves::Squeezed);
    EXPECT_EQ(halvesOf("a_HRGBD.png"), StereoHalves::Squeezed);
    EXPECT_EQ(halvesOf("a.png"), StereoHalves::Automatic);
    EXPECT_EQ(halvesOf("a.png", StereoHalves::Automatic, tv), StereoHalves::Squeezed);
    EXPECT_EQ(halvesOf("a_LR.png", StereoHalves::Automatic, 2.5), StereoHalves::Full);
}

} // namespace
} // namespace altiro3D::test
