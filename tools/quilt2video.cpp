// quilt2video: turns a quilt into a video in which the camera swings through its views.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_options.hpp"
#include "common/run_tool.hpp"
#include "common/sway_options.hpp"

#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// A quilt's layout and the width : height of its views as they are shown.
struct Views {
    QuiltLayout layout;
    double aspect = 1;
};

Views chooseViews(const CommandLine& commandLine, const std::optional<Calibration>& display,
                  const fs::path& file, const cv::Mat& picture, Messages& messages) {
    QuiltRequest request;
    request.quiltSize = picture.size();
    request.name = parseQuiltName(file);
    request.grid = gridOption(commandLine);
    const QuiltLayout usual = display ? defaultQuilt(*display) : QuiltLayout();
    std::string certainty;
    if (!request.name && !request.grid) {
        const FoundQuilt found = findQuiltLayout(picture);
        request.found = certainLayout(found, file, picture.size(), usual);
        certainty = foundText(found);
    }
    std::optional<double> aspect = commandLine.number("aspect", 0.1, 10);
    if (!aspect && request.name) aspect = request.name->aspect;
    if (!aspect && display) aspect = static_cast<double>(display->screenW) / display->screenH;
    const ResolvedQuilt resolved = resolveLayout(request, usual, aspect.value_or(1));
    if (aspect) messages.warn(resolved.notes); // else it is not known which reading is right
    const cv::Size tile = resolved.layout.tileSize;
    const Views views{resolved.layout,
                      aspect.value_or(static_cast<double>(tile.width) / tile.height)};
    messages.say("quilt: " + quiltText(views.layout, views.aspect) + certainty);
    return views;
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) commandLine.failNames("QUILT and OUT", 2);
    const fs::path& quiltFile = commandLine.files()[0];
    const fs::path& output = commandLine.files()[1];
    const FitMode fit = fitOption(commandLine, FitMode::Cover);
    const SwayOptions sway = swayOptions(commandLine);
    const auto wantedSize = swaySizeOption(commandLine);
    const auto between = commandLine.choice("view-filter", {"nearest", "linear"});
    requireVideoName(output);
    Outputs outputs(commandLine.has("y"));
    requireFile(quiltFile);
    outputs.addInput(quiltFile);
    std::optional<Calibration> display;
    if (const auto file = commandLine.value("c")) {
        const fs::path calibration = calibrationFile(*file);
        display = readChosenCalibration(calibration, commandLine, messages);
        tellDisplay(chosenDisplay(*display, calibration), DisplayUse::Quilt, messages);
        outputs.addInput(calibration);
    } else if (commandLine.has("serial")) {
        throw UsageError("--serial chooses in the file of -c, expected -c with it");
    }
    outputs.addOutput(output);
    outputs.check();

    StageTimes times;
    cv::Mat quilt = readPhotoFile(quiltFile, messages);
    times.end("read");
    const Views views = chooseViews(commandLine, display, quiltFile, quilt, messages);
    quilt = fitQuilt(quilt, views.layout);
    const cv::Size size = writeQuiltSwayFile(
        output, quilt, views.layout, views.aspect, wantedSize, fit,
        between.value_or(0) == 1 ? ViewFilter::Linear : ViewFilter::Nearest, sway);
    times.end("video");
    messages.say(output.string() + ": video, " + swayText(sway, size));
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("quilt2video",
                            "Turns a quilt into a video in which the camera swings through its "
                            "views, to show their depth on any screen.");
    commandLine.addUsage("[options] QUILT OUT.mp4");
    commandLine.addSection("Video");
    addSwayOptions(commandLine);
    commandLine.addAdvanced(
        {"view-filter"},
        "Picture between two views: nearest (default), the nearer one; or linear, a blend of both, "
        "smoother but with double edges.",
        "nearest|linear");
    commandLine.add({"fit"},
                    "Views of another shape than --size: cover (default), contain or stretch.",
                    "cover|contain|stretch");
    commandLine.add({"y"}, "Replace the output if it exists.");
    commandLine.addSection("Quilt");
    commandLine.add({"q", "layout"}, "Views in the quilt, rows x columns: 6x8 is 6 rows of 8.",
                    "RxC");
    commandLine.addOldName("layout", "quilt");
    commandLine.add({"aspect"},
                    "Width : height of what a view shows, 0.1..10 (default: as the file name says, "
                    "else as the display, else as the view's px).",
                    "A");
    commandLine.add({"c", "calibration"},
                    "Display whose default layout the quilt has; needed only if neither the file "
                    "name nor -q states the layout.",
                    "visual.json");
    commandLine.addAdvanced({"serial"}, "Choose among several displays in that file.", "NAME");
    commandLine.addNote("A file name that ends in _qs<columns>x<rows>a<aspect>, such as "
                        "photo_qs8x6a0.75.png, states the layout. "
                        "The video is H.264 4:2:0 in .mp4 (or .mov, .m4v, .mkv), which any player "
                        "plays; it begins and ends in the middle view.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "holiday_qs8x6a0.75.png swing.mp4",
                        "Write the video in the shape of the views.");
    commandLine.addTerm(CommandLine::Chapter::Examples,
                        "--seconds 6 --turns 1 holiday_qs8x6a0.75.png slow.mp4",
                        "Swing once, in 6 seconds.");
    commandLine.addTerm(CommandLine::Chapter::Examples,
                        "-q 6x8 --size 640x640 --fit contain quilt.png square.mp4",
                        "Read 6 rows of 8 views and show them whole in a square.");
    commandLine.addTerm(CommandLine::Chapter::Files, "visual.json",
                        "Calibration of a display. Its USB volume holds it as "
                        "LKG_calibration/visual.json.");
    return runTool(argc, argv, commandLine, run);
}
