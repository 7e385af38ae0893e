#pragma once

#include "media/resumable_video.hpp"

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>

/// Small videos for targets and seeds.
namespace altiro3D::fuzz {

inline cv::Mat samplePicture(int number) {
    cv::Mat picture(16, 16, CV_8UC3, cv::Scalar::all(40));
    picture(cv::Rect(number % 8, 4, 8, 8)).setTo(cv::Scalar(200, 30 * (number % 8), 90));
    return picture;
}

inline VideoWriterOptions videoOptions() {
    VideoWriterOptions options;
    options.size = {16, 16};
    options.codec = VideoCodec::Ffv1;
    options.timeBase = {1, 25};
    options.threads = 1;
    return options;
}

inline ResumableVideoOptions runOptions(bool resume) {
    ResumableVideoOptions options;
    options.segmentFrames = 2;
    options.resume = resume;
    options.settings = {{"method", "layered"}};
    return options;
}

inline std::string contentsOf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The files that an interrupted run leaves.
struct Leftovers {
    std::string run;     ///< run.json
    std::string segment; ///< 000001.mkv
};

/// Begins a run and interrupts it after its first segment.
inline Leftovers beginRun(const std::filesystem::path& video) {
    discardUnfinishedVideo(video);
    {
        ResumableVideoWriter writer(video, videoOptions(), runOptions(false));
        for (int i = 0; i < 3; ++i)
            writer.write({samplePicture(i), i, 1}, {"the state"});
    }
    const std::filesystem::path parts = unfinishedVideoDirectory(video);
    return {contentsOf(parts / "run.json"), contentsOf(parts / "000001.mkv")};
}

} // namespace altiro3D::fuzz
