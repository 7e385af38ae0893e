#include "video/video_run.hpp"

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

// Whether a file is HEIC or AVIF, by its first bytes. FFmpeg may open such a picture as a video.
bool isHeifPicture(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string start(12, '\0');
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    if (!stream || start.compare(4, 4, "ftyp") != 0) return false;
    const std::set<std::string> brands = {"heic", "heix", "heim", "heis", "mif1", "mif2", "avif"};
    return brands.count(start.substr(8)) > 0;
}

// A picture opens as a video of one frame; only --input-... makes this intentional.
bool mayBePicture(const VideoJob& job) {
    return isFile(job.input) && job.part.format.empty() && job.part.formatOptions.empty();
}

[[noreturn]] void refusePicture(const VideoJob& job) {
    throw UsageError(job.inputName() + ": is a picture, expected a video; " +
                     (job.fromQuilt
                          ? "quilt2native makes a Native picture of it if OUT is named as one"
                          : "photo2native makes a Native of a photo"));
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

double aspectOf(cv::Size size) {
    return static_cast<double>(size.width) / size.height;
}

bool isDeepGrey(const VideoFacts& facts) {
    return facts.pixelFormat.compare(0, 6, "gray16") == 0;
}

// Uses the depth that a file has in a video of its own, if it has the shape of the colours.
void takeDepthTrack(VideoRun& run, Messages& messages) {
    DepthOptions& options = run.job.depth;
    VideoJob& job = run.job;
    if (!options.isDefault || options.isFlat || options.stereo || job.fromQuilt) return;
    const auto track = findDepthTrack(job.input, job.part, run.inputFacts);
    if (!track) return;
    const std::string asGiven = "--depth " + shellWord(job.input.string());
    if (job.isFromFolder || !track->fits)
        return messages.warn(
            std::string("the depth in the file is not used, ") +
            (job.isFromFolder ? "because the videos of a folder are made alike" : kMisfitText) +
            "; " + asGiven + " uses it");
    options.fromFiles = true;
    options.given = "depth in the video";
    options.kind = track->kind();
    run.job.depthOptions.every = 1;
    job.depthInput = job.input;
    messages.warn("the depth in the file is used, " + track->text() + "; " + asGiven +
                  " --depth-kind says otherwise, -n altiro3d estimates it");
}

// Calls a function with some of the first frames of a file (0, 1, 2, 4, 8, ...), because one of
// them may be dark, or a title. Not called if the input cannot be read twice.
// @param look returns false when it has seen enough
void forEarlyFrames(const VideoJob& job, int lastFrame,
                    const std::function<bool(const cv::Mat&)>& look) {
    if (!isFile(job.input)) return;
    VideoReader reader(job.input, job.part);
    int wanted = 0;
    for (int number = 0; number <= lastFrame; ++number) {
        const auto frame = reader.next();
        if (!frame) break;
        if (number != wanted) continue;
        wanted = std::max(1, 2 * wanted);
        if (!look(frame->picture)) break;
    }
}

// Refuses a video whose name says that its frames hold photo and depth; warns if they do not.
void refuseRgbd(const VideoJob& job, Messages& messages) {
    constexpr int kLastFrame = 64;
    const std::optional<SceneName> name = parseSceneName(job.input);
    if (!name || name->contents != SceneName::Contents::Rgbd || !isFile(job.input)) return;
    bool areHalves = false;
    forEarlyFrames(job, kLastFrame, [&](const cv::Mat& frame) {
        areHalves = findDepthHalf(frame, name->isStacked).has_value();
        return !areHalves;
    });
    const std::string what = "holds photo and depth by its name (" + name->tag + ")";
    if (!areHalves)
        return messages.warn(job.inputName() + ": " + what +
                             ", but its frames do not: they are taken as ordinary ones");
    if (job.isFromFolder)
        throw NotTaken{{job.input, FileKind::HalvesVideo,
                        what + "; video2native --rgbd right makes a Native of it"}};
    throw UsageError(job.inputName() + ": " + what +
                     ", expected --rgbd with the side of the depth, as --rgbd right");
}

// Leaves a video of a folder out, or warns, if it seems to be a Native video. These carry no mark,
// but ordinary videos do not have both the size of a panel and 4:4:4 colour.
void refuseNativeVideo(const VideoJob& job, const VideoFacts& facts, const ChosenDisplay& display,
                       Messages& messages) {
    const bool fullColour = facts.pixelFormat.find("444") != std::string::npos ||
                            facts.pixelFormat.find("gbr") != std::string::npos;
    if (facts.size != display.panelSize() || !fullColour) return;
    const std::string like = "has the panel's size and 4:4:4 colour, like a Native video";
    if (job.isFromFolder) {
        throw NotTaken{
            {job.input, FileKind::NativeVideo, like + "; if it is none, it is converted alone"}};
    }
    messages.warn("the video " + like + "; do not convert a Native again");
}

// The eyes in frames, by the option or by what is found. Says what decided.
std::optional<StereoVideo> eyesOf(const VideoRun& run, Messages& messages) {
    const DepthOptions& options = run.job.depth;
    if (options.isFlat || !options.given.empty()) return std::nullopt;
    FoundEyes found;
    if (options.stereo) {
        found.eyes =
            StereoVideo{options.stereo->layout, halvesOf(run.job.input, options.stereo->halves)};
        found.eyes->halves = halvesAsShown(*found.eyes, run.inputFacts);
        found.evidence = "--stereo says it";
    } else {
        refuseVrName(run.job.input);
        found = findEyes(run.job.input, run.inputFacts, run.job.part);
        messages.warn(found.notes);
    }
    if (!found.eyes) return std::nullopt;
    const bool isBeside = found.eyes->layout == StereoLayout::LeftRight ||
                          found.eyes->layout == StereoLayout::RightLeft;
    messages.say(std::string("both eyes: ") + (isBeside ? "beside" : "above") + " each other, as " +
                 found.evidence);
    return found.eyes;
}

// What is found in the first frames of a video of quilts.
std::optional<FoundQuilt> searchFrames(const VideoJob& job, int lastFrame) {
    std::optional<FoundQuilt> best;
    forEarlyFrames(job, lastFrame, [&best](const cv::Mat& frame) {
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

// Refuses a video of a folder that is a video of quilts without its name saying so; warns if it
// may be one.
void refuseQuiltVideo(const VideoJob& job, Messages& messages) {
    constexpr int kLastFrame = 4;
    const std::optional<FoundQuilt> found = searchFrames(job, kLastFrame);
    if (!found || found->confidence <= 0) return;
    const std::string text = "a video of quilts of " + std::to_string(found->layout.columns) +
                             " columns x " + std::to_string(found->layout.rows) + " rows";
    if (found->verdict == QuiltVerdict::Quilt) {
        throw NotTaken{
            {job.input, FileKind::QuiltVideo,
             "is " + text + "; quilt2native makes a Native of it if it is named itself"}};
    }
    if (found->verdict == QuiltVerdict::Unsure)
        messages.warnOfSubject("may be " + text +
                               "; if it is one, quilt2native -q makes its Native");
}

// Checks the names before any work, see Outputs::check().
void checkOutputs(VideoRun& run) {
    VideoJob& job = run.job;
    if (job.isChecked) return;
    if (job.resume && !job.canReadAgain)
        throw UsageError("--resume reads the input again, expected a file, not " + job.inputName());
    // The interrupted run may have left these files; without any, --resume starts a new run.
    const bool goesOn = job.resume && !job.show && isVideoUnfinished(job.output);
    Outputs outputs(job.replace || goesOn);
    if (job.resume && !goesOn)
        outputs.explainExisting(job.output,
                                "and no unfinished run of it is kept, so it may be complete");
    outputs.addInputs(run.display.files);
    outputs.addInputs({job.depth.network, job.depth.profile, job.input, job.depthInput});
    if (!job.show) outputs.addResult(job.output);
    outputs.addOutputs({job.native, job.report});
    outputs.check();
    job.isChecked = true;
}

// The path from frames with depth to Natives.
// @param seenAspect width : height of the scene as it is shown
void choosePath(VideoRun& run, double seenAspect, Messages& messages) {
    run.path = "quilt";
    if (run.job.product == VideoProduct::Rgbd || run.job.product == VideoProduct::Stereo) return;
    tellCut(seenAspect, run.display.aspect(), run.job.scene.recipe, messages);
    if (run.job.product == VideoProduct::Quilt) return;
    const NativeMaker maker =
        makeNativeMaker(run.job.scene, run.display, run.layout, messages, run.job.profile.keep);
    run.path = pathName(maker);
    run.job.scene.recipe.positions = maker.options().positions;
}

void takeDepth(VideoRun& run, const std::optional<RgbdLayout>& rgbd, VideoConversion& conversion) {
    if (!run.depth) return;
    const DepthOptions& options = run.job.depth;
    if (options.given.empty()) {
        // shares the network with the run; frames bring no depth
        conversion.depth = storedDepthOr(run.depth->source(), {false, false});
        return;
    }
    GivenVideoDepth& given = conversion.given.emplace();
    if (options.fromFiles) given.source = run.job.depthInput;
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
        return !reader.next() || !reader.next(); // several pictures one after the other are a video
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
    : VideoRun(of, findDisplay(of.display, messages, {}, displayUse(of))) {}

void openDepth(VideoRun& run, Messages& messages) {
    if (!run.depth && !run.job.fromQuilt) run.depth.emplace(run.job.depth, messages);
}

QuiltLayout layoutOfViews(const VideoRun& run, Messages& messages) {
    QuiltLayout layout = chooseQuilt(run.job.quilt, run.display, messages);
    if (run.job.product == VideoProduct::Quilt && !run.job.quilt.tileSize && !run.display.map) {
        cv::Size& tile = layout.tileSize; // 4:2:0 has even sides only
        tile = {std::max(2, tile.width / 2 * 2), std::max(2, tile.height / 2 * 2)};
    }
    return layout;
}

VideoConversion openVideo(VideoRun& run, Messages& messages) {
    VideoJob& job = run.job;
    Recipe& recipe = job.scene.recipe;
    VideoConversion conversion;
    job.part.threads = std::min(cv::getNumThreads(), 16);
    job.part.bothEyes = !job.fromQuilt && !job.depth.isFlat && job.depth.given.empty();
    job.part.joinsVideos = job.depth.areVideos;
    // FFmpeg's error would not say so
    if (mayBePicture(job) && isHeifPicture(job.input)) refusePicture(job);
    conversion.reader = std::make_unique<VideoReader>(job.input, job.part);
    const VideoFacts& facts = conversion.reader->facts();
    run.inputFacts = facts;
    if (mayBePicture(job) && isPicture(job.input, facts)) refusePicture(job);
    messages.say((messages.hasSubject() ? "" : job.inputName() + ": ") + factsText(facts));
    takeDepthTrack(run, messages);
    if (!job.fromQuilt) {
        warnIfQuilt(job.input, "--from-quilt", messages);
        if (job.depth.given.empty()) refuseRgbd(job, messages);
    }
    if (job.product == VideoProduct::Native) refuseNativeVideo(job, facts, run.display, messages);
    std::optional<RgbdLayout> rgbd;
    std::optional<FoundQuilt> found;
    if (!job.fromQuilt) conversion.stereo = eyesOf(run, messages);
    if (job.fromQuilt && !isLayoutStated(job.quilt, job.input)) {
        if (!isFile(job.input) && !run.display.map)
            throw UsageError(job.inputName() +
                             ": its quilts cannot be searched for their layout, as it is read only "
                             "once; expected -q ROWSxCOLUMNS");
        found = searchFrames(job, 64);
    }
    if (job.isFromFolder && !job.fromQuilt && !job.depth.rgbd && !conversion.stereo)
        refuseQuiltVideo(job, messages);
    run.layout = job.fromQuilt
                     ? chooseQuilt(job.quilt, run.display, messages, job.input, facts.size, found)
                     : layoutOfViews(run, messages);
    if (job.product == VideoProduct::Quilt && !isStandardStream(job.output))
        job.output = quiltFileName(job.output, run.layout, run.display.aspect());
    checkOutputs(run);
    if (job.fromQuilt) {
        const QuiltShape shape(job.input, run.layout, run.display, job.fit);
        messages.say("quilt: " + quiltText(run.layout, shape.shownAspect()) +
                     (found ? foundText(*found) : ""));
        tellShape(shape, messages);
        recipe.fit = shape.fit();
        conversion.viewAspect = shape.aspect();
    } else {
        if (job.product == VideoProduct::Native)
            messages.say("quilt: " + quiltText(run.layout, run.display.aspect()));
        const bool isStereo = job.product == VideoProduct::Stereo;
        VideoEyes& eyes = conversion.eyes;
        eyes.picture = job.eyes.picture;
        eyes.from = job.eyes.from;
        eyes.swapped = job.eyes.swapped;
        eyes.filmed = isStereo && conversion.stereo && job.keepsEyes;
        if (isStereo) {
            tellEyesTag(job.output, job.eyes, messages);
            recipe.views.strengthPercent = job.eyes.strengthPercent;
            recipe.choices.strength = false;
            recipe.positions = ViewPositions::Discrete;
        }
        if (eyes.filmed) {
            messages.say("both pictures stay as they were filmed");
        } else {
            if (conversion.stereo)
                messages.say("depth: by matching both eyes, and estimated where they do not match");
            openDepth(run, messages);
        }
        if (job.depth.rgbd)
            rgbd = rgbdOf(job.input, *job.depth.rgbd,
                          facts.sampleAspect.value() * aspectOf(facts.size), messages);
        cv::Size photo = rgbd ? rgbd->photoSize(facts.size) : facts.size;
        if (conversion.stereo) photo = photoSize(*conversion.stereo, facts.size);
        choosePath(run, facts.sampleAspect.value() * aspectOf(photo), messages);
    }
    if (job.product == VideoProduct::Native && job.encoding.compatible)
        messages.warn("--compat halves the colour resolution (4:2:0): in a Native neighbouring "
                      "sub-pixels belong to different views, so views are mixed and depth blurs; "
                      "use it only for players that refuse the usual file");
    const EyesPicture picture = job.eyes.picture;
    const bool isMixed = picture == EyesPicture::Rows || isAnaglyph(picture);
    if (job.product == VideoProduct::Stereo && isMixed && job.encoding.compatible)
        messages.warn("--compat halves the colour resolution (4:2:0), which mixes the eyes of " +
                      std::string(nameOf(picture).words) + ": each sees a trace of the other");
    if (job.product == VideoProduct::Native && job.encoding.codec == VideoCodec::H264 &&
        job.encoding.crf >= 1 && !job.isMaxRateGiven)
        job.encoding.maxRate = job.profile.bitsPerPixel == 0
                                   ? 0
                                   : std::max(1.0, std::round(1e-6 * job.profile.bitsPerPixel *
                                                              run.display.panelSize().area()));
    job.encoding.threads = cv::getNumThreads();

    conversion.input = job.input;
    conversion.part = job.part;
    conversion.output = job.output;
    conversion.product = job.product;
    conversion.rgbdHalves = savedRgbdLayout(job.output).halves;
    conversion.display = run.display;
    conversion.map = run.display.map;
    conversion.layout = run.layout;
    conversion.recipe = recipe;
    conversion.fromQuilt = job.fromQuilt;
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
