#include "altiro3D/native_lut.hpp"

#include "altiro3D/error.hpp"
#include "native_lut_tables.hpp"
#include "text.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

using Point16 = cv::Vec<std::uint16_t, 2>;

// Column tables: what of Eq. (box formula, docs/mathematics.md section 1) depends on x alone.
struct ColumnTables {
    std::vector<double> u[3];          // u + k * subp, or u + cell offset, per channel
    std::vector<double> rowOffset[3];  // cell offset upward / H per channel; empty on stripes
    std::vector<std::uint16_t> inTile; // X inside a tile
};

// Rows whose cells follow the same pattern share column tables: patterns repeat after 4 rows.
constexpr int kRowPatterns = 4;

ColumnTables columnTables(const LensGeometry& g, int tileWidth, int rowPattern) {
    ColumnTables t;
    const auto width = static_cast<std::size_t>(g.panelWidth);
    for (int channel = 0; channel < 3; ++channel) {
        const int k = g.blueFirst ? 2 - channel : channel;
        t.u[channel].resize(width);
        if (!g.cells.empty()) t.rowOffset[channel].resize(width);
        for (int x = 0; x < g.panelWidth; ++x) {
            const double u = (x + 0.5) / g.panelWidth;
            const auto i = static_cast<std::size_t>(x);
            if (g.cells.empty()) {
                t.u[channel][i] = u + k * g.subpixelStep;
                continue;
            }
            // any row with this pattern will do; count from the bottom as the cells do
            const int y = g.panelHeight - 1 - rowPattern;
            const SubpixelCell& cell = g.cells[static_cast<std::size_t>(g.cellIndex(x, y))];
            const auto c = static_cast<std::size_t>(k);
            t.u[channel][i] = u + (g.mirrorX ? -1 : 1) * cell.x[c] / g.panelWidth;
            t.rowOffset[channel][i] = cell.y[c] / g.panelHeight;
        }
    }
    t.inTile.resize(width);
    for (int x = 0; x < g.panelWidth; ++x) {
        const int seen = g.mirrorX ? g.panelWidth - 1 - x : x;
        t.inTile[static_cast<std::size_t>(x)] =
            static_cast<std::uint16_t>(nearestSample(seen, g.panelWidth, tileWidth));
    }
    return t;
}

// Reads the column tables, writes one row of one channel's table; bound by the double arithmetic
// and by the write of 4 bytes per sub-pixel.
void buildRow(const LensGeometry& g, const ColumnTables& t, const std::vector<Point16>& tileOrigin,
              int views, int y, int channel, int yInTile, Point16* row) {
    const double v = 1 - (y + 0.5) / g.panelHeight;
    const double* u = t.u[channel].data();
    const double* offset = g.cells.empty() ? nullptr : t.rowOffset[channel].data();
    const double stripeShift = v * g.tilt;
    for (int x = 0; x < g.panelWidth; ++x) {
        const double shift = offset != nullptr ? (v + offset[x]) * g.tilt : stripeShift;
        const double a = (u[x] + shift) * g.periodsPerWidth - g.center;
        const int truncated = static_cast<int>(a); // |a| is limited by validate(Calibration)
        double z = a - (truncated - (a < truncated ? 1 : 0)); // a - floor(a)
        if (g.inverted) z = 1 - z;
        const Point16& origin =
            tileOrigin[static_cast<std::size_t>(LensGeometry::viewOfPhase(z, views))];
        row[x] =
            Point16(static_cast<std::uint16_t>(origin[0] + t.inTile[static_cast<std::size_t>(x)]),
                    static_cast<std::uint16_t>(origin[1] + yInTile));
    }
}

} // namespace

void NativeLut::Tables::allocate() {
    try {
        for (cv::Mat& channel : channels)
            channel.create(panelSize, CV_16UC2);
    } catch (const cv::Exception&) {
        throw Error(ErrorCode::OutOfMemory, "look-up table",
                    "no memory for a panel of " + sizeText(panelSize) + " px, expected " +
                        std::to_string(12LL * panelSize.width * panelSize.height / 1000000) +
                        " MB to be free");
    }
}

NativeLut::NativeLut(const Calibration& calibration, const QuiltLayout& quilt, InvertViews invert) {
    validate(quilt);
    const LensGeometry g = lensGeometry(calibration, invert);
    auto tables = std::make_shared<Tables>();
    tables->panelSize = {g.panelWidth, g.panelHeight};
    tables->quilt = quilt;
    tables->calibrationFingerprint = fingerprint(calibration);
    tables->serial = calibration.serial;
    tables->inverted = g.inverted;
    tables->allocate();

    const int patterns = g.cells.empty() ? 1 : kRowPatterns;
    std::vector<ColumnTables> columns;
    for (int pattern = 0; pattern < patterns; ++pattern) {
        columns.push_back(columnTables(g, quilt.tileSize.width, pattern));
    }
    std::vector<Point16> tileOrigin;
    for (int view = 0; view < quilt.viewCount; ++view) {
        const cv::Point origin = quilt.tile(view).tl();
        tileOrigin.emplace_back(static_cast<std::uint16_t>(origin.x),
                                static_cast<std::uint16_t>(origin.y));
    }
    cv::parallel_for_(cv::Range(0, g.panelHeight), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const auto pattern = static_cast<std::size_t>((g.panelHeight - 1 - y) % patterns);
            const int seen = g.mirrorY ? g.panelHeight - 1 - y : y;
            const int yInTile = nearestSample(seen, g.panelHeight, quilt.tileSize.height);
            for (int channel = 0; channel < 3; ++channel) {
                buildRow(g, columns[pattern], tileOrigin, quilt.viewCount, y, channel, yInTile,
                         tables->channels[static_cast<std::size_t>(channel)].ptr<Point16>(y));
            }
        }
    });
    tables_ = std::move(tables);
}

NativeLut::NativeLut(std::shared_ptr<const Tables> tables) : tables_(std::move(tables)) {}

cv::Size NativeLut::panelSize() const {
    return tables_->panelSize;
}

const QuiltLayout& NativeLut::quilt() const {
    return tables_->quilt;
}

std::uint64_t NativeLut::calibrationFingerprint() const {
    return tables_->calibrationFingerprint;
}

const std::string& NativeLut::serial() const {
    return tables_->serial;
}

bool NativeLut::inverted() const {
    return tables_->inverted;
}

const cv::Mat& NativeLut::channel(int channel) const {
    if (channel < 0 || channel > 2) {
        throw Error(ErrorCode::InvalidArgument, "channel",
                    "is " + std::to_string(channel) + ", expected 0 red, 1 green or 2 blue");
    }
    return tables_->channels[static_cast<std::size_t>(channel)];
}

void requireSameDisplay(const NativeLut& lut, const std::string& lutName,
                        const Calibration& calibration, const std::string& calibrationName) {
    const std::uint64_t wanted = fingerprint(calibration);
    if (lut.calibrationFingerprint() == wanted) return;
    const auto name = [](const std::string& serial, std::uint64_t print) {
        return (serial.empty() ? std::string("a display without serial number") : serial) + " (" +
               fingerprintText(print) + ")";
    };
    throw Error(ErrorCode::Mismatch, lutName,
                "was built for " + name(lut.serial(), lut.calibrationFingerprint()) + ", but " +
                    calibrationName + " is the calibration of " + name(calibration.serial, wanted) +
                    "; expected a map built from it");
}

} // namespace altiro3D
