// A simulated person who finds the numbers of a hidden lens by the instructions alone.

#include "viewer/model/lens_by_eye.hpp"

#include "altiro3D/altiro3D.hpp"
#include "support/displays.hpp"
#include "support/slow.hpp"
#include "viewer/window/lens_by_eye_dialog.hpp"
#include "window_actions.hpp"

#include <QClipboard>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QPushButton>
#include <QScreen>
#include <QSettings>
#include <QToolButton>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <stdexcept>

namespace altiro3D::test {
namespace {

using namespace viewer;

// Looks at the picture of the tool through a lens that only the simulator knows. Moving the head
// costs nothing, each press of a key counts.
class Person {
  public:
    Person(LensByEye& tool, const Calibration& lens)
        : tool_(tool), lens_(lens), shown_(tool.picture()) {
        // a lens shows the width of a sub-pixel, of those above each other that of a px
        const double subpixel = 1 / lensGeometry(lens).lensPeriodSubpixels;
        spot_ = lens.subpixelCells.empty() ? subpixel : 3 * subpixel;
        const cv::Size size = shown_.size();
        middle_ = cv::Rect(size.width * 7 / 15 - kAround, size.height * 7 / 15 - kAround,
                           size.width / 15 + 2 * kAround, size.height / 15 + 2 * kAround);
        lensOfMiddle_ = lens;
        lensOfMiddle_.screenW = middle_.width;
        lensOfMiddle_.screenH = middle_.height;
        const LensGeometry whole = lensGeometry(lens);
        const double periodsPerPx = whole.periodsPerWidth / whole.panelWidth;
        const int below = size.height - middle_.y - middle_.height;
        lensOfMiddle_.center -= periodsPerPx * (middle_.x + below / lens.slope);
        const double other = lensGeometry(lensOfMiddle_).phase(20, 30, 2) -
                             whole.phase(middle_.x + 20, middle_.y + 30, 2);
        EXPECT_NEAR(other, std::round(other), 1e-6);
    }

    int presses() const { return presses_; }

    void findNumbers() {
        findLight();
        turn(LensKnob::Pitch);
        turn(LensKnob::Slope);
        chooseOrder();
        turnCentre();
    }

  private:
    struct Light {
        int bands = 0; // along the line
        int reach = 0; // of the light that is in the middle, to either side
    };

    void press(LensKnob knob, LensStep step, int direction) {
        tool_.turn(knob, step, direction);
        lookAgain();
    }

    void lookAgain() {
        shown_ = tool_.picture();
        if (++presses_ > 100) throw std::runtime_error("the instructions lead nowhere");
    }

    cv::Mat3b look(double head) const {
        cv::Mat3b seen;
        simulateView(shown_, lens_, {head, spot_, 0}, seen);
        return seen;
    }

    // The colour of the middle; to look at it alone costs little.
    cv::Scalar middle(double head) const {
        cv::Mat3b seen;
        simulateView(shown_(middle_), lensOfMiddle_, {head, spot_, 0}, seen);
        return cv::mean(
            seen(cv::Rect(kAround, kAround, seen.cols - 2 * kAround, seen.rows - 2 * kAround)));
    }

    // The grey of the px along a line through the middle, across or down.
    static cv::Mat1d line(const cv::Mat3b& seen, bool isAcross) {
        const int columns = seen.cols / (isAcross ? 1 : 16);
        const int rows = seen.rows / (isAcross ? 16 : 1);
        const cv::Rect part((seen.cols - columns) / 2, (seen.rows - rows) / 2, columns, rows);
        cv::Mat1d mean;
        cv::Mat sum;
        cv::reduce(seen(part), sum, isAcross ? 0 : 1, cv::REDUCE_AVG, CV_64F);
        cv::transform(sum, mean, cv::Matx13d(0.1, 0.6, 0.3));
        if (!isAcross) cv::transpose(mean, mean);
        cv::blur(mean, mean, {mean.cols / 24, 1}, {-1, -1}, cv::BORDER_REFLECT);
        return mean;
    }

    double brightness(double head) const {
        const cv::Scalar bgr = middle(head);
        return 0.1 * bgr[0] + 0.6 * bgr[1] + 0.3 * bgr[2];
    }

    // Moves the head until the middle of the panel is lit, and then to both ends of that light.
    void findLight() {
        double brightest = 0;
        for (int i = 0; i < 24; ++i) {
            const double there = brightness(i / 24.0);
            if (there <= brightest) continue;
            brightest = there;
            light_ = i / 24.0;
        }
        const auto half = [&](double step) {
            double head = light_;
            while (brightness(head) > brightest / 2 && std::abs(head - light_) < 0.5)
                head += step;
            for (int i = 0; i < 3; ++i) {
                step /= 2;
                head += brightness(head - step) > brightest / 2 ? 0 : -step;
            }
            return head;
        };
        left_ = half(-0.08);
        right_ = half(0.08);
        light_ = (left_ + right_) / 2;
    }

    Light lightAlong(bool isAcross) const {
        const cv::Mat1d grey = line(look(light_), isAcross);
        double most = 0;
        cv::minMaxLoc(grey, nullptr, &most);
        const auto isLit = [&](int i) { return grey(i) > most / 2; };
        Light light;
        for (int i = 0; i < grey.cols; ++i)
            light.bands += isLit(i) && (i == 0 || !isLit(i - 1)) ? 1 : 0;
        const int middle = grey.cols / 2;
        while (light.reach < middle && isLit(middle - light.reach) && isLit(middle + light.reach))
            ++light.reach;
        return light;
    }

    // How far light wanders to the right or down while the head moves from left to right, as
    // difference of grey.
    double wandering(bool isAcross, int reach) const {
        cv::Mat1d by;
        cv::subtract(line(look(right_), isAcross), line(look(left_), isAcross), by);
        const int middle = by.cols / 2;
        return cv::mean(by.colRange(middle, middle + reach))[0] -
               cv::mean(by.colRange(middle - reach, middle))[0];
    }

    // "Pitch: if light wanders to the right, press -; to the left, +." "Slope: down -, up +."
    void turn(LensKnob knob) {
        const bool isAcross = knob == LensKnob::Pitch;
        int before = 0;
        for (Light light = lightAlong(isAcross); light.bands > 1; light = lightAlong(isAcross)) {
            const int direction = wandering(isAcross, light.reach) > 0 ? -1 : 1;
            if (direction == -before) break;
            press(knob, LensStep::Coarse, direction);
            before = direction;
        }
        findLight();
        for (const LensStep step : {LensStep::Fine, LensStep::Finest})
            turnUntil(knob, step, -1,
                      [&] { return wandering(isAcross, lightAlong(isAcross).reach); });
    }

    // "The light is white in its middle and at both ends. If it has colours, choose another order."
    void chooseOrder() {
        const SubpixelOrder orders[] = {SubpixelOrder::Bgr, SubpixelOrder::VerticalRgb,
                                        SubpixelOrder::Rgb};
        const auto hasColour = [this](double head) {
            const cv::Scalar bgr = middle(head);
            return std::max({bgr[0], bgr[1], bgr[2]}) - std::min({bgr[0], bgr[1], bgr[2]}) > 30;
        };
        for (const SubpixelOrder next : orders) {
            if (!hasColour(left_) && !hasColour(light_) && !hasColour(right_)) return;
            tool_.setOrder(next);
            lookAgain();
            findLight();
        }
    }

    // "Look from straight ahead; if the light is on your right, press +; on your left, -."
    void turnCentre() {
        const auto toTheRight = [this] { return light_ - 0.5 - std::round(light_ - 0.5); };
        for (findLight(); std::abs(toTheRight()) > 0.05; findLight())
            press(LensKnob::Centre, LensStep::Coarse, toTheRight() > 0 ? 1 : -1);
        const double quarter = (right_ - left_) / 2;
        for (const LensStep step : {LensStep::Fine, LensStep::Finest}) {
            const auto away = [&] { return brightness(0.5 + quarter) - brightness(0.5 - quarter); };
            turnUntil(LensKnob::Centre, step, 1, away);
        }
    }

    // Turns a knob by steps until nothing is seen any more, or to the better side of that.
    template <class Seen>
    void turnUntil(LensKnob knob, LensStep step, int sign, const Seen& seen) {
        double before = seen();
        while (std::abs(before) > kSeen) {
            press(knob, step, before > 0 ? sign : -sign);
            const double now = seen();
            if (now * before < 0) {
                if (std::abs(now) > std::abs(before)) press(knob, step, now > 0 ? sign : -sign);
                return;
            }
            before = now;
        }
    }

    static constexpr double kSeen = 2; // of 255, a difference that is seen
    static constexpr int kAround = 8;  // px around the middle, whose light reaches it

    LensByEye& tool_;
    Calibration lens_;
    cv::Rect middle_;          // of the panel
    Calibration lensOfMiddle_; // as a panel of its own
    double spot_;              // lens periods
    cv::Mat3b shown_;          // by the tool
    int presses_ = 0;
    double light_ = 0; // where the head sees the middle of the panel lit
    double left_ = 0;  // half as bright
    double right_ = 0;
};

// A film of lenses on a screen of 81 mm by 61 mm; real ones have more px and as many lenses.
Calibration film(double lpi, double angle, double centre,
                 SubpixelOrder order = SubpixelOrder::Rgb) {
    Calibration c = LensByEye::screenCalibration({512, 384}, 81.28, lpi, angle);
    c.center = centre;
    setSubpixels(c, order);
    return c;
}

// A Portrait with a third of the px.
Calibration smallPortrait() {
    Calibration c = stripePanel(512, 683);
    c.DPI /= 3;
    return c;
}

struct HiddenLens {
    std::string name;
    Calibration lens;
    double pitchOff; // where the tool begins, share of the pitch
    double slopeOff;
    double centreOff;   // lens periods
    double slopeWithin; // 1e-3 of the slope, or less
    SubpixelOrder order = SubpixelOrder::Rgb;
};

// googletest names the tests by it
std::ostream& operator<<(std::ostream& to, const HiddenLens& hidden) {
    return to << hidden.name;
}

double apart(double a, double b) {
    return std::abs(a - b - std::round(a - b));
}

class LensByEyeFinds : public ::testing::TestWithParam<HiddenLens> {};

TEST_P(LensByEyeFinds, TheNumbersByTheInstructions) {
    ALTIRO3D_TAKES(4);
    const HiddenLens& hidden = GetParam();
    Display start;
    start.calibration = hidden.lens;
    Calibration& c = start.calibration;
    c.pitch *= 1 + hidden.pitchOff;
    c.slope += hidden.slopeOff;
    c.center += hidden.centreOff;
    setSubpixels(c, SubpixelOrder::Rgb);
    LensByEye tool(start);
    Person person(tool, hidden.lens);
    person.findNumbers();
    const Calibration& found = tool.calibration();
    EXPECT_NEAR(found.pitch / hidden.lens.pitch, 1, 1e-4);
    EXPECT_NEAR(found.slope, hidden.lens.slope, hidden.slopeWithin);
    EXPECT_LT(apart(found.center, hidden.lens.center), 0.02);
    EXPECT_EQ(tool.order(), hidden.order);
    EXPECT_LE(person.presses(), 60);
}

INSTANTIATE_TEST_SUITE_P(
    Hidden, LensByEyeFinds,
    ::testing::Values(HiddenLens{"PortraitFromAnother", smallPortrait(), 0.01, 0.03, 0.3, 1e-3},
                      HiddenLens{"LeansRight", film(26, 8, 0.6), 0.02, -0.3, -0.3, 7e-3},
                      HiddenLens{"LeansLeftBgr", film(31, -10, 0.1, SubpixelOrder::Bgr), -0.015,
                                 0.4, 0.3, 5e-3, SubpixelOrder::Bgr},
                      HiddenLens{"VerticalRgb", film(20, 9.5, 0.9, SubpixelOrder::VerticalRgb),
                                 -0.02, -0.2, 0.3, 6e-3, SubpixelOrder::VerticalRgb},
                      HiddenLens{"NearlyVertical", film(31, 4, 0.3), 0.015, 3, -0.3, 0.0143}),
    [](const auto& hidden) { return hidden.param.name; });

Display displayWith(const Calibration& calibration) {
    Display display;
    display.calibration = calibration;
    return display;
}

// Lenses across the panel, down it, and where the middle of the panel lies under its lens.
std::array<double, 3> lensesOf(const Calibration& c) {
    const LensGeometry g = lensGeometry(c);
    const double across = g.periodsPerWidth;
    const double down = g.tilt * across;
    return {across, down, (across + down) / 2 - c.center};
}

TEST(LensByEye, KnobsDoNotDisturbEachOther) {
    LensByEye tool(displayWith(film(31, -10, 0.1)));
    const auto before = lensesOf(tool.calibration());
    const double slope = tool.calibration().slope;
    tool.turn(LensKnob::Pitch, LensStep::Coarse, 1);
    const auto pitched = lensesOf(tool.calibration());
    EXPECT_NEAR(pitched[0] - before[0], 1, 1e-9);
    EXPECT_EQ(tool.calibration().slope, slope);
    EXPECT_NEAR(apart(pitched[2], before[2]), 0, 1e-9);
    tool.turn(LensKnob::Slope, LensStep::Fine, 1);
    const auto leant = lensesOf(tool.calibration());
    EXPECT_GT(tool.calibration().slope, slope);
    EXPECT_NEAR(leant[0], pitched[0], 1e-9);
    EXPECT_NEAR(leant[1] - pitched[1], -0.1, 1e-9);
    EXPECT_NEAR(apart(leant[2], before[2]), 0, 1e-9);
    tool.turn(LensKnob::Centre, LensStep::Finest, -1);
    EXPECT_NEAR(apart(lensesOf(tool.calibration())[2], before[2] + 0.001), 0, 1e-9);
}

TEST(LensByEye, TurnsThroughTheVertical) {
    LensByEye tool(displayWith(film(31, 0, 0.1)));
    EXPECT_EQ(tool.value(LensKnob::Slope), 1e9);
    tool.turn(LensKnob::Slope, LensStep::Coarse, 1);
    EXPECT_NEAR(lensesOf(tool.calibration())[1], -1, 1e-6);
    tool.turn(LensKnob::Slope, LensStep::Coarse, -1);
    EXPECT_GE(std::abs(tool.value(LensKnob::Slope)), 1e8);
    tool.turn(LensKnob::Slope, LensStep::Coarse, -1);
    EXPECT_NEAR(lensesOf(tool.calibration())[1], 1, 1e-6);
}

TEST(LensByEye, LightsTheSubpixelsOfOneView) {
    for (const auto order : {SubpixelOrder::Rgb, SubpixelOrder::Bgr, SubpixelOrder::VerticalRgb}) {
        LensByEye tool(displayWith(film(31, -10, 0.1, order)));
        EXPECT_EQ(tool.order(), order);
        tool.setViews(8);
        EXPECT_EQ(tool.views(), 9);
        EXPECT_EQ(tool.litView(), 4);
        tool.setLitView(5);
        const cv::Mat3b picture = tool.picture();
        const LensGeometry lens = lensGeometry(tool.calibration());
        for (int y = 0; y < picture.rows; y += 7) {
            for (int x = 0; x < picture.cols; ++x) {
                for (int colour = 0; colour < 3; ++colour) {
                    const bool isLit = LensGeometry::viewOfPhase(lens.phase(x, y, colour), 9) == 5;
                    ASSERT_EQ(picture(y, x)[2 - colour], isLit ? 255 : 0) << x << " " << y;
                }
            }
        }
    }
}

// Lenses of a whole number of sub-pixels leave views dark if there are more views than those.
TEST(LensByEye, BeginsWithLight) {
    for (int half = 6; half < 80; ++half) {
        const double subpixels = half / 2.0;
        const double dpi = 100;
        const Calibration c =
            LensByEye::screenCalibration({300, 40}, 300 / dpi * 25.4, 3 * dpi / subpixels, 0);
        const cv::Mat picture = LensByEye(displayOf(c)).picture().reshape(1);
        EXPECT_GT(cv::countNonZero(picture.row(20)), 20) << subpixels << " under a lens";
    }
}

TEST(LensByEye, RefusesWhatItCannotTurn) {
    LensByEye tool(displayWith(film(31, -10, 0.1)));
    const auto before = fingerprint(tool.calibration());
    for (const double slope : {0.0, 0.5, std::nan("")})
        EXPECT_THROW(tool.set(LensKnob::Slope, slope), Error) << slope;
    for (const double pitch : {0.0, -3.0, 1e6})
        EXPECT_THROW(tool.set(LensKnob::Pitch, pitch), Error) << pitch;
    EXPECT_THROW(tool.set(LensKnob::Centre, std::nan("")), Error);
    LensNumbers print;
    print.lpi = 60;
    print.dpi = 720;
    print.width = print.height = 30;
    EXPECT_THROW(tool.setCalibration(calibrationOf(print)), Error);
    EXPECT_EQ(fingerprint(tool.calibration()), before);
}

// The panel, opened from the menu.
class ViewerLensByEye : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        window_ =
            std::make_unique<MainWindow>(sampleDisplay({150, 200}), std::vector<std::string>());
        window_->show();
        ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get()));
    }
    void inPanel(const std::function<void(LensByEyeDialog&)>& act) {
        bool hasActed = false;
        QTimer::singleShot(0, window_.get(), [&] {
            auto* panel = qobject_cast<LensByEyeDialog*>(QApplication::activeModalWidget());
            ASSERT_NE(panel, nullptr);
            ASSERT_TRUE(waitFor([&] { return panel->isAncestorOf(QApplication::focusWidget()); }));
            act(*panel);
            hasActed = true;
            QTest::keyClick(panel, Qt::Key_Escape);
        });
        window_->findChild<QAction*>("lensByEye")->trigger();
        EXPECT_TRUE(hasActed);
    }
    static double numberIn(const QWidget& panel, const char* name) {
        return panel.findChild<QAbstractSpinBox*>(name)->text().toDouble();
    }
    static QString message(const QWidget& panel) {
        return panel.findChild<QLabel*>("lensMessage")->text();
    }
    static void press(const QWidget& panel, const char* name) {
        panel.findChild<QPushButton*>(name)->click();
    }

    TemporaryDirectory folder_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerLensByEye, TurnsByKeysAndSavesWhatAllToolsRead) {
    const QSize screen = QGuiApplication::primaryScreen()->size();
    const std::filesystem::path file = folder_ / "film.json";
    inPanel([&](LensByEyeDialog& panel) {
        EXPECT_EQ(panel.picture().image().size(), screen);
        EXPECT_TRUE(panel.picture().isVisible());
        panel.findChild<QDoubleSpinBox*>("lensLpi")->setValue(28);
        panel.findChild<QDoubleSpinBox*>("lensAngle")->setValue(9);
        panel.findChild<QDoubleSpinBox*>("lensWidth")->setValue(screen.width() / 100.0 * 25.4);
        press(panel, "lensBegin");
        EXPECT_EQ(numberIn(panel, "pitch"), 28);
        const QImage before = panel.picture().image().copy();

        auto* pitch = panel.findChild<QAbstractSpinBox*>("pitch");
        const double band = 28 / (28 * std::cos(9 * CV_PI / 180) * screen.width() / 100);
        QTest::keyClick(pitch, Qt::Key_PageUp);
        QTest::keyClick(pitch, Qt::Key_Down);
        QTest::keyClick(pitch, Qt::Key_Up, Qt::ShiftModifier);
        EXPECT_NEAR(numberIn(panel, "pitch"), 28 + band * (1 - 0.1 + 0.005), 1e-3 * band + 1e-5);
        EXPECT_TRUE(waitFor([&] { return panel.picture().image() != before; }));

        auto* slope = panel.findChild<QAbstractSpinBox*>("slope");
        const auto type = [](QAbstractSpinBox& box, const char* text) {
            box.selectAll();
            QTest::keyClicks(&box, text);
            QTest::keyClick(&box, Qt::Key_Return);
        };
        type(*slope, "0.3");
        EXPECT_TRUE(message(panel).contains("slope")) << message(panel).toStdString();
        type(*slope, "6,5"); // as some write it
        EXPECT_EQ(message(panel), "");
        EXPECT_EQ(numberIn(panel, "slope"), 6.5);
        type(*slope, "1e9");
        EXPECT_EQ(slope->text(), "vertical");
        type(*slope, "6.5");
        type(*panel.findChild<QAbstractSpinBox*>("centre"), "0.25");
        auto* order = panel.findChild<QComboBox*>("lensOrder");
        QTest::keyClick(order, Qt::Key_Down);
        EXPECT_EQ(order->currentText(), "BGR");
        const QStringList asked =
            answering(file, QMessageBox::Ok, [&] { press(panel, "lensSave"); });
        EXPECT_EQ(asked, QStringList("visual.json"));
        EXPECT_TRUE(message(panel).contains("film.json"));
    });
    const Calibration saved = readCalibration(file);
    EXPECT_EQ(saved.slope, 6.5);
    EXPECT_EQ(saved.center, 0.25);
    EXPECT_EQ(saved.flipSubp, 1);
    EXPECT_EQ(saved.screenW, screen.width());
    EXPECT_EQ(fingerprint(window_->model().files.display()->calibration), fingerprint(saved));
    QProcess tool;
    tool.start(ALTIRO3D_TOOL_ALTIRO3DNATIVE, {"--info", toName(file)});
    ASSERT_TRUE(tool.waitForFinished());
    EXPECT_EQ(tool.exitCode(), 0);
    const QByteArray told = tool.readAllStandardOutput();
    EXPECT_TRUE(told.contains("screen") && told.contains("BGR stripes")) << told.toStdString();
}

TEST_F(ViewerLensByEye, CopiesNumbersAndTakesThem) {
    inPanel([](LensByEyeDialog& panel) {
        QClipboard& clipboard = *QGuiApplication::clipboard();
        press(panel, "lensCopy");
        Calibration c = parseCalibrations(clipboard.text().toStdString(), "copied").front();
        c.pitch = 33.5;
        clipboard.setText(QString::fromStdString(calibrationText(c)));
        press(panel, "lensPaste");
        EXPECT_EQ(numberIn(panel, "pitch"), 33.5);
        c.screenW += 100;
        clipboard.setText(QString::fromStdString(calibrationText(c)));
        press(panel, "lensPaste");
        EXPECT_TRUE(message(panel).contains("clipboard: holds a calibration of"));
        clipboard.setText("no numbers");
        press(panel, "lensPaste");
        EXPECT_TRUE(message(panel).contains("clipboard")) << message(panel).toStdString();
        EXPECT_EQ(numberIn(panel, "pitch"), 33.5);
    });
}

TEST_F(ViewerLensByEye, IsReachedByKeysAndNamed) {
    inPanel([](LensByEyeDialog& panel) {
        std::set<QWidget*> reached;
        for (QWidget* at = QApplication::focusWidget(); reached.insert(at).second;
             at = QApplication::focusWidget()) {
            const auto* button = qobject_cast<QAbstractButton*>(at);
            EXPECT_FALSE(at->accessibleName().isEmpty() &&
                         (button == nullptr || button->text().isEmpty()))
                << at->objectName().toStdString();
            QTest::keyClick(at, Qt::Key_Tab);
        }
        for (const char* name : {"pitch", "slope", "centre", "lensOrder", "lensViews",
                                 "lensLitView", "lensLpi", "lensSave"})
            EXPECT_EQ(reached.count(panel.findChild<QWidget*>(name)), 1U) << name;
        for (const QToolButton* button : panel.findChildren<QToolButton*>())
            EXPECT_FALSE(button->accessibleName().isEmpty());
    });
}

} // namespace
} // namespace altiro3D::test
