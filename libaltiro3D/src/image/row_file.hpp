#pragma once

#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

class RowFormat;

/// A picture of a physical size, written from top to bottom, so that it need not fit into memory:
/// PNG (pHYs, sRGB), TIFF (resolution, Deflate, sRGB profile) or a PDF of one page. The file's
/// bytes do not depend on how the rows are divided, nor on the number of threads.
class RowFile {
  public:
    /// @param path .png, .tif, .tiff or .pdf
    /// @param size of the picture, px
    /// @param type CV_8UC1 or CV_8UC3, BGR
    /// @param dpi px per inch across and down
    /// @param mark as for writeImage(); PNG only
    /// @throws Error Unsupported (extension), WriteFailed
    RowFile(const std::filesystem::path& path, cv::Size size, int type, cv::Size2d dpi,
            ImageMark mark = ImageMark::None);
    ~RowFile();
    RowFile(const RowFile&) = delete;
    RowFile& operator=(const RowFile&) = delete;

    /// Writes the next rows. @throws Error WriteFailed; Mismatch (width, type, too many rows)
    void write(const cv::Mat& rows);
    /// Completes the file. @throws Error WriteFailed; Mismatch (rows are missing)
    void finish();

    /// Whether the extension names a format that can be written.
    static bool canWrite(const std::filesystem::path& path);

  private:
    void requireRows(bool good, int rows) const;

    std::filesystem::path path_;
    cv::Size size_;
    FileWriter file_;
    std::unique_ptr<RowFormat> format_;
    cv::Mat band_;
    int filled_ = 0;  // rows of the band
    int written_ = 0; // rows before it
};

} // namespace altiro3D
