#pragma once

/// @file
/// All of altiro3D.
///
///     visual.json ─► Calibration ──┐
///                                  ├─► NativeLut (.map) ─────────────┐
///                  QuiltLayout ────┘                                 ▼
///     photo ─► depth map ─► PhotoFit ─► Depth2Quilt ─► quilt ─► Quilt2Native ─► Native
///                ▲              │                                                  ▲
///                │              └─► NativeRenderer (with Calibration) ─────────────┘
///                └─ DepthNetwork | depth_cues | depth image | RGB-D
///
/// Rules that hold for all image functions, which tell only their exceptions:
/// - Pictures are `cv::Mat`, 8-bit BGR, row 0 on top; sub-matrices with a step are fine.
/// - Depth maps are `CV_32FC1`, relative inverse depth, 0..1, 1 = nearest.
/// - View position runs from -1 (leftmost camera) to +1 (rightmost); view 0 is the leftmost and the
///   bottom-left tile of a quilt.
/// - The result is the last parameter; it is allocated if its size or type does not fit and reused
///   otherwise. Where it must not share memory with an input, parts of one canvas that lie apart
///   are fine.
/// - What is wrong with an argument or a file is an altiro3D::Error; nothing is printed.
/// - Memory that runs out is an Error OutOfMemory while a file is read or written, a network is
///   loaded or run, and memory for a quilt or a look-up table is taken; elsewhere it is what the
///   language or OpenCV throw, std::bad_alloc or a cv::Exception of the code StsNoMem.
/// - Results are bit-for-bit the same for any number of threads (`cv::setNumThreads()`).
///
/// Formulas are those of docs/mathematics.md, whose numbers stand in parentheses.

/// @namespace altiro3D
/// Photos and flat video as glasses-free 3D pictures; altiro3D.hpp tells the rules that hold for
/// all of it.

#include "altiro3D/calibration.hpp"
#include "altiro3D/camera.hpp"
#include "altiro3D/data_directories.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_cues.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/native_renderer.hpp"
#include "altiro3D/network2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/picture_quality.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/resumable_video.hpp"
#include "altiro3D/scene_cuts.hpp"
#include "altiro3D/sway.hpp"
#include "altiro3D/trade.hpp"
#include "altiro3D/version.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_pipeline.hpp"
#include "altiro3D/video_reader.hpp"
#include "altiro3D/video_types.hpp"
#include "altiro3D/video_writer.hpp"
#include "altiro3D/view_options.hpp"
