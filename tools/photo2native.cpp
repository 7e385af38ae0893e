// photo2native: turns photos into Natives.

#include "altiro3D/altiro3D.hpp"
#include "cli/display_options.hpp"
#include "cli/folders.hpp"
#include "cli/json_text.hpp"
#include "cli/quilt_options.hpp"
#include "cluster/photo_chunks.hpp"
#include "photo/photo_report.hpp"
#include "photo/photo_run.hpp"

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

// A run of one photo. @param entries receives its entry in the report
void makeOnePhoto(const PhotoItem& item, PhotoRun& run, PhotosMade& made, Json& entries,
                  Messages& messages) {
    const FolderItem file{item.photo, mainOutput(item), item.isMade};
    run.isForOnePhoto = true;
    const auto make = [&] { entries.push_back(makePhoto(item, run, messages)); };
    const auto notMade = [&](const FolderEnd& end) { end.addTo(entries, "photo", file); };
    made.status = convertOne("photo", file, make, notMade, messages, run.job.jsonProgress);
}

// A run of many photos. @param entries receives their entries in the report
void makeManyPhotos(const PhotoPlan& plan, PhotoRun& run, PhotosMade& made, Json& entries,
                    Messages& messages) {
    std::vector<FolderItem> files;
    for (const PhotoItem& item : plan.items)
        files.push_back({item.photo, mainOutput(item), item.isMade});
    FolderRun folder("photo", plan.leftOut, messages, run.job.jsonProgress);
    const auto addOutputs = [&](std::size_t i) {
        for (const fs::path& file : outputsOf(plan.items[i], run.maker.layout().viewCount))
            made.outputs.push_back(file);
    };
    const auto make = [&](std::size_t i) {
        entries.push_back(makePhoto(plan.items[i], run, messages));
        addOutputs(i);
        return kExitDone;
    };
    made.status = folder.convert(files, make, [&](std::size_t i, const FolderEnd& end) {
        end.addTo(entries, "photo", files[i]);
        if (!end.error.empty()) made.notMade.push_back("failed: " + end.error);
        if (!end.leftOut.empty())
            made.notMade.push_back(files[i].input.string() + ": " + end.leftOut);
        if (end.isSkipped) addOutputs(i);
    });
    made.mayRecover = folder.mayRecover();
}

// Makes the photos of a job.
// @param part the photos of --chunk or --join; null for all photos
PhotosMade makePhotos(const PhotoJob& job, const PhotoPart* part, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    if (isStandardStream(job.outputs.native)) messages.useStandardError();
    messages.setQuiet(part != nullptr); // --plan has said the following
    StageTimes setup;
    // the processor time until here, nearly all of it for loading libraries
    setup.add("start", 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
    ChosenDisplay display = // --go: a Looking Glass Go, which need not be connected
        job.go ? goDisplay() : findDisplay(job.display, messages, {}, displayUse(job));
    // with --print, display becomes that of the sheet
    const std::optional<PrintSheet> print = printSheet(job.print, display, messages);
    // needed even if no quilt is made: it states the number of views, and their size, in whose px
    // parallax is counted
    const QuiltLayout layout = chooseQuilt(job.quilt, display, messages);
    const PhotoInputs inputs =
        part == nullptr ? listPhotos(job, messages) : PhotoInputs{part->chunks.photos, {}, true};
    PhotoPlan plan = planPhotos(job, display, layout, inputs);
    if (part != nullptr) part->keepOwn(plan);
    const Outputs outputs = checkedOutputs(job, plan, display, layout.viewCount);
    if (part != nullptr) part->markOutdated(plan);
    if (job.go) job.go->requireSpace(plan.items.size());
    if (displayUse(job) != DisplayUse::None)
        messages.say("quilt: " + quiltText(layout, display.aspect()));
    setup.end("plan");
    PhotoRun photoRun = openPhotoRun(job, display, layout, setup, messages);
    if (print) photoRun.printOn(*print, messages);
    if (part != nullptr) part->requireSame(photoRun);
    messages.detail("ready: " + setup.text());
    const std::string unasked = unaskedText(job.scene.unasked);
    const bool isPlaced = displayUse(job) != DisplayUse::None;
    if (isPlaced && !unasked.empty()) messages.say(unasked);
    outputs.makeDirectories();
    messages.setQuiet(false);

    PhotosMade made;
    Json pictureEntries = Json::array();
    const auto writeReport = [&](int status) {
        if (job.report.empty()) return;
        Json report = photoReport(photoRun, status, messages);
        for (const auto& [stage, milliseconds] : setup.milliseconds())
            report["setupMilliseconds"][stage] = milliseconds;
        report["peakMegabytes"] = peakMegabytes();
        report["pictures"] = pictureEntries;
        writeFile(job.report, jsonText(report, 2) + "\n");
    };
    const auto showByBridge = [&] {
        std::vector<fs::path> shown;
        for (const PhotoItem& item : plan.items) {
            const fs::path& file = item.quilt.empty() ? item.rgbd : item.quilt;
            if (!plan.batch || // one photo that fails does not come here
                std::find(made.outputs.begin(), made.outputs.end(), file) != made.outputs.end())
                shown.push_back(file);
        }
        showOnBridge(*job.bridge, shown, job.outputs.quilt.empty(), display.aspect(), messages);
    };
    try {
        if (plan.batch) {
            makeManyPhotos(plan, photoRun, made, pictureEntries, messages);
            if (job.go) job.go->finish(made.outputs, messages);
        } else {
            makeOnePhoto(plan.items.front(), photoRun, made, pictureEntries, messages);
        }
        if (job.bridge && made.status != kExitStopped) showByBridge();
    } catch (...) {
        writeReport(kExitFailed);
        throw;
    }
    const double peak = peakMegabytes();
    if (peak > 0) messages.detail("peak memory " + fixed(peak, 0) + " MB");
    writeReport(made.status);
    return made;
}

} // namespace

namespace altiro3D::tools { // for the tests of photoJob()

void addPhotoOptions(CommandLine& commandLine) {
    commandLine.addUsage("[options] PHOTO OUT.png");
    commandLine.addUsage("[options] -d PHOTO DEPTH OUT.png");
    commandLine.addUsage("[options] --rgbd right RGBD OUT.png");
    commandLine.addUsage("[options] --stereo left-right PAIR OUT.png");
    commandLine.addUsage("[options] PHOTO PHOTO... | DIR  OUTDIR");
    commandLine.addUsage("--lg OUT.mp4 [options] PHOTO");
    commandLine.addUsage("--save-stereo OUT.png [options] PHOTO");
    commandLine.addUsage("--save-splats OUT.ply [options] PHOTO");
    commandLine.addUsage("--save-page OUT.html [options] PHOTO");
    commandLine.addUsage("--go DIR [options] PHOTO... | DIR");
    commandLine.addUsage("--plan PLAN [options] DIR OUTDIR");
    commandLine.addUsage("--chunk K PLAN");
    commandLine.addUsage("--join PLAN");
    addDepthOptions(commandLine);
    commandLine.addSection("Views");
    addFields(commandLine, RecipePart::Views, AutoUse::Photos);
    addNativeOptions(commandLine);
    addQuickOption(commandLine);
    CameraOptions::add(commandLine);
    Budget::add(commandLine);
    addFields(commandLine, RecipePart::Placement, AutoUse::Photos);
    commandLine.addSection("Output");
    commandLine.add({"save-quilt"}, "Also write the quilt (named ..._qs<columns>x<rows>a<aspect>).",
                    "FILE");
    commandLine.add({"save-depth"}, "Also write the depth before refinement, 16-bit, near = white.",
                    "FILE.png");
    commandLine.addAdvanced({"save-depth-size"},
                            "Longer side of the depth of --save-depth and "
                            "--save-photo-with-depth in px, at most that of the photo (default " +
                                std::to_string(kSavedDepthSide) + ").",
                            "PX");
    commandLine.addAdvanced(
        {"save-rgbd"},
        "Also write photo and depth side by side; squeezed to half their width if "
        "the name says so (a_HRGBD.png).",
        "FILE");
    commandLine.addAdvanced({"save-photo-with-depth"},
                            "Also write the photo with its depth inside, as phones do (Dynamic "
                            "Depth), for other programs.",
                            "FILE.jpg");
    commandLine.addAdvanced({"save-views"}, "Also write the single views, leftmost camera first.",
                            "DIR");
    commandLine.add({"save-splats"},
                    "Also write photo, depth and painted background as a scene of Gaussian splats, "
                    "for headsets, the web and splat2native. Without OUT no Native is made.",
                    "FILE.ply|FILE.spz");
    commandLine.addAdvanced({"splat-side"},
                            "Longer side of the grid of splats in px, at most that of the photo "
                            "(default 1024: about a million splats).",
                            "PX");
    commandLine.addAdvanced({"splat-camera"},
                            "Put the photo's camera into a .ply, as SHARP does; some viewers do "
                            "not read such files.");
    PageOptions::add(commandLine, "the whole photo, or the part of --center and --zoom, in depth");
    EyesFiles::add(
        commandLine,
        "It has the photo's own size and needs no display, and without OUT no Native is made. The "
        "parallax between the eyes is --strength, by default 2.5. The pictures in a photo of both "
        "eyes stay as they are and only get this layout, unless --strength, --focus, "
        "--depth-curve, --method or --stereo-keep is given.");
    addSwayFileOption(
        commandLine,
        "It holds the whole photo in its own shape, or the part of --center and --zoom, and");
    GoFolder::addOptions(commandLine, "photos");
    addBridgeOptions(commandLine, "Also show the quilts (with --save-rgbd: the RGB-D pictures) by");
    addProgressOption(commandLine);
    commandLine.addAdvanced({"report"},
                            "Write all settings used and the time of each stage, for programs.",
                            "FILE.json");
    commandLine.add({"y"}, "Replace outputs that exist.");
    commandLine.addAdvanced({"skip-existing"},
                            "Continue a run that ended early: skip each photo whose outputs all "
                            "exist and are not empty. Which options made them is not checked.");
    addRecursiveOption(commandLine, "photos");
    addPhotoChunkOptions(commandLine);
    commandLine.addSection("Video of --lg");
    addSwayOptions(commandLine);
    addPrintOptions(commandLine);
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine);
    commandLine.addNote("With several photos or a directory the last name is the directory for "
                        "the outputs, and so are the names of --save-... and --lg; one bad photo "
                        "does not stop the rest. In a directory, only photos are converted, each "
                        "with its depth image if one lies beside it (a.jpg and a-depth.png). "
                        "Natives, quilts, depth images without a photo, videos and other files "
                        "are named, counted and left out. A picture that is grey and smooth "
                        "counts as a depth image; name it itself if it is a photo.");
    commandLine.addNote("PHOTO may be - for standard input, and OUT.png - for standard output, to "
                        "which a PNG is written; messages then go to standard error. With --lg or "
                        "--save-... OUT may be left out: then no Native is made.");
    commandLine.addNote("Photos and depth images may be " + readableFormats() + ".");
    commandLine.addExample("holiday.jpg native.png",
                           "Make a Native for the display that is connected.");
    commandLine.addExample("--quick -c visual.json holiday.jpg quick.png",
                           "Make it quickly, for the display of that calibration.");
    commandLine.addExample("-d holiday.jpg painted.png given.png", "Take the depth from an image.");
    commandLine.addExample("--save-stereo holiday_LRF.png holiday.jpg",
                           "Make only a side-by-side picture, for a headset.");
    commandLine.addExample("--save-quilt holiday.png --lg holiday.mp4 holiday.jpg all.png",
                           "Also write the quilt, and a video of its views for any screen.");
}

} // namespace altiro3D::tools

int main(int argc, char** argv) {
    CommandLine commandLine("photo2native",
                            "Turns photos into Native pictures for a light-field display: depth is "
                            "estimated (or given), and every sub-pixel of the panel takes its "
                            "colour from its own view of the scene.");
    addPhotoOptions(commandLine);
    return runTool(argc, argv, commandLine, [&](const CommandLine& parsed, Messages& messages) {
        // with --plan, --chunk and --join
        const auto makePart = [&](const PhotoJob& planned, const PhotoPart& part) {
            return makePhotos(planned, &part, messages);
        };
        if (const auto status = runPhotoChunks(parsed, argumentsOf(argc, argv), addPhotoOptions,
                                               makePart, messages))
            return *status;
        const PhotoJob job = photoJob(parsed);
        return makePhotos(job, nullptr, messages).status;
    });
}
