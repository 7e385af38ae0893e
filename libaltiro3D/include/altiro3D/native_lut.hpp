#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

struct NativeLutTables;

/// The look-up table of a display and a quilt layout. It holds, for every sub-pixel of the panel,
/// the quilt pixel whose colour the sub-pixel shows.
///
/// Immutable and cheap to copy (copies share the tables). Safe to use from any number of threads.
class ALTIRO3D_EXPORT NativeLut {
  public:
    /// Builds the table in double precision and in parallel; equal inputs give equal bytes for any
    /// number of threads. Each sub-pixel takes the nearest view and the nearest pixel of its tile:
    /// docs/mathematics.md, (1.1) to (1.10) and (2.1) to (2.3).
    /// @param calibration the display
    /// @param quilt the layout, at most 65535 px per side
    /// @param invert whether the order of views is reversed
    /// @throws Error BadFormat (calibration), InvalidArgument or TooLarge (layout, panel),
    ///         OutOfMemory
    NativeLut(const Calibration& calibration, const QuiltLayout& quilt,
              InvertViews invert = InvertViews::Auto);

    /// Reads a `.map` file (docs/map-format.md) and validates all of it.
    /// @param file a file or a pipe
    /// @return the table
    /// @throws Error NotFound, ReadFailed (no permission, neither file nor pipe), BadFormat (not a
    ///         `.map`, truncated, corrupt, oversize), OutOfMemory
    [[nodiscard]] static NativeLut load(const std::filesystem::path& file);

    /// Writes a `.map` file; it appears complete or not at all. The file holds at most the first 47
    /// bytes of the serial number.
    /// @param file the file; its directory must exist
    /// @throws Error WriteFailed
    void save(const std::filesystem::path& file) const;

    /// Size of the panel. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const;
    /// The layout of the quilt that the coordinates refer to. @return the layout
    [[nodiscard]] const QuiltLayout& quilt() const;
    /// Identifies the calibration that the table was built from. @return its fingerprint()
    [[nodiscard]] std::uint64_t calibrationFingerprint() const;
    /// Serial number of the display. @return may be empty
    [[nodiscard]] const std::string& serial() const;
    /// Whether the order of views is reversed. @return true if it is
    [[nodiscard]] bool inverted() const;

    /// The table of one colour.
    /// @param channel 0 red, 1 green, 2 blue
    /// @return [panel rows x panel cols, CV_16UC2, (X, Y) in px of the quilt, Y grows downward]
    /// @throws Error InvalidArgument (channel)
    [[nodiscard]] const cv::Mat& channel(int channel) const;

  private:
    explicit NativeLut(std::shared_ptr<const NativeLutTables> tables);
    std::shared_ptr<const NativeLutTables> tables_;
};

/// Checks that a table was built from this calibration.
/// @param lut the table
/// @param lutName name of the table in the error message
/// @param calibration the display
/// @param calibrationName name of the calibration in the error message
/// @throws Error Mismatch that names both
ALTIRO3D_EXPORT void requireSameDisplay(const NativeLut& lut, const std::string& lutName,
                                        const Calibration& calibration,
                                        const std::string& calibrationName);

} // namespace altiro3D
