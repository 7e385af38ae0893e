// Painting depth: the canvas, strokes of the model, the bar of the window.

#include "support/compare.hpp"
#include "viewer/model/depth_canvas.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QElapsedTimer>
#include <QSettings>
#include <QSignalSpy>
#include <QToolButton>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

const cv::Size kPhoto(300, 400);

// Photo of boxDepth(): the box is bright.
cv::Mat boxPhoto() {
    cv::Mat photo(kPhoto, CV_8UC3, cv::Scalar(50, 60, 40));
    photo.setTo(cv::Scalar(200, 180, 160), boxDepth(kPhoto));
    return photo;
}

class ViewerPaint : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        for (const std::string name : {"photo", "other"}) {
            writeImage(folder_ / (name + ".png"), boxPhoto());
            writeImage(folder_ / (name + "-depth.png"), boxDepth(kPhoto));
        }
    }
    fs::path file(const std::string& name) const { return folder_ / name; }

    TemporaryDirectory folder_;
};

class ViewerPaintModel : public ViewerPaint {
  protected:
    void SetUp() override {
        ViewerPaint::SetUp();
        model_.stage.setArea(kPhoto);
        model_.settings.restore(ofVideo(Knobs())); // nothing is chosen by the photo
        model_.files.open(std::vector<fs::path>{file("photo.png"), file("photo-depth.png")});
        model_.stage.setMode(Mode::Depth);
        ASSERT_TRUE(settle());
    }
    // Waits for the frame of the last change.
    bool settle() {
        return waitFor([this] {
            const Frame& frame = model_.stage.frame();
            return !model_.stage.isBusy() && frame.setup.document == model_.files.document() &&
                   frame.setup.document && frame.setup.mode == model_.stage.mode() &&
                   frame.knobs == model_.settings.knobs() && !frame.setup.isDraft &&
                   model_.exports.obstacle().isEmpty();
        });
    }
    cv::Mat depth() const { return model_.stage.frame().depth; }
    void stroke(const Paint& paint, const std::vector<cv::Point2d>& places) {
        ASSERT_TRUE(model_.stage.beginStroke(paint, places.front()));
        for (const cv::Point2d& place : places)
            model_.stage.continueStroke(place);
        model_.stage.endStroke();
        ASSERT_TRUE(settle());
    }
    void exportTo(Product product, const char* name) {
        QSignalSpy ended(&model_.exports, &Exports::ended);
        ASSERT_TRUE(model_.exports.start(product, file(name)));
        ASSERT_TRUE(waitFor([&] { return ended.count() == 1; }));
    }
    void undo() {
        model_.settings.undoStack().undo();
        ASSERT_TRUE(settle());
    }
    Paint farther(double amount = 0.3) const {
        Paint paint;
        paint.tool = PaintTool::Farther;
        paint.amount = amount;
        return paint;
    }

    Model model_{sampleDisplay({150, 200})};
};

TEST_F(ViewerPaintModel, AStrokeChangesTheDepthUnderIt) {
    const cv::Mat before = depth().clone();
    ASSERT_EQ(before.size(), kPhoto);
    ASSERT_TRUE(model_.stage.canPaint());
    EXPECT_FALSE(model_.stage.isPainted());
    stroke(farther(), {{0.5, 0.5}, {0.6, 0.6}});
    EXPECT_TRUE(model_.stage.isPainted());
    // by the library, in px: the radius is 0.04 of the photo's longer side
    DepthBrushOptions options;
    options.brush = DepthBrush::Farther;
    options.amount = 0.3;
    options.radius = 16;
    DepthStroke expected(boxPhoto(), before, options);
    expected.moveTo({149.5, 199.5});
    expected.moveTo({179.5, 239.5});
    EXPECT_TRUE(samePicture(depth(), expected.depth(), 1e-5)); // floats of two ways to the px
    EXPECT_NEAR(depth().at<float>(200, 150), 0.7, 1e-5);
}

TEST_F(ViewerPaintModel, StrokesAreUndoneAndDoneAgain) {
    const cv::Mat before = depth().clone();
    stroke(farther(), {{0.4, 0.4}, {0.5, 0.6}});
    const cv::Mat one = depth().clone();
    stroke(farther(), {{0.6, 0.4}});
    const cv::Mat two = depth().clone();
    EXPECT_GT(compare(one, two).count, 100u);
    EXPECT_EQ(model_.settings.undoStack().undoText(), "brush: farther");
    undo();
    EXPECT_TRUE(samePicture(depth(), one));
    undo();
    EXPECT_TRUE(samePicture(depth(), before));
    EXPECT_FALSE(model_.stage.isPainted());
    EXPECT_TRUE(model_.stage.unsavedDepths().empty());
    model_.settings.undoStack().redo();
    model_.settings.undoStack().redo();
    ASSERT_TRUE(settle());
    EXPECT_TRUE(samePicture(depth(), two));
    model_.stage.unpaint();
    ASSERT_TRUE(settle());
    EXPECT_TRUE(samePicture(depth(), before));
    undo();
    EXPECT_TRUE(samePicture(depth(), two));
    undo();
    EXPECT_TRUE(samePicture(depth(), one));
}

TEST_F(ViewerPaintModel, TheFrameMovesThePlaces) {
    Knobs knobs = model_.settings.knobs();
    knobs.framing = {{0.5, 0.375}, 2};
    model_.settings.turn(knobs, "frame");
    ASSERT_TRUE(settle());
    stroke(farther(), {{0.5, 0.75}}); // the middle of the photo
    model_.stage.resetFrame();
    ASSERT_TRUE(settle());
    EXPECT_NEAR(depth().at<float>(200, 150), 0.7, 1e-5);
    EXPECT_EQ(depth().at<float>(150, 150), 1);
    EXPECT_EQ(depth().at<float>(250, 150), 1);
    EXPECT_NEAR(model_.stage.brushRadius(0.04), 16.0 / 300, 1e-9);
}

TEST_F(ViewerPaintModel, CopyTakesTheDepthOfItsFirstPlace) {
    Paint paint;
    paint.tool = PaintTool::Copy;
    paint.amount = 1;
    paint.keepsEdges = false;
    stroke(paint, {{0.1, 0.5}, {0.5, 0.5}}); // from the wall over the box
    EXPECT_EQ(depth().at<float>(200, 140), 0);
    EXPECT_EQ(depth().at<float>(260, 140), 1);
}

TEST_F(ViewerPaintModel, TheLassoLiftsWhatItEncircles) {
    Paint paint;
    paint.tool = PaintTool::Lasso;
    paint.amount = -0.4;
    stroke(paint, {{0.22, 0.22}, {0.78, 0.22}, {0.78, 0.78}, {0.22, 0.78}});
    EXPECT_EQ(model_.settings.undoStack().undoText(), "lasso");
    cv::Mat expected;
    boxDepth(kPhoto).convertTo(expected, CV_32F, 0.6 / 255);
    const Difference difference = compare(depth(), expected, 0.01);
    EXPECT_LT(static_cast<double>(difference.count), 0.005 * kPhoto.area()) << difference.report;
}

TEST_F(ViewerPaintModel, PaintedDepthStaysWithItsPhotoAndSource) {
    const cv::Mat before = depth().clone();
    stroke(farther(), {{0.5, 0.5}});
    const cv::Mat painted = depth().clone();
    model_.files.open(std::vector<fs::path>{file("other.png"), file("other-depth.png")});
    ASSERT_TRUE(settle());
    EXPECT_TRUE(samePicture(depth(), before));
    model_.files.select(0);
    ASSERT_TRUE(settle());
    EXPECT_TRUE(samePicture(depth(), painted));
    Knobs knobs = model_.settings.knobs();
    knobs.depth = "tiny";
    model_.settings.turn(knobs, "depth");
    ASSERT_TRUE(settle());
    EXPECT_FALSE(model_.stage.isPainted());
    undo();
    EXPECT_TRUE(samePicture(depth(), painted));
    ASSERT_EQ(model_.stage.unsavedDepths().size(), 1u);
    EXPECT_EQ(model_.stage.unsavedDepths().front(), file("photo.png"));
}

TEST_F(ViewerPaintModel, WhatIsExportedIsWhatIsSeen) {
    Paint paint;
    paint.tool = PaintTool::Lasso;
    paint.amount = -0.7;
    stroke(paint, {{0.2, 0.2}, {0.8, 0.2}, {0.8, 0.5}, {0.2, 0.5}});
    const cv::Mat painted = depth().clone();
    exportTo(Product::Depth, "painted.png");
    EXPECT_TRUE(model_.stage.unsavedDepths().empty());
    // another program reads the same depth, in 16 bits
    cv::Mat read;
    readDepthSamples(file("painted.png")).convertTo(read, CV_32F, 1 / 65535.0);
    EXPECT_TRUE(samePicture(read, painted, 1.0 / 65535));

    exportTo(Product::Native, "native.png");
    QSignalSpy all(&model_.exports, &Exports::allEnded);
    fs::create_directory(file("all"));
    ASSERT_TRUE(model_.exports.startAll(file("all")));
    ASSERT_TRUE(waitFor([&] { return all.count() == 1; }));
    const std::string native = slurp(file("native.png"));
    EXPECT_TRUE(slurp(file("all") / "photo_native.png") == native);
    model_.stage.unpaint();
    ASSERT_TRUE(settle());
    exportTo(Product::Native, "native.png");
    EXPECT_TRUE(slurp(file("native.png")) != native);
}

TEST_F(ViewerPaintModel, OnlyPhotosFromTheMiddleArePainted) {
    model_.stage.setMode(Mode::Sway);
    model_.stage.setPosition(0.5);
    ASSERT_TRUE(waitFor([this] { return model_.stage.frame().setup.position == 0.5; }));
    EXPECT_FALSE(model_.stage.beginStroke(farther(), {0.5, 0.5}));
    model_.stage.setPosition(0);
    ASSERT_TRUE(waitFor([this] { return model_.stage.frame().setup.position == 0; }));
    EXPECT_TRUE(model_.stage.canPaint());
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(settle());
    EXPECT_FALSE(model_.stage.beginStroke(farther(), {0.5, 0.5}));
    model_.stage.continueStroke({0.5, 0.5}); // of no stroke: nothing
    model_.stage.endStroke();
    EXPECT_EQ(model_.settings.undoStack().count(), 0);
}

TEST_F(ViewerPaintModel, StrokesLeaveTheSwayVideoTheWholePhoto) {
    model_.settings.restore(Knobs());
    ASSERT_TRUE(settle());
    ASSERT_GT(model_.stage.frame().setup.knobs.framing.zoom, 1); // no view looks beyond the sides
    const auto videoSize = [&] {
        exportTo(Product::SwayVideo, "sway.mkv");
        return VideoReader(file("sway.mkv")).facts().size;
    };
    const cv::Size whole = videoSize();
    stroke({}, {{0.5, 0.5}});
    ASSERT_TRUE(settle());
    EXPECT_FALSE(model_.settings.knobs().choices.any());
    EXPECT_EQ(videoSize(), whole);
    model_.stage.zoomFrame({0.5, 0.5}, 1.5, 0); // by the user
    ASSERT_TRUE(settle());
    EXPECT_LT(videoSize().area(), whole.area());
}

TEST(ViewerDepthCanvas, LargePhotosArePaintedSmaller) {
    const cv::Mat photo(3000, 4000, CV_8UC3, cv::Scalar::all(90));
    DepthCanvas canvas(photo, cv::Mat(10, 10, CV_32FC1, cv::Scalar(0.25)));
    EXPECT_LE(canvas.depth().total(), static_cast<std::size_t>(kMaxCanvasPixels));
    EXPECT_NEAR(static_cast<double>(canvas.depth().cols) / canvas.depth().rows, 4.0 / 3, 0.01);
    Paint paint;
    paint.amount = 0.5;
    canvas.begin(paint, {0.75, 0.25});
    const PaintedPart part = canvas.end();
    cv::Point most;
    cv::minMaxLoc(canvas.depth(), nullptr, nullptr, nullptr, &most);
    const int radius = static_cast<int>(paint.radius * canvas.depth().cols) + 1;
    EXPECT_NEAR(most.x, 0.75 * canvas.depth().cols, radius);
    EXPECT_NEAR(most.y, 0.25 * canvas.depth().rows, radius);
    EXPECT_NEAR(part.place.width, 2 * radius, 3);
    canvas.put(part.place, part.before);
    EXPECT_EQ(cv::countNonZero(canvas.depth() != 0.25F), 0);
}

class ViewerPaintWindow : public ViewerPaint {
  protected:
    void SetUp() override {
        ViewerPaint::SetUp();
        window_ = shownWindow();
        window_->model().files.open(
            std::vector<fs::path>{file("photo.png"), file("photo-depth.png")});
        ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull() && !isBusy(); }));
    }
    Model& model() { return window_->model(); }
    bool isBusy() { return model().stage.isBusy(); }
    PictureView& picture() { return *window_->findChild<PictureView*>(); }
    PaintBar& bar() { return *window_->findChild<PaintBar*>(); }
    void press(const QString& tool) {
        auto* action = bar().findChild<QAction*>(tool);
        ASSERT_NE(action, nullptr);
        qobject_cast<QToolButton*>(bar().widgetForAction(action))->click();
    }
    void beginToPaint() {
        QTest::keyClick(window_.get(), Qt::Key_B);
        ASSERT_TRUE(waitFor([this] { return bar().isVisible() && model().stage.canPaint(); }));
        ASSERT_TRUE(waitFor([this] { return picture().pointer() == PictureView::Pointer::Brush; }));
    }
    // Closes the window and answers its question.
    QString closing(QMessageBox::StandardButton answer) {
        return test::answering({}, answer, [this] { window_->close(); }).value(0);
    }

    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerPaintWindow, AKeyShowsTheBarAndEscapeHidesIt) {
    EXPECT_FALSE(bar().isVisible());
    model().stage.setSwinging(true);
    model().stage.setMode(Mode::Lens);
    beginToPaint();
    EXPECT_EQ(model().stage.mode(), Mode::Sway);
    EXPECT_FALSE(model().stage.isSwinging());
    ASSERT_TRUE(bar().paint());
    EXPECT_EQ(bar().paint()->tool, PaintTool::Nearer);
    const double radius = bar().paint()->radius;
    QTest::keyClick(window_.get(), Qt::Key_BracketRight);
    EXPECT_GT(bar().paint()->radius, radius);
    QTest::keyClick(window_.get(), Qt::Key_BracketLeft);
    EXPECT_EQ(bar().paint()->radius, radius);
    press("Smooth");
    EXPECT_EQ(bar().paint()->tool, PaintTool::Smooth);
    EXPECT_EQ(bar().paint()->amount, 1);
    press("Farther");
    EXPECT_EQ(bar().paint()->amount, 0.1);
    QTest::keyClick(window_.get(), Qt::Key_Escape);
    EXPECT_FALSE(bar().isVisible());
    EXPECT_EQ(picture().pointer(), PictureView::Pointer::Frame);
}

TEST_F(ViewerPaintWindow, TheMousePaintsAndCtrlZUndoes) {
    beginToPaint();
    press("Farther");
    ASSERT_TRUE(model().settings.knobs().choices.any());
    Knobs chosen = ofVideo(model().stage.frame().setup.knobs);
    chosen.isFramingChosen = true;
    const QPoint middle = picture().rect().center();
    drag(picture(), middle, middle + QPoint(40, 30));
    EXPECT_EQ(model().settings.knobs(), chosen); // stays as it is; no click, no drag
    EXPECT_EQ(model().settings.undoStack().count(), 1);
    EXPECT_TRUE(model().stage.isPainted());
    ASSERT_TRUE(waitFor([this] {
        const Frame& frame = model().stage.frame();
        return !frame.setup.isDraft && !frame.setup.painted.depth.empty() && !frame.depth.empty();
    }));
    const cv::Mat& depth = model().stage.frame().depth;
    EXPECT_NEAR(depth.at<float>(depth.rows / 2, depth.cols / 2), 0.9, 0.01);
    QTest::keyClick(window_.get(), Qt::Key_Z, Qt::ControlModifier);
    EXPECT_FALSE(model().stage.isPainted());
}

TEST_F(ViewerPaintWindow, ClosingAsksForDepthThatIsNotSaved) {
    EXPECT_EQ(closing(QMessageBox::Cancel), "");
    window_->show();
    beginToPaint();
    const QPoint middle = picture().rect().center();
    press("Farther");
    drag(picture(), middle, middle + QPoint(9, 9));
    EXPECT_EQ(closing(QMessageBox::Cancel),
              "The depth that you have painted is not saved. Close anyway? " +
                  QString::fromStdString(file("photo.png").string()));
    EXPECT_TRUE(window_->isVisible());
    ASSERT_TRUE(waitFor([this] { return model().exports.obstacle().isEmpty(); }));
    // saves it, then closes
    QTimer typing;
    QObject::connect(&typing, &QTimer::timeout, &typing, [] {
        if (auto* files = qobject_cast<QFileDialog*>(QApplication::activeModalWidget()))
            QMetaObject::invokeMethod(files, "accept", Qt::QueuedConnection);
    });
    typing.start(20);
    closing(QMessageBox::Save);
    EXPECT_TRUE(waitFor([this] { return !window_->isVisible(); }));
    EXPECT_TRUE(model().stage.unsavedDepths().empty());
    EXPECT_TRUE(fs::exists(file("photo_depth.png")));
}

} // namespace
} // namespace altiro3D::test
