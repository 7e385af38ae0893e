#include "image/row_file.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/colour.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <zlib.h>

namespace altiro3D {

namespace fs = std::filesystem;

// What a format writes before, for and after the rows.
class RowFormat {
  public:
    RowFormat(FileWriter& file, cv::Size size, int channels, cv::Size2d dpi)
        : file_(file), size_(size), channels_(channels), dpi_(dpi) {}
    virtual ~RowFormat() = default;
    RowFormat(const RowFormat&) = delete;
    RowFormat& operator=(const RowFormat&) = delete;
    virtual void begin() = 0;
    virtual void band(const cv::Mat& rows) = 0;
    virtual void end() = 0;

  protected:
    FileWriter& file_;
    cv::Size size_;
    int channels_;
    cv::Size2d dpi_;
};

namespace {

using Buffer = std::vector<unsigned char>;

constexpr std::size_t kStripBytes = std::size_t{1} << 19;
constexpr int kStripsInBand = 16; // shared by the threads

constexpr double kPointsPerInch = 72;

Bytes bytesOf(const Buffer& buffer) {
    return {buffer.data(), buffer.size()};
}

Bytes bytesOf(std::string_view text) {
    return {text.data(), text.size()};
}

class PngFormat : public RowFormat {
  public:
    PngFormat(FileWriter& file, cv::Size size, int channels, cv::Size2d dpi, std::string_view text)
        : RowFormat(file, size, channels, dpi), rows_(size), text_(text) {}
    void begin() override {
        Buffer head = pngHead(size_, CV_8UC(channels_), text_);
        appendPngSize(dpi_, head);
        file_.append({bytesOf(head)});
    }
    void band(const cv::Mat& rows) override {
        for (const Buffer& part : rows_.deflated(rows))
            chunk("IDAT", part);
    }
    void end() override {
        chunk("IDAT", rows_.end());
        chunk("IEND", {});
    }

  private:
    void chunk(const char* name, const Buffer& contents) {
        Buffer whole;
        appendPngChunk(name, contents, whole);
        file_.append({bytesOf(whole)});
    }
    PngRows rows_;
    std::string text_;
};

// Strips of rows, each deflated by itself, behind the header; the directory follows them.
class TiffFormat : public RowFormat {
  public:
    using RowFormat::RowFormat;

    void begin() override {
        put16(0x4949); // little endian
        put16(42);
        put32(0); // place of the directory, see end()
        flush();
    }

    void band(const cv::Mat& rows) override {
        const int stripRows = rowsOfStrip();
        const int strips = (rows.rows + stripRows - 1) / stripRows;
        std::vector<Buffer> deflated(static_cast<std::size_t>(strips));
        overRows(strips, [&](int i) {
            const int from = i * stripRows;
            deflated[static_cast<std::size_t>(i)] =
                strip(rows.rowRange(from, std::min(from + stripRows, rows.rows)));
        });
        for (const Buffer& one : deflated) {
            places_.push_back(place());
            counts_.push_back(static_cast<std::uint32_t>(one.size()));
            file_.append({bytesOf(one)});
        }
    }

    void end() override {
        const Buffer profile = srgbProfile();
        const std::uint32_t profileAt = place();
        file_.append({bytesOf(profile)});
        if (file_.size() % 2 == 1) file_.append({bytesOf(std::string_view("\0", 1))});
        const std::uint32_t bitsAt = place();
        for (int i = 0; i < 4; ++i)
            put16(8);
        flush();
        const std::uint32_t acrossAt = place();
        for (const double dpi : {dpi_.width, dpi_.height}) {
            put32(static_cast<std::uint32_t>(std::lround(dpi * 10000)));
            put32(10000);
        }
        flush();
        const std::uint32_t placesAt = list(places_);
        const std::uint32_t countsAt = list(counts_);
        const std::uint32_t directory = place();
        const auto strips = static_cast<std::uint32_t>(places_.size());
        const auto colours = static_cast<std::uint32_t>(channels_);
        enum : std::uint16_t { Short = 3, Long = 4, Rational = 5, Undefined = 7 };
        const struct {
            std::uint16_t tag, type;
            std::uint32_t count, value;
        } entries[] = {{256, Long, 1, static_cast<std::uint32_t>(size_.width)},
                       {257, Long, 1, static_cast<std::uint32_t>(size_.height)},
                       {258, Short, colours, colours == 1 ? 8 : bitsAt},
                       {259, Short, 1, 8},                      // Deflate
                       {262, Short, 1, colours == 1 ? 1U : 2U}, // black is 0; RGB
                       {273, Long, strips, placesAt},
                       {277, Short, 1, colours},
                       {278, Long, 1, static_cast<std::uint32_t>(rowsOfStrip())},
                       {279, Long, strips, countsAt},
                       {282, Rational, 1, acrossAt},
                       {283, Rational, 1, acrossAt + 8},
                       {296, Short, 1, 2}, // inch
                       {317, Short, 1, 2}, // differences of neighbours
                       {34675, Undefined, static_cast<std::uint32_t>(profile.size()), profileAt}};
        const bool isGrey = colours == 1; // the profile is of three colours
        put16(isGrey ? 13 : 14);
        for (const auto& entry : entries) {
            if (isGrey && entry.tag == 34675) continue;
            put16(entry.tag);
            put16(entry.type);
            put32(entry.count);
            put32(entry.value); // a short value has its low bytes first
        }
        put32(0);
        flush();
        put32(directory);
        file_.replace(4, bytesOf(buffer_));
        buffer_.clear();
    }

  private:
    int rowsOfStrip() const {
        const std::size_t row =
            static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(channels_);
        return static_cast<int>(std::max<std::size_t>(1, kStripBytes / row));
    }

    Buffer strip(const cv::Mat& rows) const {
        const auto channels = static_cast<std::size_t>(channels_);
        const std::size_t row = static_cast<std::size_t>(rows.cols) * channels;
        Buffer plain(row * static_cast<std::size_t>(rows.rows));
        auto* to = plain.data();
        for (int y = 0; y < rows.rows; ++y) {
            const auto* from = rows.ptr<unsigned char>(y);
            for (std::size_t i = 0; i < row; i += channels) {
                for (std::size_t c = 0; c < channels; ++c) {
                    const std::size_t at = i + channels - 1 - c; // BGR to RGB
                    const int left = i == 0 ? 0 : from[at - channels];
                    *to++ = static_cast<unsigned char>(from[at] - left);
                }
            }
        }
        uLongf size = compressBound(static_cast<uLong>(plain.size()));
        Buffer deflated(size);
        if (compress2(deflated.data(), &size, plain.data(), static_cast<uLong>(plain.size()),
                      Z_BEST_SPEED) != Z_OK)
            throw std::bad_alloc();
        deflated.resize(size);
        return deflated;
    }

    std::uint32_t place() const {
        if (file_.size() > std::numeric_limits<std::uint32_t>::max())
            throw Error(ErrorCode::TooLarge, "TIFF", "has more than 4 GB, expected a .png");
        return static_cast<std::uint32_t>(file_.size());
    }
    // Writes a list of numbers and returns its place; a single number is returned itself.
    std::uint32_t list(const std::vector<std::uint32_t>& numbers) {
        if (numbers.size() == 1) return numbers.front();
        const std::uint32_t at = place();
        for (const std::uint32_t number : numbers)
            put32(number);
        flush();
        return at;
    }
    void put16(std::uint32_t value) {
        buffer_.push_back(static_cast<unsigned char>(value & 0xffU));
        buffer_.push_back(static_cast<unsigned char>(value >> 8 & 0xffU));
    }
    void put32(std::uint32_t value) {
        put16(value & 0xffffU);
        put16(value >> 16);
    }
    void flush() {
        file_.append({bytesOf(buffer_)});
        buffer_.clear();
    }

    std::vector<std::uint32_t> places_;
    std::vector<std::uint32_t> counts_;
    Buffer buffer_;
};

// One page; its picture has the rows of a PNG.
class PdfFormat : public RowFormat {
  public:
    PdfFormat(FileWriter& file, cv::Size size, int channels, cv::Size2d dpi)
        : RowFormat(file, size, channels, dpi), rows_(size) {}

    void begin() override {
        const double across = size_.width / dpi_.width * kPointsPerInch;
        const double down = size_.height / dpi_.height * kPointsPerInch;
        // readers limit pages to 14400 units; the unit of larger ones is several points
        constexpr double kMaxUnits = 14400;
        const double unit = std::ceil(std::max({across, down, kMaxUnits}) / kMaxUnits);
        const std::string width = numberText(across / unit, 12);
        const std::string height = numberText(down / unit, 12);
        put((unit > 1 ? "%PDF-1.6" : "%PDF-1.5") + std::string("\n%\xE2\xE3\xCF\xD3\n"));
        object("<< /Type /Catalog /Pages 2 0 R >>");
        object("<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
        object("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + width + " " + height + "]" +
               (unit > 1 ? " /UserUnit " + numberText(unit) : "") +
               " /Resources << /XObject << /I 6 0 R >> >> /Contents 4 0 R >>");
        const std::string draw = "q " + width + " 0 0 " + height + " 0 0 cm /I Do Q";
        object("<< /Length " + std::to_string(draw.size()) + " >>\nstream\n" + draw +
               "\nendstream");
        const Buffer profile = srgbProfile();
        object("<< /N 3 /Length " + std::to_string(profile.size()) + " >>\nstream\n" +
               std::string(profile.begin(), profile.end()) + "\nendstream");
        const std::string columns = std::to_string(size_.width);
        open("<< /Type /XObject /Subtype /Image /Width " + columns + " /Height " +
             std::to_string(size_.height) + " /BitsPerComponent 8 /ColorSpace " +
             (channels_ == 1 ? "/DeviceGray" : "[/ICCBased 5 0 R]") +
             " /Filter /FlateDecode /DecodeParms << /Predictor 15 /Colors " +
             std::to_string(channels_) + " /BitsPerComponent 8 /Columns " + columns +
             " >> /Length 7 0 R >>\nstream\n");
        picture_ = file_.size();
    }
    void band(const cv::Mat& rows) override {
        for (const Buffer& part : rows_.deflated(rows))
            file_.append({bytesOf(part)});
    }
    void end() override {
        file_.append({bytesOf(rows_.end())});
        const std::uint64_t length = file_.size() - picture_;
        put("\nendstream\nendobj\n");
        object(std::to_string(length));
        const std::uint64_t table = file_.size();
        const std::string count = std::to_string(objects_.size() + 1);
        put("xref\n0 " + count + "\n0000000000 65535 f \n");
        for (const std::uint64_t at : objects_) {
            const std::string digits = std::to_string(at);
            put(std::string(10 - digits.size(), '0') + digits + " 00000 n \n");
        }
        put("trailer\n<< /Size " + count + " /Root 1 0 R >>\nstartxref\n" + std::to_string(table) +
            "\n%%EOF\n");
    }

  private:
    void put(const std::string& text) { file_.append({bytesOf(text)}); }
    void open(const std::string& text) {
        objects_.push_back(file_.size());
        put(std::to_string(objects_.size()) + " 0 obj\n" + text);
    }
    void object(const std::string& text) {
        open(text);
        put("\nendobj\n");
    }

    PngRows rows_;
    std::vector<std::uint64_t> objects_;
    std::uint64_t picture_ = 0;
};

const fs::path& writable(const fs::path& path) {
    if (RowFile::canWrite(path)) return path;
    throw Error(ErrorCode::Unsupported, path.string(),
                "is no format of prints, expected .png, .tif or .pdf");
}

} // namespace

bool RowFile::canWrite(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".png" || extension == ".tif" || extension == ".tiff" ||
           extension == ".pdf";
}

RowFile::RowFile(const fs::path& path, cv::Size size, int type, cv::Size2d dpi, ImageMark mark)
    : path_(path), size_(size), file_(writable(path)) {
    const std::size_t row =
        static_cast<std::size_t>(size.width) * static_cast<std::size_t>(CV_ELEM_SIZE(type));
    const int strip = static_cast<int>(std::max<std::size_t>(1, kStripBytes / row));
    band_.create(std::min(kStripsInBand * strip, size.height), size.width, type);
    const int channels = CV_MAT_CN(type);
    const std::string extension = lowerExtension(path);
    if (extension == ".png") {
        format_ = std::make_unique<PngFormat>(file_, size, channels, dpi,
                                              mark == ImageMark::Native ? kNativeMark
                                                                        : std::string_view());
    } else if (extension == ".pdf") {
        format_ = std::make_unique<PdfFormat>(file_, size, channels, dpi);
    } else {
        format_ = std::make_unique<TiffFormat>(file_, size, channels, dpi);
    }
    format_->begin();
}

RowFile::~RowFile() = default;

void RowFile::requireRows(bool good, int rows) const {
    if (good) return;
    throw Error(ErrorCode::Mismatch, path_.string(),
                "has " + std::to_string(rows) + " rows, expected " + std::to_string(size_.height));
}

void RowFile::write(const cv::Mat& rows) {
    if (rows.cols != size_.width || rows.type() != band_.type())
        throw Error(ErrorCode::Mismatch, path_.string(), shapeText(rows));
    requireRows(written_ + filled_ + rows.rows <= size_.height, written_ + filled_ + rows.rows);
    for (int from = 0; from < rows.rows;) {
        const int count = std::min(rows.rows - from, band_.rows - filled_);
        rows.rowRange(from, from + count).copyTo(band_.rowRange(filled_, filled_ + count));
        from += count;
        filled_ += count;
        if (filled_ < band_.rows && written_ + filled_ < size_.height) continue;
        format_->band(band_.rowRange(0, filled_));
        written_ += filled_;
        filled_ = 0;
    }
}

void RowFile::finish() {
    requireRows(written_ == size_.height, written_);
    format_->end();
    file_.finish();
}

} // namespace altiro3D
