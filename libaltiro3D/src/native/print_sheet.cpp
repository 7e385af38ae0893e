#include "altiro3D/print_sheet.hpp"

#include "altiro3D/lens_sheet.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/system_process.hpp"
#include "image/row_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr double kMmPerInch = 25.4;
constexpr int kMiddleBand = (kPitchBands - 1) / 2;
constexpr int kRowsAtATime = 256; // for sheets without a Native

// Places and sizes of marks, mm. The strips end before the crop marks.
constexpr double kMargin = 10;
constexpr double kStripAt = 2; // from the edge of the sheet
constexpr double kStripWidth = 5;
constexpr double kStripShorter = 5; // than the picture, at each end
constexpr double kCropAt = 1;       // from the edge of the sheet
constexpr double kCropLength = 6;
constexpr double kCropWidth = 0.2;
constexpr double kTextLine = 6; // below the other marks
constexpr double kTextHeight = 2.5;
constexpr std::size_t kMostText = 80; // characters of the caller's text

// Lens periods at a px of a print, not modulo 1: (1.4) without stripes.
class LensPlaces {
  public:
    explicit LensPlaces(const Calibration& c) {
        const LensGeometry g = lensGeometry(c);
        across_ = g.periodsPerWidth / g.panelWidth;
        up_ = g.tilt * g.periodsPerWidth / g.panelHeight;
        bottom_ = g.panelHeight;
        center_ = g.center;
    }
    double at(int x, int y) const {
        return across_ * (x + 0.5) + up_ * (bottom_ - y - 0.5) - center_;
    }
    double across() const { return across_; }
    double up() const { return up_; }

  private:
    double across_;
    double up_;
    double bottom_;
    double center_;
};

void requirePrint(const Calibration& c) {
    check(c.sheet && c.sheet->isPrint, "calibration",
          "is that of a display, expected that of a print");
}

cv::Size2d dpiOf(const Calibration& c) {
    return {c.DPI, c.sheet->dpiDown};
}

// Px of a print.
class Millimetres {
  public:
    explicit Millimetres(cv::Size2d dpi) : dpi_(dpi) {}
    int across(double mm) const {
        return static_cast<int>(std::lround(mm * dpi_.width / kMmPerInch));
    }
    int down(double mm) const {
        return static_cast<int>(std::lround(mm * dpi_.height / kMmPerInch));
    }
    cv::Rect rect(double x, double y, double width, double height) const {
        return {across(x), down(y), across(width), down(height)};
    }

  private:
    cv::Size2d dpi_;
};

// Black on white. @param height of capitals, mm
cv::Mat textPicture(const std::string& text, double height, cv::Size2d dpi, int type) {
    const auto px = height * dpi.height / kMmPerInch;
    const double scale = std::max(0.3, px / 21); // capitals of this font have 21 px
    const int thickness = std::max(1, static_cast<int>(px / 8));
    int below = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, thickness, &below);
    cv::Mat picture(size.height + below + 2 * thickness, size.width + 2 * thickness, type,
                    cv::Scalar::all(255));
    cv::putText(picture, text, {thickness, size.height + thickness}, cv::FONT_HERSHEY_SIMPLEX,
                scale, cv::Scalar::all(0), thickness, cv::LINE_AA);
    if (dpi.width == dpi.height) return picture;
    const double narrower = std::max(dpi.width / dpi.height, 1.0 / picture.cols); // 1 px at least
    cv::resize(picture, picture, {}, narrower, 1, cv::INTER_AREA);
    return picture;
}

// Calls draw(part of `rows`, its top left corner in the sheet) for the part inside a rectangle.
template <class Draw>
void inside(const cv::Rect& rectangle, cv::Mat& rows, int first, const Draw& draw) {
    const cv::Rect part = rectangle & cv::Rect(0, first, rows.cols, rows.rows);
    if (part.area() == 0) return;
    cv::Mat to = rows(part - cv::Point(0, first));
    draw(to, part.tl());
}

void fillBlack(const cv::Rect& rectangle, cv::Mat& rows, int first) {
    inside(rectangle, rows, first,
           [](cv::Mat& part, cv::Point /*at*/) { part.setTo(cv::Scalar::all(0)); });
}

void put(const cv::Mat& picture, cv::Point at, cv::Mat& rows, int first) {
    inside({at, picture.size()}, rows, first, [&](cv::Mat& part, cv::Point corner) {
        picture(cv::Rect(corner - at, part.size())).copyTo(part);
    });
}

// Fills a part of a sheet with isBlack(x, y) in px of the sheet.
template <class IsBlack>
void drawLines(const cv::Rect& rectangle, cv::Mat& rows, int first, const IsBlack& isBlack) {
    inside(rectangle, rows, first, [&](cv::Mat& part, cv::Point at) {
        const int channels = part.channels();
        overRows(part.rows, [&](int y) {
            auto* to = part.ptr<std::uint8_t>(y);
            for (int x = 0; x < part.cols; ++x, to += channels)
                std::fill_n(to, channels, isBlack(at.x + x, at.y + y) ? 0 : 255);
        });
    });
}

// The pitches of a pitch sheet, LPI.
struct Pitches {
    double middle;
    double step;
};

Pitches pitchesOf(const LensFacts& facts, const PitchSheetOptions& options) {
    const double usual = facts.lpi * (options.around != 0 ? 0.000125 : 0.00125);
    const Pitches pitches{options.around != 0 ? options.around : facts.lpi,
                          options.step != 0 ? options.step : usual};
    const double highest = facts.lpi * facts.usefulViews / 2;
    const double reach = kMiddleBand * pitches.step;
    checkNumber(pitches.step > 0, "step", pitches.step, "LPI, above 0");
    checkNumber(pitches.middle - reach > 0 && pitches.middle + reach <= highest, "around",
                pitches.middle,
                "bands above 0 and up to " + numberText(highest) + " LPI, half of the dpi");
    return pitches;
}

std::string today() {
    const std::tm local = localTime(std::time(nullptr));
    char text[16];
    return {text, std::strftime(text, sizeof text, "%Y-%m-%d", &local)};
}

std::string numbersText(const Calibration& c) {
    const LensFacts facts = lensFacts(c);
    const double down = c.sheet->dpiDown;
    return numberText(facts.lpi, 7) + " LPI, " + numberText(c.DPI) +
           (down == c.DPI ? "" : " x " + numberText(down)) + " dpi";
}

} // namespace

PrintSheet::PrintSheet(const Display& print, PrintOptions options)
    : display_(print), options_(std::move(options)) {
    Calibration& c = display_.calibration;
    requirePrint(c);
    check(lensFacts(c).usefulViews >= 2, "calibration",
          "has fewer than two px under a lens, expected a smaller pitch or more dpi");
    checkRange("bleed", options_.bleed, 0, 50, " mm");
    check(options_.text.size() <= kMostText &&
              std::all_of(options_.text.begin(), options_.text.end(),
                          [](char one) { return one >= ' ' && one <= '~'; }),
          "text",
          "is too long or has other characters than those of ASCII, expected at most " +
              std::to_string(kMostText));
    const Millimetres px(dpiOf(c));
    bleed_ = {px.across(options_.bleed), px.down(options_.bleed)};
    // the lenses stay where they are
    const LensPlaces lens(c);
    const double center = c.center + lens.across() * bleed_.width + lens.up() * bleed_.height;
    c.center = center - std::floor(center);
    c.screenW += 2 * bleed_.width;
    c.screenH += 2 * bleed_.height;
    validate(c, "print with its bleed");
    display_.quilt = defaultQuilt(c);

    const cv::Size margin = options_.hasMarks ? px.rect(0, 0, kMargin, kMargin).size() : cv::Size();
    const int textRows = options_.hasMarks ? px.down(kTextLine) : 0;
    inSheet_ = {cv::Point(margin), display_.panelSize()};
    sheet_ = inSheet_.size() + margin + margin + cv::Size(0, textRows);
    if (!options_.hasMarks) return;
    const LensFacts facts = lensFacts(print.calibration);
    const std::string text = numbersText(c) + ", " +
                             numberText(std::round(10 * facts.width) / 10, 5) + " x " +
                             numberText(std::round(10 * facts.height) / 10, 5) + " mm, " + today() +
                             (options_.text.empty() ? "" : ", " + options_.text);
    line_ = textPicture(text, kTextHeight, dpiOf(c), CV_8UC3);
    const double room = sheet_.width - picture().x; // too little for the text on small prints
    if (line_.cols > room)
        line_ = textPicture(text, kTextHeight * 0.95 * room / line_.cols, dpiOf(c), CV_8UC3);
}

cv::Size PrintSheet::size() const {
    return sheet_;
}

cv::Rect PrintSheet::picture() const {
    return {inSheet_.tl() + cv::Point(bleed_), inSheet_.size() - bleed_ - bleed_};
}

bool PrintSheet::canWrite(const fs::path& file) {
    return RowFile::canWrite(file);
}

void PrintSheet::drawMarks(cv::Mat& rows, int first) const {
    if (!options_.hasMarks) return;
    const Calibration& c = display_.calibration;
    const Millimetres px(dpiOf(c));
    const cv::Rect cut = picture();
    const cv::Point end(cut.br());
    const int marksEnd = inSheet_.br().y + px.down(kMargin); // the text is below
    const int lineWidth = std::max(1, px.across(kCropWidth));
    const int lineHeight = std::max(1, px.down(kCropWidth));
    const int right = sheet_.width - px.across(kCropAt + kCropLength);
    const int below = marksEnd - px.down(kCropAt + kCropLength);
    for (const int x : {cut.x - lineWidth / 2, end.x - lineWidth / 2}) {
        for (const int y : {px.down(kCropAt), below})
            fillBlack({x, y, lineWidth, px.down(kCropLength)}, rows, first);
    }
    for (const int y : {cut.y - lineHeight / 2, end.y - lineHeight / 2}) {
        for (const int x : {px.across(kCropAt), right})
            fillBlack({x, y, px.across(kCropLength), lineHeight}, rows, first);
    }

    const LensPlaces lens(c);
    const auto isBlack = [&](int x, int y) {
        const double pairs = lens.at(x - inSheet_.x, y - inSheet_.y) / 2;
        return std::fmod(std::floor(pairs), 2) != 0; // two lenses black, two white
    };
    cv::Rect strip;
    cv::Rect other;
    if (lensGeometry(c).isLying()) {
        const int shorter = px.across(kStripShorter);
        strip = {cut.x + shorter, px.down(kStripAt), cut.width - 2 * shorter, px.down(kStripWidth)};
        other = strip;
        other.y = marksEnd - px.down(kStripAt + kStripWidth);
    } else {
        const int shorter = px.down(kStripShorter);
        strip = {px.across(kStripAt), cut.y + shorter, px.across(kStripWidth),
                 cut.height - 2 * shorter};
        other = strip;
        other.x = sheet_.width - px.across(kStripAt + kStripWidth);
    }
    for (const cv::Rect& one : {strip, other}) {
        if (one.width > 0 && one.height > 0) drawLines(one, rows, first, isBlack);
    }
    put(line_, {cut.x, marksEnd}, rows, first);
}

void PrintSheet::write(const fs::path& file,
                       const std::function<void(const RowSink&)>& native) const try {
    checkFunction(native, "native");
    RowFile out(file, sheet_, CV_8UC3, dpiOf(display_.calibration), ImageMark::Native);
    cv::Mat band;
    int done = 0;
    const auto writeRows = [&](int count, const cv::Mat& picture) {
        band.create(count, sheet_.width, CV_8UC3);
        band.setTo(cv::Scalar::all(255));
        if (!picture.empty()) picture.copyTo(band.colRange(inSheet_.x, inSheet_.x + picture.cols));
        drawMarks(band, done);
        out.write(band);
        done += count;
    };
    const auto writeMargin = [&](int end) {
        while (done < end)
            writeRows(std::min(kRowsAtATime, end - done), {});
    };
    writeMargin(inSheet_.y);
    native([&](const cv::Mat& rows) {
        checkType(rows, {CV_8UC3}, "native", "CV_8UC3 (8-bit BGR)");
        checkSize(rows.size(), {inSheet_.width, rows.rows}, "native");
        writeRows(rows.rows, rows);
    });
    checkSize({inSheet_.width, done - inSheet_.y}, inSheet_.size(), "native");
    writeMargin(sheet_.height);
    out.finish();
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

double pitchSheetReach(const Calibration& print, const PitchSheetOptions& options) {
    validate(print);
    requirePrint(print);
    const LensFacts facts = lensFacts(print);
    const double across = lensGeometry(print).isLying() ? facts.height : facts.width;
    return kMiddleBand * pitchesOf(facts, options).step * across / kMmPerInch;
}

void writePitchSheet(const fs::path& file, const Calibration& print,
                     const PitchSheetOptions& options) try {
    validate(print);
    requirePrint(print);
    const LensFacts facts = lensFacts(print);
    const auto [middle, step] = pitchesOf(facts, options);
    const cv::Size size(print.screenW, print.screenH);
    const Millimetres px(dpiOf(print));
    const bool isLying = lensGeometry(print).isLying();
    const LensPlaces lens(print);
    // bands follow each other down; with horizontal lenses, to the right
    const int length = (isLying ? size.width : size.height) - (isLying ? 0 : px.down(kTextLine));
    struct Band {
        cv::Rect lines;
        cv::Mat label;
        cv::Point labelAt;
        double scale; // scale of places
    };
    std::vector<Band> bands;
    for (int i = 0; i < kPitchBands; ++i) {
        const double lpi = middle + (i - kMiddleBand) * step;
        const int from = static_cast<int>(std::int64_t{length} * i / kPitchBands);
        const int to = static_cast<int>(std::int64_t{length} * (i + 1) / kPitchBands);
        const double band = (to - from) * kMmPerInch / (isLying ? print.DPI : print.sheet->dpiDown);
        const double room = std::min(4.0, 0.45 * band); // room for the label, mm
        cv::Mat label = textPicture(numberText(lpi, 7) + " LPI", 0.5 * room, dpiOf(print), CV_8UC1);
        if (isLying) {
            label = textPicture(numberText(lpi, 7) + " LPI", 0.5 * room,
                                {print.sheet->dpiDown, print.DPI}, CV_8UC1);
            cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
            const int wide = px.across(room);
            bands.push_back({{from + wide, 0, to - from - wide, size.height - px.down(kTextLine)},
                             label,
                             {from + std::max(0, (wide - label.cols) / 2), px.down(2)},
                             lpi / facts.lpi});
        } else {
            const int high = px.down(room);
            bands.push_back({{0, from + high, size.width, to - from - high},
                             label,
                             {px.across(2), from + std::max(0, (high - label.rows) / 2)},
                             lpi / facts.lpi});
        }
    }
    const cv::Mat line =
        textPicture("Pitch sheet, " + numbersText(print) + ", " + today() + ": print it at 100 %",
                    std::min(kTextHeight, facts.width / 60), dpiOf(print), CV_8UC1);

    RowFile out(file, size, CV_8UC1, dpiOf(print));
    cv::Mat rows;
    for (int first = 0; first < size.height; first += kRowsAtATime) {
        rows.create(std::min(kRowsAtATime, size.height - first), size.width, CV_8UC1);
        rows.setTo(255);
        for (const Band& band : bands) {
            drawLines(band.lines, rows, first, [&](int x, int y) {
                const double place = lens.at(x, y) * band.scale;
                return place - std::floor(place) < 0.5;
            });
            put(band.label, band.labelAt, rows, first);
        }
        put(line, {px.across(2), size.height - px.down(kTextLine - 2)}, rows, first);
        out.write(rows);
    }
    out.finish();
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
