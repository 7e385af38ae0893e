#pragma once

#include "altiro3D/lens_sheet.hpp"

#include <opencv2/core/mat.hpp>
#include <optional>

namespace altiro3D::viewer {

/// What is turned to find the numbers of a lens.
enum class LensKnob { Pitch, Slope, Centre };
enum class LensStep { Coarse, Fine, Finest };

/// Finding the numbers of a lens by looking at a test picture through it: one view is lit, all
/// others are black. With the right numbers an eye sees all of the panel lit from one direction and
/// dark from the others. A wrong pitch shows bands side by side, one for each lens by which the
/// count across the panel is wrong. A wrong slope shows bands above each other, one for each lens
/// by which the shift down the panel is wrong. A wrong centre turns the light to another direction.
///
/// The knobs are independent of each other: pitch and slope leave the light in the middle of the
/// panel as it is, and the slope leaves the number of lenses across as it is.
class LensByEye {
  public:
    /// @param display where to begin: a panel with standing lenses
    /// @throws Error as setCalibration()
    explicit LensByEye(const Display& display);

    /// The calibration to begin with if there is none.
    /// @param px of the screen, which are square @param width of it, mm
    /// @param lpi lenses per inch @param angle of them, as LensNumbers::angle
    /// @throws Error as calibrationOf()
    static Calibration screenCalibration(cv::Size px, double width, double lpi, double angle);

    const Calibration& calibration() const { return calibration_; }
    /// @throws Error BadFormat (not valid), Unsupported (a print, lying lenses); nothing changes
    void setCalibration(const Calibration& calibration);

    /// Turns a knob by a coarse, fine or finest step: pitch and slope by 1, 1/10 or 1/200 of a
    /// band, the centre by 1/10, 1/100 or 1/1000 of a lens period.
    /// @param direction 1: the number grows, -1: it falls
    /// @throws Error as setCalibration(), at the end of what lenses can be
    void turn(LensKnob knob, LensStep step, int direction);
    /// @throws Error as setCalibration()
    void set(LensKnob knob, double value);
    double value(LensKnob knob) const;
    /// How much the number of a knob changes per band, about; for the centre 1, the whole period.
    double band(LensKnob knob) const;

    /// Order of the sub-pixels; nothing if that of the calibration is not one that can be chosen.
    std::optional<SubpixelOrder> order() const;
    void setOrder(SubpixelOrder order); ///< Not None.

    int views() const { return views_; }
    int litView() const { return litView_; }
    /// The views of the test picture, of which the one in the middle is lit. More of them make a
    /// narrower light, which shows smaller errors. They are not part of the calibration.
    /// @param views 3..kMostViews; even numbers become the next odd one
    void setViews(int views);
    void setLitView(int view); ///< 0 (seen from the left) .. views() - 1
    static constexpr int kMostViews = 99;

    /// [panel, CV_8UC3]
    cv::Mat picture() const;

  private:
    Calibration calibration_;
    InvertViews invert_;
    int views_ = 3;
    int litView_ = 1;
};

} // namespace altiro3D::viewer
