// Many open files: settings of each, the strip of icons, the export of all.

#include "support/compare.hpp"
#include "support/files.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/photo_strip.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QIcon>
#include <QPixmap>
#include <QProcess>
#include <QSettings>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

Knobs otherKnobs() {
    Knobs knobs;
    knobs.views.method = ViewMethod::Fast;
    knobs.views.strengthPercent = 12.5;
    knobs.views.focus = 0.3;
    knobs.views.refinement = 3;
    knobs.views.layered.fill = LayeredFill::Continue;
    knobs.framing = {{0.4, 0.6}, 1.5};
    knobs.isFramingChosen = true;
    knobs.choices = {true, false, false, true};
    knobs.depthCurve = 1.5;
    knobs.depth = "tiny";
    knobs.columns = 5;
    knobs.rows = 9;
    return knobs;
}

class ViewerKnobStore : public ::testing::Test {
  protected:
    void SetUp() override {
        spill(photo_, "one");
        spill(other_, "two");
    }
    TemporaryDirectory folder_;
    fs::path photo_ = folder_ / "photo \xe4\xf6.jpg"; // bytes that are not UTF-8
    fs::path other_ = folder_ / "other.jpg";
    fs::path file_ = folder_ / "data" / "settings.json";
};

TEST_F(ViewerKnobStore, KeepsAllSettingsOfAPhotoUntilItsContentsChange) {
    {
        KnobStore store(file_);
        EXPECT_FALSE(store.find(photo_));
        store.set(photo_, otherKnobs());
        EXPECT_EQ(store.find(photo_), otherKnobs());
        store.save();
        EXPECT_EQ(store.note(), "");
    }
    const KnobStore store(file_);
    EXPECT_EQ(store.find(photo_), otherKnobs());
    EXPECT_FALSE(store.find(other_));
    fs::rename(photo_, folder_ / "photo.jpg");
    EXPECT_FALSE(store.find(photo_));
    EXPECT_FALSE(store.find(folder_ / "photo.jpg"));
    fs::rename(folder_ / "photo.jpg", photo_);
    EXPECT_TRUE(store.find(photo_));
    spill(photo_, "more");
    EXPECT_FALSE(store.find(photo_));
}

TEST_F(ViewerKnobStore, TwoViewersKeepWhatEachHasChanged) {
    KnobStore first(file_);
    KnobStore second(file_);
    first.set(photo_, otherKnobs());
    first.save();
    second.set(other_, Knobs());
    second.save();
    const KnobStore store(file_);
    EXPECT_EQ(store.find(photo_), otherKnobs());
    EXPECT_EQ(store.find(other_), Knobs());
}

TEST_F(ViewerKnobStore, BrokenFilesAreNotUsedAndSaidSo) {
    fs::create_directories(file_.parent_path());
    {
        KnobStore store(file_);
        store.set(photo_, otherKnobs());
        store.set(other_, otherKnobs());
        store.save();
    }
    const std::string good = slurp(file_);
    const auto replaced = [&good](const std::string& from, const std::string& to) {
        std::string text = good;
        EXPECT_TRUE(holds(text, from));
        return text.replace(text.find(from), from.size(), to);
    };
    const std::string half = good.substr(0, good.size() / 2);
    for (const std::string& text :
         {std::string(), std::string("[]"), std::string("{\"version\":2}"), half,
          std::string("\xff\xfe"), std::string(1000000, '['),
          replaced("\"version\": 2", "\"version\": 1"),
          std::string(KnobStore::kMaxBytes + 1, ' ')}) {
        spill(file_, text);
        const KnobStore store(file_);
        EXPECT_FALSE(store.find(photo_));
        EXPECT_NE(store.note(), "") << text.substr(0, 40);
    }
    // one photo's settings are broken: those of the other count
    for (const auto& [from, to] :
         {std::pair{"\"strength\": 12.5", "\"strength\": -1"},
          std::pair{"\"focus\": 0.3", "\"focus\": \"x\""},
          std::pair{"\"zoom\": 1.5", "\"zoom\": 1e9"}, std::pair{"\"fit\": \"auto\"", "\"fit\": 0"},
          std::pair{"\"method\"", "\"best\""}}) {
        spill(file_, replaced(from, to));
        const KnobStore store(file_);
        EXPECT_FALSE(store.find(photo_)) << to;
        EXPECT_TRUE(store.find(other_)) << to;
        EXPECT_TRUE(holds(store.note(), "1 photo are broken"));
    }
    spill(file_, half); // is replaced by a whole one
    KnobStore store(file_);
    store.set(photo_, otherKnobs());
    store.save();
    EXPECT_EQ(KnobStore(file_).find(photo_), otherKnobs());
}

TEST_F(ViewerKnobStore, SaysThatNothingCanBeKept) {
    KnobStore store(photo_ / "settings.json"); // in a file
    store.set(other_, otherKnobs());
    store.save();
    EXPECT_TRUE(holds(store.note(), "cannot be written"));
    EXPECT_EQ(store.find(other_), otherKnobs()); // in this run
}

TEST_F(ViewerKnobStore, DropsTheOldestOfTooMany) {
    std::string text = "{\"version\":2,\"photos\":[";
    {
        KnobStore store(file_);
        store.set(photo_, otherKnobs());
        store.save();
    }
    const std::string good = slurp(file_);
    const auto from = good.find("\"settings\":");
    const std::string settings = good.substr(from, good.rfind(']') - from);
    for (std::size_t i = 0; i < KnobStore::kMaxPhotos; ++i)
        text +=
            std::string(i > 0 ? "," : "") + "{\"photo\":\"" + std::to_string(i) + "\"," + settings;
    spill(file_, text + "]}");
    ASSERT_LT(fs::file_size(file_), KnobStore::kMaxBytes);
    KnobStore store(file_);
    EXPECT_EQ(store.note(), "");
    store.set(other_, otherKnobs());
    store.save();
    EXPECT_TRUE(KnobStore(file_).find(other_));
    const std::string after = slurp(file_);
    EXPECT_FALSE(holds(after, "\"photo\": \"0\""));
    EXPECT_TRUE(holds(after, "\"photo\": \"1\""));
    EXPECT_LE(fs::file_size(file_), KnobStore::kMaxBytes);
}

// Photos in a folder: two with different pictures, one that is broken.
class ViewerManyFiles : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        fs::create_directory(folder_ / "photos");
        fs::create_directory(folder_ / "natives");
        writeImage(photo("a.png"), detailedPhoto({300, 400}));
        writeImage(photo("a-depth.png"), boxDepth({300, 400}));
        cv::Mat wide = detailedPhoto({500, 300});
        cv::circle(wide, {200, 150}, 80, {20, 60, 220}, cv::FILLED);
        writeImage(photo("b.jpg"), wide);
        spill(photo("broken.jpg"), "no picture");
    }
    fs::path photo(const std::string& name) const { return folder_ / "photos" / name; }
    fs::path native(const std::string& name) const { return folder_ / "natives" / name; }
    QString at(const std::string& name) const { return toName(folder_ / name); }
    void openFolder(Model& model) const {
        model.stage.setArea({200, 200});
        model.files.open(std::vector<fs::path>{folder_ / "photos"});
        EXPECT_TRUE(
            waitFor([&] { return model.files.sources().size() == 3 && !model.stage.isBusy(); }));
    }
    static void select(Model& model, int index) {
        model.files.select(index);
        EXPECT_TRUE(waitFor([&] { return !model.stage.isBusy(); }));
    }
    static void turnTo(Model& model, double strength, double focus) {
        Knobs knobs = model.settings.knobs();
        knobs.views.strengthPercent = strength;
        knobs.views.focus = focus;
        knobs.choices = {};
        model.settings.turn(knobs, "both");
    }
    static BatchReport exportAll(Model& model, const fs::path& folder) {
        BatchReport report;
        bool ended = false;
        QObject here;
        QObject::connect(&model.exports, &Exports::allEnded, &here, [&](const BatchReport& now) {
            report = now;
            ended = true;
        });
        EXPECT_TRUE(model.exports.startAll(folder));
        EXPECT_FALSE(model.exports.startAll(folder)); // one at a time
        EXPECT_TRUE(waitFor([&ended] { return ended; }));
        return report;
    }
    // Runs the tool for the model's display.
    void photo2native(const QStringList& options, const QStringList& files) const {
        const QStringList display{"-c", writeSample(folder_ / "c.json", {150, 200})};
        ASSERT_EQ(QProcess::execute(ALTIRO3D_TOOL_PHOTO2NATIVE, display + options + files), 0);
    }

    TemporaryDirectory folder_;
    Display display_ = sampleDisplay({150, 200});
};

TEST_F(ViewerManyFiles, EachHasItsSettingsAlsoInTheNextRun) {
    {
        Model model(display_);
        openFolder(model);
        turnTo(model, 20, 0.25);
        model.stage.zoomFrame({0.5, 0.5}, 1.5, 0);
        EXPECT_EQ(model.settings.undoStack().count(), 2);
        select(model, 1);
        EXPECT_EQ(model.settings.knobs(), Knobs());
        EXPECT_EQ(model.settings.undoStack().count(), 0); // its steps belong to the other photo
        turnTo(model, 5, 0.75);
        select(model, 0);
        EXPECT_EQ(model.settings.knobs().views.strengthPercent, 20);
        EXPECT_EQ(model.settings.knobs().framing.zoom, 1.5);
        model.files.close(0);
        ASSERT_TRUE(waitFor([&] { return !model.stage.isBusy(); }));
        EXPECT_EQ(model.settings.knobs().views.strengthPercent, 5);
    }
    Model model(display_);
    openFolder(model);
    EXPECT_EQ(model.settings.knobs().views.strengthPercent, 20);
    EXPECT_EQ(model.settings.knobs().views.focus, 0.25);
    EXPECT_EQ(model.settings.knobs().framing.zoom, 1.5);
    select(model, 1);
    EXPECT_EQ(model.settings.knobs().views.strengthPercent, 5);
    while (!model.files.sources().empty())
        model.files.close(0);
    EXPECT_EQ(model.settings.knobs(), Knobs());
}

TEST_F(ViewerManyFiles, PhotosAreChosenForVideosAreNotUnlessAsked) {
    writeGreys(folder_ / "v.mkv", {64, 48}, 2, 25);
    Model model(display_);
    openFolder(model);
    EXPECT_EQ(model.settings.knobs(), Knobs());
    EXPECT_TRUE(model.settings.knobs().choices.framing);
    model.files.open(std::vector<fs::path>{folder_ / "v.mkv"});
    ASSERT_TRUE(waitFor([&] { return !model.stage.isBusy(); }));
    EXPECT_FALSE(model.settings.knobs().choices.any());
    model.settings.reset();
    EXPECT_FALSE(model.settings.knobs().choices.any());
    Knobs knobs = model.settings.knobs();
    knobs.choices.focus = true;
    model.settings.turn(knobs, "focus");
    select(model, 0);
    select(model, static_cast<int>(model.files.sources().size()) - 1);
    EXPECT_TRUE(model.settings.knobs().choices.focus);
}

TEST_F(ViewerManyFiles, SettingsAreCopiedToAllButNotTheFrame) {
    Model model(display_);
    openFolder(model);
    select(model, 1);
    model.stage.zoomFrame({0.5, 0.5}, 2, 0);
    const double zoom = model.settings.knobs().framing.zoom; // 2 times what the photo had
    select(model, 0);
    turnTo(model, 15, 0.4);
    model.stage.zoomFrame({0.5, 0.5}, 1.25, 0);
    model.settings.copyTo(model.files.sources());
    EXPECT_EQ(model.settings.knobs().framing.zoom, 1.25);
    select(model, 1);
    EXPECT_EQ(model.settings.knobs().views.strengthPercent, 15);
    EXPECT_EQ(model.settings.knobs().framing.zoom, zoom);
    EXPECT_FALSE(model.settings.knobs().choices.any());
    EXPECT_EQ(model.settings.standardKnobs().views.strengthPercent, 15);
    EXPECT_EQ(model.settings.standardKnobs().framing, Framing());
}

TEST_F(ViewerManyFiles, ExportsOfAllAreWhatIsSeenAndWhatTheToolMakes) {
    Model model(display_);
    openFolder(model);
    turnTo(model, 7.5, 0.25);
    select(model, 1);
    Knobs knobs = model.settings.knobs();
    knobs.depth = "tiny";
    model.settings.turn(knobs, "all");
    const BatchReport report = exportAll(model, folder_ / "natives");
    EXPECT_EQ(report.written, 2u);
    EXPECT_FALSE(report.cancelled);
    ASSERT_EQ(report.problems.size(), 1u); // and it did not end the others
    EXPECT_EQ(report.problems[0].rfind(photo("broken.jpg").string() + ": ", 0), 0u)
        << report.problems[0];
    EXPECT_FALSE(fs::exists(native("broken_native.png")));

    photo2native({"-d", "--fit", "cover", "--strength", "7.5", "--focus", "0.25"},
                 {at("photos/a.png"), at("photos/a-depth.png"), at("tool-a.png")});
    EXPECT_EQ(slurp(native("a_native.png")), slurp(folder_ / "tool-a.png"));
    photo2native({}, {at("photos/b.jpg"), at("tool-b.png")});
    EXPECT_EQ(slurp(native("b_native.png")), slurp(folder_ / "tool-b.png"));

    for (const int index : {0, 1}) { // what the window shows
        select(model, index);
        model.stage.setArea({5000, 5000});
        model.stage.setMode(Mode::Native);
        ASSERT_TRUE(waitFor([&] {
            const Frame& frame = model.stage.frame();
            return frame.setup.mode == Mode::Native && frame.knobs == model.settings.knobs() &&
                   frame.setup.document == model.files.document() && !model.stage.isBusy();
        }));
        const fs::path file = native(index == 0 ? "a_native.png" : "b_native.png");
        EXPECT_TRUE(samePicture(model.stage.frame().picture, readPhoto(file)));
    }
}

TEST_F(ViewerManyFiles, ExportsOfAFolderHaveTheNamesOfTheTool) {
    fs::remove(photo("broken.jpg"));
    writeImage(photo("a.jpg"), detailedPhoto({200, 300}));
    const FolderFiles found = filesOfFolder(folder_ / "photos");
    photo2native({}, {at("photos"), at("natives")});
    std::vector<fs::path> made;
    for (const auto& entry : fs::directory_iterator(folder_ / "natives"))
        made.push_back(entry.path());
    std::vector<fs::path> named = nativesOf(found.files, folder_ / "natives");
    std::sort(made.begin(), made.end());
    std::sort(named.begin(), named.end());
    EXPECT_EQ(named, made);
    // the same name in two folders
    const std::vector<fs::path> both = nativesOf({{"/x/a.jpg", {}}, {"/y/a.jpg", {}}}, "/z");
    ASSERT_EQ(both.size(), 2u);
    EXPECT_NE(both[0], both[1]);
}

TEST_F(ViewerManyFiles, APhotoIsNeverReplacedByAnExport) {
    fs::copy(photo("b.jpg"), photo("b_native.png")); // a photo of this name
    const std::string before = slurp(photo("b_native.png"));
    Model model(display_);
    model.files.open(std::vector<fs::path>{photo("b.jpg"), photo("b_native.png")});
    const BatchReport report = exportAll(model, folder_ / "photos");
    EXPECT_EQ(report.written, 1u); // b_native_native.png
    ASSERT_EQ(report.problems.size(), 1u);
    EXPECT_TRUE(holds(report.problems[0], "is one of the photos"));
    EXPECT_EQ(slurp(photo("b_native.png")), before);
}

TEST_F(ViewerManyFiles, AnExportOfAllCanBeCancelled) {
    Model model(display_);
    model.files.open(std::vector<fs::path>{photo("b.jpg")});
    for (int i = 0; i < 40; ++i) {
        fs::copy(photo("b.jpg"), photo("c" + std::to_string(i) + ".jpg"));
        model.files.open(std::vector<Source>{
            Source{photo("c" + std::to_string(i) + ".jpg"), {}, Reading::Photo}});
    }
    QObject::connect(&model.exports, &Exports::progress, [&](double done) {
        if (done > 0.02) model.exports.cancel();
    });
    const BatchReport report = exportAll(model, folder_ / "natives");
    EXPECT_TRUE(report.cancelled);
    EXPECT_LT(report.written, 41u);
    const auto files = std::distance(fs::directory_iterator(folder_ / "natives"), {});
    EXPECT_EQ(static_cast<std::size_t>(files), report.written); // no incomplete one
    EXPECT_FALSE(model.exports.areRunning());
}

TEST_F(ViewerManyFiles, IconsLookLikeTheirPhotos) {
    writeImage(photo("red.jpg"), cv::Mat(600, 900, CV_8UC3, cv::Scalar(10, 20, 200)));
    writeImage(photo("blue.png"), cv::Mat(900, 600, CV_8UC3, cv::Scalar(200, 20, 10)));
    writeGreys(folder_ / "clip.mkv", {90, 120}, 5);
    const QImage red = thumbnailOf({photo("red.jpg"), {}}, 60);
    EXPECT_EQ(red.size(), QSize(60, 40));
    EXPECT_NEAR(red.pixelColor(30, 20).red(), 200, 4);
    EXPECT_NEAR(red.pixelColor(30, 20).blue(), 10, 4);
    const QImage blue = thumbnailOf({photo("blue.png"), {}}, 60);
    EXPECT_EQ(blue.size(), QSize(40, 60));
    EXPECT_EQ(blue.pixelColor(20, 30).blue(), 200);
    EXPECT_FALSE(thumbnailOf({folder_ / "clip.mkv", {}}, 60).isNull());
    EXPECT_TRUE(thumbnailOf({photo("broken.jpg"), {}}, 60).isNull());
    EXPECT_TRUE(thumbnailOf({photo("missing.jpg"), {}}, 60).isNull());
}

TEST_F(ViewerManyFiles, OnlyTheIconsThatAreAskedForAreMade) {
    Thumbnails thumbnails(1);
    std::vector<Source> sources;
    for (int i = 0; i < 2000; ++i)
        sources.push_back({photo(i == 0 ? "b.jpg" : std::to_string(i) + ".jpg"), {}});
    thumbnails.setSources(sources);
    QStringList made; // not a QSignalSpy, which is written in the thread that makes them
    QObject here;
    QObject::connect(&thumbnails, &Thumbnails::made, &here,
                     [&made](const QString& file) { made << file; });
    EXPECT_FALSE(thumbnails.data(thumbnails.index(3), Qt::DecorationRole).isNull()); // a sign
    EXPECT_FALSE(thumbnails.data(thumbnails.index(0), Qt::DecorationRole).isNull());
    ASSERT_TRUE(waitFor([&] { return made.count() == 2; }));
    EXPECT_TRUE(waitFor([&] {
        return thumbnails.data(thumbnails.index(0), Qt::DecorationRole).value<QPixmap>().width() ==
               Thumbnails::kSide;
    }));
    thumbnails.data(thumbnails.index(1000), Qt::DecorationRole);
    EXPECT_TRUE(waitFor([&] { return !made.isEmpty() && made.last().endsWith("1000.jpg"); }));
    EXPECT_EQ(made.count(), 3); // of 2000
}

// The window with the photos open.
class ViewerStrip : public ViewerManyFiles {
  protected:
    void SetUp() override {
        ViewerManyFiles::SetUp();
        window_ = shownWindow();
    }
    void dropFolder() {
        dropOn(*window_, {folder_ / "photos"});
        ASSERT_TRUE(waitFor(
            [this] { return model().files.sources().size() == 3 && !model().stage.isBusy(); }));
    }
    Model& model() { return window_->model(); }
    PhotoStrip& strip() { return *window_->findChild<PhotoStrip*>(); }
    QAction* entry(const QString& text) { return entryOf(*window_, text); }
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerStrip, ShowsTheFilesOfAFolderAndGoesThroughThem) {
    EXPECT_FALSE(strip().isVisible());
    dropFolder();
    EXPECT_TRUE(strip().isVisible());
    EXPECT_EQ(strip().model()->rowCount(), 3);
    EXPECT_EQ(strip().currentIndex().row(), 0);
    EXPECT_FALSE(entry("Previous file")->isEnabled());
    QTest::keyClick(window_.get(), Qt::Key_PageDown);
    EXPECT_EQ(model().files.current(), 1);
    EXPECT_EQ(strip().currentIndex().row(), 1);
    ASSERT_TRUE(waitFor([this] { return !model().stage.isBusy(); }));
    QTest::mouseClick(strip().viewport(), Qt::LeftButton, Qt::NoModifier,
                      strip().visualRect(strip().model()->index(2, 0)).center());
    EXPECT_EQ(model().files.current(), 2);
    EXPECT_FALSE(entry("Next file")->isEnabled());
    QTest::keyClick(window_.get(), Qt::Key_PageUp);
    EXPECT_EQ(model().files.current(), 1);
    strip().setFocus();
    QTest::keyClick(&strip(), Qt::Key_Left);
    EXPECT_EQ(model().files.current(), 0);
    entry("Strip of photos")->trigger();
    EXPECT_FALSE(strip().isVisible());
    entry("Strip of photos")->trigger();
    EXPECT_TRUE(strip().isVisible());
}

TEST_F(ViewerStrip, ExportsAllToAFolderAndListsWhatFailed) {
    dropFolder();
    spill(native("b_native.png"), "mine");
    const QStringList asked = answering(
        folder_ / "natives", QMessageBox::Yes, [this] { entry("Export all Natives")->trigger(); },
        [](const QStringList& soFar) { return soFar.size() == 3; });
    ASSERT_EQ(asked.size(), 3);
    EXPECT_TRUE(asked[1].contains("1 of the files exist already")) << asked[1].toStdString();
    EXPECT_TRUE(asked[2].contains("2 Natives written; 1 files were not exported"))
        << asked[2].toStdString();
    EXPECT_TRUE(asked[2].contains("broken.jpg"));
    EXPECT_NE(slurp(native("b_native.png")), "mine");
    EXPECT_TRUE(entry("Export all Natives")->isEnabled());
}

} // namespace
} // namespace altiro3D::test
