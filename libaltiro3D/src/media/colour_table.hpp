#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// The curve that makes HDR video as bright as other video. Light up to 0.97 of white (203 cd/m²)
/// stays, white becomes 0.985 of itself, and brighter light shares the rest up to 1000 cd/m².
/// @param light in units of white, from 0 @return 0..1
double videoToneMapped(double light);

/// A table from the colours of a video to the primaries of sRGB. PQ and HLG are tone-mapped by
/// videoToneMapped(), applied to the largest of red, green and blue. The system gamma of HLG counts
/// for each of them, as in FFmpeg's zscale. The result has the curve of sRGB. Other video has the
/// gamma 2.4 (BT.1886) and keeps it, so that greys stay as they are.
class ColourTable {
  public:
    /// Keeps colours as they are.
    ColourTable() = default;
    /// @param primaries, transfer codes of H.273
    ColourTable(int primaries, int transfer);

    /// Converts a row. Reads 6 or 8 bytes per px and four entries of the table, which bound the
    /// speed; writes 3.
    ///
    /// @param from blue, green, red and perhaps alpha, which composes the px over black
    /// @param channels 3 or 4
    /// @param to blue, green, red
    void row(const std::uint16_t* from, int channels, int columns, std::uint8_t* to) const;

  private:
    /// Linear light of blue, green and red, which may leave 0..1; by blue, green and red. Empty:
    /// colours stay.
    std::vector<std::array<float, 3>> nodes_;
    std::vector<float> encoded_; ///< By the root of light, 0..255.
};

} // namespace altiro3D
