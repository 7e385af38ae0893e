#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/scene.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace altiro3D {

// A picture in depth as one page (HTML) that browsers open without a connection. It holds its
// pictures, script and style, loads nothing else, and forbids loading by a Content-Security-Policy.
// It holds no data of the photo's file except those in PageText.

/// What a page says about its picture.
struct PageText {
    std::string title;  ///< UTF-8; empty: "A picture in depth".
    std::string credit; ///< Author and licence, UTF-8; empty: none.
};

/// Longer side of the picture in a page, px.
constexpr int kPageSide = 2048;
/// Longest side of a picture that all browsers draw, px.
constexpr int kPageTextureSide = 4096;

/// The page of a photo with its depth. Its views are those of method Layered.
/// @param scene photo and depth
/// @param options used: `views` (strength of at most 100 %, focus, `layered`), `refine` and
///        `depthCurve`
/// @param text what the page says
/// @param part of the photo, px; not set: all of it
/// @param side longer side of the picture, px, 16..kPageTextureSide; never more than the part has,
///        and less if the margins that views from the sides show do not fit into kPageTextureSide
/// @return the page
/// @throws Error as fitScene() and Depth2Quilt::render(), InvalidArgument
[[nodiscard]] ALTIRO3D_EXPORT std::string
photoPage(const Scene& scene, const PlacementOptions& options, const PageText& text,
          const std::optional<cv::Rect>& part = {}, int side = kPageSide);

/// The page of a quilt: it blends neighbouring views.
/// @param quilt [layout size, CV_8UC3, BGR]
/// @param layout its layout, of at least two views
/// @param aspect width : height of a view as shown, 0.01..100
/// @param text what the page says
/// @param side longer side of a view, px, 16..kPageTextureSide; never more than it has, and less if
///        the views do not fit into four pictures of kPageTextureSide
/// @return the page
/// @throws Error InvalidArgument, Mismatch (size of the quilt)
[[nodiscard]] ALTIRO3D_EXPORT std::string quiltPage(const cv::Mat& quilt, const QuiltLayout& layout,
                                                    double aspect, const PageText& text,
                                                    int side = kPageSide);

/// Whether a name is that of a page. @param file the name @return true for .html and .htm
[[nodiscard]] ALTIRO3D_EXPORT bool isPageFileName(const std::filesystem::path& file);

} // namespace altiro3D
