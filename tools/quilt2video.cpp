// quilt2video: turns a quilt into a video in which the camera swings through its views.

#include "altiro3D/altiro3D.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"
#include "cli/picture_options.hpp"
#include "photo/sway_options.hpp"

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

// The command line.
struct SwayJob {
    fs::path quilt;
    fs::path video;
    bool replace = false;
    SwayOptions sway;
    std::optional<cv::Size> size;
    FitMode fit = FitMode::Cover;
    ViewFilter between = ViewFilter::Nearest;
    QuiltRequest layout;
    std::optional<double> aspect;
    DisplayOptions display; // none without -c
};

SwayJob swayJob(const CommandLine& commandLine) {
    SwayJob job;
    commandLine.takeNames("QUILT and OUT", {&job.quilt, &job.video});
    commandLine.take({{"y", job.replace}, {"aspect", job.aspect, 0.1, 10}});
    job.fit = fitOption(commandLine).value_or(job.fit);
    job.sway = swayOptions(commandLine);
    job.size = swaySizeOption(commandLine);
    job.between = viewFilterOption(commandLine);
    job.layout = quiltRequest(commandLine);
    job.display = displayOptions(commandLine);
    requireVideoName(job.video);
    commandLine.refuseWithout("c", {"serial"}, " chooses in the file of -c, expected -c with it");
    return job;
}

Views chooseViews(const SwayJob& job, const std::optional<ChosenDisplay>& display,
                  const cv::Mat& picture, Messages& messages) {
    QuiltRequest request = job.layout;
    request.quiltSize = picture.size();
    request.name = parseQuiltName(job.quilt);
    const QuiltLayout usual = display ? usualQuilt(*display, request) : QuiltLayout();
    std::string certainty;
    if (!request.name && !request.grid) {
        const FoundQuilt found = findQuiltLayout(picture);
        request.found = certainLayout(found, job.quilt, picture.size(), usual);
        certainty = foundText(found);
    }
    std::optional<double> aspect = job.aspect;
    if (!aspect && request.name) aspect = request.name->aspect;
    if (!aspect && display) aspect = display->aspect();
    const ResolvedQuilt resolved = resolveLayout(request, usual, aspect.value_or(1));
    if (aspect) messages.warn(resolved.notes); // else it is not known which reading is right
    for (const Note& note : checkQuiltLayout(picture, resolved.layout)) {
        const bool isAsked = request.grid && note.code == NoteCode::Doubtful; // -q says so
        if (!isAsked) messages.warn(job.quilt.string() + ": " + note.text);
    }
    const cv::Size tile = resolved.layout.tileSize;
    const Views views{resolved.layout,
                      aspect.value_or(static_cast<double>(tile.width) / tile.height)};
    messages.say("quilt: " + quiltText(views.layout, views.aspect) + certainty);
    return views;
}

int makeVideo(const SwayJob& job, Messages& messages) {
    Outputs outputs(job.replace);
    requireFile(job.quilt);
    outputs.addInputs({job.quilt});
    std::optional<ChosenDisplay> display;
    if (!job.display.calibration.empty()) {
        display = findDisplay(job.display, messages, {}, DisplayUse::Quilt);
        outputs.addInputs(display->files);
    }
    outputs.addOutputs({job.video});
    outputs.check();

    StageTimes times;
    cv::Mat quilt = readPhotoFile(job.quilt, messages);
    times.end("read");
    const Views views = chooseViews(job, display, quilt, messages);
    quilt = fitQuilt(quilt, views.layout);
    const cv::Size size = writeQuiltSwayFile(job.video, quilt, views.layout, views.aspect, job.size,
                                             job.fit, job.between, job.sway);
    times.end("video");
    messages.say(job.video.string() + ": video, " + swayText(job.sway, size));
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
                    "How views that do not have the shape of --size are fitted: cover (default), "
                    "contain or stretch.",
                    "cover|contain|stretch");
    commandLine.add({"y"}, "Replace the output if it exists.");
    commandLine.addSection("Quilt");
    commandLine.add({"q", "layout"}, "Views in the quilt, rows x columns: 6x8 is 6 rows of 8.",
                    "RxC");
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
    commandLine.addExample("holiday_qs8x6a0.75.png swing.mp4",
                           "Write the video in the shape of the views.");
    commandLine.addExample("--seconds 6 --turns 1 holiday_qs8x6a0.75.png slow.mp4",
                           "Swing once, in 6 seconds.");
    commandLine.addExample("-q 6x8 --size 640x640 --fit contain quilt.png square.mp4",
                           "Read 6 rows of 8 views and show them whole in a square.");
    commandLine.addTerm(CommandLine::Chapter::Files, "visual.json",
                        "Calibration of a display. Its USB volume holds it as "
                        "LKG_calibration/visual.json.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return makeVideo(swayJob(given), messages);
    });
}
