#include "base/srgb_light.hpp"

#include <cmath>

namespace altiro3D {

SrgbLight::SrgbLight() : codes_(kSteps + 1) {
    for (std::size_t i = 0; i < light_.size(); ++i) {
        const double v = static_cast<double>(i) / 255;
        light_[i] =
            static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    for (std::size_t i = 0; i < codes_.size(); ++i) {
        const double v = static_cast<double>(i) / kSteps;
        const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
        codes_[i] = static_cast<std::uint8_t>(std::lround(255 * s));
    }
}

const SrgbLight& SrgbLight::instance() {
    static const SrgbLight tables;
    return tables;
}

} // namespace altiro3D
