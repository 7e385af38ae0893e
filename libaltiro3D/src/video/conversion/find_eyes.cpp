#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"
#include "video/conversion/frame_depth.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

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
        cv::resize(greyOf(*half), *to, {kSide, kSide}, 0, 0, cv::INTER_AREA);
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
    constexpr int kLeastSide = 16;
    const HalfPlaces places = halfPlaces(frame.size(), liesBeside(video.layout));
    if (places.first.empty()) return false;
    if (surely) { // where parallax is large, halves of a pair are not alike in small
        const Likeness likeness = likenessOf(frame(places.first), frame(places.second));
        constexpr double kMostDifference = 16;
        if (likeness.correlation < kLeastLikeness || likeness.difference > kMostDifference)
            return false;
    }
    StereoPair pair = splitStereoPair(frame, video.layout, video.halves);
    for (cv::Mat* picture : {&pair.left, &pair.right}) {
        const double scale =
            std::min(1.0, static_cast<double>(kMatchSide) / std::max(picture->cols, picture->rows));
        const cv::Size size(cvRound(picture->cols * scale), cvRound(picture->rows * scale));
        if (std::min(size.width, size.height) < kLeastSide) return false;
        cv::resize(*picture, *picture, size, 0, 0, cv::INTER_AREA);
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

// Some frames of a file, from its beginning to its end, and what they state.
struct Samples {
    std::vector<cv::Mat> frames;
    std::string eyes; // as VideoFacts
    std::optional<StereoLayout> layout;
};
Samples samplesOf(const fs::path& input, const VideoFacts& facts, VideoReaderOptions options) {
    Samples samples;
    for (const double share : {0.0, 0.1, 0.35, 0.7}) { // the first frame may be black, or a title
        options.from = share * facts.duration.value_or(0);
        options.to = std::numeric_limits<double>::infinity();
        VideoReader reader(input, options);
        VideoFrame frame;
        const bool isRead = reader.read(frame);
        if (isRead && (share > 0 || !facts.duration)) samples.frames.push_back(frame.picture);
        if (samples.eyes.empty()) {
            samples.eyes = reader.facts().eyes;
            samples.layout = reader.facts().eyesLayout;
        }
        if (!facts.duration) break;
    }
    return samples;
}

// Shape of the halves and whether it is sure.
struct HalvesShape {
    StereoHalves halves = StereoHalves::Full;
    bool isSure = true;
};

bool isWide(double eye) {
    return eye > 1.23 && eye < 2.45;
}

// Guesses by the shape that a scene has: wide, square or a portrait. Squeezed ones are wide.
// @param aspect width : height of a frame as displayed
HalvesShape guessHalves(bool isBeside, double aspect) {
    const auto isPhoto = [](double eye) {
        return isWide(eye) || (eye > 0.95 && eye < 1.05) || (eye > 0.5 && eye < 0.82);
    };
    const bool canBeFull = isPhoto(isBeside ? aspect / 2 : aspect * 2);
    const bool canBeSqueezed = isWide(aspect);
    return {canBeSqueezed && !canBeFull ? StereoHalves::Squeezed : StereoHalves::Full,
            canBeFull != canBeSqueezed};
}

// What the converter writes into the file's tags, because MP4 does not state whether halves are
// squeezed, and the size of an eye that Matroska states may be the frame's.
std::optional<StereoHalves> taggedHalves(bool isBeside, const VideoFacts& facts) {
    const auto full = isBeside ? EyesPicture::SideBySide : EyesPicture::TopBottom;
    const auto half = isBeside ? EyesPicture::SideBySideHalf : EyesPicture::TopBottomHalf;
    for (const auto& [name, value] : facts.tags) {
        if (name != "keywords" && name != "KEYWORDS") continue;
        if (value == nameOf(half).words) return StereoHalves::Squeezed;
        if (value == nameOf(full).words) return StereoHalves::Full;
    }
    return std::nullopt;
}

// Shape of the halves. In videos, LR and TB mean squeezed halves, unless the shape says otherwise.
HalvesShape shapeOfHalves(StereoLayout layout, const std::optional<SceneName>& name,
                          const VideoFacts& facts) {
    const double pixel = facts.sampleAspect.value();
    const double aspect = pixel * facts.size.width / facts.size.height;
    const bool isBeside = liesBeside(layout);
    const auto stated = [&](StereoHalves halves) {
        return HalvesShape{halvesAsShown({layout, halves}, facts), true};
    };
    if (const auto tagged = taggedHalves(isBeside, facts)) return stated(*tagged);
    if (name && name->contents == SceneName::Contents::Eyes) {
        if (name->halves != StereoHalves::Automatic) return stated(name->halves);
        const std::string tag = lowerCase(name->tag);
        const bool isShort = tag == "lr" || tag == "tb" || tag.rfind("3d", 0) == 0;
        constexpr double kWide = 2.4; // aspect from which on halves have the shape of a scene
        constexpr double kHigh = 1.1;
        if (isShort)
            return {(isBeside ? aspect < kWide : aspect > kHigh) ? StereoHalves::Squeezed
                                                                 : StereoHalves::Full,
                    true};
    }
    return guessHalves(isBeside, aspect);
}

// Whether frames that hold both eyes often have this shape: two of 4:3 to 2.4:1, or squeezed ones.
// Portrait videos do not.
// @param aspect width : height of a frame as displayed
bool isUsual(StereoLayout layout, double aspect) {
    if (aspect > 1.7 && aspect < 1.85) return true;
    if (layout == StereoLayout::LeftRight) return aspect > 2.5;
    return (aspect > 0.64 && aspect < 0.7) || (aspect > 0.8 && aspect < 1.25);
}

} // namespace

cv::Size photoSize(const StereoVideo& video, cv::Size frame) {
    return halvesOf(video).photoSize(frame);
}

StereoHalves halvesAsShown(const StereoVideo& video, const VideoFacts& facts) {
    const double pixel = facts.sampleAspect.value();
    const double eye = pixel * facts.size.width / facts.size.height; // stretched again
    // px of DVDs are not square
    const bool isStretched = liesBeside(video.layout) ? pixel > 1.6 : pixel < 0.8;
    return isStretched && (facts.eyesLayout || !isWide(eye)) ? StereoHalves::Full
                                                             : halvesOf({}, video.halves, eye);
}

FoundEyes findEyes(const fs::path& input, const VideoFacts& facts,
                   const VideoReaderOptions& options) try {
    FoundEyes found;
    const auto name = parseSceneName(input);
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorCode::Unsupported, input.string(),
                    what + ", which is not read, expected the eyes beside or above each other");
    };
    if (name && name->contents == SceneName::Contents::Vr)
        refuse("is a video for headsets by its name (" + name->tag + ")");
    const double aspect = facts.sampleAspect.value() * facts.size.width / facts.size.height;
    const auto take = [&](StereoLayout layout, const std::string& evidence) {
        const HalvesShape shape = shapeOfHalves(layout, name, facts);
        found.eyes = StereoVideo{layout, shape.halves};
        found.evidence = evidence;
        if (shape.isSure || facts.areJoined()) return;
        addNote(&found.notes, NoteCode::Doubtful,
                input.string() + ": its shape does not say whether its halves are squeezed: they "
                                 "are taken as full ones; --stereo, as with left-right:squeezed or "
                                 "left-right:full, says it");
    };
    std::error_code error;
    const bool isFile = fs::is_regular_file(input, error);
    Samples samples;
    if (isFile && facts.eyes.empty()) samples = samplesOf(input, facts, options);
    const std::string& stated = facts.eyes.empty() ? samples.eyes : facts.eyes;
    const auto& layout = facts.eyes.empty() ? samples.layout : facts.eyesLayout;
    if (layout) {
        take(*layout, "the file states it (" + stated + ")");
        if (facts.areJoined()) found.eyes->halves = StereoHalves::Full;
        return found;
    }
    if (startsWith(stated, kAlternateFrames)) { // stated, but not by the first frame: not joined
        const std::string first = stated == kAlternateFrames ? "al:sbsl" : "ar:sbsl";
        throw Error(ErrorCode::Unsupported, input.string(),
                    "shows the eyes by turns, expected them beside each other, as made by the "
                    "following and read with --stereo left-right:full: ffmpeg -i " +
                        shellWord(input.string()) + " -vf stereo3d=" + first +
                        ",sidedata=delete:STEREO3D eyes_LRF.mp4");
    }
    if (!stated.empty()) refuse("holds both eyes by \"" + stated + "\"");
    const std::vector<cv::Mat>& frames = samples.frames;
    if (name && name->contents == SceneName::Contents::Eyes && isFile) {
        const StereoVideo video{name->layout, shapeOfHalves(name->layout, name, facts).halves};
        const bool isPair = std::any_of(frames.begin(), frames.end(), [&](const cv::Mat& frame) {
            return areEyes(frame, video, false);
        });
        if (isPair) {
            take(name->layout, "its name says it (" + name->tag + "), and its halves match");
        } else {
            addNote(&found.notes, NoteCode::AsItIs,
                    input.string() + ": its name (" + name->tag +
                        ") may mean that it holds both eyes, but its halves do not match: it is "
                        "read as a flat video");
        }
        return found;
    }
    for (const auto& [half, words] : {std::pair(StereoLayout::LeftRight, "left and right half"),
                                      std::pair(StereoLayout::TopBottom, "upper and lower half")}) {
        const StereoVideo video{half, shapeOfHalves(half, std::nullopt, facts).halves};
        const bool doAllMatch =
            isUsual(half, aspect) && !frames.empty() &&
            std::all_of(frames.begin(), frames.end(),
                        [&](const cv::Mat& frame) { return areEyes(frame, video, true); });
        if (!doAllMatch) continue;
        addNote(&found.notes, NoteCode::Doubtful,
                input.string() + ": its " + words +
                    " look like the pictures of two eyes, but neither the file nor its name says "
                    "so: it is read as a flat video");
        break;
    }
    return found;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
