#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// Largest quilt side in px; coordinates are 16-bit numbers.
constexpr int kMaxQuiltSide = 65535;

/// Arrangement of the views in a quilt: view 0 is the bottom-left tile; the next ones follow to the
/// right, then up (docs/mathematics.md, (2.1)).
///
///     rows = 2      3 4 5
///     columns = 3   0 1 2
struct ALTIRO3D_EXPORT QuiltLayout {
    int columns = 8;             ///< Tiles side by side, 1..1024.
    int rows = 6;                ///< Tiles above each other, 1..1024.
    cv::Size tileSize{420, 560}; ///< Size of one view in px, >= 1 x 1.
    int viewCount = 48; ///< Views in use, 1..columns * rows; unused tiles are at the top right.

    /// Size of the quilt. @return width x height in px; the layout must be valid
    [[nodiscard]] cv::Size size() const {
        return {columns * tileSize.width, rows * tileSize.height};
    }

    /// The tile of a view: docs/mathematics.md, (2.1) to (2.3). Arguments are not checked.
    /// @param view 0 (leftmost camera) .. viewCount-1; higher numbers are the unused tiles
    /// @return its rectangle in px of the quilt, y grows downward
    [[nodiscard]] cv::Rect tile(int view) const {
        return {(view % columns) * tileSize.width, (rows - 1 - view / columns) * tileSize.height,
                tileSize.width, tileSize.height};
    }

    /// The layout as text for people.
    /// @return "8 columns x 6 rows, each view 420 x 560 px"; also the view count if tiles are
    ///         unused
    [[nodiscard]] std::string text() const;
};

/// Whether layouts are equal. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const QuiltLayout& a, const QuiltLayout& b) {
    return a.columns == b.columns && a.rows == b.rows && a.tileSize == b.tileSize &&
           a.viewCount == b.viewCount;
}
/// Whether layouts differ. @param a one @param b the other @return true if a field does
[[nodiscard]] inline bool operator!=(const QuiltLayout& a, const QuiltLayout& b) {
    return !(a == b);
}

/// Checks a layout.
/// @param layout the layout to check
/// @throws Error InvalidArgument, or TooLarge (a side beyond kMaxQuiltSide); names the field and
///         its limits
ALTIRO3D_EXPORT void validate(const QuiltLayout& layout);

/// Camera position of a view: p = 2 view / (N - 1) - 1, docs/mathematics.md, (3.1). Arguments are
/// not checked.
/// @param view 0 (leftmost camera) .. viewCount-1
/// @param viewCount N, number of views
/// @return from -1 (leftmost) to +1 (rightmost); 0 for a single view
[[nodiscard]] ALTIRO3D_EXPORT double viewPosition(int view, int viewCount);

/// Columns and rows of a quilt.
struct QuiltGrid {
    int columns = 0; ///< Tiles side by side.
    int rows = 0;    ///< Tiles above each other.
};

/// Parses `RxC`, rows x columns as in `-q 6x8`.
/// @param text two whole numbers, 1..1024, with an x or X between them and nothing else
/// @return columns and rows
/// @throws Error InvalidArgument (anything else)
[[nodiscard]] ALTIRO3D_EXPORT QuiltGrid parseQuiltGrid(const std::string& text);

/// Parses `HxW`, height x width of one view as in `-r 560x420`.
/// @param text two whole numbers, 1..99999, with an x or X between them and nothing else
/// @return the size in px
/// @throws Error InvalidArgument (anything else)
[[nodiscard]] ALTIRO3D_EXPORT cv::Size parseTileSize(const std::string& text);

/// Quilt data in a file name: the last `_qs<columns>x<rows>a<aspect>` in it, or `_cv` at its end,
/// the mark of a CubeVi C1: 8 columns, 5 rows, aspect 0.5625.
struct QuiltName {
    QuiltGrid grid;               ///< Columns and rows.
    std::optional<double> aspect; ///< Width : height of the scene on the display, 0.1..10.
};

/// Parses the quilt suffix of a file name, in upper or lower case. The extension is not part of it.
/// @param file the name; directories are ignored and the file is not accessed
/// @return nothing if the name has no such suffix
/// @throws Error InvalidArgument if the suffix is out of range (0 columns, aspect 99)
[[nodiscard]] ALTIRO3D_EXPORT std::optional<QuiltName>
parseQuiltName(const std::filesystem::path& file);

/// The file name for a quilt: `photo.png` becomes `photo_qs8x6a0.75.png`. A name that already has
/// this suffix is not changed. An aspect outside the range of parseQuiltName() is left out.
/// @param file the original name; directories and extension are kept
/// @param layout columns and rows, 1..1024 each; other fields are ignored
/// @param aspect width : height of the scene
/// @return the name
/// @throws Error Mismatch (the name's suffix has another grid, or an aspect that differs by more
///         than 5 %); InvalidArgument (columns, rows, a suffix that parseQuiltName() refuses)
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
quiltFileName(const std::filesystem::path& file, const QuiltLayout& layout, double aspect);

/// What the user specified about a quilt; each part is optional.
struct QuiltRequest {
    std::optional<QuiltGrid> grid;     ///< From `-q`.
    std::optional<cv::Size> tileSize;  ///< From `-r`.
    std::optional<QuiltName> name;     ///< From the file name.
    std::optional<QuiltGrid> found;    ///< Found in the picture, see findQuiltLayout().
    std::optional<cv::Size> quiltSize; ///< Size of the quilt picture, if it exists.
};

/// A layout and remarks about it.
struct ResolvedQuilt {
    QuiltLayout layout; ///< The layout.
    Notes notes;        ///< For example that the swapped order fits better.
};

/// Determines the layout for a request.
///
/// Columns and rows come from the file name, else from `-q`, else from the picture, else from
/// `standard`. The view's size comes from the picture (its size divided by columns and rows,
/// rounded down), else from `-r`, else from the size of `standard`'s quilt. Contradictions are
/// errors. If `-q` or `-r` gives views whose shape differs from the panel's by more than 5 %, and
/// the swapped order (columns x rows, width x height) fits, a warning names both. If nothing is
/// specified and the picture does not have the size of `standard`'s quilt, a warning states the
/// assumption.
/// @param request what is known
/// @param standard the display's default layout; must be valid
/// @param panelAspect width : height of the panel, > 0; used for the warning only
/// @return the layout, which is valid, and remarks
/// @throws Error Mismatch (`-q` and the name, `-r` and the picture), InvalidArgument, TooLarge
[[nodiscard]] ALTIRO3D_EXPORT ResolvedQuilt resolveQuilt(const QuiltRequest& request,
                                                         const QuiltLayout& standard,
                                                         double panelAspect);

} // namespace altiro3D
