#include "altiro3D/image_io.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/system_file.hpp"
#include "image/colour.hpp"
#include "image/exif.hpp"
#include "image/exr_file.hpp"
#include "image/file_walk.hpp"
#include "image/heif_file.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/image_read.hpp"
#include "image/panorama.hpp"
#include "image/pixel_values.hpp"
#include "image/tiff_file.hpp"
#include "image/xmp.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <type_traits>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

const char* nameOf(ImageFormat format) {
    constexpr const char* kNames[] = {"unknown", "PNG", "JPEG", "TIFF",      "WebP", "BMP", "PNM",
                                      "PFM",     "EXR", "HDR",  "JPEG 2000", "HEIC", "AVIF"};
    return entryOf(kNames, format);
}

// "camera raw (nef)": nef
std::string extensionOf(const std::string& rawName) {
    const std::size_t open = rawName.find('(');
    return open == std::string::npos ? rawName
                                     : rawName.substr(open + 1, rawName.size() - open - 2);
}

[[noreturn]] void refuseUnknown(const fs::path& path, const ImageHeader& header) {
    const std::string& name = header.otherFormat;
    const std::string formats = readableFormats();
    const auto unsupported = [&](const std::string& problem) {
        return Error(ErrorCode::Unsupported, path.string(), problem);
    };
    if (name == "HTML")
        throw Error(ErrorCode::BadFormat, path.string(),
                    "is a web page, expected a picture; download the picture itself");
    if (endsWith(name, " video"))
        throw unsupported("is a video (" + name.substr(0, name.size() - 6) +
                          "), expected a picture");
    if (name == "ZIP" || name == "gzip")
        throw unsupported("is a " + name + " archive, expected a picture; unpack it first");
    if (name.rfind("camera raw", 0) == 0 || name == "DNG")
        throw unsupported("is a raw picture of a camera (" + extensionOf(name) +
                          "), which is not read, expected " + formats +
                          "; export it from a photo program first");
    if (!name.empty())
        throw unsupported(name + " pictures are not read, expected " + formats +
                          "; convert it first");
    throw Error(ErrorCode::BadFormat, path.string(),
                std::string("is not a picture that can be read") +
                    (header.isText ? " (it holds text)" : "") + ", expected " + formats);
}

[[noreturn]] void failDecoder(const fs::path& path, const ImageHeader& header,
                              const std::string& message) {
    throw Error(ErrorCode::BadFormat, path.string(),
                "cannot be decoded (" + message + "), expected a whole " + nameOf(header.format) +
                    " file");
}

void checkHeader(const fs::path& path, const ImageHeader& header) {
    if (header.format == ImageFormat::Unknown) refuseUnknown(path, header);
    if (!header.unreadable.empty()) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    header.unreadable + " pictures are not read, expected an ordinary " +
                        nameOf(header.format) + " file; convert it first");
    }
    if (isHeif(header.format) && !hasHeif()) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    std::string(nameOf(header.format)) +
                        " pictures are not read, as libaltiro3D was built without libheif, "
                        "expected " +
                        readableFormats() + "; convert it first");
    }
    if (!header.decoderMessage.empty()) failDecoder(path, header, header.decoderMessage);
    if (header.columns == 0 || header.rows == 0) {
        throw Error(ErrorCode::BadFormat, path.string(),
                    std::string("its header is damaged or cut off, expected a whole ") +
                        nameOf(header.format) + " file");
    }
    const double pixels = static_cast<double>(header.columns) * static_cast<double>(header.rows);
    if (header.columns > kMaxImageSide || header.rows > kMaxImageSide || pixels > kMaxImagePixels) {
        throw Error(ErrorCode::TooLarge, path.string(),
                    "has " + std::to_string(header.columns) + " x " + std::to_string(header.rows) +
                        " px, expected at most " +
                        std::to_string(static_cast<long long>(kMaxImagePixels / 1e6)) +
                        " megapixels and sides of at most " + std::to_string(kMaxImageSide) +
                        " px");
    }
}

void addNotes(const ImageHeader& header, const std::string& extension, Notes* notes) {
    if (header.format == ImageFormat::Jpeg && header.isCutOff)
        addNote(notes, NoteCode::CutOff,
                header.hasWholeScan ? "the file is cut off: its fine detail is missing"
                                    : "the file is cut off: its lower part is missing");
    if (header.unusedChannels > 0)
        addNote(notes, NoteCode::LeftOut,
                "the file has channels that are neither colours nor alpha (" +
                    std::to_string(header.unusedChannels) + "): they are left out");
    const bool isMain = isHeif(header.format);
    const char* const kind = header.format == ImageFormat::Tiff ? " pages"
                             : isMain                           ? " pictures"
                                                                : " frames";
    if (extension == ".mpo" && header.format == ImageFormat::Jpeg) {
        addNote(notes, NoteCode::LeftOut, "the file holds several pictures: the first one is read");
    } else if (header.pictures > 1) {
        addNote(notes, NoteCode::LeftOut,
                "the file holds " + std::to_string(header.pictures) + kind +
                    (isMain ? ": the main one is read" : ": the first one is read"));
    }
}

// [1, 2, 3 or 4 channels, CV_8U, CV_16U or CV_32F]; four are BGR and alpha, or inks of 8 bits
cv::Mat tiffPicture(const std::string& bytes) {
    const auto [samples, colours] = decodeTiff(bytes);
    if (colours == TiffColours::Lab) return labToSrgb(samples);
    if (colours == TiffColours::LightXyz) return xyzToRgb(samples);
    const bool isDeep = colours == TiffColours::Inks && samples.depth() == CV_16U;
    return isDeep ? toEightBits(samples) : samples;
}

// Whether colours are converted to sRGB: those of photos are, and numbers of depth images are not.
enum class Colours { ToSrgb, AsStored };

// The coded px of formats whose decoders fill in what is lost without a word.
std::string_view codedPart(std::string_view bytes, ImageFormat format) {
    std::string_view coded;
    if (format == ImageFormat::WebP) {
        walkWebP(bytes, [&](std::string_view name, std::uint64_t at, std::uint64_t size) {
            const bool isCoded = name == "VP8 " || name == "VP8L" || name == "ANMF";
            if (isCoded) coded = ByteReader(bytes, true).text(at, size);
            return !isCoded;
        });
    }
    const std::string_view start = format == ImageFormat::Jpeg2000 ? "\xff\x4f\xff\x51" : "mdat";
    if (isHeif(format) || format == ImageFormat::Jpeg2000)
        coded = bytes.substr(std::min(bytes.find(start), bytes.size()));
    return coded;
}

// No coder writes so many zeros, but EXIF may be padded with them.
void noteHole(std::string_view bytes, ImageFormat format, Notes* notes) {
    static const std::string kZeros(512, '\0');
    constexpr std::size_t kLongestExif = 65536;
    const std::string_view coded = codedPart(bytes, format);
    const std::size_t hole = coded.find(kZeros);
    if (hole == std::string_view::npos) return;
    const std::size_t exif = coded.substr(0, hole).rfind(std::string_view("Exif\0\0", 6));
    if (exif != std::string_view::npos && hole - exif < kLongestExif) return;
    const std::size_t end = std::min(coded.find_first_not_of('\0', hole), coded.size());
    addNote(notes, NoteCode::Repaired,
            "the file is damaged (it holds " + std::to_string(end - hole) +
                " zeros in a row): a part of the picture may be wrong or missing");
}

// @throws PictureFailure of HeifFile, decodeTiff() and decodeExr()
cv::Mat decode(const fs::path& path, ImageHeader& header, const std::string& bytes, Colours colours,
               Notes* notes) {
    if (isHeif(header.format)) {
        const HeifFile file(bytes);
        header.alpha = file.isPremultiplied() ? AlphaKind::Premultiplied : AlphaKind::Straight;
        return file.decode();
    }
    if (header.format == ImageFormat::Tiff) return tiffPicture(bytes);
    if (header.format == ImageFormat::Exr) {
        cv::Mat picture = decodeExr(bytes, colours == Colours::AsStored, notes);
        if (!picture.empty()) return picture;
    }
    const std::string expected =
        std::string(", expected a whole ") + nameOf(header.format) + " file";
    std::string mended;
    // At the end of a cut-off file, libjpeg waits for more bytes unless an end marker follows.
    if (header.format == ImageFormat::Jpeg && header.isCutOff)
        mended = bytes.substr(0, header.usableBytes) + "\xff\xd9";
    // OpenCV requires a character after the last number of a text file.
    if (header.format == ImageFormat::Pnm && bytes[1] <= '3') mended = bytes + '\n';
    const std::string& whole = mended.empty() ? bytes : mended;
    std::string detail;
    std::string damage;
    cv::Mat picture;
    try {
        picture = header.isAnimated
                      ? decodeFirstFrame(header, whole)
                      : decodeImage(whole, header.format, ImageChannels::AsStored, &damage);
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) throw;
        detail = exception.err;
    }
    if (!picture.empty()) {
        if (!damage.empty() && !header.isCutOff)
            addNote(notes, NoteCode::Repaired,
                    "the file is damaged (" + damage +
                        "): a part of the picture may be wrong or missing");
        return picture;
    }
    if (header.format == ImageFormat::Exr && detail.find("OPENEXR") != std::string::npos) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "EXR pictures are switched off in this OpenCV, expected the environment "
                    "variable OPENCV_IO_ENABLE_OPENEXR=1");
    }
    throw Error(ErrorCode::BadFormat, path.string(),
                std::string(header.isCutOff ? "is cut off" : "is damaged or of an unusual kind") +
                    expected);
}

struct LoadedPicture {
    cv::Mat picture; // 1 or 3 channels, any depth, upright
    ImageHeader header;
};

// Runs the work of reading a file and reports exceptions of OpenCV as errors of the file.
template <class Work>
auto reading(const fs::path& path, const Work& work) {
    try {
        return withinMemory(path, work);
    } catch (const cv::Exception& exception) {
        throw Error(ErrorCode::BadFormat, path.string(),
                    "cannot be decoded (" + exception.err + "), expected an ordinary picture");
    }
}

// Decodes inks and converts them to sRGB; `facts` is cleared, so nothing is left to convert.
cv::Mat decodeInks(const fs::path& path, ImageHeader& header, const std::string& bytes,
                   ColourFacts& facts, Notes* notes) {
    const std::string icc = isCmykProfile(facts.icc) ? facts.icc : std::string();
    facts = ColourFacts();
    const bool isTiff = header.format == ImageFormat::Tiff;
    const bool isInverted = !isTiff && !header.isUnmarkedCmyk;
    // empty if the file is damaged
    const cv::Mat inks =
        isTiff ? tiffPicture(bytes) : decodeJpeg(bytes, ImageChannels::AsStored, nullptr, true);
    cv::Mat picture;
    if (!inks.empty() && !icc.empty()) picture = inksToSrgb(inks, icc, isInverted);
    if (picture.empty())
        addNote(notes, NoteCode::Doubtful,
                "the file is CMYK without a colour profile that can "
                "be used: its colours are approximate");
    if (header.isUnmarkedCmyk)
        addNote(notes, NoteCode::Doubtful,
                "the file is CMYK without Adobe's mark: its colours may be inverted");
    if (inks.empty()) return decode(path, header, bytes, Colours::ToSrgb, notes);
    return picture.empty() ? inksToSrgb(inks, {}, isInverted) : picture;
}

// Spreads whole numbers to the full range of their type; those of 32 bits, held as floats, to 0..1.
void spread(cv::Mat& picture, unsigned largest) {
    const double full = picture.depth() == CV_8U ? 255 : picture.depth() == CV_16U ? 65535 : 1;
    if (largest > 0 && largest != full) picture.convertTo(picture, -1, full / largest);
}

// Remarks on floats as colours.
void addFloatNotes(const cv::Mat& picture, const ImageHeader& header, const ColourFacts& facts,
                   Notes* notes) {
    if (notes == nullptr || picture.depth() != CV_32F) return;
    if (facts.icc.empty() && facts.gamma <= 0 && header.largestSample == 0) {
        addNote(notes, NoteCode::Doubtful,
                "the file holds floats without a colour profile: they are read as sRGB from 0, "
                "black, to 1, white, and not as linear light");
    }
    std::size_t bright = 0;
    for (int y = 0; y < picture.rows; ++y) {
        const float* px = picture.ptr<float>(y);
        for (int x = 0; x < picture.cols; ++x, px += picture.channels())
            bright += *std::max_element(px, px + picture.channels()) > 1.001F ? 1 : 0;
    }
    const std::size_t percent = (100 * bright + picture.total() / 2) / picture.total();
    if (percent > 0)
        addNote(notes, NoteCode::AsItIs,
                std::to_string(percent) +
                    " % of the picture is brighter than white and shown as white");
}

using ColourPart = std::function<cv::Rect(cv::Size)>;

void convertPart(cv::Mat& picture, cv::Rect area, const ColourFacts& facts, Notes* notes) {
    if (area.empty()) return; // too small to split, as the caller finds
    cv::Mat part = picture(area).clone();
    convertToSrgb(part, facts, notes);
    if (part.channels() != picture.channels()) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    part.copyTo(picture(area));
}

// @param photoPart if given, the part whose colours are converted
LoadedPicture load(const PhotoFile& file, Colours colours, Notes* notes,
                   const ColourPart& photoPart = {}) {
    const fs::path& path = file.path();
    const std::string extension = lowerExtension(path);
    const std::string& bytes = file.bytes();
    if (bytes.empty()) {
        throw Error(ErrorCode::BadFormat, path.string(), "is empty, expected a picture");
    }
    LoadedPicture loaded;
    loaded.header = readImageHeader(bytes, extension);
    ImageHeader& header = loaded.header;
    checkHeader(path, header);
    if (colours == Colours::ToSrgb)
        refuseSphere(path, bytes, {static_cast<int>(header.columns), static_cast<int>(header.rows)},
                     notes);
    ColourFacts facts =
        colours == Colours::ToSrgb ? readColourFacts(bytes, header.format) : ColourFacts();
    cv::Mat picture;
    try {
        picture = header.isCmyk ? decodeInks(path, header, bytes, facts, notes)
                                : decode(path, header, bytes, colours, notes);
    } catch (const PictureFailure& failure) {
        failDecoder(path, header, failure.what());
    }
    const bool hasAlpha = picture.channels() == 2 || picture.channels() == 4;
    if (colours == Colours::ToSrgb || hasAlpha) spread(picture, header.largestSample);
    picture = withoutAlpha(picture, header);
    blackenTransparent(picture, header);
    if (picture.channels() != 1 && picture.channels() != 3) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "has " + std::to_string(picture.channels()) +
                        " channels, expected grey, RGB or either with alpha");
    }
    if (colours == Colours::ToSrgb) addFloatNotes(picture, header, facts, notes);
    if (!photoPart) convertToSrgb(picture, facts, notes); // AsStored: `facts` is empty, no change
    loaded.picture = upright(picture, header.orientation);
    if (photoPart) convertPart(loaded.picture, photoPart(loaded.picture.size()), facts, notes);
    addNotes(header, extension, notes);
    noteHole(bytes, header.format, notes);
    return loaded;
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

// Where all three channels agree, whole numbers keep their value.
template <typename T>
cv::Mat greyOf(const cv::Mat& bgr, Notes* notes) {
    if (hasColours(bgr))
        addNote(notes, NoteCode::Doubtful,
                "has colours, and depth has none: their grey value is taken (the photo "
                "comes first, then its depth)");
    if (!std::is_integral_v<T> || !isGrey<T>(bgr)) return greyValues<T>(bgr);
    cv::Mat grey;
    cv::extractChannel(bgr, grey, 1);
    return grey;
}

} // namespace

struct PhotoFile::State {
    fs::path path;
    std::mutex mutex; // guards the following
    std::string bytes;
    bool isRead = false;
};

PhotoFile::PhotoFile(fs::path path, const State* /*state*/) : state_(std::make_shared<State>()) {
    state_->path = std::move(path);
}

PhotoFile::PhotoFile(std::string bytes, fs::path name) : PhotoFile(std::move(name), nullptr) {
    state_->bytes = std::move(bytes);
    state_->isRead = true;
}

const fs::path& PhotoFile::path() const {
    return state_->path;
}

const std::string& PhotoFile::bytes() const {
    const std::lock_guard lock(state_->mutex);
    if (!state_->isRead) {
        state_->bytes = readFile(state_->path, kMaxImageFileBytes);
        state_->isRead = true;
    }
    return state_->bytes;
}

std::string_view PhotoFile::look() const {
    {
        const std::lock_guard lock(state_->mutex);
        if (!state_->isRead && givesBytesOnce(state_->path)) return {};
    }
    return bytes();
}

std::string PhotoFile::start(std::size_t count) const {
    const std::lock_guard lock(state_->mutex);
    if (state_->isRead) return state_->bytes.substr(0, count);
    if (givesBytesOnce(state_->path)) return {};
    std::string start(count, '\0');
    std::ifstream file(state_->path, std::ios::binary);
    file.read(start.data(), static_cast<std::streamsize>(count));
    start.resize(static_cast<std::size_t>(file.gcount()));
    return start;
}

std::string readableFormats() {
    return std::string("PNG, JPEG, ") + (hasHeif() ? "HEIC, AVIF, " : "") +
           "TIFF, WebP, BMP, PNM, PFM, EXR, HDR or JPEG 2000";
}

cv::Mat readImage(const PhotoFile& file, Notes* notes) {
    return readImageParts(file, {}, notes);
}

cv::Mat readImageParts(const PhotoFile& file, const ColourPart& photoPart, Notes* notes) {
    return reading(file.path(), [&]() -> cv::Mat {
        const LoadedPicture loaded = load(file, Colours::ToSrgb, notes, photoPart);
        cv::Mat picture = loaded.picture;
        const int depth = picture.depth();
        if (loaded.header.isSigned || (depth != CV_8U && depth != CV_16U && depth != CV_32F)) {
            throw Error(ErrorCode::Unsupported, file.path().string(),
                        "has signed whole numbers, expected numbers without sign or floats; "
                        "convert it first");
        }
        if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
        return picture;
    });
}

cv::Mat readPhoto(const PhotoFile& file, Notes* notes) {
    return reading(file.path(), [&]() -> cv::Mat {
        cv::Mat picture = readImage(file, notes);
        if (picture.depth() == CV_8U) return picture;
        if (picture.depth() == CV_16U) return toEightBits(picture);
        return mapped<float, std::uint8_t>(
            picture, [](float value) { return toWhole<std::uint8_t>(value, 255.0f); });
    });
}

bool isMarkedNative(const PhotoFile& file) {
    constexpr std::size_t kMaxBytes = 4096; // the mark precedes the pixels
    const std::string bytes = file.start(kMaxBytes);
    if (imageFormat(bytes) != ImageFormat::Png) return false;
    return readImageHeader(bytes, lowerExtension(file.path())).isNative;
}

cv::Mat readDepthSamples(const PhotoFile& file, Notes* notes) {
    return reading(file.path(), [&]() -> cv::Mat {
        cv::Mat picture = load(file, Colours::AsStored, notes).picture;
        if (picture.channels() == 3) {
            cv::Mat levels = undoColourMap(picture, file.path().string(), notes);
            if (!levels.empty()) return levels;
            if (picture.depth() == CV_8U) return greyOf<std::uint8_t>(picture, notes);
            if (picture.depth() == CV_16U) return greyOf<std::uint16_t>(picture, notes);
            if (picture.depth() == CV_32F) return greyOf<float>(picture, notes);
            cv::Mat numbers;
            picture.convertTo(numbers, CV_64F);
            return greyOf<double>(numbers, notes);
        }
        if (picture.depth() == CV_8U || picture.depth() == CV_16U) return picture;
        cv::Mat depth;
        picture.convertTo(depth, CV_32F);
        return depth;
    });
}

cv::Mat readDepthImage(const PhotoFile& file, Notes* notes) {
    return reading(file.path(), [&]() -> cv::Mat {
        cv::Mat depth = readDepthSamples(file, notes);
        if (depth.depth() != CV_32F) depth.convertTo(depth, CV_32F);
        return depth;
    });
}

namespace {

// What a function reads from the EXIF of a photo; a TIFF file is EXIF itself.
template <class Read>
auto fromExif(const PhotoFile& file, const Read& read) {
    const std::string_view bytes = file.look();
    if (imageFormat(bytes) == ImageFormat::Tiff) return read(bytes);
    const ImageHeader header = readImageHeader(bytes, lowerCase(file.path().extension().string()));
    return read(std::string_view(header.exif));
}

} // namespace

double focalLengthOf(const PhotoFile& file) {
    return fromExif(file, exifFocalLength);
}

std::string creditOf(const PhotoFile& file) {
    constexpr std::string_view kDublinCore = "purl.org/dc/elements";
    std::string author;
    std::string licence;
    const auto take = [](std::string_view found, std::string& to) {
        for (const char c : to.empty() ? found : std::string_view())
            if (static_cast<unsigned char>(c) >= ' ') to += c;
    };
    fromExif(file, [&](std::string_view exif) {
        take(exifText(exif, kExifArtist), author);
        take(exifText(exif, kExifCopyright), licence);
    });
    if (imageFormat(file.look()) == ImageFormat::Jpeg) {
        walkJpeg(file.look(), [&](unsigned marker, std::size_t, std::string_view body) {
            if (marker == 0xe1 && startsWith(body, kXmpMark)) {
                const Xmp xmp(body.substr(kXmpMark.size()));
                take(xmp.value(kDublinCore, "creator"), author);
                take(xmp.value(kDublinCore, "rights"), licence);
            }
            return marker != 0xda;
        });
    }
    return author + (author.empty() || licence.empty() ? "" : "; ") + licence;
}

} // namespace altiro3D
