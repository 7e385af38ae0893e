#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D {

/// What a print shows around its picture.
struct PrintOptions {
    double bleed = 5;      ///< Extra width of the picture at each side, which is cut off, 0..50 mm.
    bool hasMarks = true;  ///< Alignment strips, crop marks and a line of text.
    std::string text = {}; ///< Text added to that line, for example the printer's name: at most 80
                           ///< characters of ASCII.
};

/// A print: a Native with bleed, alignment strips along the lenses (two lenses black, two white),
/// crop marks and a line of text, written with its physical size. Only some rows are in memory.
///
/// Immutable; safe to use from any number of threads.
class ALTIRO3D_EXPORT PrintSheet {
  public:
    /// Lays out the print.
    /// @param print a display whose calibration is for a print
    /// @param options what is around the picture
    /// @throws Error InvalidArgument (no print; options), BadFormat (too large with its bleed)
    PrintSheet(const Display& print, PrintOptions options);

    /// The display to make the Native for: the print including its bleed.
    /// @return its panel is the picture with its bleed, its quilt has the default layout
    [[nodiscard]] const Display& display() const { return display_; }
    /// Size of the whole sheet. @return columns x rows in px
    [[nodiscard]] cv::Size size() const;
    /// The picture that remains when the sheet is cut. @return in px of the sheet
    [[nodiscard]] cv::Rect picture() const;

    /// Writes the file.
    /// @param file .png, .tif or .pdf
    /// @param native passes the Native of display() to its argument, in bands [rows x panel
    ///        columns, CV_8UC3, BGR]
    /// @throws Error Unsupported (extension), WriteFailed, TooLarge (TIFF above 4 GB),
    ///         InvalidArgument and Mismatch (type and size of the Native)
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

/// Pitches of the bands on a pitch test sheet: writePitchSheet().
struct PitchSheetOptions {
    double around = 0; ///< LPI of the middle band; 0 = the calibration's.
    double step = 0;   ///< Difference between neighbouring bands in LPI; 0 = 0.125 % of the
                       ///< calibration's LPI, or a tenth of that with `around`.
};

/// Number of bands of a pitch sheet.
constexpr int kPitchBands = 21;

/// The difference between the outermost bands and the middle one, in lenses over the whole sheet.
/// Below 1, one can hardly tell which band has the correct pitch.
/// @param print calibration of a print
/// @param options the pitches
/// @return lens periods
/// @throws Error as writePitchSheet()
[[nodiscard]] ALTIRO3D_EXPORT double pitchSheetReach(const Calibration& print,
                                                     const PitchSheetOptions& options = {});

/// Writes a sheet of labelled bands of lines, each with a different pitch. Seen through the lenses,
/// the band with the correct pitch has one tone from end to end.
/// @param file .png, .tif or .pdf
/// @param print calibration of a print
/// @param options the pitches
/// @throws Error BadFormat (calibration), InvalidArgument (no print; a pitch of 0 or less, or of
///         more than half of the dpi), Unsupported (extension), WriteFailed
ALTIRO3D_EXPORT void writePitchSheet(const std::filesystem::path& file, const Calibration& print,
                                     const PitchSheetOptions& options = {});

} // namespace altiro3D
