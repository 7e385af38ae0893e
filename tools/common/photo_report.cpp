#include "altiro3D/altiro3D.hpp"
#include "common/photo_run.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// The value of an option, or null.
Json given(const CommandLine& commandLine, const std::string& option) {
    const auto value = commandLine.value(option);
    return value ? Json(*value) : Json(nullptr);
}

Json networkJson(const CommandLine& commandLine, const ChosenDepth& source) {
    if (source.network() == nullptr) return nullptr;
    return {{"name", source.network()->profile().name},
            {"file", source.network()->file().string()},
            {"profile", given(commandLine, "net-profile")},
            {"inputWidth", source.network()->inputSize().width},
            {"inputHeight", source.network()->inputSize().height},
            {"engine", engineName(source.network()->engine())},
            {"large", commandLine.has("l")}};
}

// The settings of the views besides strength and focus, by the names of the options.
Json knobsJson(const CommandLine& commandLine, const ViewOptions& views) {
    return {{"refine", views.refinement},
            {"fill", views.layered.fill == LayeredFill::Continue ? "continue" : "background"},
            {"borders", views.layered.softBorders ? "soft" : "hard"},
            {"inpaint-from", views.real.backgroundOnly ? "behind" : "around"},
            {"camera", given(commandLine, "camera")}};
}

std::string detailName(Detail detail) {
    switch (detail) {
    case Detail::View:
        return "view";
    case Detail::Lens:
        return "lens";
    case Detail::Panel:
        break;
    }
    return "panel";
}

Json filesJson(const std::vector<fs::path>& files) {
    Json names = Json::array();
    for (const fs::path& file : files)
        names.push_back(file.string());
    return names;
}

} // namespace

Json photoReport(const CommandLine& commandLine, const PhotoRun& run, const Messages& messages) {
    const QuiltLayout& layout = run.maker.layout();
    const NativeOptions& options = run.maker.options();
    Json report = {{"tool", commandLine.name()},
                   {"version", version()},
                   {"openCv", CV_VERSION},
                   {"threads", cv::getNumThreads()}};
    Json display = {{"source", run.display.source},
                    {"files", filesJson(run.display.files)},
                    {"panelWidth", run.display.panelSize().width},
                    {"panelHeight", run.display.panelSize().height}};
    display["serial"] = run.display.calibration.serial;
    display["fingerprint"] =
        fingerprintText(run.display.map ? run.display.map->calibrationFingerprint()
                                        : fingerprint(run.display.calibration));
    // with a camera or auto each picture has its own
    const Json strength = commandLine.has("camera") || run.choices.strength
                              ? Json(nullptr)
                              : Json(options.views.strengthPercent);
    const Json focus = run.choices.focus ? Json(nullptr) : Json(options.views.focus);
    report["settings"] = {{"display", display},
                          {"invert", commandLine.value("invert").value_or("auto")},
                          {"viewFilter", commandLine.value("view-filter").value_or("nearest")},
                          {"sampling", commandLine.value("sampling").value_or("nearest")},
                          {"quilt",
                           {{"columns", layout.columns},
                            {"rows", layout.rows},
                            {"viewWidth", layout.tileSize.width},
                            {"viewHeight", layout.tileSize.height},
                            {"views", layout.viewCount}}},
                          {"method", methodName(options.views.method)},
                          {"knobs", knobsJson(commandLine, options.views)},
                          {"exactDepth", options.refine.keepsDepth()},
                          {"strengthPercent", strength},
                          {"focus", focus},
                          {"fit", run.choices.framing ? "auto" : fitName(options.fit)},
                          {"center", given(commandLine, "center")},
                          {"zoom", options.framing.zoom},
                          {"detail", detailName(options.detail)},
                          {"lensFilter", options.lensFilter},
                          {"path", pathName(run.maker)},
                          {"continuous", options.positions == ViewPositions::Continuous},
                          {"depth", run.depth.description()},
                          {"depthImages", run.depth.fromFiles()},
                          {"rgbdSide", given(commandLine, "rgbd")},
                          {"stereo", given(commandLine, "stereo")},
                          {"network", networkJson(commandLine, run.depth)},
                          {"depthKind", commandLine.value("depth-kind").value_or("near-white")}};
    if (commandLine.has("lg")) {
        report["settings"]["video"] = {{"secondsPerTurn", run.sway.secondsPerTurn},
                                       {"turns", run.sway.turns},
                                       {"framesPerSecond", run.sway.frameRate.value()}};
    }
    report["budget"] = run.budget.report();
    report["warnings"] = messages.warnings();
    return report;
}

std::string reportText(const Json& report) {
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace altiro3D::tools
