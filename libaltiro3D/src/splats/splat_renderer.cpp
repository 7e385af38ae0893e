#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "splats/splat_harmonics.hpp"
#include "splats/splat_kernels.hpp"

#include <algorithm>
#include <functional>
#include <hwy/cache_control.h>
#include <limits>
#include <numeric>

namespace altiro3D {

namespace {

constexpr double kLowPass = 0.3;           // px^2, added to each covariance (3DGS)
constexpr double kFaintest = 1.0 / 255;    // what is fainter is not drawn
constexpr double kMostSigmas = 3;          // what is farther from a splat's centre is not drawn
constexpr double kNearest = 0.2;           // distance of the nearest splats in 3DGS,
constexpr double kNearestShare = 1.0 / 20; // in scenes of a smaller scale this share of the median
constexpr double kFarToSide = 1.3;         // half angles of view beyond which shapes are frozen
constexpr double kLeast = 1e-15;           // of a distance
constexpr double kLargest = 1e15;          // covariance in px^2 of splats that make no sense

// What all views know of a splat: (9.3). One cache line.
struct alignas(64) Prepared {
    float x, y;       // its centre in the middle view, px
    float closeness;  // 1 / z
    cv::Vec3f across; // covariance xx = across[0] + a across[1] + a^2 across[2]
    cv::Vec2f mixed;  // covariance xy = mixed[0] + a mixed[1]
    float down;       // covariance yy
    float opacity;
    float limit; // -ln(255 opacity)
    cv::Vec3f colour;
    std::uint32_t index;       // in the scene
    std::uint16_t top, bottom; // rows that it reaches; none if bottom is above top
};
static_assert(sizeof(Prepared) == 64);

// The covariance of a splat in the axes of a camera.
cv::Matx33d covarianceOf(const Splat& splat, const cv::Matx33d& axes) {
    const cv::Vec4d q = splat.rotation;
    const double w = q[0];
    const double x = q[1];
    const double y = q[2];
    const double z = q[3];
    const cv::Matx33d shape =
        axes *
        cv::Matx33d(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)) *
        cv::Matx33d::diag(cv::Vec3d(splat.radii));
    return shape * shape.t();
}

// How far a splat is drawn from its centre, px.
// @param limit exponent of what is too faint @param variance in this direction, px^2
double reachOf(double limit, double variance) {
    return std::sqrt(std::min(kMostSigmas * kMostSigmas, -2 * limit) * variance);
}

// The first and the last px of 0..last that an interval holds.
int firstIn(double low, int last) {
    return cvCeil(std::clamp(low, 0.0, last + 1.0));
}
int lastIn(double high, int last) {
    return cvFloor(std::clamp(high, -1.0, static_cast<double>(last)));
}

// Calls work(i) for 0..count-1, on all threads.
template <class Work>
void overAll(std::size_t count, const Work& work) {
    constexpr std::size_t kPart = 4096;
    overRows(static_cast<int>((count + kPart - 1) / kPart), [&](int part) {
        const std::size_t first = static_cast<std::size_t>(part) * kPart;
        for (std::size_t i = first; i < std::min(count, first + kPart); ++i)
            work(i);
    });
}

// For each row or column of tiles the splats that reach it, nearest first.
struct TileLists {
    std::vector<std::uint64_t> starts; // of each tile in `splats`, and the end
    std::vector<std::uint32_t> splats;

    // The first and the end of those at a px.
    std::pair<const std::uint32_t*, const std::uint32_t*> at(int pixel) const {
        const auto tile = static_cast<std::size_t>(pixel / kSplatTile);
        return {splats.data() + starts[tile], splats.data() + starts[tile + 1]};
    }

    // @param pixels of the side that the tiles divide
    // @param first, last px that a splat reaches
    template <class Splats, class Pixel>
    void fill(int pixels, const Splats& all, Pixel Splats::value_type::*first,
              Pixel Splats::value_type::*last) {
        const auto tiles = static_cast<std::size_t>((pixels + kSplatTile - 1) / kSplatTile);
        const auto overTiles = [&](const auto& splat, const auto& take) {
            for (int tile = splat.*first / kSplatTile; tile <= splat.*last / kSplatTile; ++tile)
                take(static_cast<std::size_t>(tile));
        };
        starts.assign(tiles + 1, 0);
        for (const auto& splat : all)
            overTiles(splat, [&](std::size_t tile) { ++starts[tile + 1]; });
        std::partial_sum(starts.begin(), starts.end(), starts.begin());
        splats.resize(starts.back());
        std::vector<std::uint64_t> next(starts.begin(), starts.end() - 1);
        for (std::size_t i = 0; i < all.size(); ++i)
            overTiles(all[i], [&](std::size_t tile) {
                splats[next[tile]++] = static_cast<std::uint32_t>(i);
            });
    }
};

} // namespace

struct SplatRenderer::Impl {
    const SplatScene* scene = nullptr;
    int degree = 0;
    SplatCamera camera;
    double nearest = kNearest;
    std::vector<Prepared> splats; // nearest first
    TileLists rows;

    // Buffers of a thread.
    struct Work {
        std::vector<ProjectedSplat> splats;
        TileLists tiles;
        SplatTile tile{};
    };

    void prepare() {
        const auto placeOf = [&](std::uint32_t i) {
            return camera.axes * (cv::Vec3d(scene->splats[i].centre) - camera.eye);
        };
        std::vector<std::pair<float, std::uint32_t>> order(scene->splats.size()); // by distance
        overAll(order.size(), [&](std::size_t i) {
            const auto index = static_cast<std::uint32_t>(i);
            order[i] = {static_cast<float>(placeOf(index)[2]), index};
        });
        const auto isFar = [](double least) {
            return [least](const auto& one) {
                return static_cast<double>(one.first) > least && one.first < kLargest;
            };
        };
        order.erase(std::remove_if(order.begin(), order.end(), std::not_fn(isFar(kLeast))),
                    order.end());
        std::stable_sort(order.begin(), order.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        if (!order.empty())
            nearest = std::min(kNearest,
                               kNearestShare * static_cast<double>(order[order.size() / 2].first));
        order.erase(order.begin(), std::find_if(order.begin(), order.end(), isFar(nearest)));
        splats.resize(order.size());
        overAll(order.size(), [&](std::size_t i) {
            const std::uint32_t index = order[i].second;
            splats[i] = prepared(index, placeOf(index)).value_or(Prepared{});
        });
        splats.erase(std::remove_if(splats.begin(), splats.end(),
                                    [](const Prepared& splat) { return splat.opacity <= 0; }),
                     splats.end());
        rows.fill(camera.size.height, splats, &Prepared::top, &Prepared::bottom);
    }

    std::optional<Prepared> prepared(std::uint32_t index, const cv::Vec3d& place) const {
        const Splat& splat = scene->splats[index];
        const CameraIntrinsics& lens = camera.intrinsics;
        if (static_cast<double>(splat.opacity) < kFaintest) return std::nullopt;
        const double z = place[2];
        const double steepest = kFarToSide * camera.size.height / (2 * lens.fy) +
                                std::abs(lens.cy - (camera.size.height - 1) / 2.0) / lens.fy;
        const double e = -std::clamp(place[1] / z, -steepest, steepest);
        const cv::Matx33d s = covarianceOf(splat, camera.axes);
        const double xx = lens.fx * lens.fx / (z * z);
        const double xy = lens.fx * lens.fy / (z * z);
        const double yy = lens.fy * lens.fy / (z * z);
        const double down = yy * (s(1, 1) + 2 * e * s(1, 2) + e * e * s(2, 2));
        const double a = 1 + std::abs(place[0] / z);
        const double x = lens.fx * place[0] / z + lens.cx;
        const double y = lens.fy * place[1] / z + lens.cy;
        if (!(down < kLargest && xx * a * a * (s(0, 0) + s(2, 2)) < kLargest &&
              std::abs(x) < kLargest && std::abs(y) < kLargest))
            return std::nullopt;
        Prepared result{};
        result.x = static_cast<float>(x);
        result.y = static_cast<float>(y);
        result.closeness = static_cast<float>(1 / z);
        result.across = xx * cv::Vec3d(s(0, 0), 2 * s(0, 2), s(2, 2));
        result.mixed = xy * cv::Vec2d(s(0, 1) + e * s(0, 2), s(1, 2) + e * s(2, 2));
        result.down = static_cast<float>(down);
        result.opacity = splat.opacity;
        result.colour = splat.colour;
        result.index = index;
        const double limit = std::log(kFaintest / static_cast<double>(splat.opacity));
        result.limit = static_cast<float>(limit);
        const double reach = reachOf(limit, down + kLowPass);
        const int height = camera.size.height;
        const int top = firstIn(y - reach, height - 1);
        const int bottom = lastIn(y + reach, height - 1);
        if (top > bottom) return std::nullopt;
        result.top = static_cast<std::uint16_t>(top);
        result.bottom = static_cast<std::uint16_t>(bottom);
        return result;
    }

    // The splat in the view of an eye that is `shift` to the right: (9.2) to (9.4).
    // @param closeness 1 / distance of the focus @return false if it is not in the picture
    bool project(const Prepared& splat, double shift, double closeness, ProjectedSplat& to) const {
        const CameraIntrinsics& lens = camera.intrinsics;
        const auto near = static_cast<double>(splat.closeness);
        const double x = static_cast<double>(splat.x) - lens.fx * shift * (near - closeness);
        const double flattest = kFarToSide * camera.size.width / (2 * lens.fx) +
                                std::abs(lens.cx - (camera.size.width - 1) / 2.0) / lens.fx +
                                std::abs(shift) * closeness;
        const double side = (static_cast<double>(splat.x) - lens.cx) / lens.fx;
        const double a = -std::clamp(side - shift * near, -flattest, flattest);
        const cv::Vec3d across = splat.across;
        const cv::Vec2d mixed = splat.mixed;
        const double xx = std::max(across[0] + a * (across[1] + a * across[2]), 0.0);
        const double xy = mixed[0] + a * mixed[1];
        const auto yy = static_cast<double>(splat.down);
        const double before =
            std::max(xx * yy - xy * xy, 0.0); // rounding makes it negative for needles
        const double determinant = before + kLowPass * (xx + yy + kLowPass);
        to.opacity = splat.opacity;
        to.limit = splat.limit;
        if (scene->isAntialiased) {
            to.opacity *= static_cast<float>(std::sqrt(before / determinant));
            if (static_cast<double>(to.opacity) < kFaintest) return false;
            to.limit = static_cast<float>(std::log(kFaintest / static_cast<double>(to.opacity)));
        }
        const double reach = reachOf(static_cast<double>(to.limit), xx + kLowPass);
        to.left = firstIn(x - reach, camera.size.width - 1);
        to.right = lastIn(x + reach, camera.size.width - 1);
        if (to.left > to.right) return false;
        const double scale = 1 / determinant;
        to.x = static_cast<float>(x);
        to.y = splat.y;
        to.xx = static_cast<float>((yy + kLowPass) * scale);
        to.xy = static_cast<float>(-xy * scale);
        to.yy = static_cast<float>((xx + kLowPass) * scale);
        cv::Vec3f colour = splat.colour;
        if (degree > 0) {
            const cv::Vec3d eye = camera.eye + camera.axes.t() * cv::Vec3d(shift, 0, 0);
            const cv::Vec3d way = cv::Vec3d(scene->splats[splat.index].centre) - eye;
            const std::size_t stride = 3 * coefficientsOf(degree);
            colour += colourOfHarmonics(scene->harmonics.data() + splat.index * stride, degree,
                                        cv::Vec3f(way / cv::norm(way)));
        }
        to.red = std::max(colour[0], 0.0F);
        to.green = std::max(colour[1], 0.0F);
        to.blue = std::max(colour[2], 0.0F);
        to.distance = 1 / splat.closeness;
        to.top = splat.top;
        to.bottom = splat.bottom;
        return true;
    }

    void renderRow(int row, double shift, double closeness, Work& work, cv::Mat& picture,
                   SplatView* view) const {
        const int top = row * kSplatTile;
        const auto [first, end] = rows.at(top);
        work.splats.clear();
        for (const std::uint32_t* at = first; at < end; ++at) {
            constexpr std::ptrdiff_t kAhead = 16; // they lie anywhere in memory
            hwy::Prefetch(&splats[at[std::min(kAhead, end - at - 1)]]);
            ProjectedSplat splat{};
            if (project(splats[*at], shift, closeness, splat)) work.splats.push_back(splat);
        }
        const int width = camera.size.width;
        work.tiles.fill(width, work.splats, &ProjectedSplat::left, &ProjectedSplat::right);
        const int height = std::min(kSplatTile, camera.size.height - top);
        for (int left = 0; left < width; left += kSplatTile) {
            SplatTile& tile = work.tile;
            std::fill(std::begin(tile.clear), std::end(tile.clear), 1.0F);
            for (float* const sums : {tile.red, tile.green, tile.blue})
                std::fill(sums, sums + SplatTile::kPixels, 0.0F);
            std::fill(std::begin(tile.distance), std::end(tile.distance),
                      std::numeric_limits<float>::quiet_NaN());
            const auto [order, last] = work.tiles.at(left);
            blendSplats(work.splats.data(), order, static_cast<std::size_t>(last - order), left,
                        top, tile);
            const int columns = std::min(kSplatTile, width - left);
            for (int y = 0; y < height; ++y) {
                uchar* const to = picture.ptr(top + y, left);
                const auto code = [](float value) {
                    return static_cast<uchar>(std::min(value, 1.0F) * 255 + 0.5F);
                };
                for (int x = 0; x < columns; ++x) {
                    const auto at = static_cast<std::size_t>(y * kSplatTile + x);
                    to[3 * x] = code(tile.blue[at]);
                    to[3 * x + 1] = code(tile.green[at]);
                    to[3 * x + 2] = code(tile.red[at]);
                    if (view == nullptr) continue;
                    view->alpha.at<float>(top + y, left + x) = 1 - std::abs(tile.clear[at]);
                    view->distance.at<float>(top + y, left + x) = tile.distance[at];
                }
            }
        }
    }

    void renderAll(double shift, double closeness, cv::Mat& picture, SplatView* view) const {
        picture.create(camera.size, CV_8UC3);
        forRows(static_cast<int>(rows.starts.size()) - 1, [&](const cv::Range& part) {
            Work work;
            for (int row = part.start; row < part.end; ++row)
                renderRow(row, shift, closeness, work, picture, view);
        });
    }
};

SplatRenderer::SplatRenderer(const SplatScene& scene, const SplatCamera& camera, bool simple) {
    requireCamera(camera);
    requireSplats(scene);
    auto impl = std::make_shared<Impl>();
    impl->scene = &scene;
    impl->degree = simple ? 0 : scene.degree;
    impl->camera = camera;
    orOutOfMemory("splats", "do not fit into memory, expected a smaller scene",
                  [&] { impl->prepare(); });
    impl_ = std::move(impl);
}

void SplatRenderer::render(double shift, double focusDistance, cv::Mat& picture) const try {
    checkNumber(std::abs(shift) < kLargest, "shift", shift, "a number");
    checkNumber(focusDistance > kLeast, "focusDistance", focusDistance, "more than 1e-15");
    impl_->renderAll(shift, 1 / focusDistance, picture, nullptr);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

SplatView SplatRenderer::render() const try {
    SplatView view;
    view.distance.create(impl_->camera.size, CV_32FC1);
    view.alpha.create(impl_->camera.size, CV_32FC1);
    impl_->renderAll(0, 0, view.picture, &view);
    return view;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Size SplatRenderer::size() const {
    return impl_->camera.size;
}

double SplatRenderer::nearest() const {
    return impl_->nearest;
}

bool renderQuilt(const SplatRenderer& renderer, const SplatPlacement& placement,
                 const QuiltLayout& layout, cv::Mat& quilt,
                 const std::function<bool(int view)>& goOn) try {
    validate(layout);
    checkSize(renderer.size(), layout.tileSize, "renderer", "the view's ");
    if (quilt.size() != layout.size() || quilt.type() != CV_8UC3 ||
        layout.viewCount < layout.columns * layout.rows)
        quilt = cv::Mat(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (int i = 0; i < layout.viewCount; ++i) {
        if (goOn && !goOn(i)) return false;
        const double position = layout.viewCount > 1 ? 2.0 * i / (layout.viewCount - 1) - 1 : 0;
        cv::Mat view = quilt(layout.tile(i));
        renderer.render(position * placement.baseline, placement.focusDistance, view);
    }
    return true;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
