#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// Largest quilt side in px: coordinates into it are 16-bit numbers.
constexpr int kMaxQuiltSide = 65535;

/// How the views lie in a quilt: view 0 is the bottom-left tile, then to the right, then up
/// (docs/mathematics.md, (2.1)).
///
///     rows = 2      3 4 5
///     columns = 3   0 1 2
struct ALTIRO3D_EXPORT QuiltLayout {
    int columns = 8;             ///< Tiles side by side, 1..1024.
    int rows = 6;                ///< Tiles above each other, 1..1024.
    cv::Size tileSize{420, 560}; ///< Size of one view in px, >= 1 x 1.
    int viewCount = 48; ///< Views in use, 1..columns * rows; unused tiles are at the top right.

    /// Size of the quilt. @return width x height in px; the layout must be valid
    cv::Size size() const { return {columns * tileSize.width, rows * tileSize.height}; }

    /// The tile of a view: docs/mathematics.md, (2.1) to (2.3). Nothing is checked.
    /// @param view 0 (leftmost camera) .. viewCount-1; beyond them the unused tiles
    /// @return its place in px of the quilt, y counted down
    cv::Rect tile(int view) const {
        return {(view % columns) * tileSize.width, (rows - 1 - view / columns) * tileSize.height,
                tileSize.width, tileSize.height};
    }

    /// The layout for people.
    /// @return "8 columns x 6 rows, each view 420 x 560 px", and the views if tiles are unused
    std::string text() const;
};

/// Equal layouts.
/// @param a one layout
/// @param b another one
/// @return true if all fields are equal
ALTIRO3D_EXPORT bool operator==(const QuiltLayout& a, const QuiltLayout& b);
/// Different layouts.
/// @param a one layout
/// @param b another one
/// @return true unless all fields are equal
inline bool operator!=(const QuiltLayout& a, const QuiltLayout& b) {
    return !(a == b);
}

/// Checks a layout.
/// @param layout what to check
/// @throws Error InvalidArgument, or TooLarge (a side beyond kMaxQuiltSide); names the field and
///         its limits
ALTIRO3D_EXPORT void validate(const QuiltLayout& layout);

/// Position of the camera of a view: p = 2 view / (N - 1) - 1, docs/mathematics.md, (3.1). Nothing
/// is checked.
///
/// @param view 0 (leftmost camera) .. viewCount-1
/// @param viewCount N, number of views
/// @return from -1 (leftmost) to +1 (rightmost); 0 if there is one view only
ALTIRO3D_EXPORT double viewPosition(int view, int viewCount);

/// Columns and rows, each with its name.
struct QuiltGrid {
    int columns = 0; ///< Tiles side by side.
    int rows = 0;    ///< Tiles above each other.
};

/// Reads `RxC`, rows x columns as in `-q 6x8`.
/// @param text two whole numbers, 1..1024, with an x or X between them and nothing else
/// @return columns and rows
/// @throws Error InvalidArgument (anything else)
ALTIRO3D_EXPORT QuiltGrid parseQuiltGrid(const std::string& text);

/// Reads `HxW`, height x width of one view as in `-r 560x420`.
/// @param text two whole numbers, 1..99999, with an x or X between them and nothing else
/// @return the size in px
/// @throws Error InvalidArgument (anything else)
ALTIRO3D_EXPORT cv::Size parseTileSize(const std::string& text);

/// What a file name says about a quilt: the last `_qs<columns>x<rows>a<aspect>` in it.
struct QuiltName {
    QuiltGrid grid;               ///< Columns and rows.
    std::optional<double> aspect; ///< Width : height of the scene on the display, 0.1..10.
};

/// Reads the quilt suffix of a file name (without regard to case; the extension is not part of it).
/// @param file the name; directories do not count and the file is not looked at
/// @return nothing if the name has no such suffix
/// @throws Error InvalidArgument if it has one that makes no sense (0 columns, aspect 99)
ALTIRO3D_EXPORT std::optional<QuiltName> parseQuiltName(const std::filesystem::path& file);

/// The file name for a quilt: `photo.png` becomes `photo_qs8x6a0.75.png`; a name that says the same
/// already stays. An aspect that parseQuiltName() does not take is left out.
/// @param file the name to begin with; directories and extension stay
/// @param layout columns and rows, 1..1024 each; the rest is not read
/// @param aspect width : height of the scene
/// @return the name
/// @throws Error Mismatch if the name says something else, an aspect that is off by more than 5 %
///         among it; InvalidArgument (columns, rows, a name that parseQuiltName() does not take)
ALTIRO3D_EXPORT std::filesystem::path quiltFileName(const std::filesystem::path& file,
                                                    const QuiltLayout& layout, double aspect);

/// What the user said about a quilt, whatever of it was said.
struct QuiltRequest {
    std::optional<QuiltGrid> grid;     ///< From `-q`.
    std::optional<cv::Size> tileSize;  ///< From `-r`.
    std::optional<QuiltName> name;     ///< From the file name; wins over the display's default.
    std::optional<cv::Size> quiltSize; ///< Size of the picture itself, if there is one already.
};

/// A layout and what there is to say about it.
struct ResolvedQuilt {
    QuiltLayout layout;                ///< The layout.
    std::vector<std::string> warnings; ///< For instance that the swapped reading fits better.
};

/// Finds the layout that a request means.
///
/// Columns and rows come from the file name, else from `-q`, else from `standard`; the view's size
/// from the picture (floor of its size by columns and rows), else from `-r`, else from the size of
/// `standard`'s quilt. Contradictions are errors. If a view's shape is off the panel's by more than
/// 5 % while the swapped reading (columns x rows, width x height) fits, a warning names both.
/// Another one says what is assumed of a picture of which nothing is stated and that has not the
/// size of `standard`'s quilt.
///
/// @param request what is known
/// @param standard the display's own layout, valid
/// @param panelAspect width : height of the panel, > 0; for the warning only
/// @return the layout, valid, and the warnings
/// @throws Error Mismatch (`-q` and the name, `-r` and the picture), InvalidArgument, TooLarge
ALTIRO3D_EXPORT ResolvedQuilt resolveQuilt(const QuiltRequest& request, const QuiltLayout& standard,
                                           double panelAspect);

} // namespace altiro3D
