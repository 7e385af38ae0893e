#include "altiro3D/placement.hpp"

#include "altiro3D/depth_source.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/onnx.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

class Network2QuiltOfAFile : public FileTest {
  protected:
    Network2QuiltOfAFile() {
        profile_.name = "mix";
        profile_.inputWidth = 32;
        profile_.inputHeight = 24;
        profile_.multipleOf = 8;
        spill(directory / "mix.onnx", onnx::mixModel({0.2F, 0.3F, 0.5F}, {32, 24}));
    }
    DepthNetwork network() const { return {directory / "mix.onnx", profile_}; }

    NetworkProfile profile_;
    const QuiltLayout layout_{3, 2, {30, 40}, 5};
};

TEST_F(Network2QuiltOfAFile, IsReadSceneAndFitSceneAndDepth2Quilt) {
    ViewOptions options;
    options.strengthPercent = 35;
    options.focus = 0.3;
    for (const FitMode mode : {FitMode::Cover, FitMode::Contain, FitMode::Stretch}) {
        options.method = mode == FitMode::Cover ? ViewMethod::Layered : ViewMethod::Fast;
        Network2Quilt maker(network(), layout_, options, 0.75, mode);
        const auto same = depthFromNetwork(network());
        cv::Mat quilt;
        for (const cv::Size size : {cv::Size(90, 61), cv::Size(41, 97), cv::Size(30, 40)}) {
            const cv::Mat photo = randomPhoto(size);
            maker.render(photo, quilt);
            cv::Mat expected;
            Scene scene;
            Scene fitted;
            same->readScene(photo, 0.3, scene);
            const PhotoFit fit = withMargins(fitPhoto(size, 0.75, {30, 40}, mode), size, options);
            fitScene(scene, fit, 0.3, fitted);
            Depth2Quilt(layout_, options).render(fitted, expected);
            EXPECT_TRUE(samePicture(quilt, expected)) << size;
            EXPECT_TRUE(samePicture(maker.depth(), scene.depth)) << size;
        }
    }
}

TEST_F(Network2QuiltOfAFile, WhatIsWrongIsNamed) {
    ViewOptions options;
    options.focus = 2;
    EXPECT_TRUE(
        holds(errorOf([&] { Network2Quilt(network(), layout_, options, 0.75); }), "focus: is 2"));
    const auto error = [&](const QuiltLayout& layout, double aspect) {
        return errorOf([&] { Network2Quilt(network(), layout, {}, aspect); });
    };
    EXPECT_EQ(error(layout_, 0), "panel aspect: is 0, expected 0.01..100");
    EXPECT_EQ(error(layout_, std::nan("")), "panel aspect: is nan, expected 0.01..100");
    EXPECT_EQ(error({0, 6, {9, 9}, 1}, 1),
              "quilt layout: 0 columns x 6 rows, expected 1..1024 of each");
    Network2Quilt maker(network(), layout_, {}, 0.75);
    cv::Mat quilt;
    EXPECT_TRUE(holds(errorOf([&] { maker.render(cv::Mat(), quilt); }), "expected"));
    EXPECT_TRUE(holds(errorOf([&] { maker.render(cv::Mat(4, 4, CV_8UC1), quilt); }), "photo: is "));
}

} // namespace
} // namespace altiro3D::test
