#include "video/video_run.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/file_io.hpp"
#include "cli/folders.hpp"
#include "cli/inputs.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// By its first bytes, HEIC or AVIF, which FFmpeg may open as a video.
bool isHeifPicture(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string start(12, '\0');
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    if (!stream || start.compare(4, 4, "ftyp") != 0) return false;
    const std::set<std::string> brands = {"heic", "heix", "heim", "heis", "mif1", "mif2", "avif"};
    return brands.count(start.substr(8)) > 0;
}

std::string factsText(const VideoFacts& facts) {
    std::string text = sizeText(facts.size);
    if (facts.averageRate.isKnown()) text += ", " + fixed(facts.averageRate.value(), 2) + " fps";
    if (facts.duration) text += ", " + clockText(*facts.duration);
    text += ", " + facts.codec;
    for (const VideoStreamFacts& stream : facts.streams) {
        if (stream.kind == StreamKind::Audio) text += ", sound " + stream.codec;
        if (stream.kind == StreamKind::Subtitle) text += ", subtitles " + stream.codec;
    }
    return text;
}

// A picture opens as a video of one frame; only --input-... makes this intentional.
// @param facts null: of a file that is not opened yet
void refusePicture(const VideoPlan& plan, const VideoFacts* facts) {
    if (!isFile(plan.input) || !plan.part.format.empty() || !plan.part.formatOptions.empty() ||
        !(facts != nullptr ? isPicture(plan.input, *facts) : isHeifPicture(plan.input))) {
        return;
    }
    throw UsageError(plan.inputName() + ": is a picture, expected a video; " +
                     (plan.fromQuilt
                          ? "quilt2native makes a Native picture of it if OUT is named as one"
                          : "photo2native makes a Native of a photo"));
}

// Videos carry no mark; ordinary ones have no 4:4:4 at the very size of a panel.
void refuseNativeVideo(const VideoPlan& plan, const VideoFacts& facts, const ChosenDisplay& display,
                       Messages& messages) {
    const bool fullColour = facts.pixelFormat.find("444") != std::string::npos ||
                            facts.pixelFormat.find("gbr") != std::string::npos;
    if (facts.size != display.panelSize() || !fullColour) return;
    const std::string like = "has the panel's size and 4:4:4 colour, like a Native video";
    if (plan.isFromFolder) {
        throw NotTaken{
            {plan.input, FileKind::NativeVideo, like + "; if it is none, it is converted alone"}};
    }
    messages.warn("the video " + like + "; do not convert a Native again");
}

constexpr DisplayUse kUses[] = {DisplayUse::Show, DisplayUse::Quilt, DisplayUse::None,
                                DisplayUse::None}; // as VideoProduct

// Shows some of the first frames of a file (0, 1, 2, 4, 8, ...): one of them may be dark, or a
// title. None if the frames cannot be read twice.
// @param look false: it has seen enough
void forEarlyFrames(const VideoPlan& plan, int lastFrame,
                    const std::function<bool(const cv::Mat&)>& look) {
    if (!isFile(plan.input)) return;
    VideoReader reader(plan.input, plan.part);
    int wanted = 0;
    for (int number = 0; number <= lastFrame; ++number) {
        const auto frame = reader.next();
        if (!frame) break;
        if (number != wanted) continue;
        wanted = std::max(1, 2 * wanted);
        if (!look(frame->picture)) break;
    }
}

// What is found in the first frames of a video of quilts.
std::optional<FoundQuilt> searchFrames(const VideoPlan& plan, int lastFrame) {
    std::optional<FoundQuilt> best;
    forEarlyFrames(plan, lastFrame, [&best](const cv::Mat& frame) {
        const FoundQuilt found = findQuiltLayout(frame);
        const bool saysMore =
            found.verdict == QuiltVerdict::Unsure && best &&
            (best->verdict == QuiltVerdict::NoQuilt || best->confidence < found.confidence);
        const bool isQuilt = found.verdict == QuiltVerdict::Quilt;
        if (isQuilt || !best || saysMore) best = found;
        return !isQuilt;
    });
    return best;
}

// Videos whose names say that frames hold photo and depth, and which do.
void refuseRgbd(const VideoPlan& plan, Messages& messages) {
    constexpr int kLastFrame = 64;
    const std::optional<SceneName> name = parseSceneName(plan.input);
    if (!name || name->contents != SceneName::Contents::Rgbd || !isFile(plan.input)) return;
    bool areHalves = false;
    forEarlyFrames(plan, kLastFrame, [&](const cv::Mat& frame) {
        areHalves = findDepthHalf(frame, name->isStacked).has_value();
        return !areHalves;
    });
    const std::string what = "holds photo and depth by its name (" + name->tag + ")";
    if (!areHalves)
        return messages.warn(plan.inputName() + ": " + what +
                             ", but its frames do not: they are taken as ordinary ones");
    if (plan.isFromFolder)
        throw NotTaken{{plan.input, FileKind::HalvesVideo,
                        what + "; video2native --rgbd right makes a Native of it"}};
    throw UsageError(plan.inputName() + ": " + what +
                     ", expected --rgbd with the side of the depth, as --rgbd right");
}

double aspectOf(cv::Size size) {
    return static_cast<double>(size.width) / size.height;
}

bool isDeepGrey(const VideoFacts& facts) {
    return facts.pixelFormat.compare(0, 6, "gray16") == 0;
}

// Uses the depth that a file has in a video of its own, if it has the shape of the colours.
void takeDepthTrack(VideoRun& run, Messages& messages) {
    DepthOptions& options = run.job.depth;
    VideoPlan& plan = run.job.plan;
    if (!options.isDefault || options.isFlat || options.stereo || plan.fromQuilt) return;
    const auto track = findDepthTrack(plan.input, plan.part, run.inputFacts);
    if (!track) return;
    const std::string asGiven = "--depth " + shellWord(plan.input.string());
    if (plan.isFromFolder || !track->fits)
        return messages.warn(
            std::string("the depth in the file is not used, ") +
            (plan.isFromFolder ? "because the videos of a folder are made alike" : kMisfitText) +
            "; " + asGiven + " uses it");
    options.fromFiles = true;
    options.given = "depth in the video";
    options.kind = track->kind();
    run.job.depthOptions.every = 1;
    plan.depth = plan.input;
    messages.warn("the depth in the file is used, " + track->text() + "; " + asGiven +
                  " --depth-kind says otherwise, -n altiro3d estimates it");
}

// The eyes in frames, by the option or by what is found. Says what decided.
std::optional<StereoVideo> eyesOf(const VideoRun& run, Messages& messages) {
    const DepthOptions& options = run.job.depth;
    if (options.isFlat || !options.given.empty()) return std::nullopt;
    FoundEyes found;
    if (options.stereo) {
        found.eyes = StereoVideo{options.stereo->layout,
                                 halvesOf(run.job.plan.input, options.stereo->halves)};
        found.eyes->halves = halvesAsShown(*found.eyes, run.inputFacts);
        found.evidence = "--stereo says it";
    } else {
        refuseVrName(run.job.plan.input);
        found = findEyes(run.job.plan.input, run.inputFacts, run.job.plan.part);
        messages.warn(found.notes);
    }
    if (!found.eyes) return std::nullopt;
    const bool isBeside = found.eyes->layout == StereoLayout::LeftRight ||
                          found.eyes->layout == StereoLayout::RightLeft;
    messages.say(std::string("both eyes: ") + (isBeside ? "beside" : "above") + " each other, as " +
                 found.evidence);
    return found.eyes;
}

// Videos of a folder that are not named as videos of quilts are searched for one.
void refuseQuiltVideo(const VideoPlan& plan, Messages& messages) {
    constexpr int kLastFrame = 4;
    const std::optional<FoundQuilt> found = searchFrames(plan, kLastFrame);
    if (!found || found->confidence <= 0) return;
    const std::string text = "a video of quilts of " + std::to_string(found->layout.columns) +
                             " columns x " + std::to_string(found->layout.rows) + " rows";
    if (found->verdict == QuiltVerdict::Quilt) {
        throw NotTaken{
            {plan.input, FileKind::QuiltVideo,
             "is " + text + "; quilt2native makes a Native of it if it is named itself"}};
    }
    if (found->verdict == QuiltVerdict::Unsure)
        messages.warnOfSubject("may be " + text +
                               "; if it is one, quilt2native -q makes its Native");
}

// The path from frames with depth to Natives.
// @param seenAspect width : height of the scene as it is shown
void choosePath(VideoRun& run, double seenAspect, Messages& messages) {
    run.path = "quilt";
    if (run.job.plan.product == VideoProduct::Rgbd || run.job.plan.product == VideoProduct::Stereo)
        return;
    tellCut(seenAspect, run.display.aspect(), run.job.scene.recipe, messages);
    if (run.job.plan.product == VideoProduct::Quilt) return;
    const NativeMaker maker =
        makeNativeMaker(run.job.scene, run.display, run.layout, messages, run.job.profile.keep);
    run.path = pathName(maker);
    run.job.scene.recipe.positions = maker.options().positions;
}

// Checks the names before any work, see Outputs::check().
void checkOutputs(VideoRun& run) {
    const VideoJob& job = run.job;
    VideoPlan& plan = run.job.plan;
    if (plan.isChecked) return;
    if (job.resume && !plan.isFile)
        throw UsageError("--resume reads the input again, expected a file, not " +
                         plan.inputName());
    // The interrupted run may have left these files; without any, --resume starts a new run.
    const bool goesOn = job.resume && !plan.show && isVideoUnfinished(plan.output);
    Outputs outputs(job.replace || goesOn);
    if (job.resume && !goesOn)
        outputs.explainExisting(plan.output,
                                "and no unfinished run of it is kept, so it may be complete");
    outputs.addInputs(run.display.files);
    outputs.addInputs({job.depth.network, job.depth.profile, plan.input, plan.depth});
    if (!plan.show) outputs.addResult(plan.output);
    outputs.addOutputs({plan.native, plan.report});
    outputs.check();
    plan.isChecked = true;
}

void takeDepth(VideoRun& run, const std::optional<RgbdLayout>& rgbd, VideoConversion& conversion) {
    if (!run.depth) return;
    const DepthOptions& options = run.job.depth;
    if (options.given.empty()) {
        conversion.depth = storedDepthOr(run.depth->source(), {false, false}); // has a share in it
        return;
    }
    GivenVideoDepth& given = conversion.given.emplace();
    if (options.fromFiles) given.source = run.job.plan.depth;
    given.rgbd = rgbd;
    given.kind = run.depth->kind();
    given.range = run.job.depthRange;
    given.read = [](const fs::path& file, Notes* notes) {
        const QuietStandardError quiet;
        return readDepthSamples(file, notes);
    };
}

} // namespace

bool isPicture(const fs::path& file, const VideoFacts& facts) {
    if (isHeifPicture(file)) return true;
    if (facts.format != "image2" && !endsWith(facts.format, "_pipe")) return false;
    try {
        VideoReader reader(file);
        return !reader.next() || !reader.next(); // pictures may also stand one after the other
    } catch (const Error&) {
        return true; // a broken one
    }
}

std::optional<DepthTrack> findDepthTrack(const fs::path& file, VideoReaderOptions reading,
                                         const VideoFacts& facts) {
    const auto isVideo = [](const VideoStreamFacts& stream) {
        return stream.kind == StreamKind::Video;
    };
    const auto isNamed = [&](const VideoStreamFacts& stream) {
        return isVideo(stream) && lowerCase(stream.title).find("depth") != std::string::npos;
    };
    const auto& streams = facts.streams;
    if (std::count_if(streams.begin(), streams.end(), isVideo) < 2 || !isFile(file))
        return std::nullopt;
    reading.isDepth = true;
    reading.bothEyes = false;
    const VideoFacts depth = VideoReader(file, reading).facts();
    DepthTrack track;
    track.isDeep = isDeepGrey(depth) && !isDeepGrey(facts);
    if (!track.isDeep && std::none_of(streams.begin(), streams.end(), isNamed)) return std::nullopt;
    const auto shapeOf = [](const VideoFacts& of) {
        return of.sampleAspect.value() * aspectOf(of.size);
    };
    constexpr double kTolerance = 0.02;
    track.fits = std::abs(shapeOf(depth) / shapeOf(facts) - 1) <= kTolerance;
    return track;
}

VideoRun::VideoRun(const VideoJob& of, Messages& messages)
    : VideoRun(of, findDisplay(of.display, messages, {}, entryOf(kUses, of.plan.product))) {}

void openDepth(VideoRun& run, Messages& messages) {
    if (!run.depth && !run.job.plan.fromQuilt) run.depth.emplace(run.job.depth, messages);
}

QuiltLayout layoutOfViews(const VideoRun& run, Messages& messages) {
    QuiltLayout layout = chooseQuilt(run.job.quilt, run.display, messages);
    if (run.job.plan.product == VideoProduct::Quilt && !run.job.quilt.tileSize &&
        !run.display.map) {
        cv::Size& tile = layout.tileSize; // 4:2:0 has even sides only
        tile = {std::max(2, tile.width / 2 * 2), std::max(2, tile.height / 2 * 2)};
    }
    return layout;
}

VideoConversion openVideo(VideoRun& run, Messages& messages) {
    VideoJob& job = run.job;
    VideoPlan& plan = job.plan;
    Recipe& recipe = job.scene.recipe;
    VideoConversion conversion;
    plan.part.threads = std::min(cv::getNumThreads(), 16);
    plan.part.bothEyes = !plan.fromQuilt && !job.depth.isFlat && job.depth.given.empty();
    plan.part.joinsVideos = job.depth.areVideos;
    refusePicture(plan, nullptr); // FFmpeg's error would not say so
    conversion.reader = std::make_unique<VideoReader>(plan.input, plan.part);
    const VideoFacts& facts = conversion.reader->facts();
    run.inputFacts = facts;
    refusePicture(plan, &facts);
    messages.say((messages.hasSubject() ? "" : plan.inputName() + ": ") + factsText(facts));
    takeDepthTrack(run, messages);
    if (!plan.fromQuilt) {
        warnIfQuilt(plan.input, "--from-quilt", messages);
        if (job.depth.given.empty()) refuseRgbd(plan, messages);
    }
    if (plan.product == VideoProduct::Native) refuseNativeVideo(plan, facts, run.display, messages);
    std::optional<RgbdLayout> rgbd;
    std::optional<FoundQuilt> found;
    if (!plan.fromQuilt) conversion.stereo = eyesOf(run, messages);
    if (plan.fromQuilt && !isLayoutStated(job.quilt, plan.input)) {
        if (!isFile(plan.input) && !run.display.map)
            throw UsageError(plan.inputName() +
                             ": its quilts cannot be searched for their layout, as it is read only "
                             "once; expected -q ROWSxCOLUMNS");
        found = searchFrames(plan, 64);
    }
    if (plan.isFromFolder && !plan.fromQuilt && !job.depth.rgbd && !conversion.stereo)
        refuseQuiltVideo(plan, messages);
    run.layout = plan.fromQuilt
                     ? chooseQuilt(job.quilt, run.display, messages, plan.input, facts.size, found)
                     : layoutOfViews(run, messages);
    if (plan.product == VideoProduct::Quilt && !isStandardStream(plan.output))
        plan.output = quiltFileName(plan.output, run.layout, run.display.aspect());
    checkOutputs(run);
    if (plan.fromQuilt) {
        const QuiltShape shape(plan.input, run.layout, run.display, job.fit);
        messages.say("quilt: " + quiltText(run.layout, shape.shownAspect()) +
                     (found ? foundText(*found) : ""));
        tellShape(shape, messages);
        recipe.fit = shape.fit();
        conversion.viewAspect = shape.aspect();
    } else {
        if (plan.product == VideoProduct::Native)
            messages.say("quilt: " + quiltText(run.layout, run.display.aspect()));
        const bool isStereo = plan.product == VideoProduct::Stereo;
        conversion.eyes = {job.eyes.picture, job.eyes.from, job.eyes.swapped,
                           isStereo && conversion.stereo && job.keepsEyes};
        if (isStereo) {
            tellEyesTag(plan.output, job.eyes, messages);
            recipe.views.strengthPercent = job.eyes.strengthPercent;
            recipe.choices.strength = false;
            recipe.positions = ViewPositions::Discrete;
        }
        if (conversion.eyes.filmed) {
            messages.say("both pictures stay as they were filmed");
        } else {
            if (conversion.stereo)
                messages.say("depth: by matching both eyes, and estimated where they do not match");
            openDepth(run, messages);
        }
        if (job.depth.rgbd)
            rgbd = rgbdOf(plan.input, *job.depth.rgbd,
                          facts.sampleAspect.value() * aspectOf(facts.size), messages);
        cv::Size photo = rgbd ? rgbd->photoSize(facts.size) : facts.size;
        if (conversion.stereo) photo = photoSize(*conversion.stereo, facts.size);
        choosePath(run, facts.sampleAspect.value() * aspectOf(photo), messages);
    }
    if (plan.product == VideoProduct::Native && job.encoding.compatible)
        messages.warn("--compat halves the colour resolution (4:2:0): in a Native neighbouring "
                      "sub-pixels belong to different views, so views are mixed and depth blurs; "
                      "use it only for players that refuse the usual file");
    const EyesPicture picture = job.eyes.picture;
    const bool isMixed = picture == EyesPicture::Rows || isAnaglyph(picture);
    if (plan.product == VideoProduct::Stereo && isMixed && job.encoding.compatible)
        messages.warn("--compat halves the colour resolution (4:2:0), which mixes the eyes of " +
                      std::string(nameOf(picture).words) + ": each sees a trace of the other");
    if (plan.product == VideoProduct::Native && job.encoding.codec == VideoCodec::H264 &&
        job.encoding.crf >= 1 && !job.isMaxRateGiven)
        job.encoding.maxRate = job.profile.bitsPerPixel == 0
                                   ? 0
                                   : std::max(1.0, std::round(1e-6 * job.profile.bitsPerPixel *
                                                              run.display.panelSize().area()));
    job.encoding.threads = cv::getNumThreads();

    conversion.input = plan.input;
    conversion.part = plan.part;
    conversion.output = plan.output;
    conversion.product = plan.product;
    conversion.rgbdHalves = savedRgbdLayout(plan.output).halves;
    conversion.display = run.display;
    conversion.map = run.display.map;
    conversion.layout = run.layout;
    conversion.recipe = recipe;
    conversion.fromQuilt = plan.fromQuilt;
    takeDepth(run, rgbd, conversion);
    conversion.depthOptions = job.depthOptions;
    conversion.encoding = job.encoding;
    conversion.settings = job.settings;
    if (job.resume) {
        conversion.unfinished = UnfinishedRun::Resume;
    } else if (job.replace) {
        conversion.unfinished = UnfinishedRun::Discard;
    }
    return conversion;
}

} // namespace altiro3D::tools
