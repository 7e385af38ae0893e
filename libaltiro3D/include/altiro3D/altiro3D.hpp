#pragma once

/// @file
/// Includes all of altiro3D.
///
///     visual.json ─► Display (Calibration, QuiltLayout) ─────────┐
///                                                                ▼
///     photo ─► DepthSource ─► Scene (photo, depth map) ─► NativeMaker ─► Native
///                  ▲
///                  └─ depth network | depth image | RGB-D | photo's file | stereo pair
///
///     NativeMaker:
///     Scene ─► Placement ┬─► NativeRenderer ────────────────────────────────────┬─► Native
///                        └─► Depth2Quilt ─► quilt ─► Quilt2Native (NativeLut) ──┘
///
/// Words:
/// - View: the scene as seen from one camera position.
/// - Quilt: all views in one picture, in columns and rows. A tile is the place of one view in it.
/// - Native: the interlaced picture for the panel of one display. The lens above a sub-pixel sends
///   its light in one direction, and the sub-pixel shows the view for that direction. A Native must
///   never be scaled.
/// - Calibration: how the lenses of one unit lie over its panel; the display's `visual.json`.
/// - Map: a look-up table (NativeLut, `.map` file) made from a calibration and a quilt layout.
/// - RGB-D: a picture that holds a photo and its depth side by side.
/// - Strength: parallax of the whole depth range between the outermost views, % of the picture's
///   width. Focus: the depth that appears on the panel's surface.
///
/// Rules for all image functions; each function documents only its exceptions:
/// - Pictures are `cv::Mat`, 8-bit BGR, row 0 on top; sub-matrices with a step are accepted.
/// - Depth maps are `CV_32FC1`, relative inverse depth, 0..1, 1 = nearest.
/// - View position runs from -1 (leftmost camera) to +1 (rightmost). View 0 is the leftmost view
///   and the bottom-left tile of a quilt.
/// - Most computed images are output parameters: a matrix is reused if its size and type fit, else
///   allocated. Where an output must not share memory with an input, the two must not overlap;
///   disjoint regions of one matrix are allowed. Images read from files, and images that are parts
///   of others, are return values instead.
/// - A wrong argument or file is reported as altiro3D::Error. The library itself prints nothing;
///   OpenCV (its codecs and its network module) and ONNX Runtime may.
/// - Remarks (Notes) report unusual findings that are not failures. A parameter `notes` may be
///   null; remarks are appended to it.
/// - A failed allocation is reported as Error OutOfMemory while reading or writing a file, loading
///   or running a network, rendering views of a photo and making a look-up table. Elsewhere
///   std::bad_alloc passes through. cv::Exception does not leave the library.
/// - Results are bit-for-bit the same for any number of threads (`cv::setNumThreads()`).
///
/// Numbers in parentheses refer to the formulas in docs/mathematics.md.

/// @namespace altiro3D
/// Photos and flat video as glasses-free 3D pictures. altiro3D.hpp lists the rules for the whole
/// namespace.

#include "altiro3D/camera_slide.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/lens_sheet.hpp"
#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/page.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/print_sheet.hpp"
#include "altiro3D/products.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/recipe.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/sway.hpp"
#include "altiro3D/version.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"
#include "altiro3D/view_options.hpp"
