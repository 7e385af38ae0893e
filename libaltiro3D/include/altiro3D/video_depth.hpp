#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/video_io.hpp"

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <tuple>

namespace altiro3D {

/// How often the depth of a video is estimated and how steady it is kept.
struct VideoDepthOptions {
    /// The estimator runs on every n-th picture, 1..1000; 0 = when the pictures require it:
    /// longestGap and maxChangedShare define when.
    int every = 0;
    /// With every = 0: largest number of pictures from one inference to the next, 1..1000.
    int longestGap = 12;
    /// With every = 0: a new inference is made if more than this share of the picture is new since
    /// the last one, that is, not explained by motion, 0..1.
    double maxChangedShare = 0.08;
    /// How steady the depth is where nothing moves, 0..0.99: if the last inference was n pictures
    /// ago, the previous depth keeps the weight steadiness^n against the new one (5.4). 0: each
    /// inference replaces the previous depth.
    double steadiness = 0.9;

    /// All fields, to save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tie(o.every, o.longestGap, o.maxChangedShare, o.steadiness);
    }
};

/// Checks the options.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoDepthOptions& options);

/// What happened with one picture.
struct VideoDepthStep {
    bool cut = false;      ///< First picture, one of another size, or the first of a new scene.
    bool inferred = false; ///< The estimator ran.
    bool repeated = false; ///< Picture and depth equal the previous ones bit for bit.
};

/// Makes the depth of a video steady, with few inferences (docs/mathematics.md, 5). It works
/// picture by picture and does not look ahead. An inference is one run of the estimator.
///
/// The estimator runs on the first picture of a scene, and then on every n-th picture or when the
/// picture has changed enough. In between, the last depth moves with the picture. A new inference
/// is blended with this moved depth, with a small weight where the picture has not moved and full
/// weight where it is new. The range of depth (percentiles 0.5 and 99.5 of each inference) changes
/// slowly within a scene. The first depth of a scene is normalizeDepth() of its first inference.
///
/// Pictures that equal the previous one, and pictures without contrast (black, a flash), keep its
/// depth and are not counted. Decisions and depth depend on the pictures only, not on time. For
/// equal numbers from the estimator, the result is the same bit for bit for any number of threads.
///
/// Move-only; one thread at a time per object.
class ALTIRO3D_EXPORT VideoDepth {
  public:
    /// Estimates the raw depth numbers of a picture, as DepthNetwork::infer() does.
    /// picture: [rows x cols, CV_8UC3, BGR]; raw: any size, any type that normalizeDepth() accepts.
    using Estimator = std::function<void(const cv::Mat& picture, cv::Mat& raw)>;

    /// @param estimator called by next(), in its thread
    /// @param kind meaning of the raw numbers
    /// @param options how often and how steady
    /// @throws Error InvalidArgument (options, no estimator)
    VideoDepth(Estimator estimator, DepthKind kind, const VideoDepthOptions& options = {});
    ~VideoDepth();
    VideoDepth(VideoDepth&&) noexcept;            ///< Moves.
    VideoDepth& operator=(VideoDepth&&) noexcept; ///< Moves. @return *this

    /// Makes the depth of the next picture. Strong exception guarantee, also when the estimator
    /// throws.
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @param depth [size of the raw depth, CV_32FC1, 0..1, 1 = nearest]; always in new memory
    /// @return how the depth was made
    /// @throws Error InvalidArgument (picture or raw numbers empty or of a wrong type), and what
    ///         the estimator throws
    VideoDepthStep next(const cv::Mat& picture, cv::Mat& depth);

    /// The state, to resume later with setState() of an object with the same options. On a machine
    /// of the same kind the depth is then the same bit for bit.
    /// @return the state; about 1 MB for a raw depth of 256 x 256
    [[nodiscard]] SavedState state() const;

    /// Resumes from a state.
    /// @param state from state()
    /// @throws Error BadFormat (damaged, not from state()); the object is then unchanged
    void setState(const SavedState& state);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
