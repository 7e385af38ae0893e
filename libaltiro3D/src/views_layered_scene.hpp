#pragma once

#include "views_layered.hpp"
#include "views_layered_row.hpp"

#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// A surface of a row: hidden nodes, then the pixels first..last of the photo, then nodes beyond.
/// Before it lies one guard node, behind it two (copies of its ends), for the cubic.
struct LayeredSurface {
    int first = 0;        ///< First column of the photo.
    int last = 0;         ///< Last column of the photo.
    float leftExtra = 0;  ///< See LayeredSpan.
    float rightExtra = 0; ///< See LayeredSpan.
    int hidden = 0;       ///< Nodes left of `first`: behind nearer things or left of the frame.
    int beyond = 0;       ///< Nodes right of `last`: behind nearer things or right of the frame.
    int node = 0;         ///< Index of the node of `first`.

    int begin() const { return node - hidden; }              ///< First node.
    int end() const { return node + last - first + beyond; } ///< Last node.
};

/// A row with the tables that traceRow() and samplePixel() read.
struct LayeredRowData {
    std::vector<LayeredSurface> surfaces; ///< From left to right.
    std::vector<LayeredSpan> spans;
    std::vector<float> offset;
    std::vector<std::uint8_t> colour;
    bool still = false; ///< All of the row lies at the focus: it is the photo's in every view. If
                        ///< all rows are still, the tables are empty.

    LayeredRow tables() const {
        return {offset.data(), colour.data(), spans.data(), static_cast<int>(spans.size())};
    }
};

/// Cuts a row into surfaces where its depth steps, and puts the cuts where the photo has them.
/// Mirrored input gives the mirrored surfaces.
///
/// @param bgr the row of the photo
/// @param offsets depth - focus of each pixel; soft steps are hardened, near things grow by the
///        dilation, mixed pixels at borders take the near depth
/// @param surfaces first, last and extras are set; what lies between two is mixed and belongs to
///        none
void cutSurfaces(const std::uint8_t* bgr, std::vector<float>& offsets,
                 const LayeredSettings& options, std::vector<LayeredSurface>& surfaces);

/// Makes the tables of all rows, as seen when the camera moves to the right.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1]
std::vector<LayeredRowData> layeredScene(const cv::Mat& photo, const cv::Mat& depth, double focus,
                                         const LayeredSettings& options);

/// Paints the hidden nodes of all rows. @param photo as for layeredScene()
void paintBackground(const cv::Mat& photo, const LayeredSettings& options,
                     std::vector<LayeredRowData>& rows);

} // namespace altiro3D
