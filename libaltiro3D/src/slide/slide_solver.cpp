#include "slide/slide_solver.hpp"

#include "base/pixel_rows.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace altiro3D {

namespace {

constexpr int kOwn = 8;    // unknowns of a camera: turns about x, y, z; place; zoom; shear
constexpr int kCommon = 2; // unknowns of the lens: logarithm of the focal length, bend
constexpr int kParts = 8;  // parts of the sums over tracks; fixed, so that results are reproducible

// Standard deviations of the unknowns, known beforehand.
constexpr double kTurn = 0.05; // turn of a hand, radians
constexpr double kOrbit = 0.5; // about y, if the object turns
constexpr double kAway = 0.05; // distance from a straight path, in its lengths
constexpr double kZoom = 0.02;
constexpr double kShear = 0.01;
constexpr double kFocal = 0.5;
constexpr double kBend = 0.01;
constexpr double kDepth = 5; // q, about 1

using Own = cv::Vec<double, kOwn>;
using ByOwn = cv::Matx<double, 2, kOwn>;
using ByPoint = cv::Matx<double, 2, 3>;
using ByCommon = cv::Matx<double, 2, kCommon>;

cv::Vec3d inCamera(const SlidePoint& point, const SlideCamera& camera) {
    return camera.turn * (cv::Vec3d(point.x, point.y, 1) - camera.place * point.q);
}

// Where a camera sees p, and how that changes with p, the camera's zoom and shear, and the lens.
struct Seen {
    cv::Point2d at;
    ByPoint byP;
    cv::Vec2d byZoom; // and by the logarithm of the focal length
    cv::Vec2d byShear;
    cv::Vec2d byBend;
};
Seen seen(const cv::Vec3d& p, const SlideCamera& camera, const SlideLens& lens) {
    const double m = lens.focal * std::exp(camera.zoom);
    const double x = m * p[0] / p[2];
    const double y = m * p[1] / p[2];
    const double rr = x * x + y * y;
    const double g = 1 + lens.bend * rr;
    const cv::Matx22d bent(g + 2 * lens.bend * x * x, 2 * lens.bend * x * y, 2 * lens.bend * x * y,
                           g + 2 * lens.bend * y * y);
    const cv::Matx22d byXY = cv::Matx22d(1, camera.shear, 0, 1) * bent;
    Seen result;
    result.at = {g * x + camera.shear * g * y, g * y};
    result.byP = byXY * ByPoint(m, 0, -x, 0, m, -y) * (1 / p[2]);
    result.byZoom = byXY * cv::Vec2d(x, y);
    result.byShear = {g * y, 0};
    result.byBend = cv::Vec2d(x + camera.shear * y, y) * rr;
    return result;
}

// The least squares of a path.
class Solver {
  public:
    Solver(const std::vector<SlideTrack>& tracks, const SlideGuess& guess, SlidePath& path)
        : tracks_(tracks), guess_(guess), path_(path),
          size_(kOwn * static_cast<int>(path.cameras.size()) + kCommon) {}

    // @param reach px of a residual from which on its weight falls
    void run(double reach, int rounds) {
        reach_ = reach;
        pathLength_ = lengthOf(path_.cameras);
        // Falls slowly: steps that fail cost as much as others.
        constexpr double kSofter = 1.5;
        constexpr double kHarder = 5;
        double damping = 1e-3;
        double cost = costOf(path_);
        for (int round = 0; round < rounds; ++round) {
            SlidePath next = path_;
            step(damping, next);
            const double now = costOf(next);
            if (!(now < cost)) {
                damping *= kHarder;
                if (damping > 1e6) break;
                continue;
            }
            const bool isDone = now > 0.99999 * cost;
            damping = std::max(1e-9, damping / kSofter);
            path_ = std::move(next);
            cost = now;
            if (isDone) break;
        }
    }

    double costOf(const SlidePath& path) const {
        double cost = 0;
        for (std::size_t t = 0; t < tracks_.size(); ++t) {
            if (path.fits[t] == 0) continue;
            for (int i = tracks_[t].first; i < tracks_[t].end(); ++i) {
                const cv::Vec2d r = residual(path, t, i);
                cost += reach_ * reach_ * std::log1p(r.dot(r) / (reach_ * reach_));
            }
            cost += square((path.points[t].q - 1) / kDepth);
        }
        for (const SlideCamera& camera : path.cameras) {
            const Own known = knownOf(camera);
            for (int k = 0; k < kOwn; ++k)
                cost += square(known[k]);
        }
        return cost + square(std::log(path.lens.focal / guess_.lens.focal) / focalRange()) +
               square(path.lens.bend / kBend);
    }

    // Residual of a track in a picture, px.
    cv::Vec2d residual(const SlidePath& path, std::size_t t, int i) const {
        const cv::Point2d at = tracks_[t].at[static_cast<std::size_t>(i - tracks_[t].first)];
        const cv::Point2d is =
            seenAt(path.points[t], path.cameras[static_cast<std::size_t>(i)], path.lens);
        return cv::Vec2d(is.x - at.x, is.y - at.y) * (1 / guess_.pixel);
    }

    static double lengthOf(const std::vector<SlideCamera>& cameras) {
        double low = cameras.front().place[0];
        double high = low;
        for (const SlideCamera& camera : cameras) {
            low = std::min(low, camera.place[0]);
            high = std::max(high, camera.place[0]);
        }
        return std::max(high - low, 1e-6);
    }

  private:
    static double square(double value) { return value * value; }
    double focalRange() const { return guess_.isLensKnown ? 0.03 : kFocal; }

    Own ranges() const {
        const double away = kAway * pathLength_ * (guess_.isTurntable ? 10 : 1);
        return {
            kTurn, guess_.isTurntable ? kOrbit : kTurn, kTurn, 10 * pathLength_, away, away, kZoom,
            kShear};
    }
    // A camera's unknowns as deviations from prior knowledge, in standard deviations.
    Own knownOf(const SlideCamera& camera) const {
        const cv::Matx33d& r = camera.turn;
        const Own is(r(2, 1), r(0, 2), r(1, 0), camera.place[0], camera.place[1], camera.place[2],
                     camera.zoom, camera.shear);
        Own known;
        const Own range = ranges();
        for (int k = 0; k < kOwn; ++k)
            known[k] = is[k] / range[k];
        return known;
    }

    // The normal equations of some tracks, whose points are eliminated.
    struct Sums {
        cv::Mat_<double> matrix;
        cv::Mat_<double> right;
    };
    struct PointSums {
        cv::Matx33d inverse;
        cv::Vec3d right;
        cv::Matx<double, kCommon, 3> common;
        std::vector<cv::Matx<double, 3, kOwn>> own; // for each picture of the track
    };

    PointSums addTrack(std::size_t t, double damping, Sums& sums) const {
        const SlideTrack& track = tracks_[t];
        const SlidePoint& point = path_.points[t];
        PointSums of;
        cv::Matx33d byPoint = cv::Matx33d::zeros();
        byPoint(2, 2) = 1 / square(kDepth);
        of.right = {0, 0, -(point.q - 1) / square(kDepth)};
        of.common = cv::Matx<double, kCommon, 3>::zeros();
        of.own.reserve(track.at.size());
        const int last = size_ - kCommon;
        for (int i = track.first; i < track.end(); ++i) {
            const SlideCamera& camera = path_.cameras[static_cast<std::size_t>(i)];
            const cv::Vec3d p = inCamera(point, camera);
            const Seen is = seen(p, camera, path_.lens);
            const cv::Vec2d r = residual(path_, t, i);
            const double weight = 1 / (1 + r.dot(r) / square(reach_));
            const double scale = 1 / guess_.pixel;
            const ByPoint byP = is.byP * scale;
            const cv::Matx33d cross(0, p[2], -p[1], -p[2], 0, p[0], p[1], -p[0], 0); // d p / d turn
            const ByPoint byTurn = byP * cross;
            const ByPoint byPlace = byP * camera.turn * -point.q;
            const cv::Matx33d pointAxes(camera.turn(0, 0), camera.turn(0, 1), 0, camera.turn(1, 0),
                                        camera.turn(1, 1), 0, camera.turn(2, 0), camera.turn(2, 1),
                                        0);
            ByPoint ofPoint = byP * pointAxes;
            const cv::Vec2d byQ = byP * camera.turn * camera.place * -1;
            ofPoint(0, 2) = byQ[0];
            ofPoint(1, 2) = byQ[1];
            ByOwn own;
            ByCommon common;
            for (int row = 0; row < 2; ++row) {
                for (int k = 0; k < 3; ++k) {
                    own(row, k) = byTurn(row, k);
                    own(row, 3 + k) = byPlace(row, k);
                }
                own(row, 6) = common(row, 0) = is.byZoom[row] * scale;
                own(row, 7) = is.byShear[row] * scale;
                common(row, 1) = is.byBend[row] * scale;
            }
            byPoint += ofPoint.t() * ofPoint * weight;
            of.right -= ofPoint.t() * r * weight;
            of.common += common.t() * ofPoint * weight;
            of.own.push_back(ofPoint.t() * own * weight);
            add(sums, kOwn * i, kOwn * i, own.t() * own * weight);
            add(sums, kOwn * i, last, own.t() * common * weight);
            add(sums, last, last, common.t() * common * weight);
            addRight(sums, kOwn * i, own.t() * r * -weight);
            addRight(sums, last, common.t() * r * -weight);
        }
        for (int k = 0; k < 3; ++k)
            byPoint(k, k) *= 1 + damping;
        of.inverse = byPoint.inv(cv::DECOMP_CHOLESKY);
        // eliminates the point
        for (std::size_t i = 0; i < of.own.size(); ++i) {
            const int at = kOwn * (track.first + static_cast<int>(i));
            const cv::Matx<double, 3, kOwn> solved = of.inverse * of.own[i] * -1.0;
            for (std::size_t j = i; j < of.own.size(); ++j)
                addProduct(sums, at, kOwn * (track.first + static_cast<int>(j)), solved, of.own[j]);
            add(sums, at, last, solved.t() * of.common.t());
            addRight(sums, at, solved.t() * of.right);
        }
        const cv::Matx<double, kCommon, 3> solved = of.common * of.inverse * -1.0;
        add(sums, last, last, solved * of.common.t());
        addRight(sums, last, solved * of.right);
        return of;
    }

    template <int M, int N>
    static void add(Sums& sums, int row, int column, const cv::Matx<double, M, N>& block) {
        for (int y = 0; y < M; ++y) {
            double* const to = sums.matrix[row + y] + column;
            for (int x = 0; x < N; ++x)
                to[x] += block(y, x);
        }
    }
    // Adds the transpose of a, times b: most of the time of a step.
    static void addProduct(Sums& sums, int row, int column, const cv::Matx<double, 3, kOwn>& a,
                           const cv::Matx<double, 3, kOwn>& b) {
        for (int y = 0; y < kOwn; ++y) {
            double* const to = sums.matrix[row + y] + column;
            for (int x = 0; x < kOwn; ++x)
                to[x] += a(0, y) * b(0, x) + a(1, y) * b(1, x) + a(2, y) * b(2, x);
        }
    }
    template <int M>
    static void addRight(Sums& sums, int row, const cv::Matx<double, M, 1>& block) {
        for (int y = 0; y < M; ++y)
            sums.right(row + y) += block(y, 0);
    }

    void step(double damping, SlidePath& next) const {
        std::vector<Sums> parts(kParts);
        std::vector<PointSums> points(tracks_.size());
        overRows(kParts, [&](int part) {
            Sums& sums = parts[static_cast<std::size_t>(part)];
            sums.matrix = cv::Mat_<double>::zeros(size_, size_);
            sums.right = cv::Mat_<double>::zeros(size_, 1);
            for (std::size_t t = static_cast<std::size_t>(part); t < tracks_.size(); t += kParts)
                if (path_.fits[t] != 0) points[t] = addTrack(t, damping, sums);
        });
        Sums& all = parts.front();
        for (std::size_t part = 1; part < parts.size(); ++part) {
            all.matrix += parts[part].matrix;
            all.right += parts[part].right;
        }
        addKnown(all);
        for (int k = 0; k < size_; ++k)
            all.matrix(k, k) *= 1 + damping;
        cv::completeSymm(all.matrix);
        cv::Mat_<double> solution;
        if (!cv::solve(all.matrix, all.right, solution, cv::DECOMP_CHOLESKY)) return;
        for (std::size_t i = 0; i < next.cameras.size(); ++i) {
            const double* const by = solution[static_cast<int>(i) * kOwn];
            SlideCamera& camera = next.cameras[i];
            camera.turn = turnBy({by[0], by[1], by[2]}) * camera.turn;
            camera.place += cv::Vec3d(by[3], by[4], by[5]);
            camera.zoom += by[6];
            camera.shear += by[7];
        }
        const int last = size_ - kCommon;
        const cv::Vec2d common(solution(last), solution(last + 1));
        next.lens.focal *= std::exp(std::clamp(common[0], -0.5, 0.5));
        next.lens.bend += common[1];
        for (std::size_t t = 0; t < tracks_.size(); ++t) {
            if (next.fits[t] == 0) continue;
            const PointSums& of = points[t];
            cv::Vec3d right = of.right - of.common.t() * common;
            for (std::size_t i = 0; i < of.own.size(); ++i) {
                const Own by(solution[kOwn * (tracks_[t].first + static_cast<int>(i))]);
                right -= of.own[i] * by;
            }
            const cv::Vec3d by = of.inverse * right;
            next.points[t].x += by[0];
            next.points[t].y += by[1];
            next.points[t].q += by[2];
        }
    }

    void addKnown(Sums& sums) const {
        const Own range = ranges();
        for (std::size_t i = 0; i < path_.cameras.size(); ++i) {
            const Own known = knownOf(path_.cameras[i]);
            for (int k = 0; k < kOwn; ++k) {
                const int at = kOwn * static_cast<int>(i) + k;
                sums.matrix(at, at) += 1 / square(range[k]);
                sums.right(at) -= known[k] / range[k];
            }
        }
        const int last = size_ - kCommon;
        sums.matrix(last, last) += 1 / square(focalRange());
        sums.right(last) -= std::log(path_.lens.focal / guess_.lens.focal) / square(focalRange());
        sums.matrix(last + 1, last + 1) += 1 / square(kBend);
        sums.right(last + 1) -= path_.lens.bend / square(kBend);
    }

    const std::vector<SlideTrack>& tracks_;
    const SlideGuess& guess_;
    SlidePath& path_;
    int size_;
    double reach_ = 1;
    double pathLength_ = 1;
};

// The mean without the largest 5 %.
double trimmedMean(std::vector<double> values) {
    constexpr double kKept = 0.95;
    std::sort(values.begin(), values.end());
    values.resize(static_cast<std::size_t>(std::ceil(kKept * static_cast<double>(values.size()))));
    if (values.empty()) return 0;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

} // namespace

cv::Matx33d turnBy(const cv::Vec3d& angles) {
    const double angle = cv::norm(angles);
    const cv::Vec3d axis = angle > 0 ? angles * (1 / angle) : cv::Vec3d(1, 0, 0);
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    const cv::Matx33d cross(0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0);
    return cv::Matx33d::eye() + cross * s + cross * cross * (1 - c);
}

cv::Point2d seenAt(const cv::Vec3d& p, const SlideCamera& camera, const SlideLens& lens) {
    return seen(p, camera, lens).at;
}

cv::Point2d seenAt(const SlidePoint& point, const SlideCamera& camera, const SlideLens& lens) {
    return seenAt(inCamera(point, camera), camera, lens);
}

void solvePath(const std::vector<SlideTrack>& tracks, const SlideGuess& guess, SlidePath& path) {
    constexpr double kFarReach = 3;    // px; first, while little is known
    constexpr double kNearReach = 0.7; // px
    constexpr double kFit = 1.5;       // px; root mean square of a track that fits
    constexpr double kUsual = 2.5;     // times the median of those: still used
    constexpr double kExact = 0.1;     // px
    path.fits.assign(tracks.size(), 1);
    Solver solver(tracks, guess, path);
    solver.run(kFarReach, 15);
    const auto squareOf = [&](std::size_t t) {
        double sum = 0;
        for (int i = tracks[t].first; i < tracks[t].end(); ++i) {
            const cv::Vec2d r = solver.residual(path, t, i);
            sum += r.dot(r);
        }
        return sum / static_cast<double>(tracks[t].at.size());
    };
    int misfits = 0;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        path.fits[t] = squareOf(t) <= kFit * kFit ? 1 : 0;
        if (path.fits[t] == 0) ++misfits;
    }
    path.misfitShare =
        tracks.empty() ? 0 : static_cast<double>(misfits) / static_cast<double>(tracks.size());
    solver.run(kNearReach, 40);
    // leaves out slightly wrong tracks, such as places where one edge passes in front of another
    std::vector<double> misses;
    for (std::size_t t = 0; t < tracks.size(); ++t)
        if (path.fits[t] != 0) misses.push_back(squareOf(t));
    const double most = kUsual * kUsual * std::max(kExact * kExact, percentileOf(misses, 0.5));
    for (std::size_t t = 0; t < tracks.size(); ++t)
        if (squareOf(t) > most) path.fits[t] = 0;
    solver.run(kNearReach, 40);

    path.residual.resize(path.cameras.size());
    for (int axis = 0; axis < 2; ++axis) {
        std::vector<std::vector<double>> squares(path.cameras.size());
        for (std::size_t t = 0; t < tracks.size(); ++t) {
            if (path.fits[t] == 0) continue;
            for (int i = tracks[t].first; i < tracks[t].end(); ++i) {
                const double r = solver.residual(path, t, i)[axis] * guess.pixel;
                squares[static_cast<std::size_t>(i)].push_back(r * r);
            }
        }
        for (std::size_t i = 0; i < squares.size(); ++i)
            path.residual[i][axis] = std::sqrt(trimmedMean(squares[i]));
    }
}

} // namespace altiro3D
