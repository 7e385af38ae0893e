#include "common/native_road.hpp"

#include "common/picture_options.hpp"

namespace altiro3D::tools {

namespace {

// Why a Native is not made straight; empty if it can be.
std::string obstacle(const ChosenDisplay& display, const QuiltLayout& layout, bool blends,
                     ViewMethod method) {
    if (display.map) return "a map was given";
    if (blends) return "views are blended";
    if (method == ViewMethod::Real) return "method real makes whole views";
    if (layout.viewCount > NativeRenderer::kMostViews) {
        return "there are more than " + std::to_string(NativeRenderer::kMostViews) + " views";
    }
    return {};
}

// The option that asks for continuous positions; empty: none does.
std::string continuousOption(const CommandLine& commandLine) {
    for (const char* option : {"continuous", "best"}) {
        if (commandLine.has(option)) return std::string("--") + option;
    }
    return {};
}

std::string sizeKey(cv::Size size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
}

} // namespace

void NativeRoad::add(CommandLine& commandLine) {
    commandLine.add({"continuous"},
                    "The camera of each sub-pixel stands exactly where the lens sends it, not at "
                    "the nearest of the views; with -k the best picture. Not with -g, -m and "
                    "blending.");
    commandLine.add({"best"}, "The best picture: -k and --continuous.");
}

bool NativeRoad::keepsResolution(const CommandLine& commandLine) {
    return commandLine.has("k") || commandLine.has("best");
}

void NativeRoad::check(const CommandLine& commandLine) {
    const std::string option = continuousOption(commandLine);
    if (option.empty()) return;
    if (commandLine.has("m")) {
        throw UsageError(option +
                         " reads the photo where the lens says, but a map (-m) knows "
                         "whole views only; expected the calibration with -c instead of -m");
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

NativeRoad::NativeRoad(const CommandLine& commandLine, const ChosenDisplay& display,
                       const QuiltLayout& layout, ViewMethod method, Messages& messages,
                       bool preferContinuous)
    : calibration_(display.isMapOnly ? std::nullopt : std::make_optional(display.calibration)),
      invert_(display.invert), layout_(layout), blends_(blends(samplingOption(commandLine))),
      panelSize_(display.panelSize()) {
    const std::string why = obstacle(display, layout, blends_, method);
    if (const std::string option = continuousOption(commandLine); !option.empty()) {
        if (!why.empty()) {
            throw UsageError(option + ": " + why + ", expected fewer (-q)");
        }
        positions_ = ViewPositions::Continuous;
    }
    if (preferContinuous && why.empty()) positions_ = ViewPositions::Continuous;
    if (why.empty()) {
        messages.detail(std::string("road: direct, ") +
                        (continuous() ? "continuous positions"
                                      : std::to_string(layout.viewCount) + " positions"));
        return;
    }
    messages.detail("road: over the quilt, as " + why);
    overQuilt_ = makeQuilt2Native(commandLine, display, layout, messages);
}

std::string NativeRoad::costKey(cv::Size photo) const {
    std::string key = name() + "-" + sizeKey(photo) + "-" + sizeKey(panelSize_);
    if (continuous()) key += "-continuous";
    if (blends_) key += "-blended";
    if (!direct()) key += "-" + sizeKey(layout_.tileSize) + "-" + std::to_string(layout_.viewCount);
    return key;
}

void NativeRoad::makeNative(const ViewOptions& views, const cv::Mat& photo, const cv::Mat& depth,
                            const cv::Mat& quilt, cv::Mat& native) const {
    if (overQuilt_) {
        overQuilt_->render(quilt, native);
    } else {
        renderer(views).render(photo, depth, native);
    }
}

NativeRenderer NativeRoad::renderer(const ViewOptions& views) const {
    return NativeRenderer(*calibration_, layout_.viewCount, views, positions_, invert_);
}

} // namespace altiro3D::tools
