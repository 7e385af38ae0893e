#include "common/native_options.hpp"

#include "common/picture_options.hpp"

namespace altiro3D::tools {

namespace {

// The option that requests continuous positions; empty if none does.
std::string continuousOption(const CommandLine& commandLine) {
    for (const char* option : {"continuous", "best"}) {
        if (commandLine.has(option)) return std::string("--") + option;
    }
    return {};
}

std::string sizeKey(cv::Size size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
}

// Without what NativeOptions::showAs() sets.
NativeOptions plain(NativeOptions options) {
    options.detail = Detail::View;
    options.lensFilter = false;
    options.positions = ViewPositions::Discrete;
    return options;
}

bool isContinuous(const NativeOptions& options) {
    return options.positions == ViewPositions::Continuous;
}

} // namespace

void addNativeOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"continuous"},
        "Compute each sub-pixel for the exact direction in which its lens sends it, not for the "
        "nearest view. Not with -g, -m, --view-filter and --sampling.");
    commandLine.add({"best"}, "Make the best picture; takes several times as long.");
}

void addQuickOption(CommandLine& commandLine) {
    commandLine.add({"quick"},
                    "Make views of a quilt's size, each px as it is: detail that the lenses cannot "
                    "show becomes coloured noise. So do --method, -k, --continuous, --sampling, "
                    "--view-filter, --budget and -m.");
}

void checkNativeOptions(const CommandLine& commandLine) {
    const std::string option = continuousOption(commandLine);
    if (option.empty()) return;
    if (commandLine.has("m")) {
        throw UsageError(
            option + " needs the exact directions of the lenses, but a map (-m) has whole views "
                     "only; expected -c instead of -m");
    }
    if (viewOptions(commandLine).method == ViewMethod::Real) {
        throw UsageError(option + " reads single sub-pixels, but method real makes whole views "
                                  "only; expected --method layered or fast with it");
    }
    if (blends(samplingOption(commandLine))) {
        throw UsageError(option + " needs no blending: --view-filter and --sampling blend views "
                                  "of a quilt; expected it without them");
    }
}

NativeOptions nativeOptions(const CommandLine& commandLine) {
    NativeOptions options;
    options.views = viewOptions(commandLine);
    options.fit = photoFitOption(commandLine);
    options.framing = framingOption(commandLine, options.fit);
    options.refine = refineOptions(commandLine);
    if (commandLine.has("k") || commandLine.has("best")) options.detail = Detail::Panel;
    if (!continuousOption(commandLine).empty()) options.positions = ViewPositions::Continuous;
    options.sampling = samplingOption(commandLine);
    return options;
}

NativeOptions photoNativeOptions(const CommandLine& commandLine) {
    NativeOptions options = nativeOptions(commandLine);
    if (commandLine.has("best")) {
        if (commandLine.has("quick"))
            throw UsageError("--best and --quick exclude each other, expected one of them");
        options.showAs(Detail::Panel);
        return options;
    }
    for (const char* other :
         {"quick", "m", "g", "method", "view-filter", "sampling", "budget", "k", "continuous"}) {
        if (commandLine.has(other)) return options;
    }
    options.showAs(Detail::Lens);
    return options;
}

NativeMaker makeNativeMaker(const CommandLine& commandLine, const ChosenDisplay& display,
                            const QuiltLayout& layout, NativeOptions options, Messages& messages,
                            bool preferContinuous) {
    const std::string why =
        display.map ? "a map was given" : NativeMaker::obstacle(layout, options);
    if (isContinuous(options) && !why.empty()) {
        const std::string option = continuousOption(commandLine);
        if (!option.empty()) throw UsageError(option + ": " + why + ", expected fewer (-q)");
        options = plain(options);
    }
    if (why.empty()) {
        if (preferContinuous) options.positions = ViewPositions::Continuous;
        messages.detail("path: direct, " + (isContinuous(options)
                                                ? "continuous positions"
                                                : std::to_string(layout.viewCount) + " positions"));
        return NativeMaker(display, layout, options);
    }
    messages.detail("path: over the quilt, as " + why);
    if (blends(options.sampling)) return NativeMaker(display, layout, options);
    return NativeMaker(lookUpTable(display, layout, messages), options);
}

std::string pathName(const NativeMaker& maker) {
    return maker.path() == NativePath::Direct ? "direct" : "quilt";
}

std::string costKey(const NativeMaker& maker, cv::Size photo) {
    const QuiltLayout& layout = maker.layout();
    std::string key = pathName(maker) + "-" + sizeKey(photo) + "-" + sizeKey(maker.panelSize());
    if (isContinuous(maker.options())) key += "-continuous";
    if (maker.options().lensFilter) key += "-filtered";
    if (maker.options().refine.keepsDepth()) key += "-exact";
    if (blends(maker.options().sampling)) key += "-blended";
    if (maker.path() == NativePath::OverQuilt)
        key += "-" + sizeKey(layout.tileSize) + "-" + std::to_string(layout.viewCount);
    return key;
}

} // namespace altiro3D::tools
