#pragma once

#include "altiro3D/depth_network.hpp"
#include "altiro3D/native_lut.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace altiro3D {

/// Colour of a channel. @param channel 0..2 @param order of the channels
/// @return 0 red, 1 green, 2 blue
inline int colourAt(int channel, ChannelOrder order) {
    return order == ChannelOrder::Rgb ? channel : 2 - channel;
}

/// A look-up table in a quarter of the memory. In a table built from a calibration, all sub-pixels
/// of a panel column (row) have the same column (row) inside the tile, so only the view of each
/// sub-pixel is stored.
struct ViewTable {
    cv::Size panelSize;
    QuiltLayout quilt;
    cv::Mat views; ///< [3 panel rows x panel cols, CV_8U or CV_16U]: row 3 y + c is colour c of the
                   ///< panel's row y; blue, green, red. CV_8U up to 256 tiles.
    std::vector<std::uint32_t> columns; ///< X inside the tile, per panel column.
    std::vector<std::uint32_t> rows;    ///< Y inside the tile, per panel row.

    /// Renders a Native from a quilt.
    /// @param source [quilt.size(), CV_8UC3]
    /// @param native [panelSize, CV_8UC3]
    /// @param order of the channels of both
    void render(const cv::Mat& source, cv::Mat& native, ChannelOrder order) const;
};

/// Builds the table of a display, equivalent to NativeLut; none beyond 65536 tiles.
/// @param geometry the display
/// @param quilt a valid layout
std::optional<ViewTable> viewTable(const LensGeometry& geometry, const QuiltLayout& quilt);

/// Converts a NativeLut; none if it has another form, for example from another program.
std::optional<ViewTable> viewTable(const NativeLut& lut);

/// Prefetches the next row of all tiles into the cache in small portions. The row is in as many
/// places as there are tiles, too many for the processor's prefetcher.
class RowFetcher {
  public:
    /// @param tileRows start of the current row in each tile; must remain valid
    /// @param toNext distance from there to the row to prefetch, bytes
    /// @param tileBytes length of a tile's row
    /// @param portions number of fetch() calls that prefetch everything
    void start(const std::vector<const std::uint8_t*>& tileRows, std::ptrdiff_t toNext,
               std::size_t tileBytes, std::size_t portions) {
        tile_ = tileRows.data();
        end_ = tile_ + tileRows.size();
        toNext_ = toNext;
        tileBytes_ = tileBytes;
        at_ = 0;
        const std::size_t lines = tileRows.size() * ((tileBytes - 1) / kCacheLine + 2);
        perPortion_ = (lines + portions - 1) / portions;
    }

    void fetch() {
        for (std::size_t i = 0; i < perPortion_ && tile_ != end_; ++i) {
            hwy::Prefetch(*tile_ + toNext_ + std::min(at_, tileBytes_ - 1));
            at_ += kCacheLine;
            if (at_ >= tileBytes_ + kCacheLine) { // the last byte may be in another line
                at_ = 0;
                ++tile_;
            }
        }
    }

  private:
    static constexpr std::size_t kCacheLine = 64; // bytes
    const std::uint8_t* const* tile_ = nullptr;
    const std::uint8_t* const* end_ = nullptr;
    std::ptrdiff_t toNext_ = 0;
    std::size_t tileBytes_ = 0;
    std::size_t at_ = 0; // byte inside the tile's row
    std::size_t perPortion_ = 0;
};

/// Pixels of a panel row per portion.
constexpr std::size_t kPortionPixels = 64;

/// One row of a Native.
template <class T>
struct NativeRow {
    const T* views[3];                   ///< View of each pixel's channels.
    std::ptrdiff_t toNextViews;          ///< From there to those of the next row; 0 for the last.
    const std::uint32_t* columnBytes;    ///< Place inside the tile's row, bytes.
    const std::uint8_t* const* tileRows; ///< Start of that row, per tile.
    std::size_t count;                   ///< Pixels.
    std::uint8_t* out;                   ///< Channels as in the tiles.
};

/// Renders a row and calls the fetcher once per kPortionPixels pixels.
template <class T>
void renderRowPlain(const NativeRow<T>& row, RowFetcher& fetcher) {
    std::uint8_t* out = row.out;
    for (std::size_t begin = 0; begin < row.count; begin += kPortionPixels) {
        fetcher.fetch();
        const std::size_t end = std::min(begin + kPortionPixels, row.count);
        for (std::size_t x = begin; x < end; ++x, out += 3) {
            const std::size_t column = row.columnBytes[x];
            out[0] = row.tileRows[row.views[0][x]][column];
            out[1] = row.tileRows[row.views[1][x]][column + 1];
            out[2] = row.tileRows[row.views[2][x]][column + 2];
        }
    }
}

/// Row starts of up to 256 tiles: that of view v is tileRows[0] - v / columns * perRow + v %
/// columns * perColumn.
struct TileOffsets {
    std::uint32_t columns = 1;   ///< 1..256
    std::uint32_t perColumn = 0; ///< Bytes from a tile to its right neighbour.
    std::uint32_t perRow = 0; ///< Bytes from a tile to the one above; all offsets are below 2^31.
};

} // namespace altiro3D
