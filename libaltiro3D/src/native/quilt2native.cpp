#include "altiro3D/quilt2native.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "native/native_lut_tables.hpp"
#include "native/view_table.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <optional>

namespace altiro3D {

namespace {

constexpr int kBgrOf[3] = {2, 1, 0}; // index of red, green, blue in a BGR pixel

// Two neighbouring samples along one axis and the weight of the second.
struct Tap {
    int first = 0;
    int second = 0;
    double weight = 0;
};

// Position of the centre of pixel `index` of `count` among `samples` samples, clamped to them.
Tap tapOf(int index, int count, int samples, TileSampling sampling) {
    Tap tap;
    if (sampling == TileSampling::Nearest) {
        tap.first = tap.second = nearestSample(index, count, samples);
        return tap;
    }
    const double place = std::clamp((index + 0.5) / count * samples - 0.5, 0.0, samples - 1.0);
    tap.first = static_cast<int>(place);
    tap.second = std::min(tap.first + 1, samples - 1);
    tap.weight = place - tap.first;
    return tap;
}

// The two views around a phase. View i is at the centre of its interval, phase (i + 0.5) / views.
Tap viewsOf(double phase, int views, ViewFilter filter) {
    Tap tap;
    if (filter == ViewFilter::Nearest) {
        tap.first = tap.second = LensGeometry::viewOfPhase(phase, views);
        return tap;
    }
    const double place = std::clamp(phase * views - 0.5, 0.0, views - 1.0);
    tap.first = static_cast<int>(place);
    tap.second = std::min(tap.first + 1, views - 1);
    tap.weight = place - tap.first;
    return tap;
}

void requireLayout(const cv::Mat& quilt, const QuiltLayout& layout) {
    validate(layout);
    const cv::Size tile(quilt.cols / layout.columns, quilt.rows / layout.rows);
    if (tile == layout.tileSize) return;
    throw Error(ErrorCode::Mismatch, "quilt",
                "has " + sizeText(quilt.size()) + " px, expected " + sizeText(layout.size()) +
                    " px for " + layout.text());
}

// For each of `wanted` px of `views` equal views: the nearest of `samples` px that lies in the view
// as a whole. A px on the border of two views of fractional size shows both.
std::vector<int> samplesOfViews(int wanted, int views, int samples) {
    std::vector<int> sources;
    for (int i = 0; i < wanted; ++i) {
        const std::int64_t view = i / (wanted / views);
        const auto first = static_cast<int>((view * samples + views - 1) / views);
        const auto last = static_cast<int>((view + 1) * samples / views - 1);
        const int nearest = nearestSample(i, wanted, samples);
        sources.push_back(first <= last ? std::clamp(nearest, first, last) : nearest);
    }
    return sources;
}

} // namespace

struct Quilt2Native::Impl {
    QuiltLayout quilt;
    cv::Size panelSize;
    std::optional<ViewTable> table; // absent if blending, and if `lut` is set
    std::optional<NativeLut> lut;   // set if it cannot be stored as a ViewTable
    LensGeometry geometry;
    QuiltSampling sampling;
    std::vector<Tap> columnTaps; // x inside a tile, per panel column
    std::vector<Tap> rowTaps;    // y inside a tile, per panel row

    void renderThroughLut(const cv::Mat& source, cv::Mat& native) const;
    void renderBlended(const cv::Mat& source, cv::Mat& native) const;
};

// Reads and writes each px of the quilt once; memory limits the speed.
cv::Mat fitQuilt(const cv::Mat& quilt, const QuiltLayout& layout) {
    requireLayout(quilt, layout);
    const cv::Size wanted = layout.size();
    if (quilt.size() == wanted) return quilt;
    cv::Mat whole(wanted, quilt.type());
    const std::size_t bytes = quilt.elemSize();
    const std::vector<int> columns = samplesOfViews(wanted.width, layout.columns, quilt.cols);
    const std::vector<int> lines = samplesOfViews(wanted.height, layout.rows, quilt.rows);
    std::vector<std::size_t> sources; // per column, in bytes
    for (const int column : columns)
        sources.push_back(static_cast<std::size_t>(column) * bytes);
    cv::parallel_for_(cv::Range(0, wanted.height), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const uchar* in = quilt.ptr(lines[static_cast<std::size_t>(y)]);
            uchar* out = whole.ptr(y);
            for (const std::size_t source : sources) {
                std::memcpy(out, in + source, bytes);
                out += bytes;
            }
        }
    });
    return whole;
}

cv::Mat cropQuilt(const cv::Mat& quilt, const QuiltLayout& layout, Notes* notes) {
    requireLayout(quilt, layout);
    const cv::Size wanted = layout.size();
    if (quilt.size() == wanted) return quilt;
    if (notes != nullptr) {
        notes->push_back(
            {NoteCode::LeftOut,
             "the quilt has " + sizeText(quilt.size()) + " px; its unused " +
                 std::to_string(quilt.cols - wanted.width) + " columns at the right and " +
                 std::to_string(quilt.rows - wanted.height) + " rows at the top are left out"});
    }
    return quilt(cv::Rect(0, quilt.rows - wanted.height, wanted.width, wanted.height));
}

Quilt2Native::Quilt2Native(NativeLut lut) {
    auto impl = std::make_shared<Impl>();
    impl->quilt = lut.quilt();
    impl->panelSize = lut.panelSize();
    impl->table = viewTable(lut);
    if (!impl->table) impl->lut = std::move(lut);
    impl_ = std::move(impl);
}

Quilt2Native::Quilt2Native(const Calibration& calibration, const QuiltLayout& quilt,
                           QuiltSampling sampling, InvertViews invert) {
    auto impl = std::make_shared<Impl>();
    impl->quilt = quilt;
    impl->sampling = sampling;
    validate(quilt);
    const LensGeometry g = lensGeometry(calibration, invert);
    impl->panelSize = {g.panelWidth, g.panelHeight};
    if (sampling.views == ViewFilter::Nearest && sampling.inTile == TileSampling::Nearest) {
        impl->table = viewTable(g, quilt);
        if (!impl->table) impl->lut = NativeLut(calibration, quilt, invert);
    } else {
        for (int x = 0; x < g.panelWidth; ++x) {
            impl->columnTaps.push_back(tapOf(g.mirrorX ? g.panelWidth - 1 - x : x, g.panelWidth,
                                             quilt.tileSize.width, sampling.inTile));
        }
        for (int y = 0; y < g.panelHeight; ++y) {
            impl->rowTaps.push_back(tapOf(g.mirrorY ? g.panelHeight - 1 - y : y, g.panelHeight,
                                          quilt.tileSize.height, sampling.inTile));
        }
        impl->geometry = g;
    }
    impl_ = std::move(impl);
}

cv::Size Quilt2Native::panelSize() const {
    return impl_->panelSize;
}

const QuiltLayout& Quilt2Native::quilt() const {
    return impl_->quilt;
}

void Quilt2Native::render(const cv::Mat& quilt, cv::Mat& native) const {
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    const cv::Mat source = fitQuilt(quilt, impl_->quilt);
    checkApart(native, source, "native", "quilt");
    native.create(impl_->panelSize, CV_8UC3);
    if (impl_->table) {
        impl_->table->render(source, native);
    } else if (impl_->lut) {
        impl_->renderThroughLut(source, native);
    } else {
        impl_->renderBlended(source, native);
    }
}

// For tables that cannot be stored as a ViewTable. Reads 4 bytes of table and 1 byte of quilt per
// sub-pixel, the latter scattered over the rows of several tiles; writes 1 byte. The table's
// bandwidth and the quilt's cache misses limit the speed.
void Quilt2Native::Impl::renderThroughLut(const cv::Mat& source, cv::Mat& native) const {
    std::vector<const std::uint8_t*> sourceRows(static_cast<std::size_t>(source.rows));
    for (int y = 0; y < source.rows; ++y)
        sourceRows[static_cast<std::size_t>(y)] = source.ptr(y);
    const std::uint8_t* const* rowOf = sourceRows.data();
    cv::parallel_for_(cv::Range(0, native.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            std::uint8_t* out = native.ptr(y);
            const auto* red = lut->channel(0).ptr<std::uint16_t>(y);
            const auto* green = lut->channel(1).ptr<std::uint16_t>(y);
            const auto* blue = lut->channel(2).ptr<std::uint16_t>(y);
            for (int i = 0; i < 2 * native.cols; i += 2, out += 3) {
                out[0] = rowOf[blue[i + 1]][3 * blue[i]];
                out[1] = rowOf[green[i + 1]][3 * green[i] + 1];
                out[2] = rowOf[red[i + 1]][3 * red[i] + 2];
            }
        }
    });
}

void Quilt2Native::Impl::renderBlended(const cv::Mat& source, cv::Mat& native) const {
    cv::parallel_for_(cv::Range(0, native.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            std::uint8_t* out = native.ptr(y);
            const Tap& rowTap = rowTaps[static_cast<std::size_t>(y)];
            for (int x = 0; x < native.cols; ++x) {
                const Tap& columnTap = columnTaps[static_cast<std::size_t>(x)];
                for (int channel = 0; channel < 3; ++channel) {
                    const int place = kBgrOf[channel];
                    const auto sample = [&](int view) {
                        const cv::Rect tile = quilt.tile(view);
                        const auto at = [&](int tx, int ty) -> double {
                            return source.ptr(tile.y + ty)[3 * (tile.x + tx) + place];
                        };
                        const auto row = [&](int ty) {
                            const double left = at(columnTap.first, ty);
                            return left + columnTap.weight * (at(columnTap.second, ty) - left);
                        };
                        const double upper = row(rowTap.first);
                        return upper + rowTap.weight * (row(rowTap.second) - upper);
                    };
                    const Tap views =
                        viewsOf(geometry.phase(x, y, channel), quilt.viewCount, sampling.views);
                    double value = sample(views.first);
                    if (views.weight > 0) {
                        value += views.weight * (sample(views.second) - value);
                    }
                    out[3 * x + place] = static_cast<std::uint8_t>(value + 0.5);
                }
            }
        }
    });
}

} // namespace altiro3D
