#include "altiro3D/image_io.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "image_header.hpp"
#include "pixel_values.hpp"
#include "png_encode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <type_traits>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// OpenCV takes encoded pictures as one row of at most 2^31 - 1 bytes; room for two more is kept.
constexpr std::uintmax_t kMaxFileBytes = 0x7ffffff0u;
constexpr std::uint64_t kMaxPictureSide = 65500; // the longest side of a JPEG
constexpr const char* kReadable =
    "PNG, JPEG, TIFF, WebP, BMP, PNM, PFM, EXR, HDR or JPEG 2000; convert it first";

const char* nameOf(PictureFormat format) {
    switch (format) {
    case PictureFormat::Png:
        return "PNG";
    case PictureFormat::Jpeg:
        return "JPEG";
    case PictureFormat::Tiff:
        return "TIFF";
    case PictureFormat::WebP:
        return "WebP";
    case PictureFormat::Bmp:
        return "BMP";
    case PictureFormat::Pnm:
        return "PNM";
    case PictureFormat::Pfm:
        return "PFM";
    case PictureFormat::Exr:
        return "EXR";
    case PictureFormat::Hdr:
        return "HDR";
    case PictureFormat::Jpeg2000:
        return "JPEG 2000";
    case PictureFormat::Unknown:
        break;
    }
    return "unknown";
}

std::string lowerExtension(const fs::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return extension;
}

// ------------------------------------------------------------------------------------ reading

[[noreturn]] void refuseUnknown(const fs::path& path, const PictureHeader& header) {
    const std::string& name = header.otherFormat;
    if (name == "HTML") {
        throw Error(ErrorCode::BadFormat, path.string(),
                    "is a web page, expected a picture; download the picture itself");
    }
    if (name.size() > 6 && name.compare(name.size() - 6, 6, " video") == 0) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "is a video (" + name.substr(0, name.size() - 6) + "), expected a picture");
    }
    if (name == "ZIP" || name == "gzip") {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "is a " + name + " archive, expected a picture; unpack it first");
    }
    if (!name.empty()) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    name + " pictures are not read, expected " + kReadable);
    }
    throw Error(ErrorCode::BadFormat, path.string(),
                std::string("is no picture that can be read") +
                    (header.isText ? " (it holds text)" : "") +
                    ", expected PNG, JPEG, TIFF, WebP, BMP, PNM, PFM, EXR, HDR or JPEG 2000");
}

void checkHeader(const fs::path& path, const PictureHeader& header) {
    if (header.format == PictureFormat::Unknown) refuseUnknown(path, header);
    if (!header.unreadable.empty()) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    header.unreadable + " pictures are not read, expected an ordinary " +
                        nameOf(header.format) + " file; convert it first");
    }
    if (header.columns == 0 || header.rows == 0) {
        throw Error(ErrorCode::BadFormat, path.string(),
                    std::string("its header is damaged or cut off, expected a whole ") +
                        nameOf(header.format) + " file");
    }
    const double pixels = static_cast<double>(header.columns) * static_cast<double>(header.rows);
    if (header.columns > kMaxPictureSide || header.rows > kMaxPictureSide ||
        pixels > kMaxPicturePixels) {
        throw Error(ErrorCode::TooLarge, path.string(),
                    "has " + std::to_string(header.columns) + " x " + std::to_string(header.rows) +
                        " px, expected at most " +
                        std::to_string(static_cast<long long>(kMaxPicturePixels / 1e6)) +
                        " megapixels and sides of at most " + std::to_string(kMaxPictureSide) +
                        " px");
    }
}

void addNotes(const PictureHeader& header, const std::string& extension, Notes* notes) {
    if (notes == nullptr) return;
    if (header.format == PictureFormat::Jpeg && header.isCutOff) {
        notes->push_back(header.hasWholeScan ? "the file is cut off: its fine detail is missing"
                                             : "the file is cut off: its lower part is missing");
    }
    if (header.isUnmarkedCmyk) {
        notes->push_back("the file is CMYK without Adobe's mark: its colours may be inverted");
    }
    if (extension == ".mpo" && header.format == PictureFormat::Jpeg) {
        notes->push_back("the file holds several pictures: the first one is read");
    } else if (header.pictures > 1) {
        notes->push_back("the file holds " + std::to_string(header.pictures) +
                         (header.format == PictureFormat::Tiff ? " pages" : " frames") +
                         ": the first one is read");
    }
}

// OpenCV turns TIFF pictures by itself, others not: an upright tag leaves all of it to us.
void clearTiffOrientation(const PictureHeader& header, std::string& bytes) {
    const std::size_t at = header.orientationAt;
    const std::size_t size = header.orientationSize;
    if (at == 0 || at + size > bytes.size()) return;
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), size, '\0');
    bytes[header.isLittleEndian ? at : at + size - 1] = 1;
}

cv::Mat decode(const fs::path& path, const PictureHeader& header, std::string& bytes) {
    const std::string expected =
        std::string(", expected a whole ") + nameOf(header.format) + " file";
    // libjpeg waits for more bytes at the end of a cut-off file unless its end is marked.
    if (header.format == PictureFormat::Jpeg && header.isCutOff) {
        bytes.resize(header.usableBytes);
        bytes += "\xff\xd9";
    }
    // OpenCV wants something behind the last number of a text file.
    if (header.format == PictureFormat::Pnm && bytes[1] <= '3') bytes += '\n';
    if (header.format == PictureFormat::Tiff) clearTiffOrientation(header, bytes);
    std::string detail;
    cv::Mat picture;
    try {
        const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
        const int flags = header.isPalette ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION
                                           : cv::IMREAD_UNCHANGED;
        picture = cv::imdecode(encoded, flags);
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) throw std::bad_alloc();
        detail = exception.err;
    }
    if (!picture.empty()) return picture;
    if (header.format == PictureFormat::Exr && detail.find("OPENEXR") != std::string::npos) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "EXR pictures are switched off in this OpenCV, expected the environment "
                    "variable OPENCV_IO_ENABLE_OPENEXR=1");
    }
    throw Error(ErrorCode::BadFormat, path.string(),
                std::string(header.isCutOff ? "is cut off" : "is damaged or of an unusual kind") +
                    expected);
}

// a * b / largest, rounded; 8 and 16 bits.
template <typename T>
T scaled(T color, T alpha) {
    constexpr unsigned kLargest = sizeof(T) == 1 ? 255u : 65535u;
    return static_cast<T>((static_cast<unsigned>(color) * alpha + kLargest / 2) / kLargest);
}
template <>
float scaled(float color, float alpha) {
    return alpha > 0 ? color * std::min(alpha, 1.0f) : 0.0f;
}

template <typename T>
void compositeRow(const T* from, T* to, int columns, int colors, bool premultiplied) {
    for (int x = 0; x < columns; ++x, from += colors + 1, to += colors) {
        const T alpha = from[colors];
        for (int c = 0; c < colors; ++c)
            to[c] = premultiplied ? from[c] : scaled(from[c], alpha);
    }
}

template <typename T>
bool hasColorAboveAlpha(const cv::Mat& picture) {
    const int colors = picture.channels() - 1;
    for (int y = 0; y < picture.rows; ++y) {
        const T* from = picture.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, from += colors + 1) {
            if (*std::max_element(from, from + colors) > from[colors]) return true;
        }
    }
    return false;
}

// The picture over black: the last of 2 or 4 channels is its alpha.
template <typename T>
cv::Mat compositeOver(const cv::Mat& picture, AlphaKind kind) {
    // What shows a colour brighter than its alpha cannot be multiplied yet.
    const bool premultiplied = kind == AlphaKind::Premultiplied ||
                               (kind == AlphaKind::Unstated && !hasColorAboveAlpha<T>(picture));
    const int colors = picture.channels() - 1;
    cv::Mat result(picture.size(), CV_MAKETYPE(picture.depth(), colors));
    for (int y = 0; y < picture.rows; ++y) {
        compositeRow(picture.ptr<T>(y), result.ptr<T>(y), picture.cols, colors, premultiplied);
    }
    return result;
}

cv::Mat withoutAlpha(const cv::Mat& picture, const PictureHeader& header) {
    if (picture.channels() != 2 && picture.channels() != 4) return picture;
    AlphaKind kind = header.alpha;
    if (header.format == PictureFormat::Bmp && kind == AlphaKind::Unstated) {
        kind = AlphaKind::Premultiplied; // the fourth byte is padding: left out
    } else if (header.format == PictureFormat::Tiff && picture.depth() == CV_8U &&
               kind == AlphaKind::Straight) {
        kind = AlphaKind::Premultiplied; // libtiff has multiplied already
    }
    switch (picture.depth()) {
    case CV_8U:
        return compositeOver<std::uint8_t>(picture, kind);
    case CV_16U:
        return compositeOver<std::uint16_t>(picture, kind);
    default:
        break;
    }
    if (picture.depth() == CV_32F) return compositeOver<float>(picture, kind);
    return picture;
}

// Pixels of the one transparent colour become black; OpenCV shows them.
template <typename T>
void blackenColor(cv::Mat& picture, const ColorKey& color, int bits) {
    const unsigned mask = (1u << bits) - 1;
    const unsigned factor = bits < 8 ? 255u / mask : 1u; // OpenCV spreads fewer bits over 0..255
    const T blue = static_cast<T>((color.blue & mask) * factor);
    const T green = static_cast<T>((color.green & mask) * factor);
    const T red = static_cast<T>((color.red & mask) * factor);
    const int channels = picture.channels();
    for (int y = 0; y < picture.rows; ++y) {
        T* row = picture.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, row += channels) {
            if (row[0] != blue) continue;
            if (channels == 3 && (row[1] != green || row[2] != red)) continue;
            std::fill_n(row, channels, T{0});
        }
    }
}

void blackenTransparent(cv::Mat& picture, const PictureHeader& header) {
    if (!header.transparentColor || picture.channels() == 2 || picture.channels() > 3) return;
    const int bits = header.bitsPerSample;
    if (picture.depth() == CV_8U && bits <= 8) {
        blackenColor<std::uint8_t>(picture, *header.transparentColor, bits);
    } else if (picture.depth() == CV_16U && bits == 16) {
        blackenColor<std::uint16_t>(picture, *header.transparentColor, bits);
    }
}

// cv::rotate() by a quarter turn, in bands that stay in the cache and on all threads.
void turn(const cv::Mat& picture, bool clockwise, cv::Mat& result) {
    constexpr int kBandRows = 64;
    result.create(picture.cols, picture.rows, picture.type());
    const int bands = (result.rows + kBandRows - 1) / kBandRows;
    cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& range) {
        for (int band = range.start; band < range.end; ++band) {
            const cv::Range to(band * kBandRows, std::min((band + 1) * kBandRows, result.rows));
            const cv::Range from =
                clockwise ? to : cv::Range(picture.cols - to.end, picture.cols - to.start);
            cv::Mat rows = result.rowRange(to);
            cv::rotate(picture.colRange(from), rows,
                       clockwise ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE);
        }
    });
}

cv::Mat upright(const cv::Mat& picture, int orientation) {
    cv::Mat result;
    switch (orientation) { // EXIF: where the 0th row and the 0th column of the file are seen
    case 2:
        cv::flip(picture, result, 1);
        return result; // top, right
    case 3:
        cv::flip(picture, result, -1);
        return result; // bottom, right
    case 4:
        cv::flip(picture, result, 0);
        return result; // bottom, left
    case 5:
        cv::transpose(picture, result);
        return result; // left, top
    case 6:
        turn(picture, true, result);
        return result; // right, top
    case 7:            // right, bottom
        cv::transpose(picture, result);
        cv::flip(result, result, -1);
        return result;
    case 8:
        turn(picture, false, result);
        return result;
    default:
        return picture;
    }
}

struct LoadedPicture {
    cv::Mat picture;      // 1 or 3 channels, any depth, upright
    PictureHeader header; // what the file says
};

LoadedPicture load(const fs::path& path, Notes* notes) {
    try {
        const std::string extension = lowerExtension(path);
        std::string bytes = readFile(path, kMaxFileBytes);
        if (bytes.empty()) {
            throw Error(ErrorCode::BadFormat, path.string(), "is empty, expected a picture");
        }
        LoadedPicture loaded;
        loaded.header = readPictureHeader(bytes, extension);
        const PictureHeader& header = loaded.header;
        checkHeader(path, header);
        cv::Mat picture = decode(path, header, bytes);
        std::string().swap(bytes);
        picture = withoutAlpha(picture, header);
        blackenTransparent(picture, header);
        // OpenCV knows 0 = white for 8 bits only.
        if (header.isWhiteZero && picture.type() == CV_16UC1) cv::bitwise_not(picture, picture);
        if (picture.channels() != 1 && picture.channels() != 3) {
            throw Error(ErrorCode::Unsupported, path.string(),
                        "has " + std::to_string(picture.channels()) +
                            " channels, expected grey, RGB or either with alpha");
        }
        loaded.picture = upright(picture, header.orientation);
        addNotes(header, extension, notes);
        return loaded;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::OutOfMemory, path.string(),
                    "does not fit into memory, expected a smaller picture");
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) {
            throw Error(ErrorCode::OutOfMemory, path.string(),
                        "does not fit into memory, expected a smaller picture");
        }
        throw Error(ErrorCode::BadFormat, path.string(),
                    "cannot be decoded (" + exception.err + "), expected an ordinary picture");
    }
}

template <typename T>
bool isGrey(const cv::Mat& bgr) {
    for (int y = 0; y < bgr.rows; ++y) {
        const T* pixel = bgr.ptr<T>(y);
        for (int x = 0; x < bgr.cols; ++x, pixel += 3) {
            if (pixel[0] != pixel[1] || pixel[1] != pixel[2]) return false;
        }
    }
    return true;
}

// Whole numbers stay what they are where all three channels agree.
template <typename T>
cv::Mat greyOf(const cv::Mat& bgr) {
    cv::Mat grey;
    if (std::is_integral_v<T> && isGrey<T>(bgr)) {
        cv::extractChannel(bgr, grey, 1);
        return grey;
    }
    grey.create(bgr.size(), CV_32FC1);
    for (int y = 0; y < bgr.rows; ++y)
        greyRow(bgr.ptr<T>(y), grey.ptr<float>(y), bgr.cols);
    return grey;
}

// ------------------------------------------------------------------------------------ writing

struct Writer {
    const char* extension;
    const char* format;
    bool holds16Bit;
    int channels;    // 0: grey and colour, else only this
    int longestSide; // px
};

constexpr std::array<Writer, 13> kWriters = {{
    {".png", "PNG", true, 0, 1000000},
    {".jpg", "JPEG", false, 0, 65500},
    {".jpeg", "JPEG", false, 0, 65500},
    {".jpe", "JPEG", false, 0, 65500},
    {".tif", "TIFF", true, 0, 1000000},
    {".tiff", "TIFF", true, 0, 1000000},
    {".webp", "WebP", false, 0, 16383},
    {".bmp", "BMP", false, 0, 1000000},
    {".dib", "BMP", false, 0, 1000000},
    {".ppm", "PPM", true, 3, 1000000},
    {".pgm", "PGM", true, 1, 1000000},
    {".pnm", "PNM", true, 0, 1000000},
    {".jp2", "JPEG 2000", true, 0, 1000000},
}};

const Writer* writerFor(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    const auto* const found =
        std::find_if(kWriters.begin(), kWriters.end(),
                     [&](const Writer& writer) { return extension == writer.extension; });
    return found == kWriters.end() ? nullptr : found;
}

void convertToEightBits(const cv::Mat& picture, cv::Mat& result) {
    result.create(picture.size(), CV_MAKETYPE(CV_8U, picture.channels()));
    const int samples = picture.cols * picture.channels();
    for (int y = 0; y < picture.rows; ++y) {
        const std::uint16_t* from = picture.ptr<std::uint16_t>(y);
        std::uint8_t* to = result.ptr<std::uint8_t>(y);
        for (int i = 0; i < samples; ++i) {
            to[i] = toEightBits(from[i]);
        }
    }
}

// The pieces of the file; none if it cannot be encoded.
std::vector<std::vector<unsigned char>> encode(const cv::Mat& picture, const Writer& writer) {
    const std::string format = writer.format;
    if (format == "PNG") return png::encode(picture);
    cv::Mat suited = picture;
    if (picture.depth() == CV_16U && !writer.holds16Bit) convertToEightBits(picture, suited);
    if (writer.channels == 3 && suited.channels() == 1) {
        cv::cvtColor(suited, suited, cv::COLOR_GRAY2BGR);
    }
    std::vector<int> settings;
    if (format == "JPEG") settings = {cv::IMWRITE_JPEG_QUALITY, 95};
    std::vector<std::vector<unsigned char>> pieces(1);
    if (!cv::imencode(writer.extension, suited, pieces[0], settings) || pieces[0].empty()) {
        pieces.clear();
    }
    return pieces;
}

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

unsigned char folded(char c) {
    return static_cast<unsigned char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
}

} // namespace

cv::Mat readPicture(const fs::path& path, Notes* notes) {
    const LoadedPicture loaded = load(path, notes);
    cv::Mat picture = loaded.picture;
    switch (picture.depth()) {
    case CV_8U:
    case CV_32F:
        break;
    case CV_64F:
        picture.convertTo(picture, CV_32F);
        break;
    case CV_16U:
        // OpenCV spreads PNM samples of up to 8 bits over the whole range, longer ones not.
        if (const unsigned largest = loaded.header.largestSample;
            largest > 255 && largest < 65535) {
            picture.convertTo(picture, CV_16U, 65535.0 / largest);
        }
        break;
    default:
        throw Error(ErrorCode::Unsupported, path.string(),
                    "has signed or 32-bit whole numbers, expected 8 or 16 bits without sign or "
                    "float numbers; convert it first");
    }
    if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    return picture;
}

cv::Mat readPhoto(const fs::path& path, Notes* notes) {
    cv::Mat picture = readPicture(path, notes);
    if (picture.depth() == CV_8U) return picture;
    cv::Mat photo;
    if (picture.depth() == CV_16U) {
        convertToEightBits(picture, photo);
        return photo;
    }
    photo.create(picture.size(), CV_8UC3);
    for (int y = 0; y < picture.rows; ++y) {
        const float* from = picture.ptr<float>(y);
        std::uint8_t* to = photo.ptr<std::uint8_t>(y);
        for (int i = 0; i < 3 * picture.cols; ++i) {
            to[i] = toWhole<std::uint8_t>(from[i], 255.0f);
        }
    }
    return photo;
}

double readFocalLength35mm(const fs::path& path) {
    return readPictureHeader(readFile(path, kMaxFileBytes), lowerExtension(path)).focalLength35mm;
}

cv::Mat readDepthSamples(const fs::path& path, Notes* notes) {
    cv::Mat picture = load(path, notes).picture;
    if (picture.channels() == 3) {
        switch (picture.depth()) {
        case CV_8U:
            return greyOf<std::uint8_t>(picture);
        case CV_16U:
            return greyOf<std::uint16_t>(picture);
        case CV_32F:
            return greyOf<float>(picture);
        default:
            break;
        }
        cv::Mat numbers;
        picture.convertTo(numbers, CV_64F);
        return greyOf<double>(numbers);
    }
    if (picture.depth() == CV_8U || picture.depth() == CV_16U) return picture;
    cv::Mat depth;
    picture.convertTo(depth, CV_32F);
    return depth;
}

cv::Mat readDepthImage(const fs::path& path, Notes* notes) {
    cv::Mat depth = readDepthSamples(path, notes);
    if (depth.depth() != CV_32F) depth.convertTo(depth, CV_32F);
    return depth;
}

void writePicture(const fs::path& path, const cv::Mat& picture) {
    const Writer* const writer = writerFor(path);
    if (writer == nullptr) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "its extension names no picture format that is written, expected .png, .jpg, "
                    ".tif, .webp, .bmp, .ppm, .pgm or .jp2");
    }
    const int type = picture.type();
    if (picture.empty() || picture.dims != 2 ||
        (type != CV_8UC1 && type != CV_8UC3 && type != CV_16UC1 && type != CV_16UC3)) {
        throw Error(
            ErrorCode::InvalidArgument, "picture",
            (picture.empty() ? std::string("is empty") : "has the type " + cv::typeToString(type)) +
                ", expected 8 or 16 bits and 1 or 3 channels");
    }
    if (std::max(picture.cols, picture.rows) > writer->longestSide) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    std::to_string(picture.cols) + " x " + std::to_string(picture.rows) +
                        " px are too many for " + writer->format + ", expected sides of at most " +
                        std::to_string(writer->longestSide) + " px; write a .png");
    }
    if (writer->channels == 1 && picture.channels() == 3) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    std::string(writer->format) +
                        " holds no colours, expected .ppm or .png for a colour picture");
    }
    std::vector<std::vector<unsigned char>> pieces;
    try {
        pieces = encode(picture, *writer);
    } catch (const cv::Exception& exception) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    std::string("cannot be encoded as ") + writer->format + ": " + exception.err +
                        "; write a .png");
    }
    if (pieces.empty()) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    std::string("cannot be encoded as ") + writer->format + "; write a .png");
    }
    std::vector<Bytes> parts;
    for (const std::vector<unsigned char>& piece : pieces)
        parts.push_back({piece.data(), piece.size()});
    writeFile(path, parts);
}

bool canWritePicture(const fs::path& path) {
    return writerFor(path) != nullptr;
}

std::vector<fs::path> listPictures(const fs::path& directory) {
    constexpr std::array<const char*, 19> kExtensions = {
        ".png", ".jpg", ".jpeg", ".jpe", ".mpo", ".tif", ".tiff", ".webp", ".bmp", ".dib",
        ".pnm", ".ppm", ".pgm",  ".pbm", ".pfm", ".exr", ".hdr",  ".jp2",  ".j2k"};
    std::error_code error;
    if (!fs::exists(fs::status(directory, error))) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "does not exist, expected a directory with pictures");
    }
    std::vector<fs::path> pictures;
    fs::directory_iterator entries(directory, error);
    while (!error && entries != fs::directory_iterator()) {
        const fs::path& path = entries->path();
        const bool isHidden = path.filename().string().rfind('.', 0) == 0;
        const std::string extension = lowerExtension(path);
        std::error_code unreadable; // a link into nowhere is left out
        if (!isHidden &&
            std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
            entries->is_regular_file(unreadable)) {
            pictures.push_back(path);
        }
        entries.increment(error);
    }
    if (error) {
        throw Error(ErrorCode::ReadFailed, directory.string(),
                    "cannot be listed: " + error.message() + ", expected a directory");
    }
    std::sort(pictures.begin(), pictures.end(), [](const fs::path& a, const fs::path& b) {
        return naturalLess(a.filename().string(), b.filename().string());
    });
    return pictures;
}

bool naturalLess(const std::string& a, const std::string& b) {
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size()) {
        if (!isDigit(a[i]) || !isDigit(b[j])) {
            if (folded(a[i]) != folded(b[j])) return folded(a[i]) < folded(b[j]);
            ++i;
            ++j;
            continue;
        }
        while (i < a.size() && a[i] == '0')
            ++i;
        while (j < b.size() && b[j] == '0')
            ++j;
        const auto digitsEnd = [](const std::string& text, std::size_t at) {
            while (at < text.size() && isDigit(text[at]))
                ++at;
            return at;
        };
        const std::size_t endA = digitsEnd(a, i);
        const std::size_t endB = digitsEnd(b, j);
        if (endA - i != endB - j) return endA - i < endB - j;
        const int order = a.compare(i, endA - i, b, j, endB - j);
        if (order != 0) return order < 0;
        i = endA;
        j = endB;
    }
    const std::size_t restA = a.size() - i;
    const std::size_t restB = b.size() - j;
    if ((restA == 0) != (restB == 0)) return restA == 0;
    return a < b; // equal but for case or leading zeros: some fixed order
}

} // namespace altiro3D
