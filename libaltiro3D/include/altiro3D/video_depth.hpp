#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/video_io.hpp"

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// Detects the frames of a video that begin a new scene. It uses only the pictures and does not
/// look ahead.
///
/// A picture begins a scene if it cannot be composed by moving parts of the previous picture
/// (docs/mathematics.md, 5.3). Motion, global changes of brightness, fades and pictures without
/// contrast (a flash, black) are not cuts. After a picture without contrast, the comparison uses
/// the last picture with contrast. A dissolve is not a cut, because it is gradual.
///
/// Move-only; one thread at a time per object.
class ALTIRO3D_EXPORT SceneCuts {
  public:
    SceneCuts();
    ~SceneCuts();
    SceneCuts(SceneCuts&&) noexcept;            ///< Moves.
    SceneCuts& operator=(SceneCuts&&) noexcept; ///< Moves. @return *this

    /// Whether the next picture begins a scene. The first picture and one of another size always
    /// do.
    ///
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @return true if it does
    /// @throws Error InvalidArgument (empty, wrong type)
    [[nodiscard]] bool next(const cv::Mat& picture);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// How often the depth of a video is estimated and how steady it is kept.
struct VideoDepthOptions {
    /// The network runs on every n-th picture, 1..1000; 0 = as the pictures require.
    int every = 0;
    int longestGap = 12; ///< With every = 0: pictures from one inference to the next, 1..1000.
    /// With every = 0: share of the picture that may be new since the last inference, 0..1.
    double maxChangedShare = 0.08;
    /// Share of the depth before that is kept per picture where nothing moves, 0..0.99; 0 = off:
    /// each inference stands for itself.
    double steadiness = 0.9;
};

/// Checks the options.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoDepthOptions& options);

/// What happened with one picture.
struct VideoDepthStep {
    bool cut = false;      ///< First picture, one of another size, or the first of a new scene.
    bool inferred = false; ///< The estimator ran.
    bool repeated = false; ///< The picture equals the one before bit for bit; so does the depth.
};

/// The depth of a video, picture by picture and without looking ahead: steady, and with as few
/// inferences as wanted (docs/mathematics.md, 5).
///
/// The estimator runs on the first picture of a scene and then on every n-th, or when the picture
/// has changed enough. In between the last depth moves with the picture. What a new inference says
/// is mixed with the depth carried there: little of it where the picture stood still, all of it
/// where it is new; the range of depth, the percentiles 0.5 and 99.5 of each inference, follows
/// slowly. A scene's first depth is that of its first picture alone: normalizeDepth() of it.
///
/// Pictures that equal the one before are not looked at and not counted. Decisions and depth come
/// from the pictures' values only, never from the clock; given the same numbers from the estimator
/// they are the same bits for any number of threads.
///
/// Move-only; one thread at a time per object.
class ALTIRO3D_EXPORT VideoDepth {
  public:
    /// Gives a picture's raw depth numbers, as DepthNetwork::infer() does.
    /// picture: [rows x cols, CV_8UC3, BGR]; raw: any size and type that normalizeDepth() takes.
    using Estimator = std::function<void(const cv::Mat& picture, cv::Mat& raw)>;

    /// @param estimator called by next(), in its thread
    /// @param kind meaning of the raw numbers
    /// @param options how often and how steady
    /// @throws Error InvalidArgument (options, no estimator)
    VideoDepth(Estimator estimator, DepthKind kind, const VideoDepthOptions& options = {});
    ~VideoDepth();
    VideoDepth(VideoDepth&&) noexcept;            ///< Moves.
    VideoDepth& operator=(VideoDepth&&) noexcept; ///< Moves. @return *this

    /// The options in use. @return as given to the constructor
    [[nodiscard]] const VideoDepthOptions& options() const;

    /// The depth of the next picture.
    ///
    /// If it throws, also if the estimator does, it is as if it had not been called.
    ///
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @param depth in memory of its own each time [estimator's size, CV_32FC1, 0..1, 1 = nearest]
    /// @return what was done
    /// @throws Error InvalidArgument (picture or raw numbers empty or of a wrong type), and what
    ///         the estimator throws
    VideoDepthStep next(const cv::Mat& picture, cv::Mat& depth);

    /// All that is needed to go on later, for setState() of an object with the same options on a
    /// machine of the same kind: the depth is then the same bit for bit. Some 1 MB for 256 x 256.
    /// @return the state
    [[nodiscard]] SavedState state() const;

    /// Goes on from a state().
    /// @param state from state()
    /// @throws Error BadFormat (damaged, not from state()); the object is then as before
    void setState(const SavedState& state);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
