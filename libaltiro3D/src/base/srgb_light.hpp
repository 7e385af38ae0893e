#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Linear light of a value of sRGB (IEC 61966-2-1), and back; 0..1.
inline double lightOfSrgb(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
inline double srgbOf(double light) {
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// Linear light and codes of sRGB. Converting a code to light and back is exact.
class SrgbLight {
  public:
    /// The tables, made once.
    static const SrgbLight& instance() {
        static const SrgbLight tables;
        return tables;
    }

    /// @param code 0..255 @return 0..1
    float ofCode(std::uint8_t code) const { return light_[code]; }
    /// @param light 0..1, or more, which counts as 1
    std::uint8_t code(float light) const {
        const float inside = light < 1 ? light : 1;
        return codes_[static_cast<std::size_t>(inside * kSteps + 0.5F)];
    }

  private:
    static constexpr int kSteps = 16384; // steps of light, 0..1; code 1 is five of them

    SrgbLight() : codes_(kSteps + 1) {
        for (std::size_t i = 0; i < light_.size(); ++i)
            light_[i] = static_cast<float>(lightOfSrgb(static_cast<double>(i) / 255));
        for (std::size_t i = 0; i < codes_.size(); ++i)
            codes_[i] = static_cast<std::uint8_t>(
                std::lround(255 * srgbOf(static_cast<double>(i) / kSteps)));
    }

    std::array<float, 256> light_{};
    std::vector<std::uint8_t> codes_;
};

} // namespace altiro3D
