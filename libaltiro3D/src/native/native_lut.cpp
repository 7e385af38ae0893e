#include "altiro3D/native_lut.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"
#include "display/lens_phase.hpp"
#include "native/native_lut_tables.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace altiro3D {

namespace {

// Requests large pages for memory that is not written yet. Without them, a run of photo2native with
// a map for 3840 x 2160 px takes 12 % more time. The system may refuse.
void requestLargePages([[maybe_unused]] const cv::Mat& picture) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
    const std::uintptr_t begin =
        (reinterpret_cast<std::uintptr_t>(picture.data) + kPage - 1) / kPage * kPage;
    const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(picture.dataend) / kPage * kPage;
    if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

} // namespace

void NativeLutTables::allocate() {
    try {
        const int rows = panelSize.height;
        const cv::Mat all(3 * rows, panelSize.width, CV_16UC2);
        requestLargePages(all);
        for (int channel = 0; channel < 3; ++channel) {
            channels[static_cast<std::size_t>(channel)] =
                all.rowRange(channel * rows, (channel + 1) * rows);
        }
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
    auto tables = std::make_shared<NativeLutTables>();
    tables->panelSize = {g.panelWidth, g.panelHeight};
    tables->quilt = quilt;
    tables->calibrationFingerprint = fingerprint(calibration);
    tables->serial = calibration.serial;
    tables->inverted = g.inverted;
    tables->allocate();

    const LensPhases phases(g);
    std::vector<cv::Point> tiles; // upper left corners
    for (int view = 0; view < quilt.columns * quilt.rows; ++view)
        tiles.push_back(quilt.tile(view).tl());
    const auto width = static_cast<std::size_t>(g.panelWidth);
    std::vector<int> inTile(width); // X inside a tile
    for (int x = 0; x < g.panelWidth; ++x) {
        const int seen = g.mirrorX ? g.panelWidth - 1 - x : x;
        inTile[static_cast<std::size_t>(x)] =
            nearestSample(seen, g.panelWidth, quilt.tileSize.width);
    }
    cv::parallel_for_(cv::Range(0, g.panelHeight), [&](const cv::Range& rows) {
        std::vector<std::uint32_t> views(width);
        for (int channel = 0; channel < 3; ++channel) {
            cv::Mat& table = tables->channels[static_cast<std::size_t>(channel)];
            for (int y = rows.start; y < rows.end; ++y) {
                const int seen = g.mirrorY ? g.panelHeight - 1 - y : y;
                const int yInTile = nearestSample(seen, g.panelHeight, quilt.tileSize.height);
                phases.viewsOfRow(y, channel, quilt.viewCount, views.data());
                auto* out = table.ptr<std::uint16_t>(y);
                for (std::size_t x = 0; x < width; ++x) {
                    const cv::Point& tile = tiles[views[x]];
                    *out++ = static_cast<std::uint16_t>(tile.x + inTile[x]);
                    *out++ = static_cast<std::uint16_t>(tile.y + yInTile);
                }
            }
        }
    });
    tables_ = std::move(tables);
}

NativeLut::NativeLut(std::shared_ptr<const NativeLutTables> tables) : tables_(std::move(tables)) {}

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
