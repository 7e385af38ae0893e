#include "altiro3D/camera_slide.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/system_file.hpp"
#include "base/text.hpp"
#include "depth/stereo/stereo_parts.hpp"
#include "image/pixel_values.hpp"
#include "slide/slide_checks.hpp"
#include "slide/slide_path.hpp"
#include "slide/slide_strangers.hpp"
#include "slide/slide_tracks.hpp"
#include "slide/slide_views.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <set>

namespace altiro3D {

namespace {

constexpr int kMostChosen = 80; // pictures whose cameras are found
constexpr double kTold = 0.05;  // share of the path; larger distances from a line are reported

// A picture of a stretch of the path.
struct Stop {
    int number = 0; // in the clip
    SlideCamera camera;
    double gain = 1;

    double position() const { return camera.place[0]; }
};

} // namespace

void validate(const SlideOptions& options) {
    if (options.focus) checkRange("focus", *options.focus, 0, 1);
    if (options.aspect != 0) checkRange("aspect", options.aspect, 0.01, 100);
    checkRange("longestSide", options.longestSide, 16, 16384, " px");
    checkRange("mostParallax", options.mostParallax, 0, 1e6);
    if (options.viewDegrees != 0) checkRange("viewDegrees", options.viewDegrees, 1, 150);
}

SlidePictureSource slideVideo(std::filesystem::path file, Notes* notes) {
    std::shared_ptr<FileHandle> copy; // copy of a pipe, as pictures are read more than once
    std::error_code error;
    if (std::filesystem::is_fifo(file, error)) {
        constexpr std::uintmax_t kMost = std::uintmax_t{1} << 36;
        copy = std::make_shared<FileHandle>(
            unnamedCopy(openFile(file, OpenFor::Reading), file, kMost));
        file = nameOf(*copy);
    }
    return [file = std::move(file), copy, notes](const std::function<bool(const cv::Mat&)>& take) {
        VideoReader reader(file);
        VideoFrame frame;
        while (reader.read(frame)) {
            const double aspect = frame.sampleAspect.isKnown() ? frame.sampleAspect.value() : 1;
            if (std::abs(aspect - 1) > 1e-3)
                cv::resize(frame.picture, frame.picture, {}, aspect, 1, cv::INTER_AREA);
            if (!take(frame.picture)) break;
        }
        addNotes(notes, reader.notes());
    };
}

SlidePictureSource slidePhotos(std::vector<std::filesystem::path> files, Notes* notes) {
    return [files = std::move(files), notes](const std::function<bool(const cv::Mat&)>& take) {
        cv::Size first;
        for (const std::filesystem::path& file : files) {
            const cv::Mat photo = withNamedNotes(
                file, notes, [&](Notes* own) { return readPhoto(PhotoFile(file), own); });
            if (first.empty()) first = photo.size();
            checkSize(photo.size(), first, file.string(), "like the first photo ");
            if (!take(photo)) break;
        }
    };
}

std::vector<std::string> SlideReport::lines() const {
    return {"path: parallax " + fixed(parallaxPercent, 1) + " % of the width" +
                (fromRight ? ", from right to left" : ", from left to right") + ", up to " +
                fixed(awayPercent, 1) + " % of the path off a straight line, turned up to " +
                fixed(turnDegrees, 1) + "°",
            "pictures: " + std::to_string(used) + " of " + std::to_string(pictures) + " used, " +
                fixed(stretchPercent, 0) + " % of the way of the camera",
            "residual: " + fixed(verticalPixels, 2) + " px down, " + fixed(horizontalPixels, 2) +
                " px across in the worst picture; " + fixed(misfitPercent, 0) +
                " % of the corners do not fit",
            "speed: the largest step is " + fixed(speedRatio, 1) + " times the median",
            "focus: depth " + fixed(focus, 2) + " (0 = farthest, 1 = nearest)"};
}

struct CameraSlide::Impl {
    SlidePictureSource source;
    SlideOptions options;
    std::string name;
    SlideReport report;
    Notes notes;
    double aspect = 1; // height : width of the pictures
    SlideLens lens;
    std::vector<Stop> stops; // in the order of time
    SlideWindow window;
    double low = 0; // inverse depths of the scene
    double high = 0;
    double from = 0; // positions of the outermost views
    double to = 1;

    [[noreturn]] void refuse(const std::string& problem) const {
        throw Error(ErrorCode::BadFormat, name, problem);
    }

    // Reads and measures.
    void find();
    void findStretch(const std::vector<SlidePicture>& pictures,
                     const std::vector<std::size_t>& chosen, const SlideTracks& corners,
                     const SlidePath& path);
    double frontShareOf(const std::vector<SlidePicture>& pictures) const;
    void chooseWindow(double pictureWidth);
    SlideWindow windowOf(double share, double pictureWidth) const;

    std::size_t nearestTo(double position) const; // index of the nearest stop
    // Gives the frames of the stops with these indices to a function.
    void readStops(const std::set<std::size_t>& wanted,
                   const std::function<void(std::size_t, SlideFrame)>& take) const;
    SlideFrame frameOf(const cv::Mat& picture, const Stop& stop) const;
};

double CameraSlide::Impl::frontShareOf(const std::vector<SlidePicture>& pictures) const {
    const auto frameAt = [&](double share) {
        const Stop& stop = stops[nearestTo(from + share * (to - from))];
        const auto isIt = [&](const SlidePicture& one) { return one.number == stop.number; };
        SlideFrame frame;
        cv::cvtColor(std::find_if(pictures.begin(), pictures.end(), isIt)->grey, frame.picture,
                     cv::COLOR_GRAY2BGR);
        frame.picture.convertTo(frame.picture, -1, 1 / stop.gain);
        frame.camera = stop.camera;
        frame.aspect = aspect;
        return frame;
    };
    std::vector<std::pair<SlideFrame, SlideFrame>> pairs;
    for (const double share : {0.05, 0.3, 0.55})
        pairs.emplace_back(frameAt(share), frameAt(share + 0.4));
    return frontShare(pairs, lens, window, low, high);
}

void CameraSlide::Impl::find() {
    using Clock = std::chrono::steady_clock;
    auto begin = Clock::now();
    const auto lap = [&](int stage) {
        const auto now = Clock::now();
        report.seconds[stage] += std::chrono::duration<double>(now - begin).count();
        begin = now;
    };
    SlidePictures reduced;
    cv::Size size;
    source([&](const cv::Mat& picture) {
        checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
        if (size.empty()) size = picture.size();
        checkSize(picture.size(), size, "picture", "like the first one ");
        reduced.add(picture);
        return true;
    });
    lap(0);
    report.pictures = reduced.count();
    if (report.pictures < 2)
        refuse("holds " + std::to_string(report.pictures) + " picture" +
               (report.pictures == 1 ? "" : "s") +
               ", expected a video or several photos of a camera that moves sideways");
    std::vector<SlidePicture>& pictures = reduced.kept();
    PictureSteps steps = leaveOutStrangers(pictures, {name, options.names}, notes);
    aspect = static_cast<double>(size.height) / size.width;
    if (options.turntable) // most corners may be those of the room, which stands
        std::fill(steps.steps.begin(), steps.steps.end(), cv::Point2d(1, 0));
    const std::vector<std::size_t> chosen = choosePictures(pictures, steps.steps, kMostChosen);
    std::vector<const SlidePicture*> followed;
    for (const std::size_t i : chosen)
        followed.push_back(&pictures[i]);
    SlideTracks tracks = followCorners(followed, aspect, steps.window);
    if (options.turntable) removeStill(tracks);
    lap(1);
    requireCorners(tracks.fewest, name);
    if (!options.turntable) requireMotion(tracks.tracks, name);
    const auto count = static_cast<int>(chosen.size());
    if (!options.turntable &&
        movesUpright(tracks.tracks, count, 1.0 / followed.front()->grey.cols)) {
        report.turned = true;
        addNote(&notes, NoteCode::Converted,
                "the camera moves upright: the pictures are turned by a quarter; to see them "
                "upright, turn the phone or move it sideways");
        for (SlidePicture& picture : pictures)
            cv::rotate(picture.grey, picture.grey, cv::ROTATE_90_CLOCKWISE);
        tracks.tracks = turnedByAQuarter(tracks.tracks, aspect);
        size = {size.height, size.width};
        aspect = 1 / aspect;
    }
    SlideGuess guess;
    guess.pixel = 1.0 / pictures.front().grey.cols;
    guess.isTurntable = options.turntable;
    if (options.viewDegrees != 0) {
        guess.lens.focal = 0.5 / std::tan(options.viewDegrees / 2 * CV_PI / 180);
        guess.isLensKnown = true;
    }
    FoundPaths paths = findPaths(tracks.tracks, count, guess);
    const SlidePath& path = paths.best;
    const Notes before = notes;
    const auto use = [&] {
        notes = before;
        findStretch(pictures, chosen, tracks, path);
        chooseWindow(size.width);
    };
    use();
    if (paths.reversed) {
        // decides by which things hide others; weaker evidence is enough if the tracks agree with
        // it
        constexpr double kMore = 1.25;
        constexpr double kMuchMore = 2.2;
        constexpr double kWorse = 1.8;
        constexpr double kMuchWorse = 5;
        const double front = frontShareOf(pictures);
        const bool isClear = paths.worse > kMuchWorse || front < 1 / (1 + kMuchMore) ||
                             (front < 1 / (1 + kMore) && paths.worse > kWorse);
        const bool isReversed = !isClear && front > kMuchMore / (1 + kMuchMore);
        const bool isGuessed = !isClear && !isReversed;
        if (isReversed || (isGuessed && report.fromRight)) {
            paths.best = *paths.reversed;
            use();
        }
        if (isGuessed)
            addNote(&notes, NoteCode::Doubtful,
                    "near and far may be exchanged, as the pictures follow a thing, and little in "
                    "them hides what is behind it: the first picture is taken as the leftmost one; "
                    "if the result looks inside out, give the pictures in reverse order");
    }
    lap(2);
    const double perWidth = window.focal / lens.focal;
    for (const cv::Vec2d& r : path.residual) { // the worst picture
        report.horizontalPixels = std::max(report.horizontalPixels, r[0] * perWidth);
        report.verticalPixels = std::max(report.verticalPixels, r[1] * perWidth);
    }
}

void CameraSlide::Impl::findStretch(const std::vector<SlidePicture>& pictures,
                                    const std::vector<std::size_t>& chosen,
                                    const SlideTracks& corners, const SlidePath& path) {
    lens = path.lens;
    report.misfitPercent = 100 * path.misfitShare;
    stops.clear();
    report.positions.clear();
    const std::vector<double> depths = depthsOf(path);
    low = percentileOf(depths, 0.01);
    high = percentileOf(depths, 0.99);
    const double nearFar = percentileOf(depths, 0.95) - percentileOf(depths, 0.05);
    window.focus = options.focus ? low + *options.focus * (high - low) : percentileOf(depths, 0.5);
    report.focus = (window.focus - low) / std::max(high - low, 1e-9);
    const double parallax = lens.focal * nearFar;
    double turn = 0;
    for (const SlideCamera& camera : path.cameras)
        turn = std::max(turn, std::acos(std::clamp(camera.turn(2, 2), -1.0, 1.0)));
    report.turnDegrees = turn * 180 / CV_PI;
    requireSlide(path, corners.tracks, parallax, name);

    double wholeWay = 0;
    for (std::size_t i = 1; i < path.cameras.size(); ++i)
        wholeWay += std::abs(path.cameras[i].place[0] - path.cameras[i - 1].place[0]);
    const std::vector<std::size_t> stretch = longestStretch(path.cameras);
    std::vector<double> gains;
    std::vector<double> speeds;
    for (const std::size_t i : stretch) {
        Stop stop;
        stop.number = pictures[chosen[i]].number;
        stop.camera = path.cameras[i];
        stop.gain = corners.gains[i];
        gains.push_back(stop.gain);
        if (!stops.empty())
            speeds.push_back(std::abs(stop.position() - stops.back().position()) /
                             (stop.number - stops.back().number));
        stops.push_back(stop);
    }
    const double usual = percentileOf(gains, 0.5);
    for (Stop& stop : stops)
        stop.gain /= usual;
    report.fromRight = stops.back().position() < stops.front().position();
    from = std::min(stops.front().position(), stops.back().position());
    to = std::max(stops.front().position(), stops.back().position());
    report.stretchPercent = 100 * std::min(1.0, (to - from) / std::max(wholeWay, 1e-9));
    constexpr double kLittle = 40; // %
    if (report.stretchPercent < kLittle)
        addNote(&notes, NoteCode::LeftOut,
                "the camera often turns back, or the pictures are not in the order in which they "
                "were taken: the longest stretch in one direction is " +
                    fixed(report.stretchPercent, 0) + " % of its way");
    report.speedRatio = speeds.empty() ? 1
                                       : *std::max_element(speeds.begin(), speeds.end()) /
                                             std::max(percentileOf(speeds, 0.5), 1e-9);
    double away = 0;
    for (const Stop& stop : stops)
        away = std::max({away, std::abs(stop.camera.place[1]), std::abs(stop.camera.place[2])});
    report.awayPercent = 100 * away / (to - from);
    report.parallaxPercent = 100 * parallax * (to - from);
}

// The window of the middle part of the path.
SlideWindow CameraSlide::Impl::windowOf(double share, double pictureWidth) const {
    const double middle = (from + to) / 2;
    const double reach = (to - from) / 2 * share + 1e-6;
    std::vector<SlideCamera> cameras;
    for (const Stop& stop : stops)
        if (std::abs(stop.position() - middle) <= reach) cameras.push_back(stop.camera);
    SlideWindow result;
    result.focus = window.focus;
    if (cameras.empty()) return result;
    cv::Rect2d part = commonPart(cameras, lens, aspect, window.focus);
    if (options.aspect != 0 && part.width > 0 && part.height > 0) {
        const double width = std::min(part.width, part.height * options.aspect);
        const double height = std::min(part.height, part.width / options.aspect);
        part = {part.x + (part.width - width) / 2, part.y + (part.height - height) / 2, width,
                height};
    }
    if (part.width <= 0 || part.height <= 0) return result;
    const double longest = std::max(part.width, part.height);
    result.focal = std::min(lens.focal * pictureWidth, options.longestSide / longest);
    result.size = {std::max(16, static_cast<int>(result.focal * part.width)),
                   std::max(16, static_cast<int>(result.focal * part.height))};
    result.middle = cv::Point2d(-part.x, -part.y) * result.focal;
    return result;
}

std::size_t CameraSlide::Impl::nearestTo(double position) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < stops.size(); ++i)
        if (std::abs(stops[i].position() - position) < std::abs(stops[best].position() - position))
            best = i;
    return best;
}

void CameraSlide::Impl::chooseWindow(double pictureWidth) {
    constexpr double kSmallest = 0.3; // share of a side of the pictures
    const double side = std::max(high - window.focus, window.focus - low);
    const auto isGood = [&](double share) {
        const SlideWindow at = windowOf(share, pictureWidth);
        if (at.size.empty()) return false;
        const double perWidth = at.focal / lens.focal;
        if (at.size.height < kSmallest * aspect * perWidth && at.size.width < kSmallest * perWidth)
            return false;
        return options.mostParallax == 0 ||
               at.focal * side * share * (to - from) <= options.mostParallax * at.size.width;
    };
    double share = 1;
    if (!isGood(1)) {
        double bad = 1;
        share = 0;
        for (int round = 0; round < 12; ++round) {
            const double middle = (share + bad) / 2;
            (isGood(middle) ? share : bad) = middle;
        }
        if (share == 0)
            refuse("the pictures have nothing in common, expected a camera that sees the "
                   "same things all the way");
        addNote(&notes, NoteCode::LeftOut,
                "the path is too long for the display: its middle " + fixed(100 * share, 0) +
                    " % are used");
    }
    window = windowOf(share, pictureWidth);
    const double middle = (from + to) / 2;
    const double reach = (to - from) / 2 * share;
    from = middle - reach;
    to = middle + reach;
    report.parallaxPercent *= share * window.focal / lens.focal / window.size.width;
    report.stretchPercent *= share;
    for (const Stop& stop : stops)
        if (std::abs(stop.position() - middle) <= reach + 1e-9)
            report.positions.emplace_back(stop.number, (stop.position() - from) / (to - from));
    report.used = static_cast<int>(report.positions.size());
    if (report.awayPercent > 100 * kTold)
        addNote(&notes, NoteCode::Doubtful,
                "the camera leaves a straight line by " + fixed(report.awayPercent, 0) +
                    " % of the path");
}

SlideFrame CameraSlide::Impl::frameOf(const cv::Mat& picture, const Stop& stop) const {
    SlideFrame frame;
    frame.camera = stop.camera;
    frame.aspect = aspect;
    frame.picture = picture;
    if (report.turned) cv::rotate(picture, frame.picture, cv::ROTATE_90_CLOCKWISE);
    const double scale = window.focal / (lens.focal * frame.picture.cols);
    if (scale < 0.95) // else cubic sampling suffices
        cv::resize(frame.picture, frame.picture,
                   {cvRound(frame.picture.cols * scale), cvRound(frame.picture.rows * scale)}, 0, 0,
                   cv::INTER_AREA);
    cv::Mat equal;
    frame.picture.convertTo(equal, CV_8U, 1 / stop.gain);
    frame.picture = equal;
    return frame;
}

void CameraSlide::Impl::readStops(const std::set<std::size_t>& wanted,
                                  const std::function<void(std::size_t, SlideFrame)>& take) const {
    int number = 0;
    auto next = wanted.begin();
    source([&](const cv::Mat& picture) {
        if (number++ == stops[*next].number) {
            take(*next, frameOf(picture, stops[*next]));
            ++next;
        }
        return next != wanted.end();
    });
    if (next != wanted.end())
        refuse("gives fewer pictures when it is read again, expected the same ones");
}

CameraSlide::CameraSlide(SlidePictureSource source, const SlideOptions& options,
                         const std::string& name) try
    : impl_(std::make_unique<Impl>()) {
    validate(options);
    checkFunction(source, "source");
    impl_->source = std::move(source);
    impl_->options = options;
    impl_->name = name;
    impl_->find();
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}
CameraSlide::~CameraSlide() = default;
CameraSlide::CameraSlide(CameraSlide&&) noexcept = default;
CameraSlide& CameraSlide::operator=(CameraSlide&&) noexcept = default;

const SlideReport& CameraSlide::report() const {
    return impl_->report;
}
const Notes& CameraSlide::notes() const {
    return impl_->notes;
}
cv::Size CameraSlide::viewSize() const {
    return impl_->window.size;
}

void CameraSlide::makeViews(int count,
                            const std::function<void(int view, const cv::Mat& picture)>& take) try {
    checkRange("count", count, 1, 1000);
    checkFunction(take, "take");
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<Stop>& stops = impl_->stops;
    const bool isBetween = impl_->options.views == SlideViews::Between;
    // what each view is made of, in the order of time
    struct Plan {
        int view;
        double position;
        std::size_t first; // equal to `last`: only the nearest picture is used
        std::size_t last;
    };
    std::vector<Plan> plans;
    const double step = count > 1 ? (impl_->to - impl_->from) / (count - 1) : 0;
    for (int k = 0; k < count; ++k) {
        const int view = impl_->report.fromRight ? count - 1 - k : k;
        const double position =
            count > 1 ? impl_->from + step * view : (impl_->from + impl_->to) / 2;
        Plan plan{view, position, impl_->nearestTo(position), 0};
        plan.last = plan.first;
        if (isBetween) {
            const double sign = impl_->report.fromRight ? -1 : 1;
            // Nearer ones have too little parallax to be matched well (docs/lab/slide.md).
            constexpr double kLeast = 1 - 1e-9; // steps between views
            constexpr double kBest = 2;
            const auto wayTo = [&](std::size_t stop) {
                return sign * (stops[stop].position() - position) / std::max(step, 1e-12);
            };
            const auto isBetter = [&](std::size_t next, std::size_t stop, double best) {
                return std::abs(wayTo(next) - best) < std::abs(wayTo(stop) - best);
            };
            while (plan.first > 0 &&
                   (wayTo(plan.first) > -kLeast || isBetter(plan.first - 1, plan.first, -kBest)))
                --plan.first;
            while (plan.last + 1 < stops.size() &&
                   (wayTo(plan.last) < kLeast || isBetter(plan.last + 1, plan.last, kBest)))
                ++plan.last;
            if (plan.first == plan.last) {
                const bool isAfter = sign * (stops[plan.first].position() - position) > 0;
                if ((isAfter && plan.first > 0) || plan.first + 1 == stops.size())
                    --plan.first;
                else
                    ++plan.last;
            }
        }
        plans.push_back(plan);
    }
    std::set<std::size_t> wanted;
    for (const Plan& plan : plans)
        wanted.insert({plan.first, plan.last});
    std::map<std::size_t, SlideFrame> frames;
    std::map<std::pair<std::size_t, std::size_t>, SlideDepths> depths; // depths of the last pair
    std::size_t next = 0;
    impl_->readStops(wanted, [&](std::size_t stop, SlideFrame frame) {
        frames.emplace(stop, std::move(frame));
        for (; next < plans.size() && plans[next].last <= stop; ++next) {
            const Plan& plan = plans[next];
            frames.erase(frames.begin(), frames.lower_bound(plan.first));
            const SlideFrame& first = frames.at(plan.first);
            if (plan.first == plan.last) {
                take(plan.view, viewFrom(first, impl_->lens, impl_->window, plan.position));
                continue;
            }
            const SlideFrame& last = frames.at(plan.last);
            const SlideFrame& left = impl_->report.fromRight ? last : first;
            const SlideFrame& right = impl_->report.fromRight ? first : last;
            if (depths.count({plan.first, plan.last}) == 0) {
                depths.clear();
                depths[{plan.first, plan.last}] =
                    matchFrames(left, right, impl_->lens, impl_->window, impl_->low, impl_->high);
            }
            take(plan.view, viewBetween(left, right, impl_->lens, impl_->window, plan.position,
                                        depths.begin()->second));
        }
    });
    impl_->report.seconds[3] +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void CameraSlide::makeDepth(cv::Mat& photo, cv::Mat& depth) try {
    check(&photo != &depth, "depth", "is the photo, expected another picture");
    const std::vector<Stop>& stops = impl_->stops;
    const double path = impl_->to - impl_->from;
    const std::size_t middle = impl_->nearestTo((impl_->from + impl_->to) / 2);
    std::set<std::size_t> wanted = {middle};
    for (const double away : {-0.25, -0.12, 0.12, 0.25}) // shares of the path
        wanted.insert(impl_->nearestTo(stops[middle].position() + away * path));
    if (wanted.size() == 1) // few pictures
        wanted.insert(middle > 0 ? middle - 1 : middle + 1);
    std::vector<std::pair<std::size_t, SlideFrame>> frames;
    impl_->readStops(wanted, [&](std::size_t stop, SlideFrame frame) {
        frames.emplace_back(stop, std::move(frame));
    });
    const auto isMiddle = [&](const auto& one) { return one.first == middle; };
    const SlideFrame& here = std::find_if(frames.begin(), frames.end(), isMiddle)->second;
    std::vector<cv::Mat> found;
    for (const auto& [stop, frame] : frames) {
        if (stop == middle) continue;
        const bool isLeft = stops[stop].position() < stops[middle].position();
        const SlideDepths depths = matchFrames(isLeft ? frame : here, isLeft ? here : frame,
                                               impl_->lens, impl_->window, impl_->low, impl_->high);
        found.push_back(isLeft ? depths.right : depths.left);
    }
    depth = medianDepth(found);
    photo = viewFrom(here, impl_->lens, impl_->window, stops[middle].position());
    if (std::all_of(depth.begin<float>(), depth.end<float>(),
                    [](float q) { return std::isnan(q); }))
        depth.setTo(cv::Scalar::all(impl_->window.focus));
    fillFromBehind(depth, photo);
    photo = viewFrom(here, impl_->lens, impl_->window, stops[middle].position(), depth);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
