#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Adds remarks on given depth whose numbers may mean something else: distances of an EXR file that
/// are read as near-white, and 65535 that is read as unknown.
void addKindNotes(const PhotoFile& file, const cv::Mat& raw, DepthKind kind, Notes* notes);

} // namespace altiro3D
