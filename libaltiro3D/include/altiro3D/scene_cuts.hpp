#pragma once

#include "altiro3D/export.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

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
    bool next(const cv::Mat& picture);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
