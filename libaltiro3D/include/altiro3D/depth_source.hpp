#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/photo_fit.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// Estimates depth from one photo without any network or download.
///
/// The function combines monocular cues of the picture and smooths the result along the photo's
/// edges; docs/depth.md lists the cues and their accuracy. It is the built-in default if no depth
/// network is found. It is always defined and gives the same result for any number of threads. A
/// trained network is much more accurate.
///
/// @param photo [rows x cols, CV_8UC3, BGR], any size from 1 x 1
/// @param depth [smaller or equal size of the same shape, at most 320 px a side, CV_32FC1, 0..1, 1
///        = nearest]; fitDepth() brings it to the photo's size
/// @throws Error InvalidArgument (empty or wrong type)
ALTIRO3D_EXPORT void estimateDepthFromCues(const cv::Mat& photo, cv::Mat& depth);

/// Where the depth of photos and frames comes from. One thread at a time per object.
class ALTIRO3D_EXPORT DepthSource {
  public:
    DepthSource() = default;
    virtual ~DepthSource();
    DepthSource(const DepthSource&) = delete;
    DepthSource& operator=(const DepthSource&) = delete;

    /// Names the source for people and reports. @return "network midas-small (FILE)"
    [[nodiscard]] virtual std::string description() const = 0;

    /// Meaning of the raw numbers. @return as read() gives them
    [[nodiscard]] virtual DepthKind kind() const = 0;

    /// The network that makes the depth. @return null if it comes from elsewhere
    [[nodiscard]] virtual const DepthNetwork* network() const;

    /// Reads the file of an image as read() takes it. A source with a file of its own decodes that
    /// meanwhile, and the next read() takes it from there.
    ///
    /// @param file as for readImage()
    /// @param notes as for readPhoto(), each behind the name of its file
    /// @return the photo [rows x cols, CV_8UC3, BGR], of RGB-D all that is in the file
    /// @throws Error as readPhoto(), of RGB-D readImage(), and of a depth image
    ///         readDepthSamples()
    [[nodiscard]] virtual cv::Mat readImage(const std::filesystem::path& file,
                                            Notes* notes = nullptr);

    /// Reads photo and raw depth of an image.
    ///
    /// @param image [rows x cols, CV_8UC3, BGR; of RGB-D also CV_16UC3]
    /// @param photo the image itself; of RGB-D its photo [CV_8UC3, BGR]; may be `image`
    /// @param raw raw depth numbers of the photo [any size, one channel], see kind()
    /// @throws Error as the functions that each source is made of
    virtual void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) = 0;

    /// Reads photo and depth map of an image: read() and normalizeDepth().
    ///
    /// @param image as for read(); may be `scene.photo`
    /// @param flatDepth the depth where there is no range, 0..1
    /// @param scene photo and its depth map
    /// @throws Error as read() and normalizeDepth()
    virtual void readScene(const cv::Mat& image, double flatDepth, Scene& scene);
};

/// The estimator that needs no network: estimateDepthFromCues().
/// @return the source; its raw numbers are a depth map, which readScene() takes as it is
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource> depthFromCues();

/// A depth network: DepthNetwork::infer().
/// @param network a loaded network
/// @return the source
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource> depthFromNetwork(DepthNetwork network);

/// A depth image in a file of its own: readDepthSamples().
/// @param file the depth image
/// @param kind meaning of its numbers
/// @return the source; it reads the file anew for each image
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromFile(std::filesystem::path file, DepthKind kind = DepthKind::NearWhite);

/// The depth half of a one-picture RGB-D: splitRgbd().
/// @param side where the depth is
/// @param kind meaning of its numbers
/// @return the source
[[nodiscard]] ALTIRO3D_EXPORT std::unique_ptr<DepthSource>
depthFromRgbd(DepthSide side, DepthKind kind = DepthKind::NearWhite);

} // namespace altiro3D
