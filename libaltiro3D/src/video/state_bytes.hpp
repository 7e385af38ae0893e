#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

/// Numbers and pictures as bytes of this machine, for states that are kept beside a run.
namespace altiro3D {

/// Puts them at the end.
void append(std::string& bytes, std::uint64_t value);
void append(std::string& bytes, const cv::Mat& picture);
/// Takes what append() put there off the front.
/// @return false if the bytes end before or the picture is not of the type
bool take(std::string_view& bytes, std::uint64_t& value);
bool take(std::string_view& bytes, int type, cv::Mat& picture);
/// A number of bytes that tells damaged ones.
std::uint64_t checksum(std::string_view bytes);

/// Changes a sum of 64 bits by a value: one to one in `value`, so that one change never gets lost.
std::uint64_t mixIn(std::uint64_t sum, std::uint64_t value);

} // namespace altiro3D
