#include "cli/views_folder.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/view_options.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <regex>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr int kLookSide = 256; // px of the pictures that are compared
constexpr int kAround = 900;   // a number that falls by more starts again, as 0001 after 9999

// A file name: its text with '#' for each number, and the numbers.
struct NumberedName {
    std::string text;
    std::vector<std::int64_t> numbers;
};

NumberedName numberedName(const fs::path& file) {
    constexpr std::int64_t kLargest = 1'000'000'000'000'000; // longer numbers are cut
    NumberedName name;
    bool inNumber = false;
    for (const char c : lowerCase(file.filename().string())) {
        const bool isDigit = c >= '0' && c <= '9';
        if (isDigit && !inNumber) {
            name.text += '#';
            name.numbers.push_back(0);
        }
        if (!isDigit) {
            name.text += c;
        } else if (std::int64_t& number = name.numbers.back(); number < kLargest) {
            number = 10 * number + (c - '0');
        }
        inNumber = isDigit;
    }
    return name;
}

// When a photo was taken: the earliest time in its head (EXIF); empty: unknown.
std::string timeOf(const fs::path& file) {
    std::string head(std::size_t{1} << 16, '\0');
    std::ifstream(file, std::ios::binary).read(head.data(), static_cast<int>(head.size()));
    static const std::regex time("(19|20)\\d\\d:[01]\\d:[0-3]\\d [0-2]\\d:[0-5]\\d:[0-6]\\d");
    std::string earliest;
    for (std::sregex_iterator it(head.begin(), head.end(), time), end; it != end; ++it)
        if (earliest.empty() || it->str() < earliest) earliest = it->str();
    return earliest;
}

// Finds the first picture of a row among pictures in the order of their names: a camera counts on
// with IMG_0001 after IMG_9999.
std::size_t beginningOf(const std::vector<fs::path>& files) {
    const std::size_t length = files.front().stem().string().size();
    const std::size_t head = files.front().stem().string().find_last_not_of("0123456789") + 1;
    const double all = std::pow(10, length - head);
    if (all <= kAround || all > 1e9) return 0;
    std::size_t beginning = 0;
    for (std::size_t i = 1; i < files.size(); ++i) {
        const std::string before = files[i - 1].stem().string();
        const std::string name = files[i].stem().string();
        if (name.size() != length || name.compare(0, head, before, 0, head) != 0 ||
            name.find_first_not_of("0123456789", head) != std::string::npos ||
            files[i].extension() != files[0].extension())
            return 0;
        if (std::stod(name.substr(head)) - std::stod(before.substr(head)) > 0.9 * all)
            beginning = i;
    }
    if (beginning == 0) return 0;
    const std::string first = timeOf(files.front());
    return first.empty() || timeOf(files.back()) <= first ? beginning : 0;
}

// Why the numbers in the names do not count views in equal steps; empty if they do.
std::string reasonByNames(const std::vector<fs::path>& files) {
    const NumberedName first = numberedName(files.front());
    std::optional<std::size_t> place; // of the number that counts
    std::int64_t step = 0;
    NumberedName before = first;
    for (std::size_t i = 1; i < files.size(); ++i) {
        const NumberedName name = numberedName(files[i]);
        const std::string file = files[i].filename().string();
        if (name.text != first.text) {
            return "holds " + files.front().filename().string() + " and " + file +
                   ", which are not numbered as one sequence";
        }
        for (std::size_t j = 0; j < name.numbers.size(); ++j) {
            const std::int64_t here = name.numbers[j] - before.numbers[j];
            if (here == 0 || here < -kAround) continue;
            if (place && *place != j)
                return "holds names with two numbers that count, such as " + file +
                       ", as of rows and columns of cameras";
            if (place && here != step)
                return "misses numbers between " + files[i - 1].filename().string() + " and " +
                       file;
            place = j;
            step = here;
        }
        before = name;
    }
    return {};
}

struct Look {
    cv::Size size;
    cv::Mat colours; // kLookSide
    cv::Mat grey;    // the same, CV_32F
};

Look lookAt(const fs::path& file) {
    Look look;
    const cv::Mat picture = readPhoto(file);
    look.size = picture.size();
    cv::resize(picture, look.colours, {kLookSide, kLookSide}, 0, 0, cv::INTER_AREA);
    cv::cvtColor(look.colours, look.grey, cv::COLOR_BGR2GRAY);
    look.grey.convertTo(look.grey, CV_32F);
    return look;
}

// Movements of the whole picture between neighbours, as far as they can be told.
class CameraPath {
  public:
    void add(const Look& from, const Look& to) {
        constexpr double kClear = 0.2; // height of the correlation's peak
        if (window_.empty()) cv::createHanningWindow(window_, from.grey.size(), CV_32F);
        double peak = 0;
        const cv::Point2d move = cv::phaseCorrelate(from.grey, to.grey, window_, &peak);
        if (!(peak >= kClear) || !std::isfinite(move.x) || !std::isfinite(move.y)) return;
        if (std::max(std::abs(move.x), std::abs(move.y)) > kLookSide / 8.0) return;
        sum_ += move;
        lengths_ += std::hypot(move.x, move.y);
        ++count_;
    }

    std::string problem() const {
        constexpr double kStill = 0.25; // px of a picture of kLookSide per step
        constexpr double kSteady = 0.6; // of all movements in one direction
        if (count_ < 2 || lengths_ < kStill * count_) return {};
        if (std::hypot(sum_.x, sum_.y) < kSteady * lengths_)
            return "holds pictures of a camera that moves to and fro";
        if (std::abs(sum_.y) > std::abs(sum_.x))
            return "holds pictures of a camera that moves up or down";
        return {};
    }

  private:
    cv::Mat window_;
    cv::Point2d sum_;
    double lengths_ = 0;
    int count_ = 0;
};

std::string reasonByContents(const std::vector<fs::path>& files) {
    constexpr std::size_t kMostPairs = 6;
    const std::size_t pairs = std::min(kMostPairs, files.size() - 1);
    CameraPath path;
    cv::Size size;
    for (std::size_t i = 0; i < pairs; ++i) {
        const std::size_t at = i * (files.size() - 2) / std::max<std::size_t>(1, pairs - 1);
        const Look from = lookAt(files[at]);
        const Look to = lookAt(files[at + 1]);
        if (i == 0) size = from.size;
        if (from.size != size || to.size != size) return "holds pictures of different sizes";
        if (likenessOfViews({from.colours, to.colours}) < kMinLikenessOfViews)
            return "holds pictures that do not resemble each other";
        path.add(from, to);
    }
    return path.problem();
}

// The picture nearest to a view's camera position among `pictures` evenly spaced ones.
std::size_t pictureOfView(int view, int views, std::size_t pictures) {
    const double place = (viewPosition(view, views) + 1) / 2 * static_cast<double>(pictures - 1);
    return static_cast<std::size_t>(std::lround(place));
}

// How much of a picture a view shows, 0..1.
double shareOf(std::size_t picture, int view, int views, std::size_t pictures,
               std::optional<FlipKind> flip) {
    if (!flip) return pictureOfView(view, views, pictures) == picture ? 1 : 0;
    constexpr double kSoft = 0.5; // of the views are between two pictures
    const auto count = static_cast<double>(pictures);
    // whole in the middle of a picture's part
    const double place = std::clamp((view + 0.5) / views * count - 0.5, 0.0, count - 1);
    const double off = place - static_cast<double>(picture);
    if (*flip == FlipKind::Hard) return off > -0.5 && off <= 0.5 ? 1 : 0;
    return std::clamp((0.5 - std::abs(off)) / kSoft + 0.5, 0.0, 1.0);
}

} // namespace

std::vector<fs::path> listViews(const fs::path& directory, Notes* notes) {
    std::vector<fs::path> files = listImages(directory);
    if (files.empty())
        throw Error(ErrorCode::NotFound, directory.string(),
                    "holds no pictures, expected one file for each view");
    const std::size_t beginning = beginningOf(files);
    if (beginning == 0) return files;
    notes->push_back({NoteCode::Converted, "the first picture is " +
                                               files[beginning].filename().string() +
                                               ", as the camera's numbers begin again after " +
                                               files.back().filename().string()});
    std::rotate(files.begin(), files.begin() + static_cast<std::ptrdiff_t>(beginning), files.end());
    return files;
}

std::string reasonAgainstViews(const std::vector<fs::path>& files, std::size_t fewest) {
    if (files.size() < std::max<std::size_t>(2, fewest))
        return "holds " + counted(files.size(), "picture");
    if (std::string reason = reasonByNames(files); !reason.empty()) return reason;
    const QuietStandardError quiet; // decoders print messages
    try {
        return reasonByContents(files);
    } catch (const Error& error) {
        return std::string("holds pictures that cannot be read: ") + error.what();
    }
}

ViewsQuilt quiltOfViews(const std::vector<fs::path>& files, const QuiltLayout& layout,
                        double aspect, FitMode mode, Messages& messages,
                        const std::function<void(const fs::path&)>& atFile,
                        std::optional<FlipKind> flip) {
    if (flip && files.size() > static_cast<std::size_t>(layout.viewCount)) {
        throw Error(ErrorCode::Mismatch, "--flip",
                    "has " + counted(files.size(), "picture") + " for " +
                        counted(layout.viewCount, "view") + ", expected at most a view for each");
    }
    if (!flip && files.size() != static_cast<std::size_t>(layout.viewCount)) {
        messages.warn("there are " + counted(files.size(), "picture") + " for " +
                      counted(layout.viewCount, "view") +
                      ": each view takes the picture nearest to it");
    }
    ViewsQuilt result;
    result.quilt = cv::Mat(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (const fs::path& file : files)
        refuseNative(file, "views of one scene, a file for each");
    cv::Size& viewSize = result.viewSize;
    for (std::size_t picture = 0; picture < files.size(); ++picture) {
        cv::Mat view; // read for its first tile; not read without any
        cv::Mat fitted;
        atFile(files[picture]);
        for (int i = 0; i < layout.viewCount; ++i) {
            const double share = shareOf(picture, i, layout.viewCount, files.size(), flip);
            if (share == 0) continue;
            if (view.empty()) {
                view = readPhotoFile(files[picture], messages);
                if (viewSize.area() == 0) viewSize = view.size();
                if (flip) viewSize = view.size();
                if (view.size() != viewSize) {
                    throw Error(ErrorCode::Mismatch, files[picture].string(),
                                "has " + sizeText(view.size()) + ", expected " +
                                    sizeText(viewSize) + " like the views before it");
                }
                applyFit(view, fitPhoto(viewSize, aspect, layout.tileSize, mode), fitted);
            }
            cv::Mat tile = result.quilt(layout.tile(i));
            if (share == 1) {
                fitted.copyTo(tile);
            } else {
                cv::scaleAdd(fitted, share, tile, tile); // the other one adds the rest
            }
        }
    }
    return result;
}

SlidePictureSource slideOf(const std::vector<fs::path>& inputs, std::vector<fs::path>& files,
                           Notes* notes) {
    const fs::path& first = inputs.front();
    files = inputs;
    if (inputs.size() == 1) {
        requireFile(first);
        if (isDirectory(first))
            files = listViews(first, notes);
        else if (!canWriteImage(first))
            return slideVideo(first, notes);
    }
    return slidePhotos(files, notes);
}

SlideOptions slideOptionsFor(const QuiltLayout& layout, double aspect, FitMode mode,
                             const SlideOptions& options) {
    SlideOptions result = options;
    const cv::Size tile = layout.tileSize;
    if (mode == FitMode::Cover) result.aspect = aspect;
    result.longestSide = std::clamp(std::max(tile.width, tile.height), 16, 16384);
    result.mostParallax = kParallaxBudgetPixels * (layout.viewCount - 1) / tile.width;
    return result;
}

cv::Mat quiltOfSlide(CameraSlide& slide, const QuiltLayout& layout, double aspect, FitMode mode,
                     const std::function<void(int, const cv::Mat&)>& atView) {
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    const PhotoFit fit = fitPhoto(slide.viewSize(), aspect, layout.tileSize, mode);
    slide.makeViews(layout.viewCount, [&](int view, const cv::Mat& picture) {
        if (atView) atView(view, picture);
        cv::Mat fitted;
        applyFit(picture, fit, fitted);
        fitted.copyTo(quilt(layout.tile(view)));
    });
    return quilt;
}

} // namespace altiro3D::tools
