#pragma once

#include "views/view_methods.hpp"
#include "views/views_layered_row.hpp"

#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// A surface of a row: columns first..last of the photo, and what is painted beside them.
///
///   photo row       0 1 2 3 | 4 5 6 7 | 8 9 ...        | = tear: a step of the depth
///   depth           . . . . | ####### | . . .          (4..7 stand in front)
///   surfaces        0 1 2 3 |   4 5 6 7 |   h h h h 8 9 ...
///                                           ^^^^^^^ hidden columns, behind 4..7
///
/// A surface goes on leftwards behind what hides it, because a camera that moves to the right looks
/// behind the right borders of near things. What is painted moves as the column it is painted on.
struct LayeredSurface {
    int first = 0;        ///< First column of the photo.
    int last = 0;         ///< Last column of the photo.
    float leftExtra = 0;  ///< How far it reaches beyond its first pixel, px, 0..1.
    float rightExtra = 0; ///< As leftExtra, beyond its last pixel.
    int hidden = 0;       ///< Columns left of `first`: behind nearer things or left of the frame.
    int beyond = 0;       ///< Columns right of `last`: behind nearer things or right of the frame.
    int strip = 0;        ///< Place of its leftmost painted column in LayeredRow::strips.

    /// Place in LayeredRow::strips of column first - k, k = 0..hidden.
    int hiddenAt(int k) const { return strip + hidden - k; }
    /// Place in LayeredRow::strips of column last + k, k = 0..beyond.
    int beyondAt(int k) const { return strip + hidden + 1 + k; }
    /// Columns in LayeredRow::strips.
    int stripLength() const { return hidden + beyond + 2; }
};

/// A row of the photo, in one direction.
struct LayeredRow {
    std::vector<LayeredSurface> surfaces; ///< From left to right.
    /// What is painted, with the columns first and last themselves: B G R and one unused byte each.
    std::vector<std::uint8_t> strips;
};

/// All rows, as seen when the camera moves to the right (direction 0), and of the mirrored photo
/// (direction 1).
struct LayeredScene {
    std::vector<LayeredRow> rows[2];
    cv::Mat words;                   ///< [rows x 2 * stride, CV_16SC1], LayeredTables::words
    cv::Mat bounds;                  ///< As `words`, LayeredTables::bounds
    cv::Mat left;                    ///< As `words`, LayeredTables::left
    cv::Mat surfaceOf;               ///< As `words`, LayeredTables::surfaces
    cv::Mat limits;                  ///< As `words` but CV_32SC1, LayeredTables::limits
    int width = 0;                   ///< Columns of the photo.
    float scale = 0;                 ///< LayeredTables::scale
    float reachPixels = 0;           ///< Largest shift that the bounds were made for, px.
    int reachColumns = 0;            ///< How far content moves by it at most.
    std::vector<std::uint8_t> still; ///< Rows that lie at the focus: the photo's in every view.
    bool flat = false;               ///< All of them do; there are no tables.

    int stride() const { return width + 2 * kTablePadding; }
    LayeredTables tables(int row) const;
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

/// Depth without the stairs of a file with few levels (8 bits), where they would show: each px
/// moves by up to half a level towards its neighbours on the same slope. Other depth is returned as
/// it is.
/// @param depth [rows x cols, CV_32FC1], NaN counts as 0 @param reach largest shift, px
cv::Mat withoutLevels(const cv::Mat& depth, double reach);

/// Makes surfaces and tables of all rows.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1]
/// @param focus depth of zero parallax
LayeredScene layeredScene(const cv::Mat& photo, const cv::Mat& depth, double focus,
                          const LayeredSettings& options);

/// Paints the strips of all rows.
/// @param photo mirrored for direction 1 @param direction 0 or 1
void paintBackground(const cv::Mat& photo, const LayeredSettings& options, int direction,
                     LayeredScene& scene);

} // namespace altiro3D
