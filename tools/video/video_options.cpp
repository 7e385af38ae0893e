#include "video/video_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/json_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// Measured: docs/tradeoff.md, docs/performance.md.
const std::array<VideoProfile, 3> kProfiles = {{
    {"live", ViewMethod::Fast, false, 0, EncoderPreset::UltraFast, 20, 0},
    {"balanced", ViewMethod::Layered, false, 0, EncoderPreset::SuperFast, 16, 50},
    {"best", ViewMethod::Layered, true, 1, EncoderPreset::Medium, 12, 50},
}};

// Seconds as "90", "1:30" or "0:01:30.5".
std::optional<double> secondsOption(const CommandLine& commandLine, const std::string& option) {
    const auto given = commandLine.value(option);
    if (!given) return std::nullopt;
    const std::string& text = *given;
    double seconds = 0;
    const char* at = text.data();
    const char* const end = at + text.size();
    for (int part = 0; part < 3; ++part) {
        double value = 0;
        const auto parsed = std::from_chars(at, end, value, std::chars_format::fixed);
        const bool later = part > 0 && value >= 60;
        if (parsed.ec != std::errc() || !(value >= 0) || value > 1e8 || later) break;
        seconds = seconds * 60 + value;
        if (parsed.ptr == end) return seconds;
        if (*parsed.ptr != ':' || value != std::floor(value)) break;
        at = parsed.ptr + 1;
    }
    commandLine.failValue(option, "seconds, as 12.5, or [h:]mm:ss");
}

double maxRateOption(const CommandLine& commandLine, const VideoWriterOptions& options) {
    const double rate = commandLine.number("max-rate", 0, 100000).value_or(0);
    if (rate == 0) return 0;
    if (rate < 1) {
        throw UsageError("--max-rate is " + *commandLine.value("max-rate") +
                         ", expected 0 or 1..100000");
    }
    if (options.codec == VideoCodec::Hevc)
        throw UsageError("--max-rate goes with --codec h264 or h264rgb, not with hevc");
    if (options.crf < 1)
        throw UsageError("--max-rate goes with --crf 1 or more, which need not be lossless");
    return rate;
}

// Whether the input is a folder of videos.
bool takesFolder(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    return names.size() == 2 && isDirectory(names.front());
}

VideoPlan planVideo(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pair = commandLine.has("d");
    const bool show = commandLine.has("show");
    const auto stereo = commandLine.value("stereo-out");
    const std::size_t expected = (pair ? 3 : 2) - (show ? 1 : 0);
    const bool isStereoAlone = stereo && names.size() + 1 == expected;
    if (names.size() != expected && !isStereoAlone) {
        const std::string in = pair ? "IN DEPTH" : "IN";
        commandLine.failNames(show ? in : in + (pair ? " OUT" : " and OUT"), expected);
    }
    VideoPlan plan;
    plan.input = names.front();
    plan.show = show;
    if (!show && !isStereoAlone) plan.output = names.back();
    if (pair) plan.depth = names[1];
    if (const auto depth = commandLine.value("depth")) plan.depth = *depth;
    plan.report = commandLine.value("report").value_or("");
    commandLine.exclude("quilt-out", "rgbd-out");
    if (stereo) {
        commandLine.exclude("stereo-out", {"quilt-out", "rgbd-out", "from-quilt", "show"});
        if (takesFolder(commandLine))
            commandLine.refuse({"stereo-out"}, " names one video, expected one as input");
        plan.native = plan.output;
        if (!plan.native.empty()) {
            commandLine.refuse({"plan", "resume", "report"},
                               " is for one video, expected --stereo-out without OUT");
            if (!isFile(plan.input))
                throw UsageError(plan.inputName() +
                                 ": is read twice for --stereo-out and OUT, expected a file, or "
                                 "one of them");
        }
        plan.output = *stereo;
        plan.product = VideoProduct::Stereo;
    }
    if (commandLine.has("quilt-out")) plan.product = VideoProduct::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = VideoProduct::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        constexpr const char* kOfScenes[] = {"quilt-out",
                                             "rgbd-out",
                                             "d",
                                             "depth",
                                             "rgbd",
                                             "n",
                                             "l",
                                             "net-profile",
                                             "network-size",
                                             "depth-every",
                                             "k",
                                             "g",
                                             "method",
                                             "continuous",
                                             "strength",
                                             "focus",
                                             "stereo",
                                             "depth-curve",
                                             "fill",
                                             "borders",
                                             "refine",
                                             "inpaint-from",
                                             "exact-depth",
                                             "stereo-layout",
                                             "stereo-keep",
                                             "stereo-swap"};
        for (const char* other : kOfScenes)
            commandLine.exclude("from-quilt", other);
    }
    plan.part = videoReaderOptions(commandLine);
    if (show) {
        commandLine.exclude("show", {"quilt-out", "rgbd-out", "resume", "codec", "crf", "preset",
                                     "max-rate", "compat", "progress"});
        return plan;
    }
    const bool isStream = isStandardStream(plan.output);
    if (isStream) {
        requireNoTerminal(plan.output);
        const std::string why =
            ", but standard output is written once, expected the name of a file";
        commandLine.refuse({"resume"}, " continues a file" + why);
        commandLine.refuse({"plan"}, " joins chunks" + why);
        commandLine.refuse({"progress"}, " writes to standard output, expected the name of a file "
                                         "for the video");
    }
    if (takesFolder(commandLine)) {
        if (isStream) throw UsageError("- stands for one video, expected a directory for several");
        return plan;
    }
    if (!isStream) requireVideoName(plan.output);
    if (!plan.native.empty()) requireVideoName(plan.native);
    plan.isFile = !isStream && isFile(plan.input);
    return plan;
}

std::optional<DepthRange> depthRangeOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("depth-range");
    if (!text) return std::nullopt;
    if (!commandLine.has("depth") && !commandLine.has("d"))
        commandLine.refuse({"depth-range"}, " goes with --depth, expected a depth video or images");
    DepthRange range;
    char rest = 0;
    const bool isRead =
        std::sscanf(text->c_str(), "%lf:%lf%c", &range.low, &range.high, &rest) == 2;
    if (!isRead || !(range.low >= 0) || !(range.high > range.low) || !(range.high <= 65535))
        commandLine.failValue("depth-range", "two numbers of 0..65535, as 0:4095");
    return range;
}

RunSettings settingsOf(const std::vector<std::pair<std::string, std::string>>& given) {
    RunSettings settings;
    for (const auto& [option, value] : given) {
        // The last four are left out because their effect is compared, not their text.
        constexpr std::array<const char*, 14> kOthers = {
            "bridge", "serve",         "y", "v", "resume", "recursive", "progress", "report",
            "plan",   "chunk-seconds", "c", "m", "serial", "j"};
        if (std::find(kOthers.begin(), kOthers.end(), option) != kOthers.end()) continue;
        settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    return settings;
}

} // namespace

const VideoProfile& standardVideoProfile() {
    return kProfiles[1];
}

void addProfileOption(CommandLine& commandLine) {
    commandLine.add(
        {"profile"},
        "balanced (default): method layered, depth as often as the picture needs it, --preset "
        "superfast --crf 16; live: method fast, --preset ultrafast --crf 20; best: layered with "
        "-k --continuous, --depth-every 1, --preset medium --crf 12. Other options override it.",
        "live|balanced|best");
}

VideoProfile videoProfile(const CommandLine& commandLine, bool show) {
    return kProfiles[commandLine.choice("profile", {"live", "balanced", "best"})
                         .value_or(show ? 0 : 1)];
}

void addVideoInputOptions(CommandLine& commandLine) {
    commandLine.add({"from"}, "Begin at this time: seconds, or [h:]mm:ss.", "TIME");
    commandLine.add({"to"}, "End at this time.", "TIME");
    commandLine.add({"preview"}, "Make only the first SECONDS seconds.", "SECONDS");
    commandLine.addAdvanced({"input-format"},
                            "FFmpeg's name of the format or device of IN, if it is not detected "
                            "(v4l2, x11grab, lavfi).",
                            "NAME");
    commandLine.addAdvanced({"input-options"},
                            "Settings of that format, such as video_size=1280x720,framerate=30.",
                            "LIST");
    commandLine.addAdvanced({"no-deinterlace"}, "Leave interlaced frames as they are.");
}

VideoReaderOptions videoReaderOptions(const CommandLine& commandLine) {
    VideoReaderOptions options;
    options.from = secondsOption(commandLine, "from").value_or(options.from);
    commandLine.exclude("to", "preview");
    if (const auto to = secondsOption(commandLine, "to")) {
        options.to = *to;
        if (*to <= options.from)
            throw UsageError("--to is " + *commandLine.value("to") +
                             ", expected a time after --from");
    }
    if (const auto preview = secondsOption(commandLine, "preview")) {
        if (*preview <= 0) commandLine.failValue("preview", "more than 0");
        options.to = options.from + *preview;
    }
    options.format = commandLine.value("input-format").value_or("");
    options.deinterlace = !commandLine.has("no-deinterlace");
    if (const auto list = commandLine.value("input-options")) {
        for (std::size_t at = 0; at <= list->size();) {
            const std::size_t comma = std::min(list->find(',', at), list->size());
            const std::string entry = list->substr(at, comma - at);
            const std::size_t equals = entry.find('=');
            if (equals == 0 || equals == std::string::npos) {
                throw UsageError("--input-options has \"" + entry + "\", expected name=value");
            }
            options.formatOptions.emplace_back(entry.substr(0, equals), entry.substr(equals + 1));
            at = comma + 1;
        }
    }
    return options;
}

void addEncoderOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"codec"}, "h264 (default), hevc, h264rgb, ffv1 (lossless, .mkv) or prores (.mov, .mkv).",
        "h264|hevc|h264rgb|ffv1|prores");
    commandLine.addAdvanced({"crf"}, "Quality of h264, hevc, h264rgb, 0..51; less is better.",
                            "NUMBER");
    commandLine.addAdvanced({"preset"},
                            "Effort of h264, hevc, h264rgb: a slower preset makes smaller files.",
                            "ultrafast|superfast|veryfast|faster|fast|medium|slow|slower|veryslow");
    commandLine.addAdvanced(
        {"max-rate"},
        "Most megabits per second of h264, h264rgb, as a mean of some seconds; 0: any. Default: 50 "
        "per megapixel of the panel for Natives of profile balanced and best, else any.",
        "MBITS");
    commandLine.addAdvanced({"compat"},
                            "4:2:0 for players that refuse 4:4:4 (h264, hevc). It mixes the "
                            "colours of neighbouring pixels and so the views of a Native.");
    commandLine.addAdvanced({"no-audio"}, "Leave the sound out.");
    commandLine.addAdvanced({"no-subtitles"}, "Leave the subtitles out.");
}

VideoWriterOptions encoderOptions(const CommandLine& commandLine, const VideoProfile& profile) {
    VideoWriterOptions options;
    options.codec = commandLine
                        .oneOf<VideoCodec>("codec", {{"h264", VideoCodec::H264},
                                                     {"hevc", VideoCodec::Hevc},
                                                     {"h264rgb", VideoCodec::H264Rgb},
                                                     {"ffv1", VideoCodec::Ffv1},
                                                     {"prores", VideoCodec::ProRes}})
                        .value_or(VideoCodec::H264);
    if (options.codec == VideoCodec::Ffv1 || options.codec == VideoCodec::ProRes) {
        commandLine.refuse({"crf", "preset", "max-rate"},
                           " does not apply to --codec " + commandLine.value("codec").value_or("") +
                               "; leave it out");
    }
    options.compatible = commandLine.has("compat");
    if (options.compatible && options.codec != VideoCodec::H264 &&
        options.codec != VideoCodec::Hevc) {
        throw UsageError("--compat goes with --codec h264 or hevc, not with " +
                         *commandLine.value("codec"));
    }
    options.crf = commandLine.number("crf", 0, 51).value_or(profile.crf);
    options.maxRate = maxRateOption(commandLine, options);
    std::vector<std::string> presets;
    for (int i = 0; i <= static_cast<int>(EncoderPreset::VerySlow); ++i)
        presets.emplace_back(presetName(static_cast<EncoderPreset>(i)));
    const auto preset = commandLine.choice("preset", presets);
    options.preset = preset ? static_cast<EncoderPreset>(*preset) : profile.preset;
    options.audio = !commandLine.has("no-audio");
    options.subtitles = !commandLine.has("no-subtitles");
    return options;
}

double defaultMaxRate(const VideoProfile& profile, cv::Size panel) {
    if (profile.bitsPerPixel == 0) return 0;
    return std::max(1.0, std::round(1e-6 * profile.bitsPerPixel * panel.area()));
}

bool isHeifPicture(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string start(12, '\0');
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    if (!stream || start.compare(4, 4, "ftyp") != 0) return false;
    const std::set<std::string> brands = {"heic", "heix", "heim", "heis", "mif1", "mif2", "avif"};
    return brands.count(start.substr(8)) > 0;
}

bool isPicture(const std::filesystem::path& file, const VideoFacts& facts) {
    if (isHeifPicture(file)) return true;
    const std::string& format = facts.format;
    const std::string ending = "_pipe";
    const bool mayBe = format == "image2" ||
                       (format.size() > ending.size() &&
                        format.compare(format.size() - ending.size(), ending.size(), ending) == 0);
    if (!mayBe) return false;
    try {
        VideoReader reader(file);
        return !reader.next() || !reader.next(); // pictures may also stand one after the other
    } catch (const Error&) {
        return true; // a broken one
    }
}

VideoJob videoJob(const CommandLine& commandLine) {
    const bool isFolder = takesFolder(commandLine);
    if (isFolder)
        commandLine.refuse({"show", "d", "depth"},
                           " applies to one video, expected a single video instead of a folder");
    VideoJob job = videoJob(commandLine, planVideo(commandLine));
    job.isFolder = isFolder;
    return job;
}

VideoJob videoJob(const CommandLine& commandLine, const VideoPlan& plan) {
    VideoJob job;
    job.plan = plan;
    job.tool = commandLine.name();
    job.replace = commandLine.has("y");
    job.resume = commandLine.has("resume");
    job.recursive = commandLine.has("recursive");
    job.jsonProgress = wantsJsonProgress(commandLine);
    job.isPreview = commandLine.has("preview");
    job.isMaxRateGiven = commandLine.has("max-rate");
    job.profile = videoProfile(commandLine, plan.show);
    job.scene = sceneOptions(commandLine, AutoUse::Named, job.profile.method);
    NativeOptions& native = job.scene.recipe;
    if ((native.framing != Framing() || job.scene.recipe.choices.any()) &&
        (plan.fromQuilt || plan.product == VideoProduct::Rgbd)) {
        throw UsageError(
            std::string(
                "--center, --zoom and auto apply to views that are made of frames, expected no ") +
            (plan.fromQuilt ? "--from-quilt" : "--rgbd-out") + " with them");
    }
    if (!plan.fromQuilt) job.eyes = eyesOptions(commandLine, "stereo-out");
    if (job.eyes.areFiles)
        commandLine.failValue("stereo-layout", "a layout of one video; files is for pictures");
    for (const char* other : {"strength", "focus", "depth-curve", "stereo-keep", "method"})
        job.keepsEyes = job.keepsEyes && !commandLine.has(other);
    if (plan.product == VideoProduct::Rgbd)
        commandLine.refuse({"depth-curve"}, " is for views, but --rgbd-out writes depth as it is");
    if (plan.product == VideoProduct::Stereo) {
        commandLine.refuse({"center", "zoom", "fit"},
                           " chooses a part for a panel, but eyes see whole frames; leave it out");
    }
    if (job.profile.keep) native.detail = Detail::Panel;
    if (plan.product != VideoProduct::Native) native.positions = ViewPositions::Discrete;
    if (commandLine.has("fit")) job.fit = native.fit;
    job.display = displayOptions(commandLine);
    job.screen = commandLine.value("screen").value_or("");
    job.bridge = bridgeJob(commandLine);
    const bool isForBridge =
        plan.product == VideoProduct::Quilt || plan.product == VideoProduct::Rgbd;
    if (job.bridge && (!isForBridge || job.isFolder || isStandardStream(plan.output)))
        throw UsageError("--bridge shows a quilt or RGB-D video, expected --quilt-out or "
                         "--rgbd-out with one file as OUT");
    job.quilt = quiltRequest(commandLine);
    job.encoding = encoderOptions(commandLine, job.profile);
    if (!plan.fromQuilt) {
        job.depth = depthOptions(commandLine, Medium::Video);
        job.depthRange = depthRangeOption(commandLine);
        const auto every = commandLine.value("depth-every");
        const bool isGiven = !job.depth.given.empty();
        job.depthOptions.every = isGiven ? 1 : job.profile.depthEvery;
        if (every) {
            job.depthOptions.every =
                *every == "auto" ? 0 : *commandLine.wholeNumber("depth-every", 1, 1000);
            if (isGiven)
                commandLine.refuse({"depth-every"}, " says how often depth is estimated, but here "
                                                    "it is given; leave it out");
        }
    }
    job.given = commandLine.given();
    job.settings = settingsOf(job.given);
    return job;
}

void checkOutputs(const VideoJob& job, const VideoPlan& plan, const ChosenDisplay& display) {
    if (plan.isChecked) return;
    if (job.resume && !plan.isFile) {
        throw UsageError("--resume reads the input again, expected a file, not " +
                         plan.inputName());
    }
    // The interrupted run may have left these files; without any, --resume starts a new run.
    const bool goesOn = job.resume && !plan.show && isVideoUnfinished(plan.output);
    Outputs outputs(job.replace || goesOn);
    if (job.resume && !goesOn)
        outputs.explainExisting(plan.output,
                                "and no unfinished run of it is kept, so it may be complete");
    outputs.addInputs(display.files);
    outputs.addInputs({job.depth.network, job.depth.profile});
    outputs.addInputs({plan.input, plan.depth});
    if (!plan.show) outputs.addResult(plan.output);
    outputs.addOutputs({plan.native});
    outputs.addOutputs({plan.report});
    outputs.check();
}

} // namespace altiro3D::tools
