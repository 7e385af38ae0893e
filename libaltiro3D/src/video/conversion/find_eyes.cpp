// Finds out whether the frames of a video hold both eyes' pictures.

#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/checks.hpp"
#include "image/picture_halves.hpp"
#include "video/conversion/frame_depth.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// How alike the halves are, in small. Fast, and enough to leave out most flat videos.
struct Likeness {
    double correlation = 0; // -1..1
    double difference = 0;  // mean of the absolute differences, grey levels
};
Likeness likenessOf(const cv::Mat& first, const cv::Mat& second) {
    constexpr int kSide = 32; // px; shifts of eyes are about one of them
    cv::Mat small[2];
    for (const auto& [half, to] : {std::pair(&first, &small[0]), std::pair(&second, &small[1])}) {
        cv::Mat grey;
        cv::cvtColor(*half, grey, cv::COLOR_BGR2GRAY);
        cv::resize(grey, *to, {kSide, kSide}, 0, 0, cv::INTER_AREA);
    }
    cv::Mat likeness;
    cv::matchTemplate(small[0], small[1], likeness, cv::TM_CCOEFF_NORMED);
    return {static_cast<double>(likeness.at<float>(0)),
            cv::norm(small[0], small[1], cv::NORM_L1) / static_cast<double>(small[0].total())};
}

// Whether the halves of a frame are the pictures of two eyes.
// @param surely it must be certain, as nothing else says so: patterns also match in part
bool areEyes(const cv::Mat& frame, const StereoVideo& video, bool surely) {
    constexpr double kLeastLikeness = 0.6;
    constexpr int kMatchSide = 480; // px
    const bool isBeside =
        video.layout == StereoLayout::LeftRight || video.layout == StereoLayout::RightLeft;
    const HalfPlaces places = halfPlaces(frame.size(), isBeside);
    if (places.first.empty()) return false;
    const Likeness likeness = likenessOf(frame(places.first), frame(places.second));
    constexpr double kMostDifference = 16;
    if (likeness.correlation < kLeastLikeness || (surely && likeness.difference > kMostDifference))
        return false;
    StereoPair pair = splitStereoPair(frame, video.layout, video.halves);
    for (cv::Mat* picture : {&pair.left, &pair.right}) {
        const double scale =
            std::min(1.0, static_cast<double>(kMatchSide) / std::max(picture->cols, picture->rows));
        cv::resize(*picture, *picture, {}, scale, scale, cv::INTER_AREA);
    }
    cv::Mat disparity;
    const StereoMatch match = matchStereo(pair.left, pair.right, disparity);
    constexpr double kLeastMatched = 0.6;
    constexpr double kLeastDetail = 0.8;
    constexpr double kMostRange = 0.15;
    const bool isSure = match.matchedShare >= kLeastMatched && match.likeness >= kLeastDetail &&
                        match.nearest - match.farthest <= kMostRange;
    return match.areEyes() && !match.isFlat && (isSure || !surely);
}

// Some frames of a file, from its beginning to its end.
std::vector<cv::Mat> samples(const fs::path& input, const VideoFacts& facts) {
    std::vector<cv::Mat> frames;
    for (const double share : {0.1, 0.35, 0.7}) {
        VideoReaderOptions options;
        options.from = share * facts.duration.value_or(0);
        VideoReader reader(input, options);
        VideoFrame frame;
        if (reader.read(frame)) frames.push_back(frame.picture);
        if (!facts.duration) break;
    }
    return frames;
}

} // namespace

cv::Size photoSize(const StereoVideo& video, cv::Size frame) {
    return halvesOf(video).photoSize(frame);
}

FoundEyes findEyes(const fs::path& input, const VideoFacts& facts) {
    FoundEyes found;
    const auto name = parseSceneName(input);
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorCode::Unsupported, input.string(),
                    what + ", which is not read, expected the eyes beside or above each other");
    };
    const auto halves = [&] {
        return name && name->contents == SceneName::Contents::Eyes ? name->halves
                                                                   : StereoHalves::Automatic;
    };
    if (!facts.eyes.empty()) {
        if (!facts.eyesLayout) refuse("holds both eyes by \"" + facts.eyes + "\"");
        found.eyes = StereoVideo{*facts.eyesLayout, halves()};
        found.evidence = "the file states it (" + facts.eyes + ")";
        return found;
    }
    if (name && name->contents == SceneName::Contents::Vr)
        refuse("is a video for headsets by its name (" + name->tag + ")");
    std::error_code error;
    if (!fs::is_regular_file(input, error)) return found;
    const std::vector<cv::Mat> frames = samples(input, facts);
    const auto match = [&](const StereoVideo& video) {
        return std::any_of(frames.begin(), frames.end(),
                           [&](const cv::Mat& frame) { return areEyes(frame, video, false); });
    };
    if (name && name->contents == SceneName::Contents::Eyes) {
        const StereoVideo video{name->layout, name->halves};
        if (match(video)) {
            found.eyes = video;
            found.evidence = "its name says it (" + name->tag + "), and its halves match";
        } else {
            addNote(&found.notes, NoteCode::AsItIs,
                    input.string() + ": its name (" + name->tag +
                        ") may mean that it holds both eyes, but its halves do not match: it is "
                        "read as a flat video");
        }
        return found;
    }
    for (const auto& [layout, words] :
         {std::pair(StereoLayout::LeftRight, "left and right half"),
          std::pair(StereoLayout::TopBottom, "upper and lower half")}) {
        const StereoVideo video{layout, StereoHalves::Automatic};
        const bool doAllMatch =
            !frames.empty() && std::all_of(frames.begin(), frames.end(), [&](const cv::Mat& frame) {
                return areEyes(frame, video, true);
            });
        if (!doAllMatch) continue;
        addNote(&found.notes, NoteCode::Doubtful,
                input.string() + ": its " + words +
                    " look like the pictures of two eyes, but neither the file nor its name says "
                    "so: it is read as a flat video");
        break;
    }
    return found;
}

} // namespace altiro3D
