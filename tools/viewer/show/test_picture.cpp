#include "viewer/show/presentation.hpp"

#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt2native.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::viewer {

namespace {

constexpr double kMiddle = 0.2;   // the views between -kMiddle and +kMiddle are green
constexpr double kSameGrey = 188; // half of the light of white, by the sRGB curve
constexpr int kSteps = 8;
constexpr int kMostNumbered = 16; // views

const cv::Scalar kLeft(30, 20, 220);
const cv::Scalar kCentre(40, 170, 30);
const cv::Scalar kRight(220, 70, 20);

// Words in the middle of a line. @param y px of the line
// @param below the part of the letters that lies below it
void write(cv::Mat& picture, const std::string& words, double scale, double y, double below = 0) {
    const int thickness = std::max(1, static_cast<int>(scale * 2));
    const cv::Size size =
        cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, scale, thickness, nullptr);
    const double fit = std::min(1.0, 0.9 * picture.cols / std::max(1, size.width));
    cv::putText(picture, words,
                {static_cast<int>((picture.cols - fit * size.width) / 2),
                 static_cast<int>(y + below * size.height)},
                cv::FONT_HERSHEY_SIMPLEX, fit * scale, cv::Scalar::all(255), thickness,
                cv::LINE_AA);
}

cv::Mat colouredQuilt(const QuiltLayout& layout) {
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (int view = 0; view < layout.viewCount; ++view) {
        const double position =
            layout.viewCount > 1 ? 2.0 * view / (layout.viewCount - 1) - 1 : 0; // -1..1
        const cv::Scalar& colour =
            position < -kMiddle ? kLeft : (position > kMiddle ? kRight : kCentre);
        cv::Mat tile = quilt(layout.tile(view));
        tile.setTo(colour);
        if (layout.viewCount <= kMostNumbered)
            write(tile, std::to_string(view), std::min(tile.rows, tile.cols) / 60.0,
                  tile.rows / 2.0, 0.5);
    }
    return quilt;
}

void drawStrip(cv::Mat& native) {
    const TestPictureParts parts = testPictureParts(native.size());
    native(parts.grey).setTo(cv::Scalar::all(kSameGrey));
    for (int y = 0; y < parts.lines.height; ++y)
        native(parts.lines).row(y).setTo(cv::Scalar::all(y % 2 == 0 ? 255 : 0));
    for (int step = 0; step < kSteps; ++step) {
        const int begin = parts.steps.width * step / kSteps;
        const int end = parts.steps.width * (step + 1) / kSteps;
        native(parts.steps)
            .colRange(begin, end)
            .setTo(cv::Scalar::all(std::round(255.0 * step / (kSteps - 1))));
    }
}

} // namespace

TestPictureParts testPictureParts(cv::Size panel) {
    const int side = std::max(1, std::min(panel.width / 8, panel.height / 8)) & ~1;
    const int y = panel.height - 2 * side;
    TestPictureParts parts;
    parts.lines = cv::Rect(panel.width / 2 - 3 * side, y, side, side);
    parts.grey = parts.lines + cv::Point(side, 0);
    parts.steps = cv::Rect(panel.width / 2 - side / 2, y, panel.width / 2 - side / 2, side);
    return parts;
}

cv::Mat makeTestPicture(const Display& display) {
    const NativeLut lut(display.calibration, display.quilt, display.invert);
    cv::Mat native;
    Quilt2Native(lut).render(colouredQuilt(display.quilt), native);
    drawStrip(native);
    const double scale = 0.025 * native.rows / 22;
    write(native, "from the left: red", scale, 0.1 * native.rows);
    write(native, "from the middle: green", scale, 0.15 * native.rows);
    write(native, "from the right: blue", scale, 0.2 * native.rows);
    cv::rectangle(native, {{0, 0}, native.size()}, cv::Scalar::all(255), 1);
    cv::rectangle(native, {{1, 1}, native.size() - cv::Size(2, 2)}, cv::Scalar::all(0), 1);
    return native;
}

std::vector<std::string> testPictureAdvice() {
    return {("Look at the middle of the panel with one eye: green from straight ahead, red from "
             "the left, blue from the right."),
            "Red and blue are exchanged: the views are inverted; try --invert.",
            ("Straight ahead it is not green, or several bands or slanted borders of the colours "
             "are seen: the calibration is of another display."),
            ("The square of fine lines has bands, or a white line is missing at an edge: the "
             "screen is scaled; set it to its own resolution, 100 %, without overscan."),
            ("The square of fine lines is brighter or darker than the grey one beside it, or the "
             "steps have a colour: a colour profile or a night light changes the picture; switch "
             "it off."),
            ("Up to 16 views show their numbers. From left to right they must grow one by one, "
             "else the order of the views is wrong.")};
}

} // namespace altiro3D::viewer
