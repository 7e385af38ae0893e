#include "slide/slide_checks.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace altiro3D {

namespace {

// How much the tracks that do not fit are concentrated in parts of the picture: 0 (everywhere
// alike) .. 1 (parts in which all are wrong, and parts in which none is).
double gatheringOf(const SlidePath& path, const std::vector<SlideTrack>& tracks) {
    constexpr int kCells = 4; // each way
    std::array<double, kCells * kCells> all{};
    std::array<double, kCells * kCells> wrong{};
    double misfits = 0;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        const cv::Point2d& at = tracks[t].at[tracks[t].at.size() / 2];
        const auto cellOf = [](double place) {
            return std::clamp(static_cast<int>((place + 0.5) * kCells), 0, kCells - 1);
        };
        const auto cell = static_cast<std::size_t>(cellOf(at.y) * kCells + cellOf(at.x));
        all[cell] += 1;
        if (path.fits[t] != 0) continue;
        wrong[cell] += 1;
        misfits += 1;
    }
    const auto count = static_cast<double>(tracks.size());
    const double share = misfits / count;
    double spread = 0;
    for (std::size_t cell = 0; cell < all.size(); ++cell)
        if (all[cell] > 0) spread += all[cell] * std::pow(wrong[cell] / all[cell] - share, 2);
    return spread / std::max(1e-9, count * share * (1 - share));
}

// By how much what is seen grows or shrinks over all pictures: range of the logarithm.
double growthOf(const std::vector<SlideTrack>& tracks, int pictures) {
    double now = 0;
    double least = 0;
    double most = 0;
    for (int i = 1; i < pictures; ++i) {
        std::vector<cv::Point2d> before;
        std::vector<cv::Point2d> after;
        for (const SlideTrack& track : tracks) {
            if (track.first >= i || track.end() <= i) continue;
            after.push_back(track.at[static_cast<std::size_t>(i - track.first)]);
            before.push_back(track.at[static_cast<std::size_t>(i - track.first) - 1]);
        }
        std::vector<double> ratios;
        for (std::size_t k = 0; k < before.size(); ++k) { // distances of far neighbours
            const std::size_t other = (k + before.size() / 2) % before.size();
            const double distance = cv::norm(before[k] - before[other]);
            if (distance > 0.1) ratios.push_back(cv::norm(after[k] - after[other]) / distance);
        }
        if (!ratios.empty()) now += std::log(percentileOf(ratios, 0.5));
        least = std::min(least, now);
        most = std::max(most, now);
    }
    return most - least;
}

[[noreturn]] void refuse(const std::string& problem, const std::string& name) {
    throw Error(ErrorCode::BadFormat, name, problem);
}

} // namespace

void requireCorners(int corners, const std::string& name) {
    constexpr int kFewest = 30;
    if (corners >= kFewest) return;
    refuse("only " + std::to_string(corners) +
               " corners can be followed from one picture to the next, expected " +
               std::to_string(kFewest) + " or more: a sharp scene with texture, in small steps",
           name);
}

void requireMotion(const std::vector<SlideTrack>& tracks, const std::string& name) {
    constexpr double kStill = 0.01; // share of the width
    std::vector<double> ways;
    for (const SlideTrack& track : tracks) {
        double way = 0;
        for (const cv::Point2d& at : track.at)
            way = std::max(way, cv::norm(at - track.at.front()));
        ways.push_back(way);
    }
    // pictures may be shifted so that most of what they show stays in its place
    const double way = percentileOf(ways, 0.9);
    if (way < kStill)
        refuse("the camera stands: what it sees moves by " + fixed(100 * way, 2) +
                   " % of the width, expected a camera that moves sideways (1 % or more)",
               name);
}

void requireSlide(const SlidePath& path, const std::vector<SlideTrack>& tracks, double parallax,
                  const std::string& name) {
    constexpr double kGathered = 0.25;
    constexpr double kMostMisfits = 0.3; // share of the corners
    constexpr double kLeast = 0.01;      // share of the width
    constexpr double kSideways = 0.7;    // cosine
    constexpr double kGrowth = 0.1;      // logarithm
    const char* const expected =
        ", expected a camera that moves sideways (parallax of 1 % of the width or more)";
    if (path.misfitShare > kMostMisfits) {
        const bool isPart = gatheringOf(path, tracks) > kGathered;
        refuse((isPart
                    ? "the scene moves in a part of the picture: "
                    : "the pictures are warped, as a phone's stabilisation does (turn it off), or "
                      "all of the scene moves: ") +
                   fixed(100 * path.misfitShare, 0) +
                   " % of the corners do not fit a scene at rest, expected " +
                   fixed(100 * kMostMisfits, 0) + " % at most",
               name);
    }
    const double growth = growthOf(tracks, static_cast<int>(path.cameras.size()));
    if (path.forwards > kSideways || growth > kGrowth)
        refuse("the camera zooms or moves forwards: what it sees grows by " +
                   fixed(100 * (std::exp(growth) - 1), 0) + " %" + expected,
               name);
    if (parallax < kLeast)
        refuse("the path is too short, or the camera turns instead of moving: the parallax is " +
                   fixed(100 * parallax, 2) + " % of the width" + expected,
               name);
}

} // namespace altiro3D
