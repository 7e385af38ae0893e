#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D {

/// What a print has around its picture.
struct PrintOptions {
    double bleed = 5;      ///< More of the picture at each side, which is cut off: 0..50 mm.
    bool hasMarks = true;  ///< Alignment strips, crop marks and a line of text.
    std::string text = {}; ///< Added to that line: the printer, for example. At most 80 characters
                           ///< of ASCII.
};

/// A print: a Native with bleed, alignment strips along the lenses (two lenses black, two white),
/// crop marks and a line of text, written with its physical size. Only some rows are in memory.
///
/// Immutable; safe to use from any number of threads.
class ALTIRO3D_EXPORT PrintSheet {
  public:
    /// @param print the display; its calibration is of a print
    /// @param options what is around the picture
    /// @throws Error InvalidArgument (no print; options), BadFormat (with its bleed it is too
    ///         large)
    PrintSheet(const Display& print, PrintOptions options);

    /// What the Native is made for: the print with its bleed.
    /// @return its panel is the picture with its bleed, its quilt has the default layout
    [[nodiscard]] const Display& display() const { return display_; }
    /// Size of the whole sheet. @return columns x rows in px
    [[nodiscard]] cv::Size size() const;
    /// The picture that remains when the sheet is cut. @return in px of the sheet
    [[nodiscard]] cv::Rect picture() const;

    /// Writes the file.
    /// @param file .png, .tif or .pdf
    /// @param native calls its argument with the Native of display(), in rows
    ///        [rows x panel columns, CV_8UC3, BGR]
    /// @throws Error Unsupported (extension), WriteFailed, TooLarge (TIFF above 4 GB)
    void write(const std::filesystem::path& file,
               const std::function<void(const RowSink&)>& native) const;

    /// Whether a file name has the extension of a print. @param file the name @return true if so
    [[nodiscard]] static bool canWrite(const std::filesystem::path& file);

  private:
    void drawMarks(cv::Mat& rows, int first) const;

    Display display_; // with bleed
    PrintOptions options_;
    cv::Size bleed_;   // px
    cv::Rect inSheet_; // the Native
    cv::Size sheet_;
    cv::Mat line_;
};

/// The bands of a pitch sheet.
struct PitchSheetOptions {
    double around = 0; ///< LPI of the middle band; 0 = that of the calibration.
    double step = 0;   ///< LPI from band to band; 0 = 0.125 % of the calibration's, or a tenth of
                       ///< it with `around`.
};

/// Number of bands of a pitch sheet.
constexpr int kPitchBands = 21;

/// By how many lenses the outermost bands of a pitch sheet differ from the middle one over the
/// sheet. Below 1, hardly anything shows which band is right.
/// @param print calibration of a print
/// @param options the pitches
/// @return lens periods
/// @throws Error as writePitchSheet()
[[nodiscard]] ALTIRO3D_EXPORT double pitchSheetReach(const Calibration& print,
                                                     const PitchSheetOptions& options = {});

/// Writes a sheet of bands of lines, each of another pitch and labelled: under the lenses, the one
/// of the right pitch has one tone from end to end.
/// @param file .png, .tif or .pdf
/// @param print calibration of a print
/// @param options the pitches
/// @throws Error InvalidArgument (no print; a pitch is not above 0 or above half of the dpi),
///         Unsupported (extension), WriteFailed
ALTIRO3D_EXPORT void writePitchSheet(const std::filesystem::path& file, const Calibration& print,
                                     const PitchSheetOptions& options = {});

} // namespace altiro3D
