#include "altiro3D/quilt2native.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "native/lens_filter.hpp"
#include "native/quilt_shape.hpp"
#include "native/view_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <optional>

namespace altiro3D {

namespace {

// Two neighbouring samples along one axis and the weight of the second.
struct Tap {
    int first = 0;
    int second = 0;
    double weight = 0;
};

// @param place 0..samples - 1, clamped to them
Tap tapAt(double place, int samples) {
    const double inside = std::clamp(place, 0.0, samples - 1.0);
    const int first = static_cast<int>(inside);
    return {first, std::min(first + 1, samples - 1), inside - first};
}

// Position of the centre of pixel `index` of `count` among `samples` samples.
Tap tapOf(int index, int count, int samples, TileSampling sampling) {
    if (sampling == TileSampling::Linear)
        return tapAt((index + 0.5) / count * samples - 0.5, samples);
    const int nearest = nearestSample(index, count, samples);
    return {nearest, nearest, 0};
}

// The two views around a sub-pixel. View i is at the centre of its interval, phase (i + 0.5) /
// views; views in another order do not blend.
Tap viewsOf(const LensGeometry& g, int x, int y, int colour, int views, ViewFilter filter) {
    if (filter == ViewFilter::Linear && g.viewOrder.empty())
        return tapAt(g.phase(x, y, colour) * views - 0.5, views);
    const int nearest = g.view(x, y, colour, views);
    return {nearest, nearest, 0};
}

void requireLayout(const cv::Mat& quilt, const QuiltLayout& layout) {
    validate(layout);
    const cv::Size tile(quilt.cols / layout.columns, quilt.rows / layout.rows);
    if (tile == layout.tileSize) return;
    throw Error(ErrorCode::Mismatch, "quilt",
                "has " + sizeText(quilt.size()) + ", expected " + sizeText(layout.size()) +
                    " for " + layout.text());
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

    void renderThroughLut(const cv::Mat& source, cv::Mat& native, ChannelOrder order) const;
    void renderBlended(const cv::Mat& source, int first, cv::Mat& rows, ChannelOrder order) const;
};

// Reads and writes each px of the quilt once; memory limits the speed.
cv::Mat fitQuilt(const cv::Mat& quilt, const QuiltLayout& layout) try {
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
    overRows(wanted.height, [&](int y) {
        const uchar* in = quilt.ptr(lines[static_cast<std::size_t>(y)]);
        uchar* out = whole.ptr(y);
        for (const std::size_t source : sources) {
            std::memcpy(out, in + source, bytes);
            out += bytes;
        }
    });
    return whole;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat cropQuilt(const cv::Mat& quilt, const QuiltLayout& layout, Notes* notes) try {
    requireLayout(quilt, layout);
    const cv::Size wanted = layout.size();
    if (quilt.size() == wanted) return quilt;
    addNote(notes, NoteCode::LeftOut,
            "the quilt has " + sizeText(quilt.size()) + "; its unused " +
                std::to_string(quilt.cols - wanted.width) + " columns at the right and " +
                std::to_string(quilt.rows - wanted.height) + " rows at the top are left out");
    return quilt(cv::Rect(0, quilt.rows - wanted.height, wanted.width, wanted.height));
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
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
    // a table grows with the panel, and a print may have too many px for memory
    const bool isPrint = calibration.sheet && calibration.sheet->isPrint;
    if (!sampling.blends() && !isPrint) {
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

void Quilt2Native::render(const cv::Mat& quilt, cv::Mat& native, ChannelOrder order) const try {
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    const cv::Mat source = fitQuilt(quilt, impl_->quilt);
    checkApart(native, source, "native", "quilt");
    native.create(impl_->panelSize, CV_8UC3);
    if (impl_->table) {
        impl_->table->render(source, native, order);
    } else if (impl_->lut) {
        impl_->renderThroughLut(source, native, order);
    } else {
        impl_->renderBlended(source, 0, native, order);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void Quilt2Native::render(const cv::Mat& quilt, const RowSink& sink) const try {
    checkFunction(sink, "sink");
    if (impl_->table || impl_->lut) {
        cv::Mat native;
        render(quilt, native);
        return sink(native);
    }
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    const cv::Mat source = fitQuilt(quilt, impl_->quilt);
    const cv::Size panel = impl_->panelSize;
    const int count = rowsInBand(panel.width, panel.height);
    cv::Mat rows;
    for (int first = 0; first < panel.height; first += count) {
        rows.create(std::min(count, panel.height - first), panel.width, CV_8UC3);
        impl_->renderBlended(source, first, rows, ChannelOrder::Bgr);
        sink(rows);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

// For tables that cannot be stored as a ViewTable. Reads 4 bytes of table and 1 byte of quilt per
// sub-pixel, the latter scattered over the rows of several tiles; writes 1 byte. The table's
// bandwidth and the quilt's cache misses limit the speed.
void Quilt2Native::Impl::renderThroughLut(const cv::Mat& source, cv::Mat& native,
                                          ChannelOrder order) const {
    std::vector<const std::uint8_t*> sourceRows(static_cast<std::size_t>(source.rows));
    for (int y = 0; y < source.rows; ++y)
        sourceRows[static_cast<std::size_t>(y)] = source.ptr(y);
    const std::uint8_t* const* rowOf = sourceRows.data();
    overRows(native.rows, [&](int y) {
        std::uint8_t* out = native.ptr(y);
        const auto* first = lut->channel(colourAt(0, order)).ptr<std::uint16_t>(y);
        const auto* green = lut->channel(1).ptr<std::uint16_t>(y);
        const auto* last = lut->channel(colourAt(2, order)).ptr<std::uint16_t>(y);
        for (int i = 0; i < 2 * native.cols; i += 2, out += 3) {
            out[0] = rowOf[first[i + 1]][3 * first[i]];
            out[1] = rowOf[green[i + 1]][3 * green[i] + 1];
            out[2] = rowOf[last[i + 1]][3 * last[i] + 2];
        }
    });
}

// @param first row of the panel @param native rows from it on
void Quilt2Native::Impl::renderBlended(const cv::Mat& source, int first, cv::Mat& native,
                                       ChannelOrder order) const {
    overRows(native.rows, [&](int row) {
        const int y = first + row;
        std::uint8_t* out = native.ptr(row);
        const Tap& rowTap = rowTaps[static_cast<std::size_t>(y)];
        for (int x = 0; x < native.cols; ++x) {
            const Tap& columnTap = columnTaps[static_cast<std::size_t>(x)];
            for (int place = 0; place < 3; ++place) {
                const auto sample = [&](int view) {
                    const cv::Rect tile = quilt.tile(view);
                    const auto at = [&](int tx, int ty) -> double {
                        return source.ptr(tile.y + ty)[3 * (tile.x + tx) + place];
                    };
                    const auto line = [&](int ty) {
                        const double left = at(columnTap.first, ty);
                        return left + columnTap.weight * (at(columnTap.second, ty) - left);
                    };
                    const double upper = line(rowTap.first);
                    if (rowTap.weight == 0) return upper;
                    return upper + rowTap.weight * (line(rowTap.second) - upper);
                };
                const Tap views = viewsOf(geometry, x, y, colourAt(place, order), quilt.viewCount,
                                          sampling.views);
                double value = sample(views.first);
                if (views.weight > 0) {
                    value += views.weight * (sample(views.second) - value);
                }
                out[3 * x + place] = static_cast<std::uint8_t>(value + 0.5);
            }
        }
    });
}

void eyesToNative(const cv::Mat& left, const cv::Mat& right, const Display& display,
                  double position, cv::Mat& native) try {
    checkType(left, {CV_8UC3}, "left", "CV_8UC3 (8-bit BGR)");
    checkType(right, {CV_8UC3}, "right", "CV_8UC3 (8-bit BGR)");
    checkSize(right.size(), left.size(), "right", "the left eye's ");
    checkRange("position", position, -1, 1);
    Calibration c = display.calibration; // its lenses are moved: (2.12)
    const double aside = (lensGeometry(c, display.invert).inverted ? -0.5 : 0.5) * position;
    if (c.viewOrder.empty()) c.center += aside;
    if (c.viewOrder.empty() && c.lens) c.lens->offset -= aside * c.lens->period;
    cv::Mat both;
    cv::hconcat(left, right, both);
    Quilt2Native(c, {2, 1, left.size(), 2}, {}, display.invert).render(both, native);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

bool haveSameShape(double aspect, double other) {
    constexpr double kMaxOff = 0.05; // looks right
    return std::abs(aspect / other - 1) <= kMaxOff;
}

void applyFitToViews(const cv::Mat& quilt, const QuiltLayout& layout, double viewAspect,
                     double panelAspect, FitMode mode, cv::Mat& fitted) {
    validate(layout);
    checkSize(quilt.size(), layout.size(), "quilt");
    checkRange("viewAspect", viewAspect, 0.01, 100);
    // A tile has the shape viewAspect, independent of its px; the fit is computed for that shape.
    const int height = layout.tileSize.height;
    const cv::Size shown(std::max(1, static_cast<int>(std::lround(height * viewAspect))), height);
    const PhotoFit toShown = fitPhoto(layout.tileSize, viewAspect, shown, FitMode::Stretch);
    const PhotoFit toPanel = fitPhoto(shown, panelAspect, layout.tileSize, mode);
    cv::Mat result(quilt.size(), CV_8UC3); // not `fitted`: it may be the quilt itself
    cv::parallel_for_(cv::Range(0, layout.columns * layout.rows), [&](const cv::Range& tiles) {
        cv::Mat view;
        for (int i = tiles.start; i < tiles.end; ++i) {
            applyFit(quilt(layout.tile(i)), toShown, view);
            applyFit(view, toPanel, view);
            view.copyTo(result(layout.tile(i)));
        }
    });
    fitted = result;
}

QuiltShape::QuiltShape(const std::filesystem::path& file, const QuiltLayout& layout,
                       const Display& display, std::optional<FitMode> fit)
    : layout_(layout), panelAspect_(display.aspect()) {
    validate(layout);
    const auto name = parseQuiltName(file);
    const bool isStated = name && name->aspect;
    aspect_ = isStated ? *name->aspect
                       : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    const bool isUnasked = !fit && !haveSameShape(aspect_, panelAspect_);
    isFittedUnasked_ = isUnasked && isStated;
    isStretchedUnasked_ = isUnasked && !isStated;
    fit_ = fit.value_or(isFittedUnasked_ ? FitMode::Contain : FitMode::Stretch);
}

cv::Mat QuiltShape::apply(const cv::Mat& picture) const try {
    cv::Mat quilt = fitQuilt(picture, layout_);
    if (fit_ != FitMode::Stretch)
        applyFitToViews(quilt, layout_, aspect_, panelAspect_, fit_, quilt);
    return quilt;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat filterForLens(const cv::Mat& quilt, const QuiltLayout& layout,
                      const Calibration& calibration) try {
    validate(layout);
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    checkSize(quilt.size(), layout.size(), "quilt");
    const LensGeometry lens = lensGeometry(calibration);
    if (lens.isLying()) return quilt;
    const LensFilter filter(lens, layout.tileSize);
    cv::Mat result = quilt.clone();
    cv::parallel_for_({0, layout.viewCount}, [&](const cv::Range& views) {
        for (int view = views.start; view < views.end; ++view) {
            cv::Mat filtered;
            filter.apply(quilt(layout.tile(view)), filtered);
            filtered.copyTo(result(layout.tile(view)));
        }
    });
    return result;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
