#include "slide/slide_path.hpp"

#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace altiro3D {

namespace {

// What changes from one picture to the next, in widths of the picture.
struct Step {
    double right = 0; // common shift
    double down = 0;
    double roll = 0; // radians
    double growth = 0;
    double way = 0; // way of the camera: things move to the left by it, times their nearness
};

// A corner in two neighbouring pictures.
struct Shift {
    std::size_t track = 0;
    cv::Point2d from;
    cv::Point2d by;
};
std::vector<std::vector<Shift>> shiftsOf(const std::vector<SlideTrack>& tracks,
                                         std::size_t pictures) {
    std::vector<std::vector<Shift>> shifts(pictures);
    for (std::size_t t = 0; t < tracks.size(); ++t)
        for (std::size_t i = 1; i < tracks[t].at.size(); ++i)
            shifts[static_cast<std::size_t>(tracks[t].first) + i].push_back(
                {t, tracks[t].at[i - 1], tracks[t].at[i] - tracks[t].at[i - 1]});
    return shifts;
}

cv::Point2d shiftBy(const Step& step, const cv::Point2d& from, double nearness) {
    return {step.right - step.roll * from.y + step.growth * from.x - step.way * nearness,
            step.down + step.roll * from.x + step.growth * from.y};
}

// Least squares in which far shifts weigh less.
Step stepOf(const std::vector<Shift>& shifts, const std::vector<double>& nearness, double pixel) {
    Step step;
    for (int round = 0; round < 4; ++round) {
        std::vector<double> misses;
        for (const Shift& shift : shifts)
            misses.push_back(cv::norm(shift.by - shiftBy(step, shift.from, nearness[shift.track])));
        const double reach = std::max(0.5 * pixel, 2 * percentileOf(misses, 0.5));
        cv::Matx<double, 5, 5> matrix = cv::Matx<double, 5, 5>::eye() * 1e-9;
        cv::Vec<double, 5> sum;
        for (std::size_t k = 0; k < shifts.size(); ++k) {
            const Shift& shift = shifts[k];
            const double weight = 1 / (1 + std::pow(misses[k] / reach, 2));
            const cv::Vec<double, 5> x(1, 0, -shift.from.y, shift.from.x, -nearness[shift.track]);
            const cv::Vec<double, 5> y(0, 1, shift.from.x, shift.from.y, 0);
            matrix += (x * x.t() + y * y.t()) * weight;
            sum += (x * shift.by.x + y * shift.by.y) * weight;
        }
        const cv::Vec<double, 5> is = matrix.solve(sum, cv::DECOMP_CHOLESKY);
        step = {is[0], is[1], is[2], is[3], is[4]};
    }
    return step;
}

// Finds in turn how far the camera moves and how near corners are. A shift that all corners share
// says nothing about this movement: it comes from a hand that turns, or from aligned pictures.
std::vector<Step> findSteps(const std::vector<std::vector<Shift>>& shifts,
                            std::vector<double>& nearness, double pixel) {
    constexpr int kRounds = 8;
    std::vector<Step> steps(shifts.size());
    for (int round = 0; round < kRounds; ++round) {
        std::vector<double> products(nearness.size());
        std::vector<double> squares(nearness.size(), 1e-12);
        for (std::size_t i = 1; i < shifts.size(); ++i) {
            steps[i] = stepOf(shifts[i], nearness, pixel);
            Step still = steps[i];
            still.way = 0;
            const double way = round == 0 ? 1 : steps[i].way; // first, an even speed
            for (const Shift& shift : shifts[i]) {
                products[shift.track] += way * (shiftBy(still, shift.from, 0).x - shift.by.x);
                squares[shift.track] += way * way;
            }
        }
        if (round + 1 == kRounds) break;
        for (std::size_t t = 0; t < nearness.size(); ++t)
            nearness[t] = products[t] / squares[t];
        const double far = percentileOf(nearness, 0.05);
        const double range = std::max(1e-9, percentileOf(nearness, 0.95) - far);
        for (double& one : nearness)
            one = std::clamp((one - far) / range, -1.0, 2.0);
    }
    return steps;
}

// Cameras and points from what the pictures have in common with their neighbours.
void guessPath(const std::vector<SlideTrack>& tracks, const SlideGuess& guess, SlidePath& path) {
    std::vector<double> nearness(tracks.size());
    std::vector<Step> steps =
        findSteps(shiftsOf(tracks, path.cameras.size()), nearness, guess.pixel);
    // The camera turns as little as possible; things are in front of it.
    constexpr double kLeast = 0.1; // share of the range of nearness
    double products = 0;
    double squares = 1e-12;
    for (const Step& step : steps) {
        products += step.right * step.way;
        squares += step.way * step.way;
    }
    const bool isMirrored = products > squares / 2; // near is far, left is right
    const double more = std::max(kLeast, isMirrored ? products / squares - 1 : -products / squares);
    for (double& one : nearness)
        one = std::max(kLeast / 2, (isMirrored ? 1 - one : one) + more);
    for (Step& step : steps) {
        step.right -= isMirrored ? step.way : 0;
        step.way *= isMirrored ? -1 : 1;
        step.right += step.way * more;
    }
    const double usual = percentileOf(nearness, 0.5);
    const double focal = guess.lens.focal;
    for (std::size_t i = 1; i < path.cameras.size(); ++i) {
        const Step& step = steps[i];
        SlideCamera& camera = path.cameras[i];
        camera = path.cameras[i - 1];
        camera.turn = turnBy({-step.down / focal, step.right / focal, step.roll}) * camera.turn;
        camera.place[0] += step.way * usual / focal;
        camera.zoom += step.growth;
    }
    for (std::size_t t = 0; t < tracks.size(); ++t)
        path.points[t].q = nearness[t] / usual;
}

// An object that turns about an axis at a distance of 1; its front is at .85.
void guessOrbit(const std::vector<SlideTrack>& tracks, const SlideGuess& guess, SlidePath& path) {
    const std::vector<std::vector<Shift>> shifts = shiftsOf(tracks, path.cameras.size());
    cv::Point2d sum(0, 0);
    for (std::size_t i = 1; i < path.cameras.size(); ++i) {
        std::vector<double> right;
        std::vector<double> down;
        for (const Shift& shift : shifts[i]) {
            right.push_back(shift.by.x);
            down.push_back(shift.by.y);
        }
        sum += {percentileOf(right, 0.5), percentileOf(down, 0.5)};
        const double angle = -sum.x / (0.15 * guess.lens.focal);
        path.cameras[i].place = {std::sin(angle), 0, 1 - std::cos(angle)};
        path.cameras[i].turn = turnBy({-sum.y / guess.lens.focal, 0, 0}) * turnBy({0, angle, 0});
    }
}

// Where the points are whose nearness is known.
void guessPoints(const std::vector<SlideTrack>& tracks, SlidePath& path) {
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        const SlideCamera& camera = path.cameras[static_cast<std::size_t>(tracks[t].first)];
        const cv::Point2d at =
            tracks[t].at.front() * (1 / (path.lens.focal * std::exp(camera.zoom)));
        const cv::Vec3d ray = camera.turn.t() * cv::Vec3d(at.x, at.y, 1);
        // (x, y, 1) - q place = s ray
        SlidePoint& point = path.points[t];
        const double s = (1 - point.q * camera.place[2]) / ray[2];
        point.x = point.q * camera.place[0] + s * ray[0];
        point.y = point.q * camera.place[1] + s * ray[1];
    }
}

// Turns the axes of the scene: x along the path, z forwards. Positions become 0..1.
void turnAlong(SlidePath& path) {
    // A point beyond infinity (q < 0) looks like one in front to a camera that moves the other way.
    if (percentileOf(depthsOf(path), 0.95) < 0) {
        for (SlideCamera& camera : path.cameras)
            camera.place = -camera.place;
        for (SlidePoint& point : path.points)
            point.q = -point.q;
    }
    cv::Vec3d middle(0, 0, 0);
    cv::Vec3d forwards(0, 0, 0);
    for (const SlideCamera& camera : path.cameras) {
        middle += camera.place;
        forwards += camera.turn.t() * cv::Vec3d(0, 0, 1);
    }
    middle *= 1.0 / static_cast<double>(path.cameras.size());
    cv::Matx33d spread = cv::Matx33d::zeros();
    for (const SlideCamera& camera : path.cameras) {
        const cv::Vec3d from = camera.place - middle;
        spread += from * from.t();
    }
    cv::Mat values;
    cv::Mat vectors;
    cv::eigen(cv::Mat(spread), values, vectors);
    cv::Vec3d x(vectors.ptr<double>(0));
    if (x[0] < 0) x = -x;
    path.forwards = std::abs(forwards.dot(x)) / cv::norm(forwards);
    cv::Vec3d z = forwards - x * forwards.dot(x);
    z *= 1 / cv::norm(z);
    const cv::Vec3d y = z.cross(x);
    const cv::Matx33d axes(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]);

    // an origin on the path
    double low = 1e300;
    double high = -1e300;
    double zoom = 0;
    for (SlideCamera& camera : path.cameras) {
        camera.place = axes * (camera.place - middle);
        camera.turn = camera.turn * axes.t();
        low = std::min(low, camera.place[0]);
        high = std::max(high, camera.place[0]);
        zoom += camera.zoom / static_cast<double>(path.cameras.size());
    }
    const double scale = 1 / std::max(high - low, 1e-12);
    for (SlideCamera& camera : path.cameras) {
        camera.place = (camera.place - cv::Vec3d(low, 0, 0)) * scale;
        camera.zoom -= zoom;
    }
    path.lens.focal *= std::exp(zoom);
    for (SlidePoint& point : path.points) {
        // the direction from the new origin
        const cv::Vec3d origin = middle + axes.t() * cv::Vec3d(low, 0, 0);
        const cv::Vec3d from = axes * (cv::Vec3d(point.x, point.y, 1) - origin * point.q);
        point = {from[0] / from[2], from[1] / from[2], point.q / from[2] / scale};
    }
}

// Whether the camera turns about as much as it takes to follow what it passes.
bool followsAThing(const SlidePath& path) {
    constexpr double kMuch = 0.3; // share of the turn that keeps median depth in its column
    const auto count = static_cast<double>(path.cameras.size());
    double places = 0;
    for (const SlideCamera& camera : path.cameras)
        places += camera.place[0] / count;
    double products = 0;
    double squares = 0;
    for (const SlideCamera& camera : path.cameras) {
        const double from = camera.place[0] - places;
        products += from * camera.turn(0, 2);
        squares += from * from;
    }
    const std::vector<double> depths = depthsOf(path);
    // or its pictures were shifted so, which puts points behind infinity
    const double least = percentileOf(depths, 0.05);
    return std::abs(products / squares) > kMuch * std::abs(percentileOf(depths, 0.5)) ||
           least < -0.1 * (percentileOf(depths, 0.95) - least);
}

// The other path that explains nearly the same tracks.
SlidePath reversedPath(const SlidePath& path, const std::vector<SlideTrack>& tracks,
                       const SlideGuess& guess) {
    const std::vector<double> depths = depthsOf(path);
    const double mean = std::accumulate(depths.begin(), depths.end(), 0.0) /
                        static_cast<double>(std::max<std::size_t>(1, depths.size()));
    SlidePath result = path;
    for (SlideCamera& camera : result.cameras) {
        camera.turn =
            turnBy({2 * mean * camera.place[1], -2 * mean * camera.place[0], 0}) * camera.turn;
        camera.place = -camera.place;
    }
    for (SlidePoint& point : result.points)
        point.q = 2 * mean - point.q;
    solvePath(tracks, guess, result);
    turnAlong(result);
    return result;
}

// How far a track is off: mean over its pictures, far ones count less.
double missOf(const SlideTrack& track, const SlidePoint& point, const SlidePath& path,
              double pixel) {
    constexpr double kReach = 0.7; // px
    double sum = 0;
    for (int i = track.first; i < track.end(); ++i) {
        const cv::Point2d off =
            seenAt(point, path.cameras[static_cast<std::size_t>(i)], path.lens) -
            track.at[static_cast<std::size_t>(i - track.first)];
        sum += std::log1p(off.dot(off) / std::pow(kReach * pixel, 2));
    }
    return sum / static_cast<double>(track.at.size());
}

} // namespace

std::vector<double> depthsOf(const SlidePath& path) {
    std::vector<double> depths;
    for (std::size_t t = 0; t < path.points.size(); ++t)
        if (path.fits[t] != 0) depths.push_back(path.points[t].q);
    return depths;
}

FoundPaths findPaths(const std::vector<SlideTrack>& tracks, int pictures, const SlideGuess& guess) {
    FoundPaths found;
    SlidePath& path = found.best;
    path.cameras.resize(static_cast<std::size_t>(pictures));
    path.lens = guess.lens;
    path.points.resize(tracks.size());
    if (guess.isTurntable)
        guessOrbit(tracks, guess, path);
    else
        guessPath(tracks, guess, path);
    guessPoints(tracks, path);
    solvePath(tracks, guess, path);
    turnAlong(path);
    if (guess.isTurntable || !followsAThing(path)) return found;
    found.reversed = reversedPath(path, tracks, guess);
    SlidePath& other = *found.reversed;
    double alike = 0; // correlation of positions, which are 0..1
    for (std::size_t i = 0; i < path.cameras.size(); ++i)
        alike += (path.cameras[i].place[0] - 0.5) * (other.cameras[i].place[0] - 0.5);
    if (alike > 0) { // it came back to the same one
        found.reversed.reset();
        return found;
    }
    double miss = 1e-9;
    double otherMiss = 1e-9;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        if (path.fits[t] == 0 && other.fits[t] == 0) continue;
        miss += missOf(tracks[t], path.points[t], path, guess.pixel);
        otherMiss += missOf(tracks[t], other.points[t], other, guess.pixel);
    }
    if (otherMiss < miss) {
        std::swap(path, other);
        std::swap(miss, otherMiss);
    }
    found.worse = otherMiss / miss;
    return found;
}

bool movesUpright(const std::vector<SlideTrack>& tracks, int pictures, double pixel) {
    constexpr double kClear = 0.9;
    const auto missWith = [&](const std::vector<SlideTrack>& seen) {
        const std::vector<std::vector<Shift>> shifts =
            shiftsOf(seen, static_cast<std::size_t>(pictures));
        std::vector<double> nearness(seen.size());
        const std::vector<Step> steps = findSteps(shifts, nearness, pixel);
        double sum = 0;
        for (std::size_t i = 0; i < shifts.size(); ++i)
            for (const Shift& shift : shifts[i])
                sum += std::log1p(
                    cv::norm(shift.by - shiftBy(steps[i], shift.from, nearness[shift.track])) /
                    pixel);
        return sum;
    };
    return missWith(turnedByAQuarter(tracks, 1)) < kClear * missWith(tracks);
}

std::vector<SlideTrack> turnedByAQuarter(std::vector<SlideTrack> tracks, double aspect) {
    for (SlideTrack& track : tracks)
        for (cv::Point2d& at : track.at)
            at = cv::Point2d(-at.y, at.x) * (1 / aspect);
    return tracks;
}

std::vector<std::size_t> longestStretch(const std::vector<SlideCamera>& cameras) {
    constexpr double kBack = 0.02; // share of the path
    std::size_t bestBegin = 0;
    std::size_t bestEnd = 0;
    double bestSign = 1;
    double best = -1;
    for (const double sign : {1.0, -1.0}) {
        const auto at = [&](std::size_t i) { return sign * cameras[i].place[0]; };
        for (std::size_t begin = 0; begin < cameras.size(); ++begin) {
            double farthest = at(begin);
            for (std::size_t i = begin; i < cameras.size() && at(i) >= farthest - kBack; ++i) {
                farthest = std::max(farthest, at(i));
                if (at(i) - at(begin) <= best) continue;
                best = at(i) - at(begin);
                bestBegin = begin;
                bestEnd = i;
                bestSign = sign;
            }
        }
    }
    std::vector<std::size_t> stretch;
    for (std::size_t i = bestBegin; i <= bestEnd; ++i) {
        const auto goesOn = [&] {
            return bestSign * (cameras[i].place[0] - cameras[stretch.back()].place[0]) > 1e-4;
        };
        if (stretch.empty() || goesOn()) stretch.push_back(i);
    }
    return stretch;
}

} // namespace altiro3D
