#pragma once

#include "altiro3D/error.hpp"

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

/// Numbers and pictures as bytes in this machine's format, for the saved state of a run.
namespace altiro3D {

void append(std::string& bytes, std::uint64_t value);
void append(std::string& bytes, const cv::Mat& picture);
/// Reads a value of append() from the front of `bytes`.
/// @return false if the bytes are too few or the picture has another type
bool take(std::string_view& bytes, std::uint64_t& value);
bool take(std::string_view& bytes, int type, cv::Mat& picture);
/// The error for bytes that cannot be the state of an earlier run.
[[nodiscard]] Error damagedState();
/// A checksum that detects damaged bytes.
std::uint64_t checksum(std::string_view bytes);

/// Mixes a value into a sum of 64 bits. Bijective in `value`, so a single change is never lost.
std::uint64_t mixIn(std::uint64_t sum, std::uint64_t value);

} // namespace altiro3D
