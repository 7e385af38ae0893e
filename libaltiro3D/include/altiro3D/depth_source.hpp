#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/scene.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// What matchStereo() found. Disparities are shares of the picture's width: (x of a point in the
/// left picture - x in the right one) / width. Larger = nearer. 3D cameras shift the pictures
/// against each other, so disparities may have both signs.
struct ALTIRO3D_EXPORT StereoMatch {
    double shift = 0;    ///< Median disparity. This and the next two count only px with detail.
    double farthest = 0; ///< Smallest disparity: percentile 0.5.
    double nearest = 0;  ///< Largest disparity: percentile 99.5.
    /// Share of the width by which the right picture's middle is lower; undone before matching.
    double verticalOffset = 0;
    double rollDegrees = 0;    ///< Clockwise rotation of the right picture in degrees; undone.
    double matchedShare = 0;   ///< Share of the left picture's px that have a match, 0..1.
    double likeness = 0;       ///< Similarity: correlation of the fine detail of matched px, -1..1.
    bool isReliable = false;   ///< Enough px match and look alike; otherwise do not use the depth.
    bool isFlat = false;       ///< The disparities have a range below 0.15 % of the width.
    bool looksSwapped = false; ///< Background appears in front of foreground: exchange the eyes.

    /// Whether two pictures of unknown origin certainly belong to the two eyes of one view.
    /// Disparities of unrelated pictures spread over 58 % of the width or more, those of real pairs
    /// over 3 to 10 % (docs/depth.md).
    /// @return true if the match is reliable and its disparities have a range of at most 40 %
    [[nodiscard]] bool areEyes() const { return isReliable && nearest - farthest <= 0.4; }

    /// Describes the match for people: "shift -12.0 %, 93 % matched", and unusual findings.
    /// @return the text
    [[nodiscard]] std::string text() const;
    /// Remarks for the user: the pictures do not match, the eyes look swapped.
    /// @param pair name of the pair for the text, for example StereoPair::origin
    /// @return the remarks, usually none
    [[nodiscard]] Notes remarks(const std::string& pair) const;
};

/// Finds the depth of a stereo pair by matching (OpenCV's semi-global matching).
///
/// The pictures are shrunk to at most 1000 px a side and 750 000 px; a vertical offset, a small
/// rotation and a small difference of scale between them are found and undone, and brightness and
/// contrast are made equal. Disparities are searched from -35 % to +35 % of the width, first
/// coarsely. A px counts as matched if the match from the right picture leads back to it within 1
/// px. Px without a match take the farther disparity next to them, because px that one eye does not
/// see belong to the background. The values filled in are then smoothed by a median that is
/// weighted by similarity of colour.
/// @param left [rows x cols, CV_8UC3, BGR]
/// @param right as `left`; its shape may differ by 5 %; it is resized to the left picture's size
/// @param disparity [the shrunk size, CV_32FC1, shares of the width, larger = nearer]; without any
///        match and for flat pairs, all values are `shift`
/// @param hidden if given, receives what only the right eye sees: its picture and disparities (not
///        depth) of the shrunk size, in the colours and rows of the left picture; empty if the
///        pictures do not match or are flat
/// @return what was found
/// @throws Error InvalidArgument (empty, wrong type), Mismatch (shapes)
[[nodiscard]] ALTIRO3D_EXPORT StereoMatch matchStereo(const cv::Mat& left, const cv::Mat& right,
                                                      cv::Mat& disparity,
                                                      HiddenLayer* hidden = nullptr);

/// Turns the disparities of matchStereo()'s hidden layer into depth, with the scale that turned the
/// photo's disparities into its depth.
/// @param disparity of the photo, from matchStereo()
/// @param depth [as disparity, CV_32FC1, 0..1], from normalizeDepth()
/// @param hidden its disparities become depth, not clamped, NaN stays; empty if the depth has no
///        range
/// @throws Error Mismatch (disparity and depth differ in size), InvalidArgument (types)
ALTIRO3D_EXPORT void scaleHiddenDepth(const cv::Mat& disparity, const cv::Mat& depth,
                                      HiddenLayer& hidden);

/// Where depth comes from.
enum class DepthOrigin {
    Estimated, ///< From the photo alone.
    Given,     ///< Stored: a depth image, depth in the photo's file, or an RGB-D image.
    Matched    ///< From the pictures of both eyes.
};

/// A photo, and the depth that came with it.
struct PhotoDepth {
    cv::Mat
        photo; ///< [CV_8UC3, BGR]: the whole picture, its photo half, or the left eye's picture.
    cv::Mat rawDepth; ///< [any size, one channel]; empty: the depth must be estimated.
    DepthKind kind = DepthKind::NearWhite;       ///< Meaning of the numbers of the depth.
    HiddenLayer hidden;                          ///< Of matchStereo(), with disparities, which
                                                 ///< makeScene() turns into depth.
    DepthOrigin origin = DepthOrigin::Estimated; ///< Where the depth comes from.
    std::string text; ///< Origin for people: "depth image beside the photo (FILE)".
    std::filesystem::path separateFile; ///< The depth image that storedDepthOr() found; else empty.
    cv::Size whole;                     ///< Size of an RGB-D image, px; else empty.
};

/// The scene of a photo and the depth that came with it.
/// @param found with rawDepth, for example from readNamedHalves()
/// @param flatDepth as for DepthSource::readScene()
/// @param scene the photo, its depth map of any size, and what only the right eye of a pair sees
/// @throws Error as normalizeDepth()
ALTIRO3D_EXPORT void makeScene(const PhotoDepth& found, double flatDepth, Scene& scene);

/// A source of depth for photos and video frames: a network, a file, or the depth half of an RGB-D
/// image. Each photo is independent of those before it:
///
///     const auto source = storedDepthOr(estimatedDepth());
///     Scene scene;
///     source->readScene(source->readPhoto("photo.jpg"), 0.5, scene);
///
/// One thread at a time per object.
class ALTIRO3D_EXPORT DepthSource {
  public:
    DepthSource() = default;
    virtual ~DepthSource();
    DepthSource(const DepthSource&) = delete;
    DepthSource& operator=(const DepthSource&) = delete;

    /// Names the source for people and reports. @return for example "network midas-small (FILE)"
    [[nodiscard]] virtual std::string description() const = 0;

    /// Meaning of the raw depth numbers that read() gives. @return the kind
    [[nodiscard]] virtual DepthKind kind() const = 0;

    /// What is known about the edges of read()'s depth. @return Unknown unless overridden
    [[nodiscard]] virtual DepthEdges edges() const;

    /// The network that estimates the depth. @return null for other sources, and for networks that
    ///         are not loaded yet
    [[nodiscard]] virtual const DepthNetwork* network() const;

    /// Loads the network now instead of for the first photo. Does nothing for other sources.
    /// @throws Error as DepthNetwork::DepthNetwork(); NotFound (estimatedDepth() without a network)
    virtual void load();

    /// Reads a photo, and depth that comes with it, if the source looks for such depth.
    /// @param file as for altiro3D::readImage()
    /// @param notes if given, receives the remarks of readPhoto(), each after the file name
    /// @return the photo, without depth if that must be estimated
    /// @throws Error as altiro3D::readPhoto(); for depthFromFile() also as readDepthSamples(); for
    ///         depthFromRgbd() as readRgbdImage() and splitRgbd()
    [[nodiscard]] virtual PhotoDepth readPhoto(const PhotoFile& file, Notes* notes = nullptr);

    /// Gives the photo and the raw depth of an image in memory. The depth is the image's depth half
    /// (depthFromRgbd()), the depth image (depthFromFile()), or an estimate.
    /// @param image [rows x cols, CV_8UC3, BGR]; for depthFromRgbd() also CV_16UC3
    /// @param photo the image itself (shares its memory); for depthFromRgbd() its photo half
    ///        [CV_8UC3, BGR]; may be `image`
    /// @param raw depth of the photo [any size, one channel]; kind() states its meaning
    /// @throws Error as the function that each source calls, see below
    virtual void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) = 0;

    /// read() for a frame of a video: sources may spend less time on it. VideoConverter calls it.
    /// @param image, photo, raw as for read()
    /// @throws Error as read()
    virtual void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw);

    /// Makes a scene by normalizeDepth() from the depth that came with the photo, else from read().
    /// @param found from readPhoto()
    /// @param flatDepth depth of the whole photo if its raw depth has no range (all values equal or
    ///        unknown), 0..1. Use ViewOptions::focus: all views then show the photo unchanged.
    /// @param scene the photo, its depth map of any size, and what only the right eye of a pair
    ///        sees
    /// @throws Error as read() and normalizeDepth()
    void readScene(const PhotoDepth& found, double flatDepth, Scene& scene);

    /// read(), then normalizeDepth(), for an image in memory.
    /// @param image as for read(); may be `scene.photo`
    /// @param flatDepth, scene as above
    /// @throws Error as read() and normalizeDepth()
    void readScene(const cv::Mat& image, double flatDepth, Scene& scene);
};

/// Depth from a network, with DepthEdges::Aligned.
///
/// Networks read a copy of the photo with at most 1024 px a side. Those with InputShape::Photo run
/// three times: on the copy at their profile's size, and on the mirrored copy at 1.25 and at 1.625
/// times that size. The result is the mean of the first two runs, with half of the fine detail of
/// the third. If DepthNetwork::inputSize() exceeds the profile's size, the third run uses it
/// instead of 1.625 times the profile's size. A network with another InputShape, or with an input
/// smaller than its profile's, runs once. For a frame of a video, every network runs once, on the
/// frame itself. In photos, depth then becomes linear along straight edges; in photos and frames,
/// steps of depth become hard where the picture has an edge (docs/mathematics.md, 4a). The raw
/// numbers are a depth map whose longer side is at most 512 px, 320 px for frames; kind() is
/// NearWhite.
/// @param network a loaded network
/// @return the source
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource> depthFromNetwork(DepthNetwork network);

/// As depthFromNetwork(), but loads the network when a photo first needs it: network() is null
/// before that. With storedDepthOr(), photos that contain depth cost no time for loading.
/// @param file the ONNX file; it and the following arguments are as for
///        DepthNetwork::DepthNetwork()
/// @param profile preparation of the input, meaning of the output
/// @param target processor to run on
/// @param inputSize size of the network's input; empty: the profile's
/// @param engine program that runs the graph
/// @return the source; its read() and readScene() also throw as DepthNetwork::DepthNetwork()
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromNetworkFile(std::filesystem::path file, NetworkProfile profile,
                     InferenceTarget target = InferenceTarget::Cpu, cv::Size inputSize = {},
                     InferenceEngine engine = InferenceEngine::Best);

/// Depth estimated from the photo alone by standardNetwork(), loaded when first needed, as by
/// depthFromNetworkFile(). If no network is installed, estimating fails; with storedDepthOr(),
/// photos that have depth still work.
/// @return the source; its description() names the network, or is "no network" if none is
///         installed; read(), readFrame(), readScene() and load() then throw Error NotFound
/// @throws Error as standardNetwork()
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource> estimatedDepth();

/// Depth from a separate depth image: readDepthSamples().
/// @param file the depth image
/// @param kind meaning of its numbers
/// @return the source; it reads the depth image again for each photo; readPhoto() may use a second
///         thread for this
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromFile(std::filesystem::path file, DepthKind kind = DepthKind::NearWhite);

/// Depth from an RGB-D image, which holds photo and depth side by side: splitRgbd().
/// Files are read by readRgbdImage().
/// @param layout position of the depth half, shape of the halves; Automatic: halvesOf() the file
/// @param kind meaning of its numbers
/// @return the source
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromRgbd(const RgbdLayout& layout, DepthKind kind = DepthKind::NearWhite);

/// Splits a picture whose name says that it holds both eyes or photo and depth (parseSceneName()),
/// if its contents agree: both eyes match (matchStereo()), or a half is depth (findDepthHalf()).
/// Otherwise it is an ordinary photo, and a remark says so.
/// @param file the picture's file; an RGB-D image is decoded again (readRgbdImage())
/// @param picture [rows x cols, CV_8UC3, BGR], as read by readPhoto()
/// @param notes if given, receives remarks, without the name of the file
/// @return nothing for ordinary photos
/// @throws Error Unsupported (a VR picture by its name), and as readRgbdImage()
[[nodiscard]] ALTIRO3D_EXPORT std::optional<PhotoDepth>
readNamedHalves(const PhotoFile& file, const cv::Mat& picture, Notes* notes = nullptr);

/// Rejects files whose names say that they are made for headsets (SceneName::Contents::Vr).
/// @param file its name is examined @throws Error Unsupported
ALTIRO3D_EXPORT void refuseVrName(const std::filesystem::path& file);

/// What storedDepthOr() takes from a photo's file.
struct PhotoDepthOptions {
    bool useDepth = true;    ///< Use depth in the file or next to it.
    bool unblurred = false;  ///< Read the sharp original where the file has one.
    bool namedHalves = true; ///< With useDepth: also readNamedHalves().
};

/// Depth that comes with the photo, or else from another source. It searches in this order:
/// - a depth image next to the photo (findDepthBeside());
/// - depth in the photo's file (readEmbeddedDepth());
/// - a stereo pair in the file (readStereoPair(), matchStereo()), whose left picture is the photo;
/// - the halves that the file's name states (readNamedHalves()).
///
/// Photos without these, pairs that do not match and images in memory use `fallback`, which is
/// estimatedDepth() in the tools.
/// @param fallback the source for all other photos
/// @param options what to take
/// @return the source; its readPhoto() also throws Error Unsupported (a VR picture by its name,
///         interleaved or anaglyph JPS)
/// @throws Error InvalidArgument (`fallback` is null)
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
storedDepthOr(std::shared_ptr<DepthSource> fallback, const PhotoDepthOptions& options = {});

/// Where the pictures of both eyes are.
struct StereoInput {
    StereoLayout layout = StereoLayout::LeftRight; ///< In one picture: order of the eyes.
    /// In one picture: shape of the halves; Automatic: halvesOf() the file.
    StereoHalves halves = StereoHalves::Automatic;
    std::filesystem::path right; ///< The right eye's picture; empty: one picture holds both eyes.
};

/// Depth of stereo pairs by matching: splitStereoPair(), matchStereo(). The photo is the left eye's
/// picture. For a pair that does not match, another source gives the depth, and a remark says so.
/// @param input where the pictures are
/// @param fallback the source for pairs that do not match
/// @return the source; its readPhoto() also throws Error Mismatch (pictures of different shapes),
///         InvalidArgument (too small to split)
/// @throws Error InvalidArgument (`fallback` is null)
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromStereo(StereoInput input, std::shared_ptr<DepthSource> fallback);

} // namespace altiro3D
