#pragma once

#include "altiro3D/altiro3D.hpp"
#include "cli/display_options.hpp"
#include "support/files.hpp"

#include <QProcess>
#include <QTest>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

/// The sample calibration, or a panel of its lenses with other numbers of px.
inline Display sampleDisplay(cv::Size panel = {1536, 2048}) {
    Calibration calibration = readCalibration(sourcePath("calibration/portrait-sample.json"));
    calibration.screenW = panel.width;
    calibration.screenH = panel.height;
    return displayOf(calibration, "sample");
}

inline QString toName(const std::filesystem::path& file) {
    return QString::fromStdString(file.string());
}

/// The file of sampleDisplay().
inline QString writeSample(const std::filesystem::path& file, cv::Size panel) {
    std::string text = slurp(sourcePath("calibration/portrait-sample.json"));
    for (const auto& [from, to] : {std::pair("1536", panel.width), {"2048", panel.height}})
        text.replace(text.find(from), 4, std::to_string(to));
    spill(file, text);
    return toName(file);
}

/// A photo with detail. [size, CV_8UC3]
inline cv::Mat detailedPhoto(cv::Size size) {
    cv::Mat photo(size, CV_8UC3);
    cv::RNG(7).fill(photo, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(photo, photo, {7, 7}, 2);
    return photo;
}

/// A near box in the middle (depth 1) before a far wall (depth 0). [size, CV_8UC1]
inline cv::Mat boxDepth(cv::Size size) {
    cv::Mat depth(size, CV_8UC1, cv::Scalar(0));
    depth(cv::Rect(size.width / 4, size.height / 4, size.width / 2, size.height / 2)) = 255;
    return depth;
}

/// A video of `frames` grey pictures, so many a second.
inline void writeGreys(const std::filesystem::path& file, cv::Size size, int frames,
                       int rate = 25) {
    VideoWriterOptions options;
    options.size = size;
    options.timeBase = {1, rate};
    options.frameRate = {rate, 1};
    VideoWriter writer(file, options);
    for (int i = 0; i < frames; ++i) {
        VideoFrame frame;
        frame.picture = cv::Mat(size, CV_8UC3, cv::Scalar::all(20 + 10 * i));
        frame.pts = i;
        frame.duration = 1;
        writer.write(frame);
    }
    writer.finish();
}

/// Lets events come until something is so, 2 minutes at most (ThreadSanitizer on a busy machine).
inline bool waitFor(const std::function<bool()>& so) {
    return QTest::qWaitFor(so, 120000);
}

} // namespace altiro3D::test
