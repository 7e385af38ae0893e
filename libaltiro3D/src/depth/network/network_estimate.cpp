#include "depth/network/network_estimate.hpp"

#include "base/pixel_rows.hpp"
#include "depth/refine/depth_steps.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kPhotoSide = 512; // longer side of the depth of photos, px
constexpr int kFrameSide = 320; // the same for frames
constexpr int kReadSide = 1024; // networks read a copy of larger photos
// docs/lab/depth.md has the measurements of other sizes and shares.
constexpr double kSecondSize = 1.25;  // sizes of the mirrored copies, in sizes of the network's
constexpr double kDetailSize = 1.625; // input
constexpr double kDetailShare = 0.5;  // how much of the detail is that of the largest run
constexpr int kWindows = 16;          // windows across the longer side; what is finer is detail

cv::Mat resized(const cv::Mat& picture, cv::Size size) {
    if (picture.size() == size) return picture;
    cv::Mat result;
    const bool shrinks = size.width < picture.cols;
    cv::resize(picture, result, size, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
    return result;
}

// The longer side of a copy, as the network takes it.
int sideOf(const NetworkProfile& profile, double size) {
    const int own = std::max(profile.inputWidth, profile.inputHeight);
    const double multiples = own * size / profile.multipleOf;
    return std::min(4096 / profile.multipleOf, static_cast<int>(std::lround(multiples))) *
           profile.multipleOf;
}

// The depth of the three runs of a photo: the mean of the smaller ones, which order surfaces best,
// with detail of the largest one.
cv::Mat joined(const std::vector<cv::Mat>& depths, cv::Size size) {
    const auto upright = [&](const cv::Mat& mirrored) {
        cv::Mat depth;
        cv::flip(mirrored, depth, 1);
        return resized(depth, size);
    };
    cv::Mat depth = (resized(depths[0], size) + upright(depths[1])) / 2;
    const cv::Mat missing = upright(depths[2]) - depth;
    const int side = std::max(2, std::max(size.width, size.height) / kWindows);
    cv::Mat coarse;
    cv::blur(missing, coarse, {side + 1, side + 1}, {-1, -1}, cv::BORDER_REFLECT);
    depth += kDetailShare * (missing - coarse);
    cv::min(cv::max(depth, 0), 1, depth);
    return depth;
}

constexpr double kMinLength = 0.07;  // share of the photo's longer side
constexpr double kLongLength = 0.16; // lines of this length and more have the full weight
// The depth is read this far from an edge, px.
constexpr std::array<float, 5> kAsides{-3.0F, -1.5F, 0.0F, 1.5F, 3.0F};
constexpr double kAccepted = 0.1; // departure, in units of depth, that can be corrected
constexpr double kAcceptedShare = 0.7;
constexpr double kNoise = 0.01; // departures from a line that are not outliers
constexpr float kStep = 0.02F;  // a step of depth beside a px: no surface goes on there
constexpr float kHold = 2e-3F;  // pull of each px to where it is
constexpr int kPasses = 14;
constexpr float kOverrelaxation = 1.75F;

// Depth beside an edge, or beside a part of it that has no step.
struct Profile {
    std::vector<cv::Point> places;
    std::vector<double> along; // 0..1
    std::vector<double> depth;
};

// @return the parts between steps, from the one end to the other
std::vector<Profile> readProfiles(const cv::Vec4f& line, float aside, const cv::Mat& depth) {
    const cv::Point2f from(line[0], line[1]);
    const cv::Point2f way(line[2] - line[0], line[3] - line[1]);
    const auto length = static_cast<float>(cv::norm(way));
    const cv::Point2f offset(-way.y * aside / length, way.x * aside / length);
    const int count = static_cast<int>(length) + 1;
    std::vector<Profile> profiles(1);
    for (int i = 0; i < count; ++i) {
        const float along = static_cast<float>(i) / static_cast<float>(std::max(count - 1, 1));
        const cv::Point2f exact = from + along * way + offset;
        const cv::Point place(cvRound(exact.x), cvRound(exact.y));
        if (!cv::Rect({}, depth.size()).contains(place)) continue;
        const auto value = static_cast<double>(depth.at<float>(place));
        if (!profiles.back().depth.empty() &&
            std::abs(value - profiles.back().depth.back()) > static_cast<double>(kStep))
            profiles.emplace_back();
        Profile& profile = profiles.back();
        profile.places.push_back(place);
        profile.along.push_back(static_cast<double>(along));
        profile.depth.push_back(value);
    }
    return profiles;
}

// Departures from the affine function of the place along the line that fits best: f(along) - depth.
// Outliers count little (Cauchy's weights).
std::vector<double> departures(const Profile& profile) {
    constexpr int kFits = 5;
    const std::size_t count = profile.depth.size();
    std::vector<double> weights(count, 1);
    std::vector<double> missing(count);
    for (int fit = 0; fit < kFits; ++fit) {
        double sum = 0;
        double meanAlong = 0;
        double meanDepth = 0;
        for (std::size_t i = 0; i < count; ++i) {
            sum += weights[i];
            meanAlong += weights[i] * profile.along[i];
            meanDepth += weights[i] * profile.depth[i];
        }
        meanAlong /= sum;
        meanDepth /= sum;
        double square = 0;
        double product = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double along = profile.along[i] - meanAlong;
            square += weights[i] * along * along;
            product += weights[i] * along * (profile.depth[i] - meanDepth);
        }
        const double slope = square > 0 ? product / square : 0;
        std::vector<double> sizes(count);
        for (std::size_t i = 0; i < count; ++i) {
            missing[i] = meanDepth + slope * (profile.along[i] - meanAlong) - profile.depth[i];
            sizes[i] = std::abs(missing[i]);
        }
        const double scale = std::max(kNoise, 1.48 * valueOfRank(sizes, count / 2));
        for (std::size_t i = 0; i < count; ++i)
            weights[i] = 1 / (1 + missing[i] * missing[i] / (scale * scale));
    }
    return missing;
}

// A membrane, cut where the depth has a step, that is pulled to corrections and, weakly, to 0.
class Membrane {
  public:
    explicit Membrane(const cv::Mat& depth)
        : size_(depth.size()), wanted_(cv::Mat::zeros(size_, CV_32FC1)), pull_(wanted_.clone()),
          right_(wanted_.clone()), down_(wanted_.clone()) {
        overRows(size_.height, [&](int y) {
            const auto* const row = depth.ptr<float>(y);
            for (int x = 0; x + 1 < size_.width; ++x)
                right_.ptr<float>(y)[x] = hold(row[x + 1] - row[x]);
            if (y + 1 == size_.height) return;
            const auto* const below = depth.ptr<float>(y + 1);
            for (int x = 0; x < size_.width; ++x)
                down_.ptr<float>(y)[x] = hold(below[x] - row[x]);
        });
    }

    void pull(cv::Point place, float correction, float weight) {
        wanted_.at<float>(place) += weight * correction;
        pull_.at<float>(place) += weight;
    }

    // @return the corrections, by red-black overrelaxation (Young 1954)
    cv::Mat settle() const {
        cv::Mat correction = cv::Mat::zeros(size_, CV_32FC1);
        for (int pass = 0; pass < 2 * kPasses; ++pass) {
            overRows(size_.height, [&](int y) { relax(y, (y + pass) % 2, correction); });
        }
        return correction;
    }

  private:
    static float hold(float step) {
        const auto steps = static_cast<double>(step / kStep);
        return static_cast<float>(std::exp(-steps * steps)); // libraries differ in expf()
    }

    // Every other px of a row; those beside them stay.
    void relax(int y, int first, cv::Mat& correction) const {
        const auto* const above = correction.ptr<float>(std::max(y - 1, 0));
        const auto* const below = correction.ptr<float>(std::min(y + 1, size_.height - 1));
        const auto* const holdUp = down_.ptr<float>(std::max(y - 1, 0));
        const bool hasAbove = y > 0;
        auto* const row = correction.ptr<float>(y);
        const auto* const holdDown = down_.ptr<float>(y);
        const auto* const holdRight = right_.ptr<float>(y);
        const auto* const wanted = wanted_.ptr<float>(y);
        const auto* const pull = pull_.ptr<float>(y);
        for (int x = first; x < size_.width; x += 2) {
            const float left = x > 0 ? holdRight[x - 1] : 0.0F;
            const float right = holdRight[x];
            const float up = hasAbove ? holdUp[x] : 0.0F;
            const float down = holdDown[x];
            float sum = wanted[x] + up * above[x] + down * below[x];
            if (x > 0) sum += left * row[x - 1];
            if (x + 1 < size_.width) sum += right * row[x + 1];
            const float all = left + right + up + down + pull[x] + kHold;
            row[x] += kOverrelaxation * (sum / all - row[x]);
        }
    }

    cv::Size size_;
    cv::Mat wanted_; // weighted corrections
    cv::Mat pull_;   // their weights
    cv::Mat right_;  // coupling of each px to that on its right
    cv::Mat down_;   // coupling to that below it
};

bool isAtFrame(const cv::Vec4f& line, cv::Size size) {
    constexpr float kFrame = 4;
    const auto beyond = [&](float a, float b, int length) {
        const float last = static_cast<float>(length - 1) - kFrame;
        return std::max(a, b) < kFrame || std::min(a, b) > last;
    };
    return beyond(line[0], line[2], size.width) || beyond(line[1], line[3], size.height);
}

double lengthOf(const cv::Vec4f& line) {
    return std::hypot(static_cast<double>(line[2] - line[0]),
                      static_cast<double>(line[3] - line[1]));
}

} // namespace

std::vector<NetworkRun> runsOfPhoto(const NetworkProfile& profile, cv::Size inputSize,
                                    const cv::Mat& photo) {
    const int own = std::max(profile.inputWidth, profile.inputHeight);
    const int chosen = std::max(inputSize.width, inputSize.height);
    const cv::Mat read = downscale(photo, kReadSide);
    if (profile.inputShape != InputShape::Photo || chosen < own) return {{read, 0}};
    cv::Mat mirrored;
    cv::flip(read, mirrored, 1);
    return {{read, own},
            {mirrored, sideOf(profile, kSecondSize)},
            {mirrored, chosen > own ? chosen : sideOf(profile, kDetailSize)}};
}

cv::Mat depthOfRuns(cv::Size photo, const cv::Mat& read, const std::vector<cv::Mat>& depths) {
    const cv::Size size = downscaledSize(photo, kPhotoSide);
    cv::Mat depth = depths.size() > 1 ? joined(depths, size) : resized(depths[0], size);
    const cv::Mat seen = resized(read, size);
    const std::vector<cv::Vec4f> lines = findLines(seen);
    straightenLines(lines, depth);
    decideContours(seen, depth);
    straightenLines(lines, depth);
    return depth;
}

cv::Mat estimatePhoto(DepthNetwork& network, const cv::Mat& photo) {
    const std::vector<NetworkRun> runs = runsOfPhoto(network.profile(), network.inputSize(), photo);
    std::vector<cv::Mat> depths(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i)
        network.estimate(runs[i].photo, depths[i], runs[i].longerSide);
    return depthOfRuns(photo.size(), runs.front().photo, depths);
}

cv::Mat estimateFrame(DepthNetwork& network, const cv::Mat& frame) {
    cv::Mat depth;
    network.estimate(frame, depth);
    const cv::Size size = downscaledSize(frame.size(), kFrameSide);
    depth = resized(depth, size);
    decideContours(resized(frame, size), depth);
    return depth;
}

std::vector<cv::Vec4f> findLines(const cv::Mat& photo) {
    std::vector<cv::Vec4f> lines;
    cv::createLineSegmentDetector(cv::LSD_REFINE_NONE, 0.6)->detect(greyOf(photo), lines);
    const double least = kMinLength * std::max(photo.cols, photo.rows);
    const auto isUseless = [&](const cv::Vec4f& line) {
        return lengthOf(line) < least || isAtFrame(line, photo.size());
    };
    lines.erase(std::remove_if(lines.begin(), lines.end(), isUseless), lines.end());
    return lines;
}

void straightenLines(const std::vector<cv::Vec4f>& lines, cv::Mat& depth) {
    if (lines.empty()) return;
    Membrane membrane(depth);
    const int side = std::max(depth.cols, depth.rows);
    const auto pull = [&](const Profile& profile) {
        const auto length = static_cast<double>(profile.depth.size());
        if (length < kMinLength * side) return;
        const std::vector<double> missing = departures(profile);
        const auto isAccepted = [](double value) { return std::abs(value) < kAccepted; };
        const auto accepted = std::count_if(missing.begin(), missing.end(), isAccepted);
        if (static_cast<double>(accepted) < kAcceptedShare * length) return;
        const auto weight = static_cast<float>(std::min(1.0, length / (kLongLength * side)));
        for (std::size_t i = 0; i < missing.size(); ++i) {
            if (isAccepted(missing[i]))
                membrane.pull(profile.places[i], static_cast<float>(missing[i]), weight);
        }
    };
    for (const cv::Vec4f& line : lines) {
        for (const float aside : kAsides) {
            for (const Profile& profile : readProfiles(line, aside, depth))
                pull(profile);
        }
    }
    cv::add(depth, membrane.settle(), depth);
}

} // namespace altiro3D
