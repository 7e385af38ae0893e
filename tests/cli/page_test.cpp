// Pages for any browser: what they hold, and what Chromium shows of them.

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/photo_files.hpp"
#include "support/slow.hpp"

#include <QByteArray>
#include <QCryptographicHash>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <regex>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

std::string between(const std::string& text, const std::string& before, const std::string& after) {
    const std::size_t begin = text.find(before);
    if (begin == std::string::npos) return {};
    const std::size_t from = begin + before.size();
    return text.substr(from, text.find(after, from) - from);
}

std::string hashOf(const std::string& text) {
    const auto hash =
        QCryptographicHash::hash(QByteArray::fromStdString(text), QCryptographicHash::Sha256);
    return "'sha256-" + hash.toBase64().toStdString() + "'";
}

// The picture files that a page holds.
std::vector<std::string> picturesOf(const std::string& page) {
    std::vector<std::string> files;
    for (std::size_t at = page.find(";base64,"); at != std::string::npos;
         at = page.find(";base64,", at + 1))
        files.push_back(QByteArray::fromBase64(
                            QByteArray::fromStdString(between(page.substr(at), ";base64,", "\"")))
                            .toStdString());
    return files;
}

// What Layered shows of the whole photo.
SwayView layeredViews(const Scene& scene, const PlacementOptions& options) {
    PhotoFit whole;
    whole.size = scene.photo.size();
    whole.source = whole.target = cv::Rect({}, whole.size);
    return swayViewsOf(scene, options, whole);
}

// A JPEG with an author, a licence and things that are nobody's business.
std::string privatePhoto(const cv::Mat& picture) {
    const std::vector<unsigned char> jpeg = encodePicture(picture, "a.jpg");
    const auto entry = [](unsigned tag, const std::string& text, std::size_t offset) {
        return littleEndian(tag, 2) + littleEndian(2, 2) + littleEndian(text.size(), 4) +
               littleEndian(offset, 4);
    };
    const std::string artist("Ada <b>\0", 8);
    const std::string model("CAMERA-XYZ GPS 48.1N\0", 21);
    const std::string exif = std::string("Exif\0\0II*\0\10\0\0\0\2\0", 16) +
                             entry(0x110, model, 38) + entry(0x13b, artist, 38 + model.size()) +
                             std::string(4, '\0') + model + artist;
    const std::string xmp =
        xmpOf("xmlns:dc=\"http://purl.org/dc/elements/1.1/\" secret=\"/home/ada/pictures\"",
              "<dc:rights><rdf:Alt><rdf:li xml:lang=\"x-default\">CC BY 4.0</rdf:li></rdf:Alt>"
              "</dc:rights>");
    return withSegments({jpeg.begin(), jpeg.end()}, jpegSegment(0xe1, exif) + xmpSegment(xmp));
}

// Pages in Chromium, which has no window and draws by the processor.
class Page : public StudioTest {
  protected:
    Page() : StudioTest("photo2native") {
        for (const char* const file : {"/usr/bin/chromium", "/usr/bin/chromium-browser"})
            if (browser_.empty() && fs::exists(file)) browser_ = file;
    }
    // The page of photo.png and its depth.
    std::string made(const Arguments& more = {}) const {
        EXPECT_TRUE(says(run(more + Arguments("-y -d --save-page p.html photo.png depth.png")),
                         "p.html: page for browsers"));
        return slurp(studio_ / "p.html");
    }
    Outcome open(const std::string& address, const Arguments& options) const {
        return studio_.run("/usr/bin/timeout",
                           Arguments{"60", browser_, "--headless=new", "--no-sandbox",
                                     "--disable-dev-shm-usage", "--use-gl=angle",
                                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                                     "--hide-scrollbars", "--virtual-time-budget=20000",
                                     "--user-data-dir=" + (studio_ / "profile").string()} +
                               options + Arguments{"file://" + (studio_ / address).string()});
    }
    // The page's elements after its script has run, without that.
    std::string elements(const std::string& address, const Arguments& options = {}) const {
        const std::string all = open(address, options + Arguments("--dump-dom")).out;
        return all.substr(0, all.find("<script>"));
    }
    // What a window shows in which a px of the picture takes one.
    cv::Mat viewOf(const std::string& page, double position, cv::Size size) const {
        const int kCaption = 250;
        fs::remove(studio_ / "shot.png");
        const Outcome outcome = open(page + "#view=" + std::to_string(position),
                                     {"--screenshot=" + (studio_ / "shot.png").string(),
                                      "--window-size=" + std::to_string(size.width) + "," +
                                          std::to_string(size.height + kCaption)});
        if (!fs::exists(studio_ / "shot.png")) throw std::runtime_error(outcome.text());
        return readBack(studio_ / "shot.png")(cv::Rect({}, size)).clone();
    }
    // dB of the outermost views against Layered, the mean.
    double qualityOf(const Scene& scene) const {
        const PlacementOptions options;
        writeFile(studio_ / "q.html", photoPage(scene, options, {}));
        const SwayView layered = layeredViews(scene, options);
        double quality = 0;
        for (const double position : {-1.0, 1.0}) {
            cv::Mat expected;
            layered(position, expected);
            quality += cv::PSNR(viewOf("q.html", position, expected.size()), expected) / 2;
        }
        return quality;
    }

    std::string browser_;
};

#define ALTIRO3D_REQUIRE_CHROMIUM()                                                                \
    if (browser_.empty()) GTEST_SKIP() << "needs a browser: apt-get install chromium"

} // namespace

TEST_F(Page, HoldsAllThatItShowsAndForbidsTheRest) {
    const std::string page = made();
    EXPECT_EQ(between(page, "Content-Security-Policy\" content=\"", "\""),
              "default-src 'none'; img-src data:; script-src " +
                  hashOf(between(page, "<script>", "</script>")) + "; style-src " +
                  hashOf(between(page, "<style>", "</style>")) +
                  "; base-uri 'none'; form-action 'none'");
    const std::string rest = std::regex_replace(page, std::regex("src=\"data:|xmlns='[^']*'"),
                                                ""); // which is no address
    for (const char* const way : {"src=", "href", "url(", "http:", "https:", " style=", "@import"})
        EXPECT_EQ(rest.find(way), std::string::npos) << way;
    const std::vector<std::string> pictures = picturesOf(page);
    ASSERT_EQ(pictures.size(), 4U); // surfaces, background, depth and its range
    std::size_t bytes = 0;
    for (const std::string& picture : pictures)
        bytes += picture.size();
    EXPECT_LE(page.size(), bytes * 14 / 10 + 60000);
    EXPECT_TRUE(holds(page, "<title>photo</title>"));
    EXPECT_TRUE(holds(page, "alt=\"photo\""));
}

TEST_F(Page, TellsOnlyTitleAuthorAndLicence) {
    const std::string name = "<script>alert(1)<a>&\".jpg";
    spill(studio_ / name, privatePhoto(readBack(studio_ / "photo.png")));
    ASSERT_TRUE(isDone(run({"-d", "--save-page", "p.html", name, "depth.png"})));
    const std::string page = slurp(studio_ / "p.html");
    EXPECT_TRUE(holds(page, "<h1>&lt;script&gt;alert(1)&lt;a&gt;&amp;&quot;</h1>"));
    EXPECT_TRUE(holds(page, "<p>Ada &lt;b&gt;; CC BY 4.0</p>"));
    std::string all = page;
    for (const std::string& picture : picturesOf(page))
        all += picture;
    for (const char* const word : {"Exif", "GPS", "CAMERA-XYZ", "/home/ada", "purl.org", "Ada <b>"})
        EXPECT_EQ(all.find(word), std::string::npos) << word;
    EXPECT_EQ(all.find(studio_.work().string()), std::string::npos);
    EXPECT_TRUE(holds(made({"--title", "A & B"}), "<title>A &amp; B</title>"));
}

TEST_F(Page, HasTheWantedSize) {
    EXPECT_TRUE(holds(made("--page-side 60"), "&quot;width&quot;:45,&quot;height&quot;:60,"));
    EXPECT_FALSE(fs::exists(studio_ / "native.png"));
    const Scene scene{madePhoto(600, 20), cv::Mat(20, 600, CV_32FC1, cv::Scalar(1))};
    PlacementOptions options;
    options.views.strengthPercent = 100;
    const std::string wide = photoPage({madePhoto(4000, 8), scene.depth}, options, {}, {}, 4096);
    EXPECT_TRUE(holds(wide, "&quot;width&quot;:27")); // with its margins 4096
    options.views.strengthPercent = 101;
    EXPECT_TRUE(holds(errorOf([&] { photoPage(scene, options, {}); }), "strength: is 101"));
}

TEST_F(Page, IsRefusedWithASentence) {
    const auto refused = [&](const Arguments& arguments, const std::string& why) {
        EXPECT_TRUE(fails(run(Arguments("-d") + arguments), 2, why));
    };
    refused("--save-page p.png photo.png depth.png", "p.png: is not the name of a page");
    refused("--save-page - photo.png depth.png", "-: is not the name of a page");
    refused("--title a photo.png depth.png n.png", "--title describes a page");
    refused("--page-side 8 --save-page p.html photo.png depth.png", "--page-side");
    spill(studio_ / "p.html", "before");
    EXPECT_TRUE(
        fails(run("-d --save-page p.html photo.png depth.png"), 1, "p.html: exists")); // no -y
    studio_.limitFiles(20000); // as on a full disk
    EXPECT_EQ(run("-y -d --save-page p.html photo.png depth.png").status, 1);
    EXPECT_EQ(slurp(studio_ / "p.html"), "before");
    EXPECT_TRUE(fails(studio_.run("quilt2native", "-q 1x1 --save-page q.html photo.png"), 1,
                      "has one view, expected two or more for a page"));
    EXPECT_TRUE(
        fails(studio_.run("quilt2native", "--print --save-page q.html quilt.png"), 2, "--print"));
}

TEST_F(Page, IsMadeByEachToolAndOfFolders) {
    studio_.makeSlide();
    studio_.makeScan();
    const auto isMade = [&](const std::string& tool, const Arguments& arguments,
                            const std::string& page) {
        EXPECT_TRUE(isDone(studio_.convert(tool, arguments)));
        const std::string text = slurp(studio_ / page);
        EXPECT_TRUE(holds(text, "&quot;kind&quot;:&quot;" +
                                    std::string(tool == "photo2native" ? "photo" : "views")));
    };
    isMade("quilt2native", "--save-page a.html quilt.png", "a.html");
    isMade("slide2native", "--save-page b.html slide.mkv", "b.html");
    isMade("splat2native", "--save-page c.html scan.ply", "c.html");
    EXPECT_EQ(filesIn(studio_.work()), 12U); // no Native
    fs::create_directory(studio_ / "all");
    for (const char* const name : {"all/x.png", "all/y.png"})
        fs::copy(studio_ / "quilt.png", studio_ / name);
    isMade("quilt2native", "--save-page pages all", "pages/y.html");
    EXPECT_EQ(filesIn(studio_ / "pages"), 2U);
    isMade("quilt2native", "--save-page more all natives", "more/x.html");
    EXPECT_EQ(filesIn(studio_ / "natives"), 2U);
    fs::copy(studio_ / "photo.png", studio_ / "photos/0.png");
    isMade("photo2native", "--save-page pages-p photos", "pages-p/0.html");
    EXPECT_EQ(filesIn(studio_ / "pages-p"), filesIn(studio_ / "photos"));
}

TEST_F(Page, ShowsTheViewsOfLayered) {
    ALTIRO3D_TAKES(8);
    ALTIRO3D_REQUIRE_CHROMIUM();
    cv::Mat depth;
    madeDepth(640, 480).convertTo(depth, CV_32F, 1 / 65535.0);
    EXPECT_GE(qualityOf({madePhoto(640, 480), depth}), 32);
}

TEST_F(Page, ShowsSixPhotosAsLayeredDoes) {
    ALTIRO3D_TAKES(40);
    ALTIRO3D_REQUIRE_CHROMIUM();
    const auto source = estimatedDepth();
    double mean = 0;
    for (const char* const name :
         {"kodak/kodim04.png", "kodak/kodim08.png", "kodak/kodim15.png", "kodak/kodim23.png",
          "skimage/coffee.png", "skimage/chelsea.png"}) {
        ALTIRO3D_REQUIRE_DATA(std::string("photos/") + name);
        Scene scene;
        source->readScene(readPhoto(dataPath(std::string("photos/") + name)), 0.5, scene);
        const double quality = qualityOf(scene);
        EXPECT_GE(quality, 30) << name;
        std::printf("%s: %.1f dB\n", name, quality);
        mean += quality / 6;
    }
    EXPECT_GE(mean, 32);
}

TEST_F(Page, ShowsTheViewsOfAQuilt) {
    ALTIRO3D_TAKES(8);
    ALTIRO3D_REQUIRE_CHROMIUM();
    const QuiltLayout layout{3, 1, {600, 450}, 3};
    cv::Mat quilt(layout.size(), CV_8UC3);
    const cv::Mat photo = madePhoto(600, 450);
    for (int i = 0; i < 3; ++i)
        quilt(layout.tile(i)) = 0.4 * photo + cv::Scalar(40 * i, 140 - 60 * i, 20);
    writeFile(studio_ / "q.html", quiltPage(quilt, layout, 600 / 450.0, {}));
    for (int i = 0; i < 3; ++i)
        EXPECT_GE(cv::PSNR(viewOf("q.html", i - 1, layout.tileSize), quilt(layout.tile(i))), 30);
    const cv::Mat blended = 0.5 * quilt(layout.tile(0)) + 0.5 * quilt(layout.tile(1));
    EXPECT_GE(cv::PSNR(viewOf("q.html", -0.5, layout.tileSize), blended), 30);
}

TEST_F(Page, SaysWhatItCannotDo) {
    ALTIRO3D_TAKES(8);
    ALTIRO3D_REQUIRE_CHROMIUM();
    const std::string page = made();
    const std::string good = elements("p.html");
    EXPECT_TRUE(holds(good, "aria-pressed=\"true\">Motion<"));
    EXPECT_EQ(good.find(">Tilt<"), std::string::npos); // a file may not ask for it
    EXPECT_EQ(good.find(">Headset<"), std::string::npos);
    EXPECT_TRUE(holds(good, "role=\"status\" hidden"));
    EXPECT_TRUE(holds(elements("p.html", {"--force-prefers-reduced-motion"}),
                      "aria-pressed=\"false\">Motion<"));
    EXPECT_TRUE(holds(elements("p.html", {"--disable-3d-apis"}), "as it has no WebGL"));
    std::string damaged = page;
    damaged.replace(damaged.find(";base64,", damaged.find("data-exact")) + 8, 400,
                    std::string(400, 'A'));
    spill(studio_ / "d.html", damaged);
    EXPECT_TRUE(holds(elements("d.html"), "cannot be decoded"));
}

} // namespace altiro3D::test
