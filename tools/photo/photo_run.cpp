#include "photo/photo_run.hpp"

#include "altiro3D/altiro3D.hpp"
#include "cli/folders.hpp"
#include "cli/inputs.hpp"
#include "cli/network_trust.hpp"
#include "photo/photo_report.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// Pictures that were not named are converted only if they are photos.
void requirePhoto(const PhotoItem& item, const PhotoScene& photo, Messages& messages) {
    if (!item.isFromFolder || !item.depth.empty()) return;
    const FoundQuilt found = findQuiltLayout(photo.photo);
    if (found.verdict == QuiltVerdict::Quilt) {
        throw NotTaken{{item.photo, FileKind::Quilt,
                        "is a quilt of " + std::to_string(found.layout.columns) + " columns x " +
                            std::to_string(found.layout.rows) +
                            " rows; quilt2native makes Natives of quilts"}};
    }
    if (found.verdict == QuiltVerdict::Unsure && found.confidence > 0) {
        messages.warn(item.photo.string() + ": may be a quilt of " +
                      std::to_string(found.layout.columns) + " columns x " +
                      std::to_string(found.layout.rows) +
                      " rows; if it is one, quilt2native -q makes its Native");
    }
    if (photo.origin != DepthOrigin::Estimated || hasColours(photo.photo)) return;
    const QuietStandardError quiet;
    if (looksLikeDepthImage(readImage(item.photo))) { // with all its bits
        throw NotTaken{{item.photo, FileKind::DepthImage,
                        "looks like a depth image, as it is grey and smooth; a photo is converted "
                        "if it is named itself"}};
    }
}

// A photo on the display.
struct PlacedPhoto {
    Placement placement;
    NativeOptions options;  // with framing, focus and strength of this photo
    std::string chosen;     // tells them
    double aspect = 1;      // of the Native
    double quiltAspect = 1; // of the quilt to save
};

// "4 px left, 3 px top": where a scan's border was cut.
std::string borderText(cv::Size photo, const cv::Rect& inside) {
    const std::pair<const char*, int> sides[] = {{"left", inside.x},
                                                 {"right", photo.width - inside.br().x},
                                                 {"top", inside.y},
                                                 {"bottom", photo.height - inside.br().y}};
    std::string text;
    for (const auto& [side, pixels] : sides) {
        if (pixels == 0) continue;
        text += (text.empty() ? "" : ", ") + std::to_string(pixels) + " px " + side;
    }
    return text;
}

// Places a photo. run.maker has the options that were asked for, PlacedPhoto::options those that
// were chosen for this photo. placeScene() uses all of these; makerOf() passes on strength and
// focus.
PlacedPhoto placePhoto(const PhotoItem& item, const PhotoRun& run, const PhotoScene& scene,
                       Messages& messages) {
    PlacedPhoto placed;
    const double panelAspect = run.display.aspect();
    placed.quiltAspect = // of its name, which quiltFileName() has made
        item.quilt.empty() ? panelAspect : parseQuiltName(item.quilt)->aspect.value_or(panelAspect);
    const bool isOverQuilt = run.maker.path() == NativePath::OverQuilt;
    const double aspect = placed.aspect = isOverQuilt ? placed.quiltAspect : panelAspect;
    NativeOptions& options = placed.options = run.maker.options();
    const cv::Size size = scene.photo.size();
    AutoChoices choices = run.job.scene.recipe.choices;
    const cv::Size workSize = run.maker.workSize(); // also over a quilt, where no lens is filtered
    // the fit with the framing so far; only the camera uses it, which margins do not affect
    const auto fitNow = [&] {
        return fitPhoto(size, aspect, workSize, options.fit, options.framing);
    };
    const auto strength = run.job.camera.strength(fitNow()); // nothing without --camera
    if (strength) {
        options.views.strengthPercent = *strength;
        choices.strength = choices.limit = false;
    }
    const ChosenOptions choice =
        chooseFromScene(scene, aspect, run.maker.layout(), options, choices);
    static_cast<PlacementOptions&>(options) = choice.options; // detail and sampling stay
    double& used = options.views.strengthPercent;
    used = std::min(used, run.mostStrength);
    placed.chosen = autoText(choices, options.framing, options.views);
    const std::string border = borderText(size, choice.inside);
    if (!border.empty()) placed.chosen += "; border of the scan cut: " + border;
    options.views = run.job.camera.apply(options.views, fitNow(), messages); // without it, the same
    placed.placement = placeScene(scene, aspect, workSize, options);
    return placed;
}

std::string sizeKey(cv::Size size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
}

// What the time of a Native depends on besides the picture; usable in a file name.
// @param photo size of the fitted photo
std::string costKey(const NativeMaker& maker, cv::Size photo) {
    const QuiltLayout& layout = maker.layout();
    std::string key = pathName(maker) + "-" + sizeKey(photo) + "-" + sizeKey(maker.panelSize());
    if (maker.options().positions == ViewPositions::Continuous) key += "-continuous";
    if (maker.options().lensFilter) key += "-filtered";
    if (maker.options().refine.keepsDepth()) key += "-exact";
    if (maker.options().sampling.blends()) key += "-blended";
    if (maker.path() == NativePath::OverQuilt)
        key += "-" + sizeKey(layout.tileSize) + "-" + std::to_string(layout.viewCount);
    return key;
}

// Chooses depth and method by the first photo, for all of them.
// @return true if the depth must be estimated anew
bool chooseByBudget(PhotoRun& run, const PhotoScene& scene, const Scene& fitted,
                    Messages& messages) {
    std::vector<NamedDepthSource> sources;
    std::vector<std::unique_ptr<DepthSource>> loaded;
    std::vector<BudgetDepth> depths;
    Scene estimated;
    const double focus = run.maker.options().views.focus;
    if (scene.origin == DepthOrigin::Estimated) {
        if (run.job.depth.isDefault) {
            sources = depthSources(messages);
        } else {
            depths.push_back(
                {run.depthSource.description(), [] {},
                 [&] { run.depthSource.estimateScene(scene.photo, focus, estimated); }});
        }
    }
    loaded.resize(sources.size());
    for (std::size_t i = 0; i < sources.size(); ++i) {
        depths.push_back({sources[i].name, [&, i] { loaded[i] = sources[i].load(); },
                          [&, i] { loaded[i]->readScene(scene.photo, focus, estimated); }});
    }
    const auto makeNative = [&](const ViewOptions& views) {
        const NativeMaker maker = run.maker.withViews(views);
        cv::Mat refined; // only for its time: the depth is refined already
        refineDepth(fitted.photo, fitted.depth, refined, maker.options().refine);
        cv::Mat quilt; // in new memory, as for a single photo
        cv::Mat native;
        if (maker.path() == NativePath::OverQuilt) maker.makeQuilt(fitted, quilt);
        maker.makeNative(fitted, quilt, native);
    };
    const BudgetSetting chosen =
        run.budget.choose(run.maker.options().views, costKey(run.maker, fitted.photo.size()),
                          depths, makeNative, messages);
    run.maker = run.maker.withViews(chosen.views);
    if (chosen.depth == 0 || sources.empty()) return false;
    run.depthSource.useEstimator(loaded[chosen.depth] ? std::move(loaded[chosen.depth])
                                                      : sources[chosen.depth].load());
    return true;
}

// The maker for one photo; with --camera or auto each photo has its own strength and focus.
NativeMaker makerOf(const PhotoRun& run, const ViewOptions& views) {
    const ViewOptions& usual = run.maker.options().views;
    const bool isUsual =
        views.strengthPercent == usual.strengthPercent && views.focus == usual.focus;
    return isUsual ? run.maker : run.maker.withViews(views);
}

// Reports a parallax close to the limit; above the limit there is a warning.
// @param hasCamera the strength follows from --camera
AdjacentParallax tellParallax(bool hasCamera, const NativeMaker& maker, const cv::Mat& depth,
                              Messages& messages) {
    constexpr double kNearTheLimit = 0.8 * kParallaxBudgetPixels;
    double nearest = 0;
    double farthest = 0;
    cv::minMaxLoc(depth, &farthest, &nearest);
    const ViewOptions& views = maker.options().views;
    const AdjacentParallax parallax =
        adjacentParallax(views, maker.layout(), maker.panelSize(), {farthest, nearest});
    const std::string line =
        "parallax: strength " + fixed(views.strengthPercent, 1) + " %, focus " +
        fixed(views.focus, 2) + ": at most " + fixed(parallax.viewPixels, 2) + " view px (" +
        fixed(parallax.panelPixels, 2) + " panel px) between adjacent views; above " +
        fixed(kParallaxBudgetPixels, 0) + " view px hard edges show double";
    const bool isNear =
        parallax.viewPixels > kNearTheLimit && parallax.viewPixels <= kParallaxBudgetPixels;
    if (isNear || messages.verbose()) messages.say(line);
    if (views.strengthPercent > 0 && views.strengthPercent < 1 && parallax.viewPixels < 0.1)
        messages.warn("the picture will be nearly flat: --strength is in %, 10 is usual");
    warnAboutParallax(parallax, messages, hasCamera ? "the baseline in --camera" : "--strength");
    return parallax;
}

// Tells how a photo was placed. @return what is reported of it, but for the size of its video
PhotoFacts tellPlacement(const PhotoItem& item, const PhotoRun& run, const PhotoScene& scene,
                         const PlacedPhoto& placed, const NativeMaker& maker, Messages& messages) {
    PhotoFacts facts{item};
    facts.photoSize = scene.photo.size();
    facts.aspect = placed.aspect;
    facts.quiltAspect = placed.quiltAspect;
    facts.crop = placed.placement.fit.source;
    facts.framing = placed.options.framing;
    facts.views = maker.options().views;
    facts.chosen = placed.chosen;
    facts.depthSource = scene.source;
    facts.isUnblurred = scene.isUnblurred;
    // a depth image beside the photo may not fit it
    facts.isImageUsed = !item.depth.empty() && scene.file.filename() == item.depth.filename();
    if (displayUse(run.job) != DisplayUse::None) {
        if (!messages.hasSubject()) {
            tellCut(facts.photoAspect(), placed.aspect, run.maker.options(), messages);
            if (!placed.chosen.empty()) messages.say("auto: " + placed.chosen);
        }
        const bool hasCamera = !run.job.camera.file().empty();
        facts.parallax =
            tellParallax(hasCamera, maker, shownDepth(placed.placement.scene), messages);
    } else if (item.video.empty() && !item.stereo.empty()) {
        facts.views.strengthPercent = run.job.eyes.options().strengthPercent;
    }
    return facts;
}

void makeQuilt(const NativeMaker& maker, const Scene& scene, const PlacedPhoto& placed,
               cv::Mat& quilt) {
    const bool isSame =
        maker.quiltSize() == maker.workSize() && placed.quiltAspect == placed.aspect;
    if (isSame || maker.path() == NativePath::OverQuilt)
        return maker.makeQuilt(placed.placement.scene, quilt);
    maker.makeQuilt(placeScene(scene, placed.quiltAspect, maker.quiltSize(), placed.options).scene,
                    quilt);
}

// Writes the video that swings through the views; returns its size.
// @param part of the photo that it shows; nothing: all of it
cv::Size saveVideo(const PhotoItem& item, const PhotoRun& run, const PlacementOptions& placed,
                   const PhotoScene& scene, const std::optional<cv::Rect>& part,
                   Messages& messages) {
    PlacementOptions options = placed;
    const PhotoFit fit = swayFitOf(scene.photo.size(), options, part, run.job.swaySize);
    options.views = run.job.camera.apply(options.views, fit, messages);
    writeSwayFile(item.video, fit.size, run.job.sway, swayViewsOf(scene, options, fit));
    return fit.size;
}

// Both eyes' pictures as they were photographed; nothing if options ask for other ones, or if the
// photo is not of both eyes.
std::optional<StereoPair> photographedEyes(const PhotoItem& item, const PhotoRun& run,
                                           DepthOrigin origin) {
    const PhotoJob& job = run.job;
    const bool areEyes = job.depth.stereo || origin == DepthOrigin::Matched;
    if (!areEyes || !job.keepsEyes) return std::nullopt;
    if (!isFile(item.photo))
        throw UsageError("--save-stereo reads a photo of both eyes again, expected a file instead "
                         "of a pipe, or --strength");
    const PhotoFile photo = pictureToRead(item.photo);
    if (job.depth.isPair) return StereoPair{readPhoto(photo), readPhoto(item.depth), {}};
    if (!job.depth.stereo)
        if (auto pair = readStereoPair(photo)) return pair;
    const auto name = parseSceneName(photo.path());
    if (!job.depth.stereo && !name) return std::nullopt;
    const StereoLayout layout = job.depth.stereo ? job.depth.stereo->layout : name->layout;
    const StereoHalves halves =
        halvesOf(photo.path(), job.depth.stereo ? job.depth.stereo->halves : name->halves);
    const cv::Mat whole = readPhoto(photo);
    const EyesOptions& wanted = job.eyes.options();
    if (!wanted.areFiles && !wanted.swapped &&
        eyesPictureOf(layout, halves, whole.size()) == wanted.picture) {
        throw Error(ErrorCode::InvalidArgument, photo.path().string(),
                    std::string("is ") + nameOf(wanted.picture).words +
                        " already, expected another --stereo-layout");
    }
    return splitStereoFile(whole, layout, halves, photo);
}

// Writes the pictures for two eyes, of the whole photo at its own size.
void saveStereo(const PhotoItem& item, const PhotoRun& run, const NativeOptions& options,
                const PhotoScene& scene, Messages& messages) {
    if (const auto pair = photographedEyes(item, run, scene.origin)) {
        messages.say("both eyes: as they were photographed");
        StereoPair eyes = *pair;
        if (eyes.right.size() != eyes.left.size())
            cv::resize(eyes.right, eyes.right, eyes.left.size(), 0, 0, cv::INTER_AREA);
        item.eyes.write(eyes, messages);
        return;
    }
    const cv::Size size = scene.photo.size();
    if (std::max(size.width, size.height) > 100LL * std::min(size.width, size.height))
        throw Error(ErrorCode::Unsupported, item.photo.string(),
                    "has " + sizeText(size) +
                        ", expected for --save-stereo at most 100 px of one "
                        "side to 1 px of the other");
    const EyesOptions& wanted = run.job.eyes.options();
    item.eyes.write(photoEyes(scene, options, wanted.strengthPercent, wanted.from), messages);
}

// Writes the photo as splats. @param part as for saveVideo()
void saveSplats(const PhotoItem& item, const PhotoRun& run, const PlacementOptions& options,
                const PhotoScene& scene, const std::optional<cv::Rect>& part, Messages& messages) {
    const double focalLength = isFile(item.photo) ? focalLengthOf(item.photo) : 0;
    SplatScene splats = photoSplats(scene, options, part, run.job.splatSide, focalLength);
    if (!run.job.keepsSplatCamera) splats.camera.reset();
    writeSplats(item.splats, splats);
    messages.say("splats: " + std::to_string(splats.splats.size()) + "; focal length " +
                 (focalLength > 0 ? "by EXIF, " + numberText(focalLength)
                                  : "not known, taken as " + numberText(kUsualFocalLength)) +
                 " mm on 36 x 24");
}

// Writes the photo as a page. @param part as for saveVideo()
void savePage(const PhotoItem& item, const PhotoRun& run, const PlacementOptions& options,
              const PhotoScene& scene, const std::optional<cv::Rect>& part) {
    const PageOptions& page = run.job.page;
    writeFile(item.page, photoPage(scene, options, page.text(item.photo), part, page.side));
}

// Writes the outputs other than the Native; false if there are none. Releases the scene's memory.
bool saveOthers(const PhotoItem& item, const PhotoRun& run, Scene& scene, Messages& messages) {
    if (!item.quilt.empty()) writeImage(item.quilt, run.quilt);
    if (!item.rgbd.empty()) {
        cv::Mat rgbd;
        joinRgbd(scene.photo, savedDepth(scene, scene.photo.cols + scene.photo.rows),
                 savedRgbdLayout(item.rgbd), rgbd);
        writeImage(item.rgbd, rgbd);
    }
    if (!item.savedDepth.empty() || !item.photoWithDepth.empty()) {
        const cv::Mat photo = item.photoWithDepth.empty() ? cv::Mat() : scene.photo;
        const cv::Mat depth = savedDepth(std::move(scene), run.job.savedDepthSide);
        if (!item.savedDepth.empty()) {
            warnAboutDepthFormat(item.savedDepth, messages);
            writeImage(item.savedDepth, depthTo16Bit(depth));
        }
        if (!item.photoWithDepth.empty()) writePhotoWithDepth(item.photoWithDepth, photo, depth);
    }
    if (!item.views.empty()) {
        const QuiltLayout& layout = run.maker.layout();
        const auto fileOf = [&](int view) {
            return item.views / viewFileName(view, layout.viewCount);
        };
        writeViews(fileOf, run.quilt, layout);
    }
    return !item.quilt.empty() || item.savesDepth() || !item.views.empty();
}

// Prints are written while they are made.
void makePrint(const PhotoItem& item, const PhotoRun& run, const NativeMaker& maker,
               const Scene& fitted) {
    run.print->write(item.native, [&](const RowSink& rows) {
        maker.makeNative(fitted, run.quilt, [&](const cv::Mat& band) {
            endIfStopWanted();
            rows(band);
        });
    });
}

// The most strength of a print whose strength was not given, %: what its sheet shows without blur.
double sharpStrength(const Calibration& print, const Messages& messages) {
    const LensFacts facts = lensFacts(print);
    if (facts.sharpDepth == 0) return std::numeric_limits<double>::infinity();
    messages.say("strength: at most " + fixed(facts.sharpStrength, 1) + " %, the " +
                 fixed(facts.sharpDepth, 1) + " mm of depth that the sheet shows without blur");
    return facts.sharpStrength;
}

} // namespace

void PhotoRun::printOn(const PrintSheet& sheet, Messages& messages) {
    print = sheet;
    if (lensGeometry(display.calibration).isLying())
        messages.warn("lenses that lie show both eyes the same view: the print has no depth, and "
                      "changes as it is tilted");
    if (!job.isStrengthGiven) mostStrength = sharpStrength(display.calibration, messages);
}

PhotoRun openPhotoRun(const PhotoJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                      StageTimes& times, Messages& messages) {
    ChosenDepth depth(job.depth, messages);
    if (depth.network() != nullptr) times.end("network");
    PhotoRun run{job, display, makeNativeMaker(job.scene, display, layout, messages), job.budget,
                 std::move(depth)};
    times.end("display");
    return run;
}

Json makePhoto(const PhotoItem& item, PhotoRun& run, Messages& messages) {
    StageTimes times;
    const double flatDepth = run.maker.options().views.focus; // the photo's own is chosen later
    PhotoScene scene = run.depthSource.read(item.photo, item.depth, flatDepth, messages, times);
    endIfStopWanted();
    requirePhoto(item, scene, messages);
    PlacedPhoto placed = placePhoto(item, run, scene, messages);
    times.end("fit");
    endIfStopWanted();
    if (run.budget.mustChoose()) { // --budget, at the first photo
        if (chooseByBudget(run, scene, placed.placement.scene, messages))
            scene.source = run.depthSource.estimateScene(scene.photo, flatDepth, scene);
        placed = placePhoto(item, run, scene, messages); // the views are others now
        times.end("budget");
    }
    if (run.isForOnePhoto) { // the network has done its work; the report still names it
        run.networkEntry = std::make_shared<const Json>(networkJson(run));
        run.depthSource.release();
    }
    const NativeMaker maker = makerOf(run, placed.options.views);
    const Scene& fitted = placed.placement.scene;
    PhotoFacts facts = tellPlacement(item, run, scene, placed, maker, messages);

    const bool makesNative = !item.native.empty();
    const bool isOverQuilt = maker.path() == NativePath::OverQuilt;
    if ((isOverQuilt && makesNative) || !item.quilt.empty() || !item.views.empty()) {
        makeQuilt(maker, scene, placed, run.quilt);
        times.end("views");
    }
    if (!item.savesDepth() && item.video.empty() && item.stereo.empty() && item.splats.empty() &&
        item.page.empty())
        static_cast<Scene&>(scene) = {}; // large, and no longer needed
    if (makesNative && !run.print) {
        warnAboutNativeFormat(item.native, messages);
        maker.makeNative(fitted, run.quilt, run.native); // of scene or quilt, by its path
        times.end("native");
    }
    endIfStopWanted();

    std::optional<cv::Rect> part; // of the photo, by --center or --zoom; nothing: all of it
    if (run.maker.options().framing != Framing()) part = facts.crop;
    if (!item.video.empty()) {
        facts.videoSize = saveVideo(item, run, placed.options, scene, part, messages);
        times.end("video");
        endIfStopWanted();
    }
    if (!item.stereo.empty()) {
        saveStereo(item, run, placed.options, scene, messages);
        times.end("stereo");
        endIfStopWanted();
    }
    if (!item.splats.empty()) {
        saveSplats(item, run, placed.options, scene, part, messages);
        times.end("splats");
        endIfStopWanted();
    }
    if (!item.page.empty()) {
        savePage(item, run, placed.options, scene, part);
        times.end("page");
        endIfStopWanted();
    }
    if (saveOthers(item, run, scene, messages)) times.end("save");
    // last, so that an existing Native means that all outputs exist
    if (makesNative && run.print) {
        makePrint(item, run, maker, fitted);
        times.end("native and write");
    } else if (makesNative) {
        writePicture(item.native, run.native, ImageMark::Native);
        times.end("write");
    }

    tellPicture(run, facts, messages);
    messages.detail(times.text());
    return pictureReport(run, facts, times);
}

} // namespace altiro3D::tools
