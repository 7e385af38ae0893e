#include "altiro3D/altiro3D.hpp"
#include "photo/photo_run.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// What an option was given, or what stands for it.
Json given(const PhotoJob& job, const std::string& option, const Json& standard = nullptr) {
    const auto value = job.given.find(option);
    return value == job.given.end() ? standard : Json(value->second);
}

Json networkJson(const PhotoRun& run) {
    const DepthNetwork* const network = run.depth.network();
    if (network == nullptr) return nullptr;
    return {{"name", network->profile().name},
            {"file", network->file().string()},
            {"profile", given(run.job, "net-profile")},
            {"inputWidth", network->inputSize().width},
            {"inputHeight", network->inputSize().height},
            {"engine", engineName(network->engine())},
            {"large", run.job.depth.isLarge}};
}

// The settings of the views besides strength and focus, by the names of the options.
Json knobsJson(const PhotoJob& job, const ViewOptions& views) {
    return {{"refine", views.refinement},
            {"fill", views.layered.fill == LayeredFill::Continue ? "continue" : "background"},
            {"borders", views.layered.softBorders ? "soft" : "hard"},
            {"inpaint-from", views.real.backgroundOnly ? "behind" : "around"},
            {"camera", given(job, "camera")}};
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

Json photoReport(const PhotoRun& run, const Messages& messages) {
    const PhotoJob& job = run.job;
    const QuiltLayout& layout = run.maker.layout();
    const NativeOptions& options = run.maker.options();
    Json report = {{"tool", "photo2native"},
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
    const Json strength = !job.camera.file().empty() || run.choices.strength
                              ? Json(nullptr)
                              : Json(options.views.strengthPercent);
    const Json focus = run.choices.focus ? Json(nullptr) : Json(options.views.focus);
    report["settings"] = {{"display", display},
                          {"invert", given(job, "invert", "auto")},
                          {"viewFilter", given(job, "view-filter", "nearest")},
                          {"sampling", given(job, "sampling", "nearest")},
                          {"quilt",
                           {{"columns", layout.columns},
                            {"rows", layout.rows},
                            {"viewWidth", layout.tileSize.width},
                            {"viewHeight", layout.tileSize.height},
                            {"views", layout.viewCount}}},
                          {"method", methodName(options.views.method)},
                          {"knobs", knobsJson(job, options.views)},
                          {"exactDepth", options.refine.keepsDepth()},
                          {"strengthPercent", strength},
                          {"focus", focus},
                          {"fit", run.choices.framing ? "auto" : fitName(options.fit)},
                          {"center", given(job, "center")},
                          {"zoom", options.framing.zoom},
                          {"detail", detailName(options.detail)},
                          {"lensFilter", options.lensFilter},
                          {"path", pathName(run.maker)},
                          {"continuous", options.positions == ViewPositions::Continuous},
                          {"depth", run.depth.description()},
                          {"depthImages", job.depth.fromFiles},
                          {"rgbdSide", given(job, "rgbd")},
                          {"stereo", given(job, "stereo")},
                          {"network", networkJson(run)},
                          {"depthKind", given(job, "depth-kind", "near-white")}};
    if (!job.outputs.video.empty()) {
        report["settings"]["video"] = {{"secondsPerTurn", job.sway.secondsPerTurn},
                                       {"turns", job.sway.turns},
                                       {"framesPerSecond", job.sway.frameRate.value()}};
    }
    report["budget"] = run.budget.report();
    report["warnings"] = messages.warnings();
    return report;
}

std::string reportText(const Json& report) {
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace altiro3D::tools
