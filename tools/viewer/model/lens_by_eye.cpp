#include "viewer/model/lens_by_eye.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/quilt2native.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D::viewer {

namespace {

constexpr double kSteepest = 1e9; // slope of a vertical lens

double stepOf(LensKnob knob, LensStep step) {
    constexpr double kSteps[][3] = {{1, 0.1, 0.005}, {0.1, 0.01, 0.001}}; // coarse, fine, finest
    return kSteps[knob == LensKnob::Centre ? 1 : 0][static_cast<int>(step)];
}

// Lenses across the panel, and the shift of one over its height in lenses.
struct LensCount {
    double across;
    double down;
};

LensCount countOf(const Calibration& c) {
    const LensGeometry g = lensGeometry(c);
    return {g.periodsPerWidth, g.tilt * g.periodsPerWidth};
}

} // namespace

LensByEye::LensByEye(const Display& display) : invert_(display.invert) {
    setCalibration(display.calibration);
    // with more views than sub-pixels under a lens, one may have none
    setViews((static_cast<int>(lensFacts(calibration_).usefulViews) - 1) | 1);
}

Calibration LensByEye::screenCalibration(cv::Size px, double width, double lpi, double angle) {
    LensNumbers numbers;
    numbers.lpi = lpi;
    numbers.angle = angle;
    numbers.width = width;
    numbers.height = width * px.height / px.width;
    numbers.dpi = px.width / width * 25.4;
    numbers.subpixels = SubpixelOrder::Rgb;
    return calibrationOf(numbers);
}

void LensByEye::setCalibration(const Calibration& calibration) {
    if (calibration.sheet && calibration.sheet->isPrint)
        throw Error(ErrorCode::Unsupported, "calibration", "is of a print, expected a screen");
    if (lensGeometry(calibration).isLying())
        throw Error(ErrorCode::Unsupported, "slope",
                    "is that of lenses that lie, expected one below -1 or above 1");
    calibration_ = calibration;
}

void LensByEye::turn(LensKnob knob, LensStep step, int direction) {
    const double by = direction * stepOf(knob, step);
    const LensCount count = countOf(calibration_);
    switch (knob) {
    case LensKnob::Pitch:
        return set(knob, calibration_.pitch * (count.across + by) / count.across);
    case LensKnob::Slope: {
        // H P / (W s) lenses down; as they grow, the slope falls
        const Calibration& c = calibration_;
        const double most = count.across * c.screenH / c.screenW;
        const double down = most / c.slope - by;
        return set(knob, std::abs(down) * kSteepest > most ? most / down : kSteepest);
    }
    case LensKnob::Centre:
        return set(knob, calibration_.center + by);
    }
}

void LensByEye::set(LensKnob knob, double value) {
    Calibration c = calibration_;
    c.lens.reset(); // pitch, slope and centre decide from now on
    const LensCount before = countOf(c);
    if (knob == LensKnob::Centre) {
        c.center = value;
    } else {
        (knob == LensKnob::Pitch ? c.pitch : c.slope) = value;
        if (knob == LensKnob::Slope) c.pitch *= before.across / countOf(c).across; // as many lenses
        const LensCount after = countOf(c); // the one over the middle of the panel stays there
        c.center += (after.across + after.down - before.across - before.down) / 2;
    }
    c.center -= std::floor(c.center);
    setCalibration(c);
}

double LensByEye::value(LensKnob knob) const {
    return knob == LensKnob::Pitch   ? calibration_.pitch
           : knob == LensKnob::Slope ? calibration_.slope
                                     : calibration_.center;
}

double LensByEye::band(LensKnob knob) const {
    const Calibration& c = calibration_;
    const double across = countOf(c).across;
    return knob == LensKnob::Pitch   ? c.pitch / across
           : knob == LensKnob::Slope ? c.slope * c.slope * c.screenW / (across * c.screenH)
                                     : 1;
}

std::optional<SubpixelOrder> LensByEye::order() const {
    for (const auto order : {SubpixelOrder::Rgb, SubpixelOrder::Bgr, SubpixelOrder::VerticalRgb}) {
        Calibration c = calibration_;
        setSubpixels(c, order);
        if (fingerprint(c) == fingerprint(calibration_)) return order;
    }
    return std::nullopt;
}

void LensByEye::setOrder(SubpixelOrder order) {
    Calibration c = calibration_;
    setSubpixels(c, order);
    setCalibration(c);
}

void LensByEye::setViews(int views) {
    views_ = std::clamp(views, 3, kMostViews) | 1;
    litView_ = views_ / 2;
}

void LensByEye::setLitView(int view) {
    litView_ = std::clamp(view, 0, views_ - 1);
}

cv::Mat LensByEye::picture() const {
    QuiltLayout layout;
    layout.columns = views_;
    layout.rows = 1;
    layout.tileSize = {1, 1};
    layout.viewCount = views_;
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    quilt(layout.tile(litView_)).setTo(cv::Scalar::all(255));
    cv::Mat native;
    Quilt2Native(calibration_, layout, {}, invert_).render(quilt, native);
    return native;
}

} // namespace altiro3D::viewer
