#include "video/video_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/json_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// Measured: docs/tradeoff.md, docs/performance.md.
const std::array<VideoProfile, 3> kProfiles = {{
    {"live", ViewMethod::Fast, false, 0, EncoderPreset::UltraFast, 20, 0},
    {"balanced", ViewMethod::Layered, false, 0, EncoderPreset::SuperFast, 16, 50},
    {"best", ViewMethod::Layered, true, 1, EncoderPreset::Medium, 12, 50},
}};

constexpr std::pair<const char*, std::size_t> kProfileNames[] = {
    {"live", 0}, {"balanced", 1}, {"best", 2}};
constexpr std::pair<const char*, VideoCodec> kCodecs[] = {{"h264", VideoCodec::H264},
                                                          {"hevc", VideoCodec::Hevc},
                                                          {"h264rgb", VideoCodec::H264Rgb},
                                                          {"ffv1", VideoCodec::Ffv1},
                                                          {"prores", VideoCodec::ProRes}};

// Seconds as "90", "1:30" or "0:01:30.5".
std::optional<double> readSeconds(const std::string& text) {
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
    return std::nullopt;
}

std::optional<DepthRange> readRange(const std::string& text) {
    DepthRange range;
    char rest = 0;
    const bool isRead = std::sscanf(text.c_str(), "%lf:%lf%c", &range.low, &range.high, &rest) == 2;
    const bool isRange = range.low >= 0 && range.high > range.low && range.high <= 65535;
    return isRead && isRange ? std::optional(range) : std::nullopt;
}

// The part of the input, and how it is opened.
VideoReaderOptions readerOptions(const CommandLine& commandLine) {
    constexpr const char* kExpected = "seconds, as 12.5, or [h:]mm:ss";
    VideoReaderOptions options;
    std::optional<double> to;
    std::optional<double> preview;
    std::string list;
    commandLine.exclude("to", "preview");
    commandLine.take({{"from", options.from, readSeconds, kExpected},
                      {"to", to, readSeconds, kExpected},
                      {"preview", preview, readSeconds, kExpected},
                      {"input-format", options.format},
                      {"no-deinterlace", options.deinterlace, false},
                      {"input-options", list}});
    if (to && *to <= options.from)
        throw UsageError("--to is " + *commandLine.value("to") + ", expected a time after --from");
    if (preview && *preview <= 0) commandLine.failValue("preview", "more than 0");
    options.to = to ? *to : preview ? options.from + *preview : options.to;
    for (std::size_t at = 0; !list.empty() && at <= list.size();) {
        const std::size_t comma = std::min(list.find(',', at), list.size());
        const std::string entry = list.substr(at, comma - at);
        const std::size_t equals = entry.find('=');
        if (equals == 0 || equals == std::string::npos)
            throw UsageError("--input-options has \"" + entry + "\", expected name=value");
        options.formatOptions.emplace_back(entry.substr(0, equals), entry.substr(equals + 1));
        at = comma + 1;
    }
    return options;
}

void requireRate(const CommandLine& commandLine, const VideoWriterOptions& options) {
    if (options.maxRate == 0) return;
    if (options.maxRate < 1)
        throw UsageError("--max-rate is " + *commandLine.value("max-rate") +
                         ", expected 0 or 1..100000");
    if (options.codec == VideoCodec::Hevc)
        throw UsageError("--max-rate goes with --codec h264 or h264rgb, not with hevc");
    if (options.crf < 1)
        throw UsageError("--max-rate goes with --crf 1 or more, which need not be lossless");
}

// How frames are encoded; the video sets size and times, and its size the default of maxRate.
VideoWriterOptions encoderOptions(const CommandLine& commandLine, const VideoProfile& profile) {
    VideoWriterOptions options;
    options.crf = profile.crf;
    options.preset = profile.preset;
    std::string codec;
    commandLine.take(
        {{"codec", options.codec, kCodecs}, {"codec", codec}, {"compat", options.compatible}});
    if (options.codec == VideoCodec::Ffv1 || options.codec == VideoCodec::ProRes)
        commandLine.refuse({"crf", "preset", "max-rate"},
                           " does not apply to --codec " + codec + "; leave it out");
    if (options.compatible && options.codec != VideoCodec::H264 &&
        options.codec != VideoCodec::Hevc)
        throw UsageError("--compat goes with --codec h264 or hevc, not with " + codec);
    commandLine.take({{"crf", options.crf, 0, 51}, {"max-rate", options.maxRate, 0, 100000}});
    requireRate(commandLine, options);
    std::vector<std::string> presets;
    for (int i = 0; i <= static_cast<int>(EncoderPreset::VerySlow); ++i)
        presets.emplace_back(presetName(static_cast<EncoderPreset>(i)));
    if (const auto preset = commandLine.choice("preset", presets))
        options.preset = static_cast<EncoderPreset>(*preset);
    commandLine.take(
        {{"no-audio", options.audio, false}, {"no-subtitles", options.subtitles, false}});
    return options;
}

// The names of inputs and outputs, and what kind of files these are.
VideoJob jobOfNames(const CommandLine& commandLine, bool isFolder) {
    const std::vector<fs::path>& names = commandLine.files();
    VideoJob job;
    job.isFolder = isFolder;
    bool pair = false;
    fs::path stereo;
    commandLine.take({{"d", pair}, {"show", job.show}, {"stereo-out", stereo}});
    const std::size_t expected = (pair ? 3 : 2) - (job.show ? 1 : 0);
    const bool isStereoAlone = !stereo.empty() && names.size() + 1 == expected;
    if (names.size() != expected && !isStereoAlone) {
        const std::string in = pair ? "IN DEPTH" : "IN";
        commandLine.failNames(job.show ? in : in + (pair ? " OUT" : " and OUT"), expected);
    }
    job.input = names.front();
    if (!job.show && !isStereoAlone) job.output = names.back();
    if (pair) job.depthInput = names[1];
    commandLine.exclude("quilt-out", "rgbd-out");
    commandLine.take({{"depth", job.depthInput},
                      {"report", job.report},
                      {"stereo-out", job.product, VideoProduct::Stereo},
                      {"quilt-out", job.product, VideoProduct::Quilt},
                      {"rgbd-out", job.product, VideoProduct::Rgbd},
                      {"from-quilt", job.fromQuilt}});
    if (!stereo.empty()) {
        commandLine.exclude("stereo-out", {"quilt-out", "rgbd-out", "from-quilt", "show"});
        if (isFolder) commandLine.refuse({"stereo-out"}, " names one video, expected one as input");
        job.native = job.output;
        if (!job.native.empty()) {
            commandLine.refuse({"plan", "resume", "report"},
                               " is for one video, expected --stereo-out without OUT");
            if (!isFile(job.input))
                throw UsageError(job.inputName() +
                                 ": is read twice for --stereo-out and OUT, expected a file, or "
                                 "one of them");
        }
        job.output = stereo;
    }
    commandLine.exclude("from-quilt", {"quilt-out", "rgbd-out", "d", "depth", "rgbd", "n", "l",
                                       "net-profile", "network-size", "depth-every"});
    commandLine.exclude("from-quilt", {"k", "g", "method", "continuous", "strength", "focus",
                                       "stereo", "depth-curve"});
    commandLine.exclude("from-quilt", {"fill", "borders", "refine", "inpaint-from", "exact-depth",
                                       "stereo-layout", "stereo-keep", "stereo-swap"});
    job.part = readerOptions(commandLine);
    if (job.show) {
        commandLine.exclude("show", {"quilt-out", "rgbd-out", "resume", "codec", "crf", "preset",
                                     "max-rate", "compat", "progress"});
        return job;
    }
    const bool isStream = isStandardStream(job.output);
    if (isStream) {
        requireNoTerminal(job.output);
        const std::string why =
            ", but standard output is written once, expected the name of a file";
        commandLine.refuse({"resume"}, " continues a file" + why);
        commandLine.refuse({"plan"}, " joins chunks" + why);
        commandLine.refuse({"progress"}, " writes to standard output, expected the name of a file "
                                         "for the video");
    }
    if (isFolder) {
        if (isStream) throw UsageError("- stands for one video, expected a directory for several");
        return job;
    }
    if (!isStream) requireVideoName(job.output);
    if (!job.native.empty()) requireVideoName(job.native);
    job.canReadAgain = !isStream && isFile(job.input);
    return job;
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
        "Limit of the bit rate of h264 and h264rgb in Mbit/s, as a mean over some seconds; 0: no "
        "limit. Default: 50 per megapixel of the panel for Natives of profile balanced and best, "
        "else no limit.",
        "MBITS");
    commandLine.addAdvanced({"compat"},
                            "4:2:0 for players that refuse 4:4:4 (h264, hevc). It mixes the "
                            "colours of neighbouring pixels and so the views of a Native.");
    commandLine.addAdvanced({"no-audio"}, "Leave the sound out.");
    commandLine.addAdvanced({"no-subtitles"}, "Leave the subtitles out.");
}

DisplayUse displayUse(const VideoJob& job) {
    if (job.product == VideoProduct::Native) return DisplayUse::Show;
    return job.product == VideoProduct::Quilt ? DisplayUse::Quilt : DisplayUse::None;
}

VideoJob videoJob(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool isFolder = names.size() == 2 && isDirectory(names.front());
    if (isFolder)
        commandLine.refuse({"show", "d", "depth"},
                           " applies to one video, expected a single video instead of a folder");
    return videoJob(commandLine, jobOfNames(commandLine, isFolder));
}

VideoJob videoJob(const CommandLine& commandLine, VideoJob job) {
    job.tool = commandLine.name();
    job.jsonProgress = wantsJsonProgress(commandLine);
    std::size_t profile = job.show ? 0 : 1;
    commandLine.take({{"y", job.replace},
                      {"resume", job.resume},
                      {"recursive", job.recursive},
                      {"preview", job.isPreview},
                      {"max-rate", job.isMaxRateGiven},
                      {"screen", job.screen},
                      {"profile", profile, kProfileNames},
                      {"strength", job.keepsEyes, false},
                      {"focus", job.keepsEyes, false},
                      {"depth-curve", job.keepsEyes, false},
                      {"stereo-keep", job.keepsEyes, false},
                      {"method", job.keepsEyes, false}});
    job.profile = kProfiles[profile];
    job.scene = sceneOptions(commandLine, AutoUse::Named, job.profile.method);
    NativeOptions& native = job.scene.recipe;
    commandLine.take({{"fit", job.fit, native.fit}});
    const bool isRgbd = job.product == VideoProduct::Rgbd;
    if ((native.framing != Framing() || job.scene.recipe.choices.any()) &&
        (job.fromQuilt || isRgbd))
        throw UsageError(
            std::string(
                "--center, --zoom and auto apply to views that are made of frames, expected no ") +
            (job.fromQuilt ? "--from-quilt" : "--rgbd-out") + " with them");
    if (!job.fromQuilt) job.eyes = eyesOptions(commandLine, "stereo-out");
    if (isRgbd)
        commandLine.refuse({"depth-curve"}, " is for views, but --rgbd-out writes depth as it is");
    if (job.product == VideoProduct::Stereo)
        commandLine.refuse({"center", "zoom", "fit"},
                           " chooses a part for a panel, but eyes see whole frames; leave it out");
    if (job.profile.keep) native.detail = Detail::Panel;
    if (job.product != VideoProduct::Native) native.positions = ViewPositions::Discrete;
    job.display = displayOptions(commandLine);
    job.bridge = bridgeJob(commandLine);
    if (job.bridge &&
        ((job.product != VideoProduct::Quilt && !isRgbd) || isStandardStream(job.output)))
        throw UsageError("--bridge shows a quilt or RGB-D video, expected --quilt-out or "
                         "--rgbd-out with a file or a folder as OUT");
    job.quilt = quiltRequest(commandLine);
    job.encoding = encoderOptions(commandLine, job.profile);
    job.given = commandLine.given();
    job.settings = settingsOf(job.given);
    if (job.fromQuilt) return job;
    job.depth = depthOptions(commandLine, Medium::Video);
    if (!job.depth.fromFiles)
        commandLine.refuse({"depth-range"}, " goes with --depth, expected a depth video or images");
    const bool isGiven = !job.depth.given.empty();
    job.depthOptions.every = isGiven ? 1 : job.profile.depthEvery;
    std::string every;
    commandLine.take(
        {{"depth-range", job.depthRange, readRange, "two numbers of 0..65535, as 0:4095"},
         {"depth-every", every}});
    if (every == "auto") job.depthOptions.every = 0;
    if (every != "auto") commandLine.take({{"depth-every", job.depthOptions.every, 1, 1000}});
    if (isGiven)
        commandLine.refuse({"depth-every"}, " says how often depth is estimated, but here "
                                            "it is given; leave it out");
    return job;
}

} // namespace altiro3D::tools
