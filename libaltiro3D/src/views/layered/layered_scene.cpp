#include "views/layered/layered_scene.hpp"

#include "base/pixel_rows.hpp"
#include "views/depth_offsets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <optional>

namespace altiro3D {

namespace {

constexpr int kMaxRun = 4096;       // px of hidden background at one tear
constexpr int kMaxHiddenWidths = 4; // limit of hidden px in a row, in widths
constexpr int kSpareColumns = 3;    // for mixed px and for px under soft borders

// Columns outside the frame that views within the reach can show.
int outsideCount(double pixels) {
    return static_cast<int>(std::ceil(std::clamp(pixels, 0.0, 1.0 * kMaxRun))) + 1;
}

// Number of px of the surface at `first` that can become visible behind the surfaces to its left.
// @param soft columns of the surface to its left in which it is visible at once
int hiddenCount(const std::vector<float>& offsets, int first, int soft, double reach, double tear) {
    const double own = static_cast<double>(offsets[static_cast<std::size_t>(first)]);
    if (first == 0) return outsideCount(-own * reach);
    double nearest = own;
    int count = 0;
    while (count < kMaxRun) {
        const int x = std::max(first - 1 - count, 0);
        const double front = static_cast<double>(offsets[static_cast<std::size_t>(x)]);
        if (front <= own + tear) break;
        nearest = std::max(nearest, front);
        if (count > reach * (nearest - own) + kSpareColumns + soft) break;
        ++count;
    }
    return count;
}

// Prepares the strips beside a row's surfaces and fills them with the colour of the adjacent px.
// @param mirrored whether surfaces and offsets are those of the mirrored row; bgr is never mirrored
void prepareStrips(const std::uint8_t* bgr, bool mirrored, const std::vector<float>& offsets,
                   const LayeredSettings& options, LayeredRow& row) {
    const double tear = options.tearStep();
    const auto offsetAt = [&](int x) {
        return static_cast<double>(offsets[static_cast<std::size_t>(x)]);
    };
    std::int64_t hidden = 0;
    int soft = 0;
    for (LayeredSurface& surface : row.surfaces) {
        surface.hidden = hiddenCount(offsets, surface.first, soft, options.reachPixels, tear);
        hidden += surface.hidden;
        soft = surface.softRight;
    }
    const auto width = static_cast<std::int64_t>(offsets.size());
    if (hidden > kMaxHiddenWidths * width + kMaxRun) { // noisy depth: limit the memory
        const std::int64_t longest =
            kMaxHiddenWidths * width / static_cast<std::int64_t>(row.surfaces.size());
        for (LayeredSurface& surface : row.surfaces)
            surface.hidden = std::min(surface.hidden, static_cast<int>(longest));
    }
    int painted = 0;
    for (std::size_t i = 0; i < row.surfaces.size(); ++i) {
        LayeredSurface& surface = row.surfaces[i];
        if (i + 1 == row.surfaces.size()) {
            surface.beyond = outsideCount(offsetAt(surface.last) * options.reachPixels);
        } else if (offsetAt(row.surfaces[i + 1].first) > offsetAt(surface.last)) {
            surface.beyond = row.surfaces[i + 1].first - surface.last; // the mixed px and one more
        }
        surface.strip = painted;
        painted += surface.stripLength();
    }
    row.strips.resize(4 * static_cast<std::size_t>(painted));
    const auto pixel = [&](int x) {
        return bgr + 3 * (mirrored ? static_cast<std::ptrdiff_t>(width) - 1 - x : x);
    };
    for (const LayeredSurface& surface : row.surfaces) {
        std::uint8_t* strip = row.strips.data() + 4 * static_cast<std::ptrdiff_t>(surface.strip);
        for (int k = 0; k < surface.stripLength(); ++k)
            std::memcpy(strip + 4 * static_cast<std::ptrdiff_t>(k),
                        pixel(k <= surface.hidden ? surface.first : surface.last), 3);
    }
}

// The surfaces of the mirrored row.
void mirrorSurfaces(int width, const std::vector<LayeredSurface>& surfaces,
                    std::vector<LayeredSurface>& mirrored) {
    mirrored.resize(surfaces.size());
    std::transform(surfaces.rbegin(), surfaces.rend(), mirrored.begin(),
                   [width](const LayeredSurface& surface) {
                       LayeredSurface other;
                       other.first = width - 1 - surface.last;
                       other.last = width - 1 - surface.first;
                       other.leftExtra = surface.rightExtra;
                       other.rightExtra = surface.leftExtra;
                       other.softLeft = surface.softRight;
                       other.softRight = surface.softLeft;
                       return other;
                   });
}

// Writes the tables of one row in one direction.
class TableWriter {
  public:
    explicit TableWriter(const LayeredScene& scene)
        : width_(scene.width), reach_(scene.reachColumns), reachPixels_(scene.reachPixels),
          inOrder_(scene.inOrder) {}

    void write(const std::vector<float>& offsets, double scale, const LayeredRow& row,
               std::int16_t* words, std::int16_t* surfaceOf, std::uint16_t* freeUpTo) const {
        const auto perUnit = static_cast<float>(1 / scale);
        const auto largest = static_cast<float>(kMaxOffset);
        for (int x = 0; x < width_; ++x) {
            const float units = std::abs(offsets[static_cast<std::size_t>(x)]) * perUnit + 0.5F;
            const int whole = static_cast<int>(std::min(units, largest));
            const bool negative = offsets[static_cast<std::size_t>(x)] < 0;
            words[x] = columnWord(negative ? -whole : whole, false);
        }
        for (std::size_t k = 0; k < row.surfaces.size(); ++k) {
            const LayeredSurface& surface = row.surfaces[k];
            const int end = k + 1 < row.surfaces.size() ? row.surfaces[k + 1].first : width_;
            for (int x = surface.last; x < end; ++x) // with mixed px, which belong to no surface
                words[x] = static_cast<std::int16_t>(words[x] | kLastFlag);
            std::fill(surfaceOf + surface.first, surfaceOf + end, static_cast<std::int16_t>(k));
        }
        writeFreeUpTo(words, static_cast<float>(scale), row, freeUpTo);
    }

  private:
    void writeFreeUpTo(const std::int16_t* words, float scale, const LayeredRow& row,
                       std::uint16_t* freeUpTo) const {
        std::fill_n(freeUpTo, width_, static_cast<std::uint16_t>(inOrder_ ? kFreeForAll : 0));
        if (!inOrder_) return;
        for (const LayeredSurface& surface : row.surfaces) {
            const float offset = scale * static_cast<float>(wordOffset(words[surface.first]));
            const float border = surface.hidden > 0 ? 0 : 1 + surface.leftExtra;
            for (int x = surface.first - 1; x >= 0 && x + reach_ >= surface.first; --x) {
                // a little less, for rounding errors
                const float way = static_cast<float>(surface.first - x) - border - 0.01F;
                if (way > 0 && way >= offset * reachPixels_) break;
                const float shift = way > 0 ? way / offset : 0;
                const int units = static_cast<int>(shift / reachPixels_ * kFreeForAll);
                freeUpTo[x] = static_cast<std::uint16_t>(std::min(int{freeUpTo[x]}, units));
            }
        }
    }

    static constexpr int kFreeForAll = 65535;

    int width_;
    int reach_;
    float reachPixels_;
    bool inOrder_;
};

bool isStill(const cv::Mat& depth, int row, double focus) {
    const auto* values = depth.ptr<float>(row);
    return std::all_of(values, values + depth.cols,
                       [&](float value) { return offsetFromFocus(value, focus) == 0; });
}

// Sets what lies beside both directions of a row of a table.
void padTable(cv::Mat& table, int y, int width, std::int16_t value) {
    auto* const row = table.ptr<std::int16_t>(y);
    auto* const end = row + table.cols;
    std::fill_n(row, kTablePadding, value);
    std::fill_n(row + kTablePadding + width, 2 * kTablePadding, value);
    std::fill(row + 3 * kTablePadding + 2 * width, end, value);
}

} // namespace

LayeredTables LayeredScene::tables(int row) const {
    LayeredTables result;
    result.words = words.ptr<std::int16_t>(row) + kTablePadding;
    result.surfaces = surfaceOf.ptr<std::int16_t>(row) + kTablePadding;
    result.freeUpTo = freeUpTo.ptr<std::uint16_t>(row) + kTablePadding;
    if (!shares.empty()) result.shares = shares.ptr<std::uint8_t>(row);
    result.stride = stride();
    result.width = width;
    result.scale = scale;
    result.reachPixels = reachPixels;
    return result;
}

LayeredScene layeredScene(const cv::Mat& photo, const cv::Mat& depth, double focus,
                          const LayeredSettings& options) {
    const auto rowCount = static_cast<std::size_t>(photo.rows);
    LayeredScene scene;
    scene.width = photo.cols;
    scene.still.resize(rowCount);
    for (int y = 0; y < photo.rows; ++y)
        scene.still[static_cast<std::size_t>(y)] = isStill(depth, y, focus) ? 1 : 0;
    scene.flat = std::all_of(scene.still.begin(), scene.still.end(),
                             [](std::uint8_t still) { return still != 0; });
    if (scene.flat) return scene;
    const double largest = std::max(focus, 1 - focus);
    const double scale = largest / kMaxOffset;
    const int reach = static_cast<int>(
        std::min(std::ceil(options.reachPixels * largest) + kEndReach, 1.0 * photo.cols));
    scene.scale = static_cast<float>(scale);
    scene.reachPixels = static_cast<float>(options.reachPixels);
    scene.reachColumns = reach;
    scene.inOrder = options.tearPixels <= 1; // with more, a surface may fold
    scene.freeUpTo.create(photo.rows, 2 * scene.stride(), CV_16UC1);
    const std::array<cv::Mat*, 2> padded = {&scene.words, &scene.surfaceOf};
    for (cv::Mat* table : padded)
        table->create(photo.rows, 2 * scene.stride() + static_cast<int>(kRowPadding), CV_16SC1);
    for (std::vector<LayeredRow>& rows : scene.rows)
        rows.resize(rowCount);
    std::optional<BorderShares> borders;
    if (options.softBorders) {
        borders.emplace(depth, focus, options.mixedPixels);
        scene.shares.create(photo.rows, photo.cols, CV_8UC1);
    }
    cv::parallel_for_(cv::Range(0, photo.rows), [&](const cv::Range& range) {
        std::vector<float> offsets(static_cast<std::size_t>(photo.cols));
        const TableWriter writer(scene);
        const std::int16_t outside = columnWord(0, true);
        for (int y = range.start; y < range.end; ++y) {
            const auto* depthRow = depth.ptr<float>(y);
            const auto* bgr = photo.ptr<std::uint8_t>(y);
            offsetsFromFocus(depthRow, offsets.size(), focus, offsets.data());
            for (cv::Mat* table : padded)
                padTable(*table, y, photo.cols, table == &scene.words ? outside : 0);
            LayeredRow& plain = scene.rows[0][static_cast<std::size_t>(y)];
            LayeredRow& mirrored = scene.rows[1][static_cast<std::size_t>(y)];
            cutSurfaces(bgr, offsets, options, plain.surfaces);
            if (borders)
                borders->find(y, offsets, plain.surfaces, scene.shares.ptr<std::uint8_t>(y));
            mirrorSurfaces(photo.cols, plain.surfaces, mirrored.surfaces);
            int begin = kTablePadding;
            for (LayeredRow* row : {&plain, &mirrored}) {
                if (row == &mirrored) std::reverse(offsets.begin(), offsets.end());
                prepareStrips(bgr, row == &mirrored, offsets, options, *row);
                writer.write(offsets, scale, *row, scene.words.ptr<std::int16_t>(y) + begin,
                             scene.surfaceOf.ptr<std::int16_t>(y) + begin,
                             scene.freeUpTo.ptr<std::uint16_t>(y) + begin);
                begin += scene.stride();
            }
        }
    });
    if (options.fill != LayeredFill::BackgroundLayer) return scene;
    overRows(2, [&](int direction) { paintBackground(photo, focus, options, direction, scene); });
    return scene;
}

} // namespace altiro3D
