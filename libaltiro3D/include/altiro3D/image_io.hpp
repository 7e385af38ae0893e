#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace altiro3D {

/// Receives a picture in bands of rows, from top to bottom.
using RowSink = std::function<void(const cv::Mat& rows)>;

/// Pictures whose header states more pixels than this are refused before memory is allocated.
constexpr double kMaxImagePixels = 4.0e8;

/// A picture file that is read once, or a picture in memory. All functions that read pictures take
/// one. A path converts to it; if a file is examined several times, keep one PhotoFile:
///
///     const PhotoFile file("photo.jpg");
///     const cv::Mat photo = readPhoto(file);
///     const std::optional<EmbeddedDepth> depth = readEmbeddedDepth(file);
///
/// Copies share the bytes. Several threads may read one object. Its source is image_read.cpp.
class ALTIRO3D_EXPORT PhotoFile {
  public:
    /// A picture file, which is not read before its bytes are needed.
    /// @param path the file; a std::filesystem::path, or what converts to it
    template <class Path,
              class = std::enable_if_t<std::is_convertible_v<Path&&, std::filesystem::path>>>
    PhotoFile(Path&& path) // NOLINT(google-explicit-constructor): readPhoto("photo.jpg")
        : PhotoFile(std::filesystem::path(std::forward<Path>(path)), nullptr) {}
    /// A picture in memory.
    /// @param bytes those of a picture file
    /// @param name name for messages; its extension and tags count as those of a file
    PhotoFile(std::string bytes, std::filesystem::path name);

    /// The name. @return as given
    [[nodiscard]] const std::filesystem::path& path() const;
    /// All bytes; the file is read now if it was not before.
    /// @return the bytes, valid as long as this object or a copy lives
    /// @throws Error NotFound, ReadFailed, TooLarge (2 GiB), OutOfMemory
    [[nodiscard]] const std::string& bytes() const;
    /// The bytes, without reading from a pipe, which can be read only once. Use it to examine a
    /// picture before it is read.
    /// @return bytes(); empty for a pipe that bytes() has not read
    /// @throws Error as bytes()
    [[nodiscard]] std::string_view look() const;
    /// The first bytes; reads less of the file than look().
    /// @param count number of bytes
    /// @return at most `count` bytes; empty for a pipe that bytes() has not read and for a file
    ///         that cannot be read
    [[nodiscard]] std::string start(std::size_t count) const;

  private:
    struct State;
    // called by the constructor above; the pointer, always null, distinguishes the two
    PhotoFile(std::filesystem::path path, const State* state);
    std::shared_ptr<State> state_;
};

/// Reads a picture upright (EXIF orientation applied), with its full bit depth.
///
/// Grey, palette, CMYK and alpha pictures become BGR; transparent areas become black. The contents
/// decide the format, not the name. Sides are limited to 65500 px. OpenCV's codecs may print
/// warnings on stderr.
///
/// Colours are converted to sRGB: by ICC profiles (PNG, JPEG, TIFF, WebP, HEIC, AVIF), PNG's cICP,
/// gAMA and cHRM, and the colour codes of HEIC and AVIF. EXR, HDR and LogLuv TIFF hold linear
/// light, in the primaries that the file states, else those of sRGB; 1 becomes white. Other floats
/// without a profile are taken as sRGB, with a remark. Pictures whose profile is equal to sRGB keep
/// their bytes. PQ and HLG are tone-mapped by the curve of ITU-R BT.2390. Gain maps are ignored:
/// the base picture is used. Depth is never converted.
///
/// HEIC and AVIF need libheif at build time. Their own rotation and mirroring are applied; the EXIF
/// orientation, which repeats them, is ignored.
/// @param file PNG, JPEG (also MPO: its first picture), HEIC, AVIF, TIFF, WebP, BMP, PNM/PFM, EXR,
///        HDR or JPEG 2000
/// @param notes if given, receives remarks (a cut-off JPEG, several pages, ...), without the name
///        of the file
/// @return [rows x cols, CV_8UC3, CV_16UC3 or CV_32FC3, BGR]
/// @throws Error NotFound, ReadFailed, Unsupported (names the format: GIF, PCX, ...; HEIC and AVIF
///         without libheif), TooLarge, BadFormat, OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readImage(const PhotoFile& file, Notes* notes = nullptr);

/// The 35 mm equivalent focal length in the EXIF of a photo.
/// @param file the photo; not read from a pipe
/// @return mm; 0 if it states none
/// @throws Error as PhotoFile::look()
[[nodiscard]] ALTIRO3D_EXPORT double focalLengthOf(const PhotoFile& file);

/// Author and licence that EXIF, or XMP of a JPEG, state: "Ada Lovelace; CC BY 4.0".
/// @param file the photo; not read from a pipe
/// @return the text; empty if they state none
/// @throws Error as PhotoFile::look()
[[nodiscard]] ALTIRO3D_EXPORT std::string creditOf(const PhotoFile& file);

/// The formats that readImage() reads, for people.
/// @return "PNG, JPEG, HEIC, AVIF, TIFF, WebP, BMP, PNM, PFM, EXR, HDR or JPEG 2000"; without HEIC
///         and AVIF if the library was built without libheif
[[nodiscard]] ALTIRO3D_EXPORT std::string readableFormats();

/// Reads a photo: as readImage(), converted to 8 bits (16-bit values are divided by 257 and
/// rounded, float values are clamped to 0..1).
/// @param file as for readImage()
/// @param notes as for readImage()
/// @return [rows x cols, CV_8UC3, BGR]
/// @throws Error as readImage()
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readPhoto(const PhotoFile& file, Notes* notes = nullptr);

/// Reads the raw numbers of a depth image: 8-bit, 16-bit or float, one channel or the grey value of
/// three. Values are not normalized; normalizeDepth() does that. EXIF orientation is applied.
///
/// Depth of 8 or 16 bits that is drawn in one of the colour maps turbo, jet, Spectral, inferno,
/// magma, viridis, plasma and hue is read as the place in the map, 0..255, where 255 is the warm or
/// bright end. The map hue begins and ends with red; its 255 is the end after magenta. Black px are
/// 0 if the map does not contain black.
/// @param file as for readImage(); 16-bit PNG/PGM/TIFF, float TIFF, PFM and EXR keep their values
/// @param notes as for readImage(); also a remark if the picture shows colours
/// @return [rows x cols, CV_32FC1, as in the file]
/// @throws Error as readImage(); BadFormat if the colours fit two contradictory colour maps
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readDepthImage(const PhotoFile& file, Notes* notes = nullptr);

/// As readDepthImage(), without conversion to float: files of 8 and 16 bits take a quarter and half
/// of the memory. normalizeDepth() is faster on them and gives the same result.
/// @param file as for readDepthImage()
/// @param notes as for readDepthImage()
/// @return [rows x cols, CV_8UC1, CV_16UC1 or CV_32FC1, as in the file]
/// @throws Error as readImage()
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readDepthSamples(const PhotoFile& file,
                                                       Notes* notes = nullptr);

/// Whether a picture shows colours, which a depth image does not. It does if in more than 2 % of
/// its px the channels differ by more than a sixteenth of white; for floats, a sixteenth of the
/// largest value. From 512 rows on, only evenly spaced rows are examined.
/// @param picture [rows x cols, CV_8UC3, CV_16UC3, CV_32FC3 or CV_64FC3]
/// @return true if it does
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT bool hasColours(const cv::Mat& picture);

/// What a picture file is marked as, so that it is not used as a photo by mistake.
enum class ImageMark {
    None,
    Native ///< A Native: a PNG file gets a text chunk "altiro3D".
};

/// Writes a picture in the format of the extension. The file appears complete or not at all.
///
/// PNG files hold no resolution (DPI) and no metadata except the mark. JPEG is written at quality
/// 95, a Native at 100 with full chroma (4:4:4), WebP without loss. For formats of 8 bits, 16-bit
/// values are divided by 257 and rounded.
/// @param path file name with the extension .png, .jpg, .jpeg, .jpe, .tif, .tiff, .webp, .bmp,
///        .dib, .ppm, .pgm, .pnm or .jp2, in upper or lower case
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR]
/// @param mark what the picture is; PNG files state it, for isMarkedNative()
/// @throws Error InvalidArgument (empty, wrong type), Unsupported (unknown extension, too many px
///         for the format, colours in a .pgm), WriteFailed, OutOfMemory
ALTIRO3D_EXPORT void writeImage(const std::filesystem::path& path, const cv::Mat& picture,
                                ImageMark mark = ImageMark::None);

/// Encodes a picture as PNG, for a pipe or a network.
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR]
/// @param mark as for writeImage()
/// @return the bytes that writeImage() writes to a .png file
/// @throws Error InvalidArgument (empty, wrong type), Unsupported (too many px), OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT std::vector<unsigned char>
encodePicture(const cv::Mat& picture, ImageMark mark = ImageMark::None);

/// Encodes a picture in any format that writeImage() can write.
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR]
/// @param name file name; its extension decides the format, as for writeImage(). Errors name it.
/// @param mark as for writeImage()
/// @return the bytes that writeImage() writes to a file of that name
/// @throws Error as writeImage()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<unsigned char>
encodePicture(const cv::Mat& picture, const std::filesystem::path& name,
              ImageMark mark = ImageMark::None);

/// Whether a PNG file is marked as a Native, so it is not used as a photo by mistake. False for
/// Natives in other formats or from other programs, for files that cannot be read, and for pipes
/// that PhotoFile::bytes() has not read. Throws only if an allocation fails.
/// @param file the file
/// @return true if it is
[[nodiscard]] ALTIRO3D_EXPORT bool isMarkedNative(const PhotoFile& file);

/// Whether writeImage() can write the extension of a file name.
/// @param path file name; the file is not accessed
/// @return true if it can
[[nodiscard]] ALTIRO3D_EXPORT bool canWriteImage(const std::filesystem::path& path);

/// Extensions of readable pictures. Other names can be read as well: the contents decide.
/// @return the extensions, in lower case and with their dots
[[nodiscard]] ALTIRO3D_EXPORT const std::vector<std::string>& imageExtensions();

/// Lists the pictures in a directory in natural order: `view9.png` before `view10.png`. These are
/// files with a picture's extension, and files without an extension whose contents are a picture;
/// hidden ones are left out. Subdirectories are not searched.
/// @param directory the directory
/// @return their paths, including the directory
/// @throws Error NotFound or ReadFailed (no directory, no permission)
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::filesystem::path>
listImages(const std::filesystem::path& directory);

/// Natural order of names: runs of digits compare as numbers, letters regardless of case. Names
/// that differ only in case or leading zeros compare as bytes.
/// @param a one name
/// @param b another one
/// @return true if `a` comes before `b`
[[nodiscard]] ALTIRO3D_EXPORT bool naturalLess(const std::string& a, const std::string& b);

/// How a photo's file holds depth.
enum class EmbeddedDepthForm {
    AppleHeic,    ///< Auxiliary picture of a portrait by an iPhone.
    AppleJpeg,    ///< The same in a JPEG: a further JPEG in the file (multi-picture format).
    GDepth,       ///< Base64 in XMP: lens blur and older phones by Google.
    DynamicDepth, ///< A picture after the photo: newer phones by Google and others.
    Avif,         ///< Auxiliary picture of an AVIF file.
    Exr           ///< Distances in a channel of an EXR file: Z, Depth.Z, ViewLayer.Depth.V.
};

/// Depth from a photo's file. It is small and soft compared with the photo; fitScene() aligns it.
struct EmbeddedDepth {
    EmbeddedDepthForm form = EmbeddedDepthForm::DynamicDepth; ///< How the file held it.
    /// [any size, CV_32FC1, 0..1, 1 = nearest], relative inverse depth, upright; NaN = unknown
    cv::Mat depth;

    /// Describes the depth for people. @return for example "Dynamic Depth, 1024 x 768 px"
    [[nodiscard]] ALTIRO3D_EXPORT std::string text() const;
};

/// Reads the depth that phones store in their photos, and renderers in their EXR files.
///
/// Depth is used only if its shape is the photo's (2 %) and it is not flat. Portrait mattes and
/// gain maps are not depth. If the file describes depth in XMP but does not hold it, there is no
/// depth. Damaged depth never makes the photo unreadable: it is skipped and reported in `notes`.
/// @param photo JPEG, HEIC, AVIF or EXR; other formats hold no depth
/// @param notes if given, receives a remark if the file has depth that is not used
/// @return the depth; nothing if no depth can be used, and for pipes, see PhotoFile::look()
/// @throws Error as PhotoFile::bytes()
[[nodiscard]] ALTIRO3D_EXPORT std::optional<EmbeddedDepth>
readEmbeddedDepth(const PhotoFile& photo, Notes* notes = nullptr);

/// The photo that a depth image is for, by its name: "d/a" for d/a-depth.png. The end of the name,
/// before the extension, is one of '-', '_', '.' and ' ', and then `depth`, `depthmap`, `depth_map`
/// or `disparity`, in upper or lower case. a_with_depth.jpg is a photo that holds its depth.
/// @param depth the depth image; the file is not accessed
/// @return the photo's path without extension; empty if the name is not that of a depth image
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
photoOfDepthName(const std::filesystem::path& depth);

/// Finds the depth image next to a photo: a picture in the same directory whose photoOfDepthName()
/// is the photo. If there is none, names are compared by comparableName(), unless another photo has
/// the same comparable name.
/// @param photo the photo; the file is not accessed
/// @return the first such picture in natural order; empty if none or the directory is unreadable
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
findDepthBeside(const std::filesystem::path& photo);

/// Why a depth image found next to a photo must not be used: its shape is not the photo's (2 %), or
/// its percentiles 0.5 and 99.5 differ by less than 1/255 of the larger one.
/// @param samples from readDepthSamples(); non-finite values do not count
/// @param photo size of the photo, px
/// @return a part of a sentence ("it is flat"); empty if it can be used
/// @throws Error InvalidArgument (empty, wrong type)
[[nodiscard]] ALTIRO3D_EXPORT std::string reasonAgainstDepth(const cv::Mat& samples,
                                                             cv::Size photo);

/// Whether a picture looks like a depth image rather than a photo: it shows no colours
/// (hasColours()), at least 70 % of it is smooth, and it has several greys. The result is also true
/// for grey photos of little detail, such as fog, and false for depth that is noisy or has few
/// levels (docs/depth.md).
/// @param picture [rows x cols, CV_8UC3, CV_16UC3 or CV_32FC3, BGR], as from readImage()
/// @return true if it does; false for pictures below 16 px a side
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT bool looksLikeDepthImage(const cv::Mat& picture);

/// Writes a photo with its depth as one JPEG in the form Dynamic Depth 1.0: both with quality 95,
/// the depth as RangeInverse (near = dark), after the photo. The file appears complete or not at
/// all. readEmbeddedDepth() reads it back; so do programs for the depth photos that phones take.
/// @param path file name with the extension .jpg or .jpeg
/// @param photo [rows x cols, CV_8UC3, BGR], sides of at most 65500 px
/// @param depth [any size of the photo's shape, CV_32FC1, 0..1, 1 = nearest]; clamped, NaN is 0
/// @throws Error InvalidArgument (empty, wrong type), Unsupported (extension, too many px),
///         Mismatch (shapes differ by more than 2 %), WriteFailed, OutOfMemory
ALTIRO3D_EXPORT void writePhotoWithDepth(const std::filesystem::path& path, const cv::Mat& photo,
                                         const cv::Mat& depth);

/// How one picture holds the pictures of both eyes.
enum class StereoLayout {
    LeftRight, ///< The left eye's picture is the left half.
    RightLeft, ///< The left eye's picture is the right half (for cross-eyed viewing).
    TopBottom, ///< The left eye's picture is the upper half.
    BottomTop  ///< The left eye's picture is the lower half.
};

/// Shape of the halves of a picture that holds both eyes, or photo and depth.
enum class StereoHalves {
    Automatic, ///< Squeezed if the whole picture is about 16:9 (1.70 to 1.85), else full.
    Full,      ///< Each half has the shape of the scene.
    Squeezed   ///< Each half is squeezed to half its width (above each other: height), as for 3D
               ///< TV.
};

/// How one picture shows the pictures of both eyes, for headsets, televisions and coloured glasses.
enum class EyesPicture {
    SideBySide,     ///< The left eye's picture at the left, both whole.
    SideBySideHalf, ///< SideBySide, with both squeezed to half their width.
    Crossed,        ///< The left eye's picture at the right, to be seen with crossed eyes.
    TopBottom,      ///< The left eye's picture above, both whole.
    TopBottomHalf,  ///< TopBottom, with both squeezed to half their height.
    Anaglyph,       ///< For red-cyan glasses, colours by Dubois, docs/mathematics.md, (3.9).
    AnaglyphHalf,   ///< For red-cyan glasses, the left eye in grey, the right one in colour.
    AnaglyphGrey,   ///< For red-cyan glasses, both eyes in grey.
    Rows, ///< For televisions with polarized rows: rows 0, 2, 4, ... show the left eye's picture,
          ///< the others the right eye's.
    Columns,     ///< For screens with a parallax barrier: as Rows, with columns.
    Checkerboard ///< For DLP televisions: px with an even sum of column and row are the left eye's.
};

/// Whether neighbouring px, rows or columns are of different eyes: such pictures cannot be scaled.
/// @param picture the kind @return true if they are
[[nodiscard]] inline bool isInterlaced(EyesPicture picture) {
    return picture >= EyesPicture::Rows;
}

/// Whether a picture is for red-cyan glasses. @param picture the kind @return true if it is
[[nodiscard]] inline bool isAnaglyph(EyesPicture picture) {
    return picture == EyesPicture::Anaglyph || picture == EyesPicture::AnaglyphHalf ||
           picture == EyesPicture::AnaglyphGrey;
}

/// Contents of a picture or video according to its file name: the tags that players of 3D files
/// read. The contents must confirm it: `_LR` may mean Lightroom.
struct SceneName {
    /// Meaning of the tag.
    enum class Contents {
        Eyes, ///< Both eyes: `LR`, `SBS`, `2x1`, `TB`, `TAB`, `OU`, `RL`, ...
        Rgbd, ///< Photo and depth: `RGBD`, `HRGBD`.
        Vr ///< A picture for headsets, which no panel can show: `180x180`, `180`, `360`, `VR180`.
    };
    Contents contents = Contents::Eyes;            ///< What the picture holds.
    std::string tag;                               ///< The tag as written in the name: "LR".
    StereoLayout layout = StereoLayout::LeftRight; ///< Eyes: order of the eyes.
    bool isStacked = false;                        ///< Rgbd: the halves lie above each other.
    StereoHalves halves = StereoHalves::Automatic; ///< Shape of the halves, if the tag states it.
};

/// Reads the tags of a file name: words of letters and digits, in upper or lower case, after the
/// first word. The last tag for eyes counts; VR takes precedence over RGB-D, and RGB-D over eyes.
/// `180` and `360` are numbers, not tags, if the directory holds a file whose name differs only in
/// that number.
/// @param file the file
/// @return the tag; nothing without one
[[nodiscard]] ALTIRO3D_EXPORT std::optional<SceneName>
parseSceneName(const std::filesystem::path& file);

/// Shape of the halves of a file: the stated one, else that in its name (HSBS and HRGBD are
/// squeezed, RGBD and LRF full, ...), else Automatic, which the aspect resolves if it is known.
/// @param file its name is used, not its contents
/// @param stated Automatic: nothing is stated
/// @param aspect width : height of the whole picture as it is seen; 0: not known
/// @return the shape; Automatic only if the aspect is 0
[[nodiscard]] ALTIRO3D_EXPORT StereoHalves halvesOf(const std::filesystem::path& file,
                                                    StereoHalves stated = StereoHalves::Automatic,
                                                    double aspect = 0);

/// The pictures of the two eyes.
struct StereoPair {
    cv::Mat left;       ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat right;      ///< [rows x cols, CV_8UC3, BGR]; its size may differ a little
    std::string origin; ///< Origin for people: "MPO", "spatial HEIC", "left and right half".
};

/// Reads the two pictures, upright and in sRGB, of a file that is marked as a stereo pair:
/// - an MPO of a 3D camera (JPEG with MP type "multi-frame image, disparity", CIPA DC-007);
/// - a spatial photo (HEIC or AVIF with a group `ster`);
/// - a JPEG with the header of JPS (layout, order, half width and height, separation are used);
/// - a PNG with the chunk sTER or the mark of writeEyes();
/// - a panorama of Cardboard Camera;
/// - a file named .jps or .pns; the right eye's picture is at the left unless stated otherwise.
///
/// Other multi-picture files (bursts, other panoramas, portraits) are not pairs. If the second
/// picture or the header is damaged, or if the header says that the picture is for one eye, the
/// function returns no pair (for .jps and .pns: the pair that the name implies) and adds a remark.
/// @param photo any picture
/// @param notes if given, receives a remark if the file has a pair that is not used
/// @return the pair; nothing for other files, and for pipes, see PhotoFile::look()
/// @throws Error as PhotoFile::bytes(); as readPhoto(), for a file that is a pair; Unsupported
///         (interleaved or anaglyph JPS)
[[nodiscard]] ALTIRO3D_EXPORT std::optional<StereoPair> readStereoPair(const PhotoFile& photo,
                                                                       Notes* notes = nullptr);

/// The layout of a file that holds both eyes in one picture, which readStereoPair() splits: JPS and
/// the like, not MPO.
/// @param photo as for readStereoPair()
/// @return the layout; nothing for other files
/// @throws Error as PhotoFile::bytes(), Unsupported (interleaved or anaglyph JPS)
[[nodiscard]] ALTIRO3D_EXPORT std::optional<StereoLayout> readStereoLayout(const PhotoFile& photo);

/// Splits a picture that holds both eyes, exactly in the middle (an odd row or column in the middle
/// belongs to neither). Squeezed halves are stretched to their shape by linear interpolation.
/// @param picture [rows x cols, CV_8UC3, BGR], at least 2 px in the direction of the split
/// @param layout order of the eyes
/// @param halves shape of the halves
/// @return the pair; full halves share the memory of `picture`
/// @throws Error InvalidArgument (empty, wrong type, too small to split)
[[nodiscard]] ALTIRO3D_EXPORT StereoPair splitStereoPair(
    const cv::Mat& picture, StereoLayout layout, StereoHalves halves = StereoHalves::Automatic);

/// Writes a picture for two eyes: as writeImage(), with a mark in PNG (text chunk "altiro3D") and
/// JPEG (header of JPS) by which readStereoPair() splits it, or refuses it if it is an anaglyph or
/// interlaced. As JPEG, anaglyphs and interlaced pictures have quality 100 and full chroma (4:4:4).
/// @param path, picture as for writeImage()
/// @param kind what the picture is
/// @param swapped the eyes are exchanged in it
/// @throws Error as writeImage()
ALTIRO3D_EXPORT void writeEyes(const std::filesystem::path& path, const cv::Mat& picture,
                               EyesPicture kind, bool swapped = false);

/// As splitStereoPair(), for a picture from a file. Automatic halves follow the file's name
/// (halvesOf()), else its mark, else their shape. A frame of one colour around both eyes' pictures
/// and a gap between them are removed.
/// @param picture, layout, halves as for splitStereoPair()
/// @param file the picture's file
/// @param notes if given, receives remarks: a frame is removed, the shape is doubtful
/// @return the pair
/// @throws Error as splitStereoPair()
[[nodiscard]] ALTIRO3D_EXPORT StereoPair splitStereoFile(const cv::Mat& picture,
                                                         StereoLayout layout, StereoHalves halves,
                                                         const PhotoFile& file,
                                                         Notes* notes = nullptr);

/// Whether a picture seems to mix both eyes' pictures: its red is shifted against its green, or
/// every second row or column belongs to another picture.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @return a remark for people ("looks like a red-cyan anaglyph, ..."); empty for other pictures
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT std::string mixedEyes(const cv::Mat& picture);

} // namespace altiro3D
