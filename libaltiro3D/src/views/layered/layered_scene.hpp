#pragma once

#include "views/layered/layered_row.hpp"
#include "views/view_methods.hpp"

#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

// What belongs to surfaces and their borders is in layered_surfaces.cpp, the painted background in
// layered_fill.cpp, the rest in layered_scene.cpp.

/// A surface of a row: columns first..last of the photo, and the columns painted beside them.
///
///   photo row       0 1 2 3 | 4 5 6 7 | 8 9 ...        | = tear: a step of the depth
///   depth           . . . . | ####### | . . .          (4..7 stand in front)
///   surfaces        0 1 2 3 |   4 5 6 7 |   h h h h 8 9 ...
///                                           ^^^^^^^ hidden columns, behind 4..7
///
/// A surface continues to the left behind its occluder, because a camera moving right sees behind
/// the right borders of near things. Painted columns move with the adjacent end of the surface.
struct LayeredSurface {
    int first = 0;        ///< First column of the photo.
    int last = 0;         ///< Last column of the photo.
    float leftExtra = 0;  ///< Extent beyond its first pixel, px, 0..1.
    float rightExtra = 0; ///< Extent beyond its last pixel, px, 0..1.
    int hidden = 0;       ///< Columns left of `first`, behind nearer things or left of the frame.
    int beyond = 0;       ///< Columns right of `last`, behind nearer things or right of the frame.
    bool clearLeft = false;  ///< The photo shows its left border clearly, so the border is hard.
    bool clearRight = false; ///< The same at its right end. Both are for BorderShares alone.
    int softLeft = 0;        ///< Columns at its left end that also show the surface beside it.
    int softRight = 0;       ///< The same at its right end.
    int strip = 0;           ///< Index of its leftmost painted column in LayeredRow::strips.

    /// Index in LayeredRow::strips of column first - k, k = 0..hidden.
    int hiddenAt(int k) const { return strip + hidden - k; }
    /// Index in LayeredRow::strips of column last + k, k = 0..beyond.
    int beyondAt(int k) const { return strip + hidden + 1 + k; }
    /// Number of columns in LayeredRow::strips.
    int stripLength() const { return hidden + beyond + 2; }
};

/// A row of the photo, in one direction.
struct LayeredRow {
    std::vector<LayeredSurface> surfaces; ///< From left to right.
    /// Painted columns, including the columns first and last: B G R and one unused byte each.
    std::vector<std::uint8_t> strips;
};

/// All rows for a camera that moves to the right (direction 0), and mirrored (direction 1).
struct LayeredScene {
    std::vector<LayeredRow> rows[2];
    cv::Mat words;     ///< [rows x 2 * stride, CV_16SC1], LayeredTables::words
    cv::Mat surfaceOf; ///< As `words`, LayeredTables::surfaces
    cv::Mat freeUpTo;  ///< As `words` but CV_16UC1, LayeredTables::freeUpTo
    /// [rows x cols, CV_8UC1], share of the surface behind in px of soft borders, in 1/256, else 0.
    /// Empty if all borders are hard.
    cv::Mat shares;
    int width = 0;         ///< Columns of the photo.
    float scale = 0;       ///< LayeredTables::scale
    float reachPixels = 0; ///< Largest shift that is prepared, px.
    int reachColumns = 0;  ///< Largest movement of content at that shift.
    /// Rows entirely at the focus; they equal the photo in every view.
    std::vector<std::uint8_t> still;
    bool flat = false; ///< All rows are still; there are no tables.
    /// Whether surfaces keep the order of their columns within the reach.
    bool inOrder = false;

    int stride() const { return width + 2 * kTablePadding; }
    LayeredTables tables(int row) const;
};

/// Divides a row into surfaces at its depth steps and moves the cuts to the edges in the photo.
/// Mirrored input gives the mirrored surfaces.
/// @param bgr the row of the photo
/// @param offsets depth - focus of each pixel; on return, near surfaces are dilated, and
///        mixed pixels at borders have the near depth
/// @param surfaces result: first, last, extras and clear borders are set; pixels between two
///        surfaces are mixed and belong to neither
void cutSurfaces(const std::uint8_t* bgr, std::vector<float>& offsets,
                 const LayeredSettings& options, std::vector<LayeredSurface>& surfaces);

/// Finds soft borders: px in which the photo shows a near surface and the one behind it
/// (docs/mathematics.md, (3.7)). Borders that the photo shows clearly are hard.
class BorderShares {
  public:
    /// @param depth [rows x cols, CV_32FC1]; must outlive this object
    /// @param mixedPixels Scene::mixedPixels
    BorderShares(const cv::Mat& depth, double focus, int mixedPixels);

    /// Sets LayeredSurface::softLeft and softRight of a row.
    /// @param offsets, surfaces after cutSurfaces()
    /// @param shares result: row of LayeredScene::shares
    void find(int row, const std::vector<float>& offsets, std::vector<LayeredSurface>& surfaces,
              std::uint8_t* shares) const;

  private:
    int shareBehind(int row, int x, float middle) const;

    cv::Mat depth_; // its steps are in the middle of the edges of the photo
    float focus_;
    int mostColumns_;
    std::vector<int> weights_; // weights of px at a distance along a row or a column
};

/// Smooths the staircases of depth with few levels (8 bits) if views would show them. Px move by up
/// to half a level towards neighbours on the same slope. Other depth is unchanged.
/// @param depth [rows x cols, CV_32FC1], NaN counts as 0
/// @param reach largest shift, px
cv::Mat withoutLevels(const cv::Mat& depth, double reach);

/// Builds the surfaces and tables of all rows.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1]
/// @param focus depth of zero parallax
LayeredScene layeredScene(const cv::Mat& photo, const cv::Mat& depth, double focus,
                          const LayeredSettings& options);

/// Paints the strips of all rows, with known colours where options.hidden has some.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param focus depth of zero parallax
/// @param direction 0 or 1
void paintBackground(const cv::Mat& photo, double focus, const LayeredSettings& options,
                     int direction, LayeredScene& scene);

} // namespace altiro3D
