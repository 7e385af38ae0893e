#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/native_lut.hpp"
#include "common/run_tool.hpp"

#include <filesystem>

namespace altiro3D::tools {

/// The user's directory for cached look-up tables and measured costs. It need not exist. Empty if
/// the environment does not define one.
std::filesystem::path cacheDirectory();

/// The look-up table of a display from the cache. A missing table is built and kept there. The
/// cache is optional: if anything is wrong with it, the table is built.
NativeLut cachedLut(const Calibration& calibration, const QuiltLayout& layout, InvertViews invert,
                    Messages& messages);

} // namespace altiro3D::tools
