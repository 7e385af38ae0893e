#pragma once

#include "altiro3D/native_renderer.hpp"
#include "altiro3D/quilt2native.hpp"
#include "common/display_options.hpp"

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// How the fitted photos of a run become Natives: straight, or over a quilt.
///
/// Straight wherever the calibration is known and no option needs whole views: no map, no blending,
/// not method Real.
class NativeRoad {
  public:
    /// --continuous --best
    static void add(CommandLine& commandLine);
    /// Whether the photo is read at the panel's resolution: -k, or --best.
    static bool keepsResolution(const CommandLine& commandLine);
    /// Refuses options that go with no road; to be called before any work. @throws UsageError
    static void check(const CommandLine& commandLine);

    /// The road over the quilt gets its look-up table here.
    /// @param method of all pictures; those that a budget chooses go one road
    /// @throws UsageError, Error
    /// @param preferContinuous as --continuous, but only where no option stands against it
    NativeRoad(const CommandLine& commandLine, const ChosenDisplay& display,
               const QuiltLayout& layout, ViewMethod method, Messages& messages,
               bool preferContinuous = false);

    /// No quilt is needed for the Native.
    bool direct() const { return !overQuilt_; }
    /// Cameras stand anywhere, not only at the views.
    bool continuous() const { return positions_ == ViewPositions::Continuous; }
    /// "direct" or "quilt"
    std::string name() const { return direct() ? "direct" : "quilt"; }
    /// What the time of a Native depends on besides the picture: fit for a file name.
    /// @param photo size of the fitted photo
    std::string costKey(cv::Size photo) const;

    /// The renderer of the direct road, for many pictures. Only where direct() is true.
    NativeRenderer renderer(const ViewOptions& views) const;

    /// Makes the Native.
    /// @param photo, depth fitted; the direct road reads these
    /// @param quilt made of them; the road over the quilt reads this
    void makeNative(const ViewOptions& views, const cv::Mat& photo, const cv::Mat& depth,
                    const cv::Mat& quilt, cv::Mat& native) const;

  private:
    std::optional<Calibration> calibration_;
    InvertViews invert_;
    QuiltLayout layout_;
    ViewPositions positions_ = ViewPositions::Discrete;
    bool blends_;
    cv::Size panelSize_;
    std::optional<Quilt2Native> overQuilt_; // absent: direct
};

} // namespace altiro3D::tools
