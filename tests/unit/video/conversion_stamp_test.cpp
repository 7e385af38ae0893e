#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/onnx.hpp"
#include "support/video.hpp"
#include "video/conversion/conversion_run.hpp"

#include <chrono>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <utility>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

using Change = std::function<void(VideoConversion&)>;

void unchanged(VideoConversion&) {}

// A clip whose frames may be photos or quilts of six views, and a network.
class ConversionStamp : public FileTest {
  protected:
    ConversionStamp() {
        writeClip(directory / "clip.mkv", {movingPicture({72, 64}, 0), movingPicture({72, 64}, 1)});
        spill(directory / "net.onnx", onnx::mixModel({0.2F, 0.3F, 0.5F}, {64, 32}));
        profile_.name = "test";
        profile_.inputWidth = 64;
        profile_.inputHeight = 32;
    }

    // What an unfinished run keeps.
    RunSettings stamp(const Change& change) const {
        VideoConversion conversion;
        conversion.input = directory / "clip.mkv";
        conversion.output = directory / "out.mkv";
        conversion.display = sixViewDisplay(48, 64, {24, 32});
        conversion.depth = depthFromNetworkFile(directory / "net.onnx", profile_);
        conversion.encoding.threads = 1;
        change(conversion);
        return ConversionRun(std::move(conversion)).stamp;
    }
    // Why the run cannot be resumed; empty: it can.
    std::string difference(const RunSettings& before, const Change& change = unchanged) const {
        return differenceOf(settingsJson(before), settingsJson(stamp(change)));
    }

    NetworkProfile profile_;
};

TEST_F(ConversionStamp, HoldsTheDisplayAndTheThreads) {
    const RunSettings before = stamp(unchanged);
    EXPECT_EQ(difference(before), "");
    EXPECT_TRUE(startsWith(
        difference(before, [](VideoConversion& c) { c.display->calibration.pitch = 52.57; }),
        "display was "));
    EXPECT_TRUE(startsWith(
        difference(before, [](VideoConversion& c) { c.display->invert = InvertViews::Off; }),
        "order of views was "));
    EXPECT_EQ(difference(before, [](VideoConversion& c) { c.encoding.threads = 2; }),
              "threads was 1 and is 2");
}

TEST_F(ConversionStamp, HoldsTheContentsOfAMap) {
    const auto with = [](InvertViews invert) {
        return [invert](VideoConversion& c) {
            c.map = NativeLut(c.display->calibration, c.display->quilt, invert);
        };
    };
    const RunSettings before = stamp(with(InvertViews::Off));
    EXPECT_EQ(difference(before, with(InvertViews::Off)), "");
    EXPECT_TRUE(startsWith(difference(before, with(InvertViews::On)), "map was "));
}

TEST_F(ConversionStamp, HoldsTheShapeOfTheViewsOfQuilts) {
    const auto quilts = [](double aspect) {
        return [aspect](VideoConversion& c) {
            c.depth.reset();
            c.fromQuilt = true;
            c.viewAspect = aspect;
        };
    };
    const RunSettings before = stamp(quilts(0.75));
    EXPECT_EQ(difference(before, quilts(1.5)), "shape of the views was 0.750000 and is 1.500000");
    const auto renamed = [&](VideoConversion& c) {
        quilts(0.75)(c);
        c.input = directory / "other.mkv";
    };
    fs::rename(directory / "clip.mkv", directory / "other.mkv");
    EXPECT_EQ(difference(before, renamed), "");
}

TEST_F(ConversionStamp, HoldsWhichPictureOfDepthBelongsToEachFrame) {
    const fs::path folder = directory / "depth";
    fs::create_directory(folder);
    writeImage(folder / "0.png", movingPicture({32, 24}, 0));
    writeImage(folder / "1.png", movingPicture({32, 24}, 1));
    const auto given = [&](VideoConversion& c) { c.given.emplace().source = folder; };
    const auto swapPictures = [&] {
        fs::rename(folder / "0.png", directory / "aside");
        fs::rename(folder / "1.png", folder / "0.png");
        fs::rename(directory / "aside", folder / "1.png");
    };
    const std::string changed = "the file of the depth video has changed";
    const RunSettings before = stamp(given);
    swapPictures();
    EXPECT_EQ(difference(before, given), changed);
    swapPictures();
    EXPECT_EQ(difference(before, given), "");
    // older than the newest
    fs::last_write_time(folder / "0.png",
                        fs::last_write_time(folder / "0.png") - std::chrono::hours(1));
    EXPECT_EQ(difference(before, given), changed);
}

TEST_F(ConversionStamp, HoldsTheNetworkAndItsProfile) {
    const RunSettings before = stamp(unchanged);
    const NetworkProfile profile = profile_;
    const std::function<void(NetworkProfile&)> changes[] = {
        [](NetworkProfile& p) { p.channelOrder = ChannelOrder::Bgr; },
        [](NetworkProfile& p) { p.scale = 0.5; },
        [](NetworkProfile& p) { p.mean[1] = 0.1; },
        [](NetworkProfile& p) { p.std[2] = 2; },
        [](NetworkProfile& p) { p.resizeKernel = ResizeKernel::Nearest; },
        [](NetworkProfile& p) { p.output = NetworkOutput::MetricDepth; },
        [](NetworkProfile& p) { p.inputShape = InputShape::Photo; }};
    for (const auto& change : changes) {
        profile_ = profile;
        change(profile_);
        EXPECT_TRUE(startsWith(difference(before), "network profile was ")) << &change - changes;
    }
    profile_ = profile;
    const auto time = fs::last_write_time(directory / "net.onnx");
    spill(directory / "net.onnx", onnx::mixModel({0.3F, 0.2F, 0.5F}, {64, 32}));
    fs::last_write_time(directory / "net.onnx", time + std::chrono::seconds(3));
    EXPECT_EQ(difference(before), "the file of the network has changed");
}

} // namespace
} // namespace altiro3D::test
