#pragma once

#include "altiro3D/splats.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace altiro3D {

/// The spherical harmonic of degree 0, whose coefficients files give as colours: sqrt(1 / (4 pi)).
constexpr double kHarmonic0 = 0.28209479177387814;
/// Most splats of a file.
constexpr std::uint64_t kMaxSplats = std::uint64_t{1} << 26;

/// The number of coefficients of a degree for each colour, besides that of degree 0.
constexpr std::size_t coefficientsOf(int degree) {
    return static_cast<std::size_t>((degree + 1) * (degree + 1) - 1);
}

/// The display value of a file's coefficient of degree 0, and the other way round.
inline float displayValue(float harmonic) {
    return static_cast<float>(0.5 + kHarmonic0 * static_cast<double>(harmonic));
}
inline double harmonicOf(float displayValue) {
    return (static_cast<double>(displayValue) - 0.5) / kHarmonic0;
}

/// The radius that a file gives as its logarithm. In double, as libraries differ in the last bit.
inline float radiusOf(float logarithm) {
    return static_cast<float>(std::exp(static_cast<double>(logarithm)));
}

/// The opacity that a file gives as its logit; infinite ones are valid.
inline float opacityOf(float logit) {
    return static_cast<float>(1 / (1 + std::exp(-static_cast<double>(logit))));
}

/// A unit vector of four components, of which a file leaves out the largest. The uppermost two bits
/// say which one that is; the others follow in ten bits each, from the highest bits down.
/// @param valueOf the value of ten bits
template <class ValueOf>
cv::Vec4f smallestThree(std::uint32_t packed, const ValueOf& valueOf) {
    const auto largest = static_cast<int>(packed >> 30);
    cv::Vec4f result;
    double rest = 1;
    unsigned shift = 30;
    for (int i = 0; i < 4; ++i) {
        if (i == largest) continue;
        shift -= 10;
        const double value = valueOf(packed >> shift & 1023U);
        result[i] = static_cast<float>(value);
        rest -= value * value;
    }
    result[largest] = static_cast<float>(std::sqrt(std::max(rest, 0.0)));
    return result;
}

/// Adds the bytes of a number or an array, or the first ones, to those of a file.
template <class T>
void addBytes(std::string& bytes, const T& value, std::size_t count = sizeof(T)) {
    bytes.append(reinterpret_cast<const char*>(&value), count);
}

/// Collects the splats of a file and leaves out those whose numbers make no sense.
class SplatCollector {
  public:
    /// @param count number of splats that will come, at most kMaxSplats
    /// @param degree of the file's harmonics, 0..4; those of degree 4 are not kept
    SplatCollector(std::uint64_t count, int degree);

    /// @param splat its rotation may have any length
    /// @param harmonics red, green, blue of each coefficient; may be null without harmonics
    void add(Splat splat, const double* harmonics);

    /// @param name of the file, for errors
    /// @return the scene @throws Error BadFormat (no splat is left)
    SplatScene finish(const std::string& name, Notes* notes);

  private:
    SplatScene scene_;
    std::uint64_t leftOut_ = 0;
    int fileDegree_;
};

/// Largest side of a picture, px.
constexpr int kMaxPicture = 16384;

/// @throws Error InvalidArgument unless the scene has splats, and the harmonics of its degree
void requireSplats(const SplatScene& scene);

/// @throws Error InvalidArgument unless pictures can be made with the camera
void requireCamera(const SplatCamera& camera);

/// Turns a scene by half a turn about x, as RUB and RDF differ.
void turnAboutX(SplatScene& scene);

/// Reads each format. @param bytes the whole file @param name for errors
/// @throws Error as readSplats()
SplatScene parsePly(std::string_view bytes, const std::string& name, Notes* notes);
SplatScene parseSpz(std::string_view bytes, const std::string& name, SplatAxes axes, Notes* notes);
/// As above, for scenes of .spz to be written. @throws Error InvalidArgument
std::string spzBytes(const SplatScene& scene, const std::string& name);
std::string plyBytes(const SplatScene& scene);

} // namespace altiro3D
