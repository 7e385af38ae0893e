#pragma once

#include "altiro3D/export.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Finds the pictures of a video that begin a new scene, from the pictures alone and without
/// looking ahead.
///
/// A picture begins a scene if it cannot be put together from the one before by moving parts of it
/// (docs/mathematics.md, 5.3). Movement, changes of brightness as a whole, fades and pictures
/// without contrast (a flash, black) are no cut; after these the last picture that showed something
/// counts. A dissolve is no cut: nothing in it happens at once.
///
/// Move-only; one thread at a time per object.
class ALTIRO3D_EXPORT SceneCuts {
  public:
    SceneCuts();
    ~SceneCuts();
    SceneCuts(SceneCuts&&) noexcept;            ///< Moves.
    SceneCuts& operator=(SceneCuts&&) noexcept; ///< Moves. @return *this

    /// Whether the next picture begins a scene; so does the first one and one of another size.
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
