#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Linear light and codes of sRGB (IEC 61966-2-1). Codes of light and back give the same code.
class SrgbLight {
  public:
    /// The tables, made once.
    static const SrgbLight& instance();

    /// @param code 0..255 @return 0..1
    float ofCode(std::uint8_t code) const { return light_[code]; }
    /// @param light 0..1, or more, which counts as 1
    std::uint8_t code(float light) const {
        const float inside = light < 1 ? light : 1;
        return codes_[static_cast<std::size_t>(inside * kSteps + 0.5F)];
    }

  private:
    static constexpr int kSteps = 16384; // five for the smallest code

    SrgbLight();

    std::array<float, 256> light_{};
    std::vector<std::uint8_t> codes_;
};

} // namespace altiro3D
