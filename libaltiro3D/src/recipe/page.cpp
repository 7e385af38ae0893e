// Pages of photos and quilts: which pictures they hold.

#include "altiro3D/page.hpp"

#include "altiro3D/stereo_views.hpp"
#include "base/checks.hpp"
#include "base/image_format.hpp"
#include "image/image_codecs.hpp"
#include "page_parts.hpp" // made of page.js and page.css
#include "views/layered/layered_pixels.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

namespace altiro3D {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kPhotoQuality = 88;
constexpr int kBackgroundQuality = 80; // it has no detail
constexpr int kViewsQuality = 85;
constexpr int kBlock = 16; // px, of which the page knows the nearest and the farthest depth
constexpr double kMostStrength = 100;
constexpr double kEyesMetres = 0.063;

// Camera positions (-1..1) per metre that a head moves.
double positionsPerMetre(double strengthPercent) {
    return strengthPercent > 0 ? 2 * kEyesStrength / strengthPercent / kEyesMetres : 0;
}

// Fills places without colours smoothly from those around, so that JPEG has no edges there.
// @param sums [CV_32FC4, blue, green, red, 1; 0 where none are set]
cv::Mat goneOn(const cv::Mat& sums) {
    if (sums.cols == 1 && sums.rows == 1) {
        const auto& own = sums.at<cv::Vec4f>(0, 0);
        return cv::Mat(1, 1, CV_32FC4, own[3] > 0 ? own / own[3] : cv::Vec4f(0, 0, 0, 1));
    }
    cv::Mat half;
    cv::resize(sums, half, {(sums.cols + 1) / 2, (sums.rows + 1) / 2}, 0, 0, cv::INTER_AREA);
    cv::Mat whole;
    cv::resize(goneOn(half), whole, sums.size(), 0, 0, cv::INTER_LINEAR);
    whole.forEach<cv::Vec4f>([&](cv::Vec4f& colour, const int* at) {
        const auto& own = sums.at<cv::Vec4f>(at[0], at[1]);
        colour = own + (1 - own[3]) * colour;
    });
    return whole;
}

// What the page draws a photo from; it is described in page.js. All have margins at the left and
// the right, for what the views from the sides show beside the photo.
class PhotoLayers {
  public:
    PhotoLayers(const cv::Mat& photo, const std::vector<LayeredPixel>& pixels, int margin)
        : margin_(margin), sums_(cv::Mat::zeros(photo.rows, photo.cols + 2 * margin, CV_32FC4)),
          depth_(cv::Mat::zeros(sums_.size(), CV_8UC3)),
          distances_(sums_.size(), CV_32FC1, cv::Scalar(kNone)) {
        cv::copyMakeBorder(photo, surfaces_, 0, 0, margin, margin, cv::BORDER_REPLICATE);
        for (const LayeredPixel& pixel : pixels) {
            low_ = std::min(low_, pixel.depth);
            high_ = std::max(high_, pixel.depth);
        }
        for (const LayeredPixel& pixel : pixels)
            if (pixel.isHidden)
                addHidden(pixel);
            else if (pixel.beside == 0)
                addVisible(pixel);
            else
                addBorder(pixel);
        for (const LayeredPixel& pixel : pixels)
            if (pixel.isHidden && std::abs(pixel.beside) == 1) joinToSurface(pixel);
    }

    float low() const { return low_; }
    float level() const { return std::max(high_ - low_, 1e-6F) / (kLevels - 1); }
    const cv::Mat& surfaces() const { return surfaces_; }
    const cv::Mat& depth() const { return depth_; }
    cv::Mat background() const {
        cv::Mat colours;
        goneOn(sums_).convertTo(colours, CV_8U);
        cv::cvtColor(colours, colours, cv::COLOR_BGRA2BGR);
        return colours;
    }

    // The depths that can appear in each block, in a view of any position.
    cv::Mat range() const {
        const cv::Size blocks((depth_.cols + kBlock - 1) / kBlock,
                              (depth_.rows + kBlock - 1) / kBlock);
        cv::Mat least(blocks, CV_8UC1, cv::Scalar(kLevels));
        cv::Mat most(blocks, CV_8UC1, cv::Scalar(1));
        for (int y = 0; y < depth_.rows; ++y)
            for (int x = 0; x < depth_.cols; ++x)
                for (int layer = 0; layer < 2; ++layer) {
                    const std::uint8_t code = depth_.at<cv::Vec3b>(y, x)[2 - layer];
                    auto& low = least.at<std::uint8_t>(y / kBlock, x / kBlock);
                    auto& high = most.at<std::uint8_t>(y / kBlock, x / kBlock);
                    if (code != 0) low = std::min(low, code);
                    high = std::max(high, code);
                }
        const cv::Mat around = cv::Mat::ones(1, 2 * (margin_ / kBlock + 1) + 1, CV_8UC1);
        cv::erode(least, least, around);
        cv::dilate(most, most, around);
        cv::Mat range;
        cv::merge(std::vector<cv::Mat>{cv::Mat::zeros(blocks, CV_8UC1), most, least}, range);
        return range;
    }

  private:
    static constexpr int kLevels = 255; // 1..255; 0: none
    static constexpr float kNone = 1e9F;
    static constexpr int kEnds = 15;   // 1..15; 0: no end
    static constexpr int kShares = 16; // 1/16..1

    std::uint8_t codeOf(float depth) const {
        return static_cast<std::uint8_t>(1 + std::lround((depth - low_) / level()));
    }
    bool holds(int x) const { return x >= -margin_ && x < depth_.cols - margin_; }

    void addVisible(const LayeredPixel& pixel) {
        auto& own = depth_.at<cv::Vec3b>(pixel.y, pixel.x + margin_);
        own[2] = codeOf(pixel.depth);
        const auto share = std::clamp<long>(std::lround(pixel.share * kShares), 1, kShares) - 1;
        own[0] = static_cast<std::uint8_t>(16 * share + std::max(own[0] % 16, int{pixel.isLast}));
        surfaces_.at<cv::Vec3b>(pixel.y, pixel.x + margin_) = cv::Vec3b(pixel.bgr);
    }
    // The border of a surface reaches into the px beside it.
    void addBorder(const LayeredPixel& pixel) {
        const int x = pixel.x + margin_ - (pixel.beside > 0 ? 1 : 0);
        std::uint8_t& mark = depth_.at<cv::Vec3b>(pixel.y, x)[0];
        const long end = 1 + std::lround(pixel.share * (kEnds - 1));
        mark = static_cast<std::uint8_t>(mark - mark % 16 + std::clamp<long>(end, 1, kEnds));
    }
    // Where the backgrounds of two surfaces overlap, the px belongs to the surface whose end is
    // nearer. Slivers, which occur at steps of depth, count as farther, so they do not reach far
    // behind others.
    void addHidden(const LayeredPixel& pixel) {
        constexpr int kSliver = 16; // px
        const int x = pixel.x + margin_;
        if (!holds(pixel.x)) return;
        const float distance = static_cast<float>(std::abs(pixel.beside)) /
                               static_cast<float>(std::min(pixel.width, kSliver));
        auto& least = distances_.at<float>(pixel.y, x);
        if (distance >= least) return;
        least = distance;
        depth_.at<cv::Vec3b>(pixel.y, x)[1] = codeOf(pixel.depth);
        sums_.at<cv::Vec4f>(pixel.y, x) = {static_cast<float>(pixel.bgr[0]),
                                           static_cast<float>(pixel.bgr[1]),
                                           static_cast<float>(pixel.bgr[2]), 1};
    }
    // Gives the background the colour of the px at the end of its surface, because colours are
    // interpolated from there.
    void joinToSurface(const LayeredPixel& pixel) {
        const int x = pixel.x - pixel.beside;
        if (x < 0 || !holds(x)) return;
        auto& sum = sums_.at<cv::Vec4f>(pixel.y, x + margin_);
        const auto own = surfaces_.at<cv::Vec3b>(pixel.y, x + margin_);
        if (sum[3] == 0) sum = {1.0F * own[0], 1.0F * own[1], 1.0F * own[2], 1};
    }

    int margin_;
    float low_ = 1;
    float high_ = 0;
    cv::Mat surfaces_;
    cv::Mat sums_;
    cv::Mat depth_; // blue: marks, green: background, red: surfaces
    cv::Mat distances_;
};

// A picture of a page: JPEG for colours, PNG for numbers.
using PagePicture = std::vector<unsigned char>;

std::string base64(const unsigned char* bytes, std::size_t count) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((count + 2) / 3 * 4);
    for (std::size_t i = 0; i < count; i += 3) {
        unsigned bits = 0;
        for (std::size_t k = i; k < i + 3; ++k)
            bits = bits << 8 | (k < count ? bytes[k] : 0U);
        for (int k = 3; k >= 0; --k)
            text += kDigits[bits >> (6 * k) & 63U];
    }
    for (std::size_t k = 0; k < (3 - count % 3) % 3; ++k)
        text[text.size() - 1 - k] = '=';
    return text;
}

// A source of a Content-Security-Policy that allows only a part with exactly these bytes.
std::string hashSource(const PagePart& part) {
    unsigned char digest[32];
    for (std::size_t i = 0; i < sizeof digest; ++i)
        std::from_chars(part.sha256 + 2 * i, part.sha256 + 2 * i + 2, digest[i], 16);
    return "'sha256-" + base64(digest, sizeof digest) + "'";
}

std::string escaped(std::string_view text) {
    constexpr std::string_view kMarks = "&<>\"";
    constexpr const char* kNames[] = {"&amp;", "&lt;", "&gt;", "&quot;"};
    std::string html;
    for (const char c : text) {
        const std::size_t mark = kMarks.find(c);
        if (mark != std::string_view::npos)
            html += kNames[mark];
        else if (static_cast<unsigned char>(c) >= ' ')
            html += c;
    }
    return html;
}

// With full chroma, as edges of depth are edges of colours. @param quality 1..100
PagePicture pageJpeg(const cv::Mat& picture, int quality) {
    PagePicture made = encodeJpeg(picture, true, quality);
    check(!made.empty(), "page", "no memory for a picture of " + sizeText(picture.size()));
    return made;
}

// The page of pictures; the first one is what browsers without WebGL show.
// @param scene what page.js needs
std::string writtenPage(const Json& scene, const std::vector<PagePicture>& pictures,
                        const PageText& text) {
    const std::string title = escaped(text.title.empty() ? "A picture in depth" : text.title);
    const double aspect = scene.at("aspect");
    constexpr double kRoom = 16384; // px, more than screens have
    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
        "script-src " +
        hashSource(kPageScript) + "; style-src " + hashSource(kPageStyle) +
        "; base-uri 'none'; form-action 'none'\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"generator\" content=\"altiro3D\">\n<title>" +
        title + "</title>\n<style>" + kPageStyle.text +
        "</style>\n</head>\n<body>\n<main data-scene=\"" + escaped(scene.dump()) +
        "\">\n<figure>\n<div id=\"stage\" tabindex=\"0\" role=\"group\" "
        "aria-label=\"The arrow keys move the view\">\n<img id=\"room\" alt=\"\" "
        "src=\"data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' width='" +
        numberText(kRoom * std::min(aspect, 1.0)) + "' height='" +
        numberText(kRoom * std::min(1 / aspect, 1.0)) + "'/%3E\">\n";
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const PagePicture& picture = pictures[i];
        const bool isPng = picture[0] != 0xff;
        page += i == 0 ? "<img id=\"picture\" alt=\"" + title + "\""
                       : std::string("<img alt=\"\" hidden");
        page += isPng ? " data-exact src=\"data:image/png" : " src=\"data:image/jpeg";
        page += ";base64," + base64(picture.data(), picture.size());
        page += "\">\n";
    }
    page += "<canvas id=\"view\" hidden></canvas>\n</div>\n<figcaption>\n<h1>" + title + "</h1>\n";
    if (!text.credit.empty()) page += "<p>" + escaped(text.credit) + "</p>\n";
    page +=
        "<div id=\"buttons\"></div>\n<p id=\"note\" role=\"status\" hidden></p>\n"
        "<noscript>This browser runs no scripts: this is the picture without depth.</noscript>\n"
        "</figcaption>\n</figure>\n</main>\n<script>";
    page += kPageScript.text;
    page += "</script>\n</body>\n</html>\n";
    return page;
}

} // namespace

std::string photoPage(const Scene& scene, const PlacementOptions& options, const PageText& text,
                      const std::optional<cv::Rect>& part, int side) try {
    const cv::Rect shown = part.value_or(cv::Rect({}, scene.photo.size()));
    check(!shown.empty() && (shown & cv::Rect({}, scene.photo.size())) == shown, "part",
          "is not inside the photo, expected a part of its px");
    checkRange("side", side, 16, kPageTextureSide, " px");
    const ViewOptions& views = options.views;
    checkRange("strength", views.strengthPercent, 0, kMostStrength, " % of the width for a page");
    // content moves by this part of the width at most
    const double most = views.strengthPercent / 200 * std::max(views.focus, 1 - views.focus);
    constexpr int kSpare = 4; // px, for ends of surfaces
    const double scale =
        std::min({1.0, static_cast<double>(side) / std::max(shown.width, shown.height),
                  (kPageTextureSide - 2.0 * kSpare - 2) / (shown.width * (1 + 2 * most))});
    PhotoFit fit;
    fit.size = {std::max(1, cvRound(shown.width * scale)),
                std::max(1, cvRound(shown.height * scale))};
    fit.source = shown;
    fit.target = {{}, fit.size};
    Scene fitted;
    fitScene(withDepthCurve(scene, options.depthCurve), fit, views.focus, fitted, options.refine);
    LayeredSettings settings{views.layered};
    settings.hidden = fitted.hidden;
    settings.mixedPixels = fitted.mixedPixels;
    settings.reachPixels = views.strengthPercent / 200 * fit.size.width;
    const int margin = static_cast<int>(std::ceil(most * fit.size.width)) + kSpare;
    const PhotoLayers layers(
        fitted.photo, layeredPixels(fitted.photo, fitted.depth, views.focus, settings), margin);
    constexpr int kSpareSteps = 8;
    const double tear = settings.reachPixels > 0 ? settings.tearStep() : 1;
    const Json description = {{"kind", "photo"},
                              {"width", fit.size.width},
                              {"height", fit.size.height},
                              {"aspect", 1.0 * fit.size.width / fit.size.height},
                              {"margin", margin},
                              {"reach", settings.reachPixels},
                              {"low", layers.low() - views.focus},
                              {"level", layers.level()},
                              {"tear", tear + static_cast<double>(layers.level())},
                              {"block", kBlock},
                              {"steps", static_cast<int>(settings.reachPixels) + kSpareSteps},
                              {"perMetre", positionsPerMetre(views.strengthPercent)}};
    return writtenPage(description,
                       {pageJpeg(layers.surfaces(), kPhotoQuality),
                        pageJpeg(layers.background(), kBackgroundQuality),
                        encodePng(layers.depth()), encodePng(layers.range())},
                       text);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

std::string quiltPage(const cv::Mat& quilt, const QuiltLayout& layout, double aspect,
                      const PageText& text, int side) try {
    validate(layout);
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    checkSize(quilt.size(), layout.size(), "quilt");
    checkRange("aspect", aspect, 0.01, 100);
    checkRange("side", side, 16, kPageTextureSide, " px");
    check(layout.viewCount >= 2, "quilt", "has one view, expected two or more for a page");
    constexpr int kSheets = 4;
    // as many views of this size as the sheets hold, in px as they are shown
    const auto perSheet = [](cv::Size size) {
        return (kPageTextureSide / size.width) * (kPageTextureSide / size.height);
    };
    const double longer = std::min(side, std::max(layout.tileSize.width, layout.tileSize.height));
    cv::Size size;
    for (double length = longer; size.empty() || perSheet(size) * kSheets < layout.viewCount;
         length *= 0.98)
        size = {std::max(1, cvRound(aspect >= 1 ? length : length * aspect)),
                std::max(1, cvRound(aspect >= 1 ? length / aspect : length))};
    const int columns = std::min(kPageTextureSide / size.width, layout.viewCount);
    const int rows =
        std::min(kPageTextureSide / size.height, (layout.viewCount + columns - 1) / columns);
    std::vector<PagePicture> sheets;
    for (int first = 0; first < layout.viewCount; first += columns * rows) {
        cv::Mat sheet(rows * size.height, columns * size.width, CV_8UC3, cv::Scalar::all(0));
        for (int i = 0; i < std::min(columns * rows, layout.viewCount - first); ++i)
            cv::resize(quilt(layout.tile(first + i)),
                       sheet(cv::Rect({i % columns * size.width, i / columns * size.height}, size)),
                       size, 0, 0, cv::INTER_AREA);
        sheets.push_back(pageJpeg(sheet, kViewsQuality));
    }
    constexpr double kUsualStrength = 10;
    const Json description = {
        {"kind", "views"},           {"width", size.width},
        {"height", size.height},     {"aspect", aspect},
        {"columns", columns},        {"rows", rows},
        {"views", layout.viewCount}, {"perMetre", positionsPerMetre(kUsualStrength)}};
    return writtenPage(description, sheets, text);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

bool isPageFileName(const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    return extension == ".html" || extension == ".htm";
}

} // namespace altiro3D
