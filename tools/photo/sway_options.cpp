#include "photo/sway_options.hpp"
#include "cli/json_text.hpp"

#include <QRegularExpression>
#include <cmath>

namespace altiro3D::tools {

namespace {

constexpr int kMinSide = 16;
constexpr int kMaxSide = 16384;

} // namespace

void addSwayOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"seconds"},
        "Time of one turn, from the middle to the right, to the left and back, 0.1..600 "
        "(default 4); rounded to a multiple of 4 frames.",
        "S");
    commandLine.addAdvanced(
        {"turns"}, "Turns in the video, 1..1000 (default 2). It loops without a seam.", "N");
    commandLine.addAdvanced({"fps"}, "Frames per second, 1..240 (default 30).", "RATE");
    commandLine.addAdvanced({"size"},
                            "Size of the video in px, width x height (-r is height x width), both "
                            "even (default: the size of the picture, reduced to at most 1920 px "
                            "on the longer and 1080 px on the shorter side).",
                            "WxH");
}

void addSwayFileOption(CommandLine& commandLine, const std::string& of) {
    commandLine.add({"lg", "looking"},
                    "Also write a video in which the camera swings through the views, to show the "
                    "depth on any screen. " +
                        of + " plays everywhere (H.264 4:2:0).",
                    "FILE.mp4");
}

void requireSwayFile(const CommandLine& commandLine) {
    if (commandLine.has("lg")) return;
    const auto has = [&](const char* option) { return commandLine.has(option); };
    if (has("seconds") || has("turns") || has("fps") || has("size"))
        throw UsageError("--seconds, --turns, --fps and --size describe the video of --lg, "
                         "expected --lg with them");
}

SwayOptions swayOptions(const CommandLine& commandLine) {
    SwayOptions options;
    options.secondsPerTurn =
        commandLine.number("seconds", 0.1, 600).value_or(options.secondsPerTurn);
    options.turns = commandLine.wholeNumber("turns", 1, 1000).value_or(options.turns);
    if (const auto rate = commandLine.number("fps", 1, 240)) {
        // whole, as film in television (24000/1001), or as it is written
        const double thousand = *rate * 1001 / 1000;
        if (*rate != std::round(*rate) && std::abs(thousand - std::round(thousand)) < 0.005) {
            options.frameRate = {static_cast<int>(std::lround(thousand)) * 1000, 1001};
        } else if (*rate == std::round(*rate)) {
            options.frameRate = {static_cast<int>(std::lround(*rate)), 1};
        } else {
            options.frameRate = {static_cast<int>(std::lround(*rate * 1000)), 1000};
        }
    }
    return options;
}

std::optional<cv::Size> swaySizeOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("size");
    if (!text) return std::nullopt;
    static const QRegularExpression kPair("\\A([0-9]{1,5})[xX]([0-9]{1,5})\\z");
    const QRegularExpressionMatch match = kPair.match(QString::fromStdString(*text));
    const cv::Size size(match.captured(1).toInt(), match.captured(2).toInt()); // 0 x 0: no match
    const auto good = [](int side) {
        return side >= kMinSide && side <= kMaxSide && side % 2 == 0;
    };
    if (!good(size.width) || !good(size.height)) {
        commandLine.failValue("size",
                              "WIDTHxHEIGHT, even numbers 16..16384, for instance 1920x1080");
    }
    // what fitting can do
    if (size.width > 100 * size.height || size.height > 100 * size.width) {
        commandLine.failValue("size", "a shape of 1:100..100:1");
    }
    return size;
}

std::string swayText(const SwayOptions& options, cv::Size size) {
    const int frames = framesPerTurn(options) * options.turns;
    return sizeText(size) + ", " + std::to_string(frames) + " frames, " +
           numberText(frames / options.frameRate.value(), 4) + " s";
}

void writeSwayFile(const std::filesystem::path& file, cv::Size size, const SwayOptions& options,
                   const SwayView& view) {
    Progress progress(static_cast<std::size_t>(framesPerTurn(options)) *
                      static_cast<std::size_t>(options.turns));
    catchStop();
    const bool isMade = writeSway(file, size, options, view, [&](const VideoProgress&) {
        progress.step(file.filename().string());
        return !isStopWanted();
    });
    progress.clear();
    if (!isMade) endIfStopWanted();
}

cv::Size writeQuiltSwayFile(const std::filesystem::path& file, const cv::Mat& quilt,
                            const QuiltLayout& layout, double aspect,
                            std::optional<cv::Size> wanted, FitMode fit, ViewFilter between,
                            const SwayOptions& options) {
    const cv::Size size = wanted.value_or(swaySize(layout.tileSize, aspect));
    writeSwayFile(file, size, options,
                  quiltViews(quilt, layout, swayFit(layout.tileSize, aspect, size, fit), between));
    return size;
}

} // namespace altiro3D::tools
