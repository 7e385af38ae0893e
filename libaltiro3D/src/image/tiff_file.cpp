#include "image/tiff_file.hpp"

#include "base/owned.hpp"
#include "image/exif.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tiffio.h>
#include <vector>

namespace altiro3D {

namespace {

constexpr unsigned kMaxPages = 10000;
constexpr std::size_t kMaxProfileBytes = std::size_t{16} << 20;
constexpr std::uint64_t kMaxTileBytes = std::uint64_t{1} << 31;

// The file as libtiff reads it, and its last complaint.
struct Source {
    std::string_view bytes;
    std::size_t at = 0;
    std::array<char, 160> complaint{};
};

Source& sourceOf(thandle_t handle) {
    return *static_cast<Source*>(handle);
}

tmsize_t readSource(thandle_t handle, void* to, tmsize_t size) {
    Source& source = sourceOf(handle);
    if (source.at > source.bytes.size() || size < 0) return 0;
    const std::size_t count =
        source.bytes.copy(static_cast<char*>(to), static_cast<std::size_t>(size), source.at);
    source.at += count;
    return static_cast<tmsize_t>(count);
}

toff_t seekSource(thandle_t handle, toff_t offset, int from) {
    Source& source = sourceOf(handle);
    const toff_t base = from == SEEK_CUR ? source.at : from == SEEK_END ? source.bytes.size() : 0;
    source.at = static_cast<std::size_t>(base + offset);
    return source.at;
}

toff_t sizeOfSource(thandle_t handle) {
    return sourceOf(handle).bytes.size();
}

int mapSource(thandle_t handle, void** base, toff_t* size) {
    const std::string_view bytes = sourceOf(handle).bytes;
    *base = const_cast<char*>(bytes.data()); // libtiff does not write to it
    *size = bytes.size();
    return 1;
}

int keepComplaint(TIFF* /*file*/, void* source, const char* /*module*/, const char* format,
                  va_list values) {
    auto& complaint = static_cast<Source*>(source)->complaint;
    std::vsnprintf(complaint.data(), complaint.size(), format, values);
    return 1; // the handlers of the whole program are not called
}

int ignoreWarning(TIFF* /*file*/, void* /*source*/, const char* /*module*/, const char* /*format*/,
                  va_list /*values*/) {
    return 1;
}

using File = std::unique_ptr<TIFF, Free<TIFFClose>>;

File open(Source& source) {
    const std::unique_ptr<TIFFOpenOptions, Free<TIFFOpenOptionsFree>> options(
        TIFFOpenOptionsAlloc());
    if (!options) throw std::bad_alloc();
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keepComplaint, &source);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignoreWarning, nullptr);
    const auto write = [](thandle_t, void*, tmsize_t) -> tmsize_t { return 0; };
    const auto close = [](thandle_t) { return 0; };
    return File(TIFFClientOpenExt("TIFF", "r", &source, readSource, write, seekSource, close,
                                  sizeOfSource, mapSource, nullptr, options.get()));
}

// A field of one number; a fallback if the file does not state it.
template <typename T>
unsigned field(TIFF* file, std::uint32_t tag, unsigned fallback) {
    T value = 0;
    return TIFFGetFieldDefaulted(file, tag, &value) == 1 ? value : fallback;
}

// A reduced copy or a mask.
bool isSecondary(TIFF* file) {
    std::uint16_t old = 0;
    if (TIFFGetField(file, TIFFTAG_OSUBFILETYPE, &old) == 1 && old == OFILETYPE_REDUCEDIMAGE)
        return true;
    return (field<std::uint32_t>(file, TIFFTAG_SUBFILETYPE, 0) &
            (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

// Goes to the picture's directory. @return how many there are, without reduced copies and masks
unsigned choosePage(TIFF* file) {
    std::vector<std::uint64_t> below;
    std::uint16_t count = 0;
    std::uint64_t* offsets = nullptr;
    if (TIFFGetField(file, TIFFTAG_SUBIFD, &count, &offsets) == 1)
        below.assign(offsets, offsets + count);
    unsigned pages = 0;
    tdir_t chosen = 0;
    for (unsigned i = 0; i < kMaxPages; ++i) {
        if (!isSecondary(file) && ++pages == 1) chosen = static_cast<tdir_t>(i);
        if (TIFFReadDirectory(file) != 1) break;
    }
    if (pages == 0) {
        for (const std::uint64_t offset : below) {
            if (TIFFSetSubDirectory(file, offset) == 1 && !isSecondary(file)) return 1;
        }
    }
    return TIFFSetDirectory(file, chosen) == 1 ? std::max(1U, pages) : 0;
}

// The numbers of a palette have 16 bits; those that use 8 are taken as such.
cv::Mat coloursOfPalette(TIFF* file, unsigned bits, const cv::Mat& indices) {
    std::array<std::uint16_t*, 3> columns{}; // blue, green, red
    if (TIFFGetField(file, TIFFTAG_COLORMAP, &columns[2], &columns[1], &columns[0]) != 1)
        throw PictureFailure("its palette is missing");
    const bool isDeep = std::any_of(columns.begin(), columns.end(), [&](const auto* column) {
        return std::any_of(column, column + (std::size_t{1} << bits),
                           [](unsigned v) { return v > 255; });
    });
    cv::Mat whole;
    indices.convertTo(whole, CV_16U);
    cv::Mat result(indices.size(), CV_8UC3);
    for (int y = 0; y < whole.rows; ++y) {
        const auto* const from = whole.ptr<std::uint16_t>(y);
        std::uint8_t* to = result.ptr(y);
        for (int x = 0; x < whole.cols; ++x)
            for (const std::uint16_t* column : columns)
                *to++ = static_cast<std::uint8_t>(column[from[x]] >> (isDeep ? 8 : 0));
    }
    return result;
}

// L* fills the range, a* and b* are signed (CIELab) or begin at -128 (ICCLab).
cv::Mat labOf(const cv::Mat& stored, bool isIcc) {
    const bool deep = stored.depth() == CV_16U;
    const float step = deep ? 256 : 1;
    const float light = !deep ? 255.0F / 100 : (isIcc ? 65280.0F : 65535.0F) / 100;
    cv::Mat lab;
    stored.convertTo(lab, CV_32F);
    for (int y = 0; y < lab.rows; ++y) {
        for (auto* px = lab.ptr<cv::Vec3f>(y); px != lab.ptr<cv::Vec3f>(y) + lab.cols; ++px) {
            (*px)[0] /= light;
            for (int c = 1; c < 3; ++c) {
                float value = (*px)[c] / step;
                if (isIcc || value >= 128) value -= isIcc ? 128 : 256;
                (*px)[c] = value;
            }
        }
    }
    return lab;
}

// A field that decides how the others are read, so it comes first.
unsigned photometricOf(TIFF* file, unsigned compression, unsigned samples, bool isPlanar) {
    const bool isFax = compression >= COMPRESSION_CCITTRLE && compression <= COMPRESSION_CCITTFAX4;
    const unsigned stated = field<std::uint16_t>(file, TIFFTAG_PHOTOMETRIC,
                                                 samples >= 3 ? PHOTOMETRIC_RGB
                                                 : isFax      ? PHOTOMETRIC_MINISWHITE
                                                              : PHOTOMETRIC_MINISBLACK);
    if (stated == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG && !isPlanar) {
        TIFFSetField(file, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
        return PHOTOMETRIC_RGB;
    }
    if (stated == PHOTOMETRIC_LOGL || stated == PHOTOMETRIC_LOGLUV)
        TIFFSetField(file, TIFFTAG_SGILOGDATAFMT, SGILOGDATAFMT_FLOAT);
    return stated;
}

// What the chosen directory says.
struct Page {
    explicit Page(TIFF* tiff);

    bool isWhole() const { return format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID; }
    bool isLab() const {
        return photometric == PHOTOMETRIC_CIELAB || photometric == PHOTOMETRIC_ICCLAB;
    }
    bool isLogLuv() const {
        return photometric == PHOTOMETRIC_LOGL || photometric == PHOTOMETRIC_LOGLUV;
    }
    bool isPalette() const { return photometric == PHOTOMETRIC_PALETTE; }
    bool isInks() const { return photometric == PHOTOMETRIC_SEPARATED; }
    // samples that are colours
    unsigned colours() const {
        const bool isGrey = photometric == PHOTOMETRIC_MINISWHITE ||
                            photometric == PHOTOMETRIC_MINISBLACK ||
                            photometric == PHOTOMETRIC_LOGL;
        return isGrey || isPalette() ? 1 : isInks() ? 4 : 3;
    }
    // depth of the decoded samples
    int depth() const { return !isWhole() || bits > 16 ? CV_32F : bits > 8 ? CV_16U : CV_8U; }
    std::string kindThatIsNotRead() const;

    TIFF* file;
    unsigned compression = field<std::uint16_t>(file, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    unsigned samples = field<std::uint16_t>(file, TIFFTAG_SAMPLESPERPIXEL, 1);
    bool isPlanar = field<std::uint16_t>(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) ==
                    PLANARCONFIG_SEPARATE;
    unsigned photometric = photometricOf(file, compression, samples, isPlanar);
    std::uint32_t columns = field<std::uint32_t>(file, TIFFTAG_IMAGEWIDTH, 0);
    std::uint32_t rows = field<std::uint32_t>(file, TIFFTAG_IMAGELENGTH, 0);
    unsigned bits = field<std::uint16_t>(file, TIFFTAG_BITSPERSAMPLE, 1);
    unsigned format = field<std::uint16_t>(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    unsigned inkSet = field<std::uint16_t>(file, TIFFTAG_INKSET, INKSET_CMYK);
    int alphaAt = -1; // number of the sample
    AlphaKind alpha = AlphaKind::Straight;
};

Page::Page(TIFF* tiff) : file(tiff) {
    std::uint16_t count = 0;
    std::uint16_t* extras = nullptr;
    const bool takesAlpha = photometric <= PHOTOMETRIC_RGB;
    if (!takesAlpha || TIFFGetField(file, TIFFTAG_EXTRASAMPLES, &count, &extras) != 1) return;
    for (unsigned i = 0; i < count && alphaAt < 0; ++i) {
        // a fourth sample that the file does not explain is taken as alpha
        const bool isUnstated = extras[i] == EXTRASAMPLE_UNSPECIFIED;
        if (isUnstated && (samples != 4 || colours() != 3)) continue;
        alphaAt = static_cast<int>(colours() + i);
        alpha = isUnstated                            ? AlphaKind::Unstated
                : extras[i] == EXTRASAMPLE_ASSOCALPHA ? AlphaKind::Premultiplied
                                                      : AlphaKind::Straight;
    }
}

// Names an unsupported kind for people; empty if the page can be read.
std::string Page::kindThatIsNotRead() const {
    const std::string depthText = std::to_string(bits) + "-bit " +
                                  (format == SAMPLEFORMAT_IEEEFP ? "float "
                                   : format == SAMPLEFORMAT_INT  ? "signed "
                                                                 : "");
    if (format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP)
        return "complex-number TIFF";
    if (TIFFIsCODECConfigured(static_cast<std::uint16_t>(compression)) == 0)
        return "TIFF (compression " + std::to_string(compression) + ")";
    const bool isPlain = isWhole() && (bits == 8 || bits == 16);
    switch (photometric) {
    case PHOTOMETRIC_MINISWHITE:
        if (!isWhole()) return depthText + "min-is-white TIFF";
        break;
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_RGB:
    case PHOTOMETRIC_LOGL:
    case PHOTOMETRIC_LOGLUV:
        break;
    case PHOTOMETRIC_PALETTE:
        if (!isWhole() || bits > 16) return depthText + "palette TIFF";
        break;
    case PHOTOMETRIC_SEPARATED:
        if (inkSet != INKSET_CMYK || samples < 4) return "TIFF (inks other than CMYK)";
        if (!isPlain) return depthText + "CMYK TIFF";
        break;
    case PHOTOMETRIC_YCBCR:
        if (!isWhole() || bits != 8) return depthText + "YCbCr TIFF";
        break;
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
        if (!isPlain) return depthText + "Lab TIFF";
        break;
    default:
        return "TIFF (photometric interpretation " + std::to_string(photometric) + ")";
    }
    const bool isRead = isWhole()                       ? bits <= 16 || bits == 32
                        : format == SAMPLEFORMAT_INT    ? bits == 8 || bits == 16 || bits == 32
                        : format == SAMPLEFORMAT_IEEEFP ? bits == 16 || bits == 32 || bits == 64
                                                        : false;
    if (!isRead) return depthText + "TIFF";
    if (samples < colours() || samples > CV_CN_MAX)
        return "TIFF (" + std::to_string(samples) + " samples)";
    return {};
}

// An open file at the directory of its picture.
class Tiff {
  public:
    explicit Tiff(std::string_view bytes) : source_{bytes}, file_(open(source_)) {
        if (file_) pages = choosePage(file_.get());
        if (pages == 0) fail();
        source_.complaint[0] = '\0';
        page.emplace(file_.get());
    }
    Tiff(const Tiff&) = delete;
    Tiff& operator=(const Tiff&) = delete;

    cv::Mat decode() const;

    unsigned pages = 0;
    std::optional<Page> page;

  private:
    [[noreturn]] void fail() const {
        std::string text = source_.complaint.data();
        if (text.empty())
            throw PictureFailure("a part is damaged or missing"); // tiles, for instance
        std::replace(text.begin(), text.end(), '\n', ' ');
        throw PictureFailure("libtiff: " + text);
    }
    cv::Mat samplesOf(std::vector<std::uint8_t>& block, cv::Size size, int samples) const;
    cv::Mat decodeSamples() const;
    cv::Mat decodeYcbcr() const;

    Source source_;
    File file_;
};

// The samples of a block in the type of the picture.
cv::Mat Tiff::samplesOf(std::vector<std::uint8_t>& block, cv::Size size, int samples) const {
    const std::size_t step = block.size() / static_cast<std::size_t>(size.height);
    const auto as = [&](int depth) {
        return cv::Mat(size, CV_MAKETYPE(depth, samples), block.data(), step);
    };
    const unsigned bits = page->bits;
    cv::Mat result;
    if (page->format == SAMPLEFORMAT_IEEEFP) {
        as(bits == 16 ? CV_16F : bits == 32 ? CV_32F : CV_64F).convertTo(result, CV_32F);
        return result;
    }
    if (page->format == SAMPLEFORMAT_INT) {
        as(bits == 8 ? CV_8S : bits == 16 ? CV_16S : CV_32S).convertTo(result, CV_32F);
        return result;
    }
    if (bits == 8 || bits == 16) return as(bits == 8 ? CV_8U : CV_16U);
    result.create(size, CV_MAKETYPE(page->depth(), samples));
    for (int y = 0; y < size.height; ++y) {
        const std::uint8_t* const from = block.data() + static_cast<std::size_t>(y) * step;
        for (int i = 0; i < size.width * samples; ++i) {
            if (bits == 32) {
                result.ptr<float>(y)[i] =
                    static_cast<float>(reinterpret_cast<const std::uint32_t*>(from)[i]);
                continue;
            }
            unsigned value = 0; // most significant bits first
            const std::size_t begin = std::size_t{bits} * static_cast<std::size_t>(i);
            for (std::size_t at = begin; at < begin + bits; ++at)
                value = value << 1 | (from[at / 8] >> (7 - at % 8) & 1U);
            if (bits < 8) {
                result.ptr(y)[i] = static_cast<std::uint8_t>(value);
            } else {
                result.ptr<std::uint16_t>(y)[i] = static_cast<std::uint16_t>(value);
            }
        }
    }
    return result;
}

// Colours and alpha as they are in the file, red and blue exchanged.
cv::Mat Tiff::decodeSamples() const {
    TIFF* const tiff = file_.get();
    const int colours = static_cast<int>(page->colours());
    const int channels = colours + (page->alphaAt >= 0 ? 1 : 0);
    const auto sampleOf = [&](int channel) {
        if (channel == colours) return page->alphaAt;
        return page->photometric == PHOTOMETRIC_RGB ? 2 - channel : channel;
    };
    const bool isTiled = TIFFIsTiled(tiff) != 0;
    // Strips are read row by row.
    cv::Size block(static_cast<int>(page->columns), 1);
    std::uint64_t bytes = TIFFScanlineSize64(tiff);
    if (isTiled) {
        const unsigned width = field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0);
        const unsigned height = field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH, 0);
        bytes = TIFFTileSize64(tiff);
        if (width < 1 || height < 1 || bytes > kMaxTileBytes)
            throw PictureFailure("its tiles are empty or too large");
        block = {static_cast<int>(width), static_cast<int>(height)};
    }
    const unsigned perBlock = page->isPlanar ? 1 : page->samples;
    if (bytes / static_cast<unsigned>(block.height) * 8 <
        std::uint64_t{page->bits} * perBlock * static_cast<unsigned>(block.width))
        throw PictureFailure("its size is damaged");
    cv::Mat picture(static_cast<int>(page->rows), static_cast<int>(page->columns),
                    CV_MAKETYPE(page->depth(), channels));
    std::vector<std::uint8_t> buffer(bytes);
    for (int plane = 0; plane < (page->isPlanar ? channels : 1); ++plane) {
        std::vector<int> pairs; // sample of the block, channel of the picture
        for (int c = 0; c < channels; ++c) {
            if (page->isPlanar && c != plane) continue;
            pairs.insert(pairs.end(), {page->isPlanar ? 0 : sampleOf(c), c});
        }
        const auto sample = static_cast<std::uint16_t>(sampleOf(plane));
        for (int y = 0; y < picture.rows; y += block.height) {
            for (int x = 0; x < picture.cols; x += block.width) {
                const auto left = static_cast<std::uint32_t>(x);
                const auto top = static_cast<std::uint32_t>(y);
                const tmsize_t size = isTiled
                                          ? TIFFReadTile(tiff, buffer.data(), left, top, 0, sample)
                                          : TIFFReadScanline(tiff, buffer.data(), top, sample);
                if (size < 0) fail();
                const cv::Rect part(0, 0, std::min(block.width, picture.cols - x),
                                    std::min(block.height, picture.rows - y));
                const cv::Mat from = samplesOf(buffer, block, static_cast<int>(perBlock))(part);
                cv::Mat to = picture(part + cv::Point(x, y));
                cv::mixChannels(&from, 1, &to, 1, pairs.data(), pairs.size() / 2);
            }
        }
    }
    return picture;
}

// Decodes with libtiff, which knows how the colours are sampled.
cv::Mat Tiff::decodeYcbcr() const {
    TIFF* const tiff = file_.get();
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT); // turning is left to others
    cv::Mat raster(static_cast<int>(page->rows), static_cast<int>(page->columns), CV_32SC1,
                   cv::Scalar(0));
    if (TIFFReadRGBAImageOriented(tiff, page->columns, page->rows, raster.ptr<std::uint32_t>(),
                                  ORIENTATION_TOPLEFT, 1) != 1)
        fail();
    cv::Mat picture;
    cv::cvtColor(cv::Mat(raster.size(), CV_8UC4, raster.data), picture, cv::COLOR_RGBA2BGR);
    return picture;
}

cv::Mat Tiff::decode() const {
    if (page->photometric == PHOTOMETRIC_YCBCR) return decodeYcbcr();
    cv::Mat picture = decodeSamples();
    if (page->isPalette()) return coloursOfPalette(file_.get(), page->bits, picture);
    if (page->isLab()) return labOf(picture, page->photometric == PHOTOMETRIC_ICCLAB);
    if (page->photometric == PHOTOMETRIC_MINISWHITE) {
        const auto largest = static_cast<double>((std::uint64_t{1} << page->bits) - 1);
        cv::Scalar white(largest, 0); // alpha stays
        cv::Mat colours;
        cv::extractChannel(picture, colours, 0);
        cv::subtract(white, colours, colours);
        cv::insertChannel(colours, picture, 0);
    }
    return picture;
}

} // namespace

void describeTiff(std::string_view bytes, ImageHeader& header) {
    const Tiff tiff(bytes);
    const Page& page = *tiff.page;
    header.columns = page.columns;
    header.rows = page.rows;
    header.orientation = validOrientation(field<std::uint16_t>(page.file, TIFFTAG_ORIENTATION, 1));
    header.pictures = tiff.pages;
    header.isCmyk = page.isInks();
    header.isSigned = page.format == SAMPLEFORMAT_INT;
    const unsigned char* version = nullptr;
    if (TIFFGetField(page.file, TIFFTAG_DNGVERSION, &version) == 1) header.otherFormat = "DNG";
    if (page.isWhole() && page.photometric <= PHOTOMETRIC_RGB && page.bits <= 32)
        header.largestSample = static_cast<unsigned>((std::uint64_t{1} << page.bits) - 1);
    header.alpha = page.alpha;
    if (page.samples > page.colours())
        header.unusedChannels = page.samples - page.colours() - (page.alphaAt >= 0 ? 1 : 0);
    header.unreadable = page.kindThatIsNotRead();
}

TiffLight tiffLight(std::string_view bytes) {
    const Tiff tiff(bytes);
    std::uint32_t size = 0;
    const void* profile = nullptr;
    if (TIFFGetField(tiff.page->file, TIFFTAG_ICCPROFILE, &size, &profile) != 1 ||
        size > kMaxProfileBytes)
        size = 0;
    return {std::string(static_cast<const char*>(size > 0 ? profile : ""), size),
            tiff.page->isLogLuv()};
}

TiffPicture decodeTiff(std::string_view bytes) {
    const Tiff tiff(bytes);
    const Page& page = *tiff.page;
    return {tiff.decode(), page.isLab()                             ? TiffColours::Lab
                           : page.isInks()                          ? TiffColours::Inks
                           : page.photometric == PHOTOMETRIC_LOGLUV ? TiffColours::LightXyz
                                                                    : TiffColours::GreyOrRgb};
}

} // namespace altiro3D
