#include "photo/photo_report.hpp"

#include "altiro3D/altiro3D.hpp"
#include "cli/json_text.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

Json parallaxJson(const AdjacentParallax& parallax) {
    return {{"viewPixels", parallax.viewPixels}, {"panelPixels", parallax.panelPixels}};
}

// What an option was given, or what stands for it.
Json given(const PhotoJob& job, const std::string& option, const Json& standard = nullptr) {
    const auto value = job.given.find(option);
    return value == job.given.end() ? standard : Json(value->second);
}

Json filesJson(const std::vector<fs::path>& files) {
    Json names = Json::array();
    for (const fs::path& file : files)
        names.push_back(file.string());
    return names;
}

// The outputs besides Native and video: their key in the report, and what they are.
struct OtherOutput {
    const char* key;
    const char* text;
    std::string file;
};
std::vector<OtherOutput> othersOf(const PhotoItem& item) {
    const OtherOutput all[] = {
        {"quilt", "quilt", item.quilt.string()},
        {"depth", "depth", item.savedDepth.string()},
        {"rgbd", "RGB-D image", item.rgbd.string()},
        {"photoWithDepth", "photo with its depth", item.photoWithDepth.string()},
        {"views", "views", item.views.string()},
        {"splats", "splats", item.splats.string()},
        {"page", "page for browsers", item.page.string()},
        {"stereo", item.eyes.words(), item.eyes.names()}};
    std::vector<OtherOutput> made;
    for (const OtherOutput& other : all)
        if (!other.file.empty()) made.push_back(other);
    return made;
}

} // namespace

Json networkJson(const PhotoRun& run) {
    const DepthNetwork* const network = run.depthSource.network();
    if (network == nullptr) return nullptr;
    return {{"name", network->profile().name},
            {"file", network->file().string()},
            {"profile", given(run.job, "net-profile")},
            {"inputWidth", network->inputSize().width},
            {"inputHeight", network->inputSize().height},
            {"engine", engineName(network->engine())},
            {"large", run.job.depth.isLarge}};
}

void tellPicture(const PhotoRun& run, const PhotoFacts& made, Messages& messages) {
    const PhotoItem& item = made.item;
    std::vector<std::string> lines; // names and what they are
    if (!item.native.empty()) {
        lines.push_back(nameOf(item.native, "standard output") +
                        (run.print ? ": print, " + sizeText(run.print->size())
                                   : ": Native, " + sizeText(run.native.size())));
    }
    const bool isOneLine = messages.hasSubject();
    for (const OtherOutput& other : othersOf(item))
        lines.push_back((isOneLine ? "" : other.file + ": ") + other.text);
    if (!item.video.empty()) {
        lines.push_back(isOneLine ? "video"
                                  : item.video.string() + ": video, " +
                                        swayText(run.job.sway, made.videoSize));
    }
    if (!isOneLine) {
        for (const std::string& line : lines)
            messages.say(line);
        return;
    }
    std::string line = joined(lines);
    if (made.isImageUsed && !run.job.depth.isPair)
        line += "; depth of " + item.depth.filename().string();
    if (displayUse(run.job) != DisplayUse::None) {
        const std::string cut = cutText(made.photoAspect(), made.aspect, run.maker.options().fit);
        line += cut.empty() ? "" : "; " + cut;
        line += made.chosen.empty() ? "" : "; " + made.chosen;
    }
    messages.say(line);
}

Json pictureReport(const PhotoRun& run, const PhotoFacts& made, const StageTimes& times) {
    const PhotoItem& item = made.item;
    Json report = {{"photo", item.photo.string()},
                   {"photoWidth", made.photoSize.width},
                   {"photoHeight", made.photoSize.height}};
    if (!item.native.empty()) report["native"] = item.native.string();
    if (made.isImageUsed)
        report[run.job.depth.isPair ? "rightImage" : "depthImage"] = item.depth.string();
    report["depthSource"] = made.depthSource;
    if (run.job.depth.stored.unblurred) report["unblurred"] = made.isUnblurred;
    for (const OtherOutput& other : othersOf(item))
        report[other.key] = other.file;
    if (!item.video.empty()) {
        report["video"] = {{"file", item.video.string()},
                           {"width", made.videoSize.width},
                           {"height", made.videoSize.height},
                           {"frames", framesPerTurn(run.job.sway) * run.job.sway.turns}};
    }
    report["aspect"] = made.aspect;
    if (!item.quilt.empty()) report["quiltAspect"] = made.quiltAspect;
    report["crop"] = {made.crop.x, made.crop.y, made.crop.width, made.crop.height};
    report["center"] = {made.framing.centre.x, made.framing.centre.y};
    report["strengthPercent"] = made.views.strengthPercent;
    report["focus"] = made.views.focus;
    report["adjacentParallax"] = parallaxJson(made.parallax);
    for (const auto& [stage, milliseconds] : times.milliseconds())
        report["milliseconds"][stage] = milliseconds;
    return report;
}

Json photoReport(const PhotoRun& run, int exitStatus, const Messages& messages) {
    const PhotoJob& job = run.job;
    const AutoChoices& choices = job.scene.recipe.choices;
    const QuiltLayout& layout = run.maker.layout();
    const NativeOptions& options = run.maker.options();
    Json report = {{"tool", "photo2native"},
                   {"version", version()},
                   {"state", stateName(exitStatus)},
                   {"openCv", CV_VERSION},
                   {"threads", cv::getNumThreads()}};
    const Json display = {
        {"source", run.display.source},
        {"files", filesJson(run.display.files)},
        {"panelWidth", run.display.panelSize().width},
        {"panelHeight", run.display.panelSize().height},
        {"serial", run.display.calibration.serial},
        {"fingerprint", fingerprintText(run.display.map ? run.display.map->calibrationFingerprint()
                                                        : fingerprint(run.display.calibration))}};
    // Null with --camera or auto, as each picture then has its own strength; else what was asked
    // for. If the limit for estimated depth has lowered it, the picture's entry tells.
    const Json strength = !job.camera.file().empty() || choices.strength
                              ? Json(nullptr)
                              : Json(options.views.strengthPercent);
    const Json focus = choices.focus ? Json(nullptr) : Json(options.views.focus);
    const Json recipe = Json::parse(recipeText({options, choices}));
    Json knobs; // of single methods
    for (const RecipeField& field : recipeFields())
        if (field.method) knobs[field.name] = recipe[field.name];
    knobs["camera"] = given(job, "camera");
    report["settings"] = {
        {"display", display},
        {"invert", given(job, "invert", "auto")},
        {"viewFilter", recipe["view-filter"]},
        {"sampling", recipe["sampling"]},
        {"quilt",
         {{"columns", layout.columns},
          {"rows", layout.rows},
          {"viewWidth", layout.tileSize.width},
          {"viewHeight", layout.tileSize.height},
          {"views", layout.viewCount}}},
        {"method", recipe["method"]},
        {"knobs", knobs},
        {"exactDepth", recipe["exact-depth"]},
        {"strengthPercent", strength},
        {"focus", focus},
        {"fit", recipe["fit"]},
        {"center", given(job, "center")},
        {"zoom", options.framing.zoom},
        {"detail", recipe["detail"]},
        {"lensFilter", options.lensFilter},
        {"path", pathName(run.maker)},
        {"continuous", options.positions == ViewPositions::Continuous},
        {"depth", run.depthSource.description()},
        {"depthImages", job.depth.fromFiles},
        {"rgbdSide", given(job, "rgbd")},
        {"stereo", given(job, "stereo")},
        {"network", run.networkEntry != nullptr ? *run.networkEntry : networkJson(run)},
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

} // namespace altiro3D::tools
