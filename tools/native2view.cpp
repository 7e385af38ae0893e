// native2view: the picture that an eye sees of a Native through the display's lenses.

#include "altiro3D/altiro3D.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"
#include "cli/picture_options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/core.hpp>
#include <sstream>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

constexpr double kWidestAngle = 90;

int viewNumber(const std::string& text, int views) {
    int view = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), view);
    if (error != std::errc() || end != text.data() + text.size() || view < 0 || view >= views) {
        throw UsageError("--view names view " + text + ", expected 0.." +
                         std::to_string(views - 1) + ", numbers like 0,12,47, or all");
    }
    return view;
}

// The views that --view names, in its order.
std::vector<int> chosenViews(const std::string& text, int views) {
    std::vector<int> chosen;
    if (text == "all") {
        for (int i = 0; i < views; ++i)
            chosen.push_back(i);
        return chosen;
    }
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        const int view = viewNumber(word, views);
        if (std::find(chosen.begin(), chosen.end(), view) != chosen.end())
            throw UsageError("--view names view " + word + " twice, expected each view once");
        chosen.push_back(view);
    }
    return chosen;
}

// The command line.
struct ViewJob {
    fs::path native;
    fs::path output;
    bool replace = false;
    double angle = 0;       // degrees
    std::string views;      // empty: one angle
    bool quilt = false;     // of all views
    bool isBlurred = false; // as by the eye
    double distance = 50;   // of the eye, cm
    DisplayOptions display;
    QuiltRequest layout;
};

ViewJob viewJob(const CommandLine& commandLine) {
    ViewJob job;
    commandLine.takeNames("NATIVE and OUT", {&job.native, &job.output});
    commandLine.exclude("angle", {"view", "quilt-out"});
    commandLine.exclude("view", "quilt-out");
    commandLine.take({{"y", job.replace},
                      {"angle", job.angle, -kWidestAngle, kWidestAngle},
                      {"quilt-out", job.quilt},
                      {"quilt-out", job.views, "all"},
                      {"view", job.views},
                      {"eye", job.isBlurred},
                      {"distance", job.distance, 10, 1000}});
    commandLine.refuseWithout("eye", {"distance"}, " is that of the eye, expected --eye with it");
    job.display = displayOptions(commandLine);
    job.layout = quiltRequest(commandLine);
    return job;
}

// One picture, pictures in a directory, or a quilt of all views.
struct Pictures {
    std::vector<LensEye> eyes;
    std::vector<fs::path> files;  // one for each eye; a quilt is one file
    std::optional<cv::Size> size; // of each view, else the panel's
};

Pictures planPictures(const ViewJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                      Messages& messages) {
    const fs::path& output = job.output;
    const int count = layout.viewCount;
    Pictures pictures;
    if (job.quilt || job.layout.tileSize) pictures.size = layout.tileSize;
    if (job.views.empty()) {
        const double most = viewConeDegrees(display.calibration) / 2;
        if (std::abs(job.angle) > most) {
            messages.warn("the display's views fill " + fixed(most, 1) +
                          " degrees to each side; beyond that they repeat");
        }
        pictures.eyes = {eyeAtAngle(display.calibration, job.angle)};
        pictures.files = {output};
    } else {
        const std::vector<int> views = chosenViews(job.views, count);
        for (const int view : views) {
            pictures.eyes.push_back(eyeAtView(view, count));
            if (!job.quilt) pictures.files.push_back(output / viewFileName(view, count));
        }
        if (job.quilt)
            pictures.files = {quiltFileName(output, layout, display.aspect())};
        else if (views.size() == 1)
            pictures.files = {output};
    }
    for (LensEye& eye : pictures.eyes)
        if (job.isBlurred) eye.blur = eyeBlur(display.calibration, job.distance);
    const bool directory = pictures.files.size() > 1;
    if (directory && canWriteImage(output)) {
        throw UsageError(output.string() +
                         ": names one file, expected a directory for the pictures of several "
                         "views (--quilt-out puts all into one picture)");
    }
    if (!directory) requirePictureName(pictures.files.front());
    return pictures;
}

Outputs checkedOutputs(const ViewJob& job, const ChosenDisplay& display, const Pictures& pictures) {
    Outputs outputs(job.replace);
    outputs.addInputs({job.native});
    outputs.addInputs(display.files);
    if (pictures.files.size() > 1) outputs.addDirectory(job.output);
    outputs.addOutputs(pictures.files);
    outputs.check();
    return outputs;
}

int showViews(const ViewJob& job, Messages& messages) {
    const fs::path& nativeFile = job.native;
    const ChosenDisplay display = findDisplay(job.display, messages, {}, DisplayUse::Simulate);
    if (display.isMapOnly) {
        throw UsageError("a map does not contain the geometry of the lenses, expected the "
                         "display's calibration with -c");
    }
    const QuiltLayout layout = chooseQuilt(job.layout, display, messages);
    const Pictures pictures = planPictures(job, display, layout, messages);
    requireFile(nativeFile);
    const Outputs outputs = checkedOutputs(job, display, pictures);
    StageTimes times;
    const cv::Mat native = readPhotoFile(nativeFile, messages);
    if (native.size() != display.panelSize()) {
        throw Error(ErrorCode::Mismatch, nativeFile.string(),
                    "has " + sizeText(native.size()) + ", expected a Native of the panel's " +
                        sizeText(display.panelSize()) + " (" + display.source +
                        "; -c gives another)");
    }
    times.end("read");
    outputs.makeDirectories();
    cv::Mat quilt;
    if (job.quilt) {
        messages.say("quilt: " + quiltText(layout, display.aspect()));
        quilt = cv::Mat(layout.size(), CV_8UC3, cv::Scalar::all(0));
    }
    Progress progress(pictures.eyes.size());
    cv::Mat seen;
    cv::Mat sized;
    for (std::size_t i = 0; i < pictures.eyes.size(); ++i) {
        progress.step("view " + std::to_string(i + 1));
        simulateView(native, display.calibration, pictures.eyes[i], seen, display.invert);
        sized = seen;
        if (pictures.size) {
            const PhotoFit fit =
                fitPhoto(seen.size(), display.aspect(), *pictures.size, FitMode::Stretch);
            applyFit(seen, fit, sized);
        }
        if (job.quilt)
            sized.copyTo(quilt(layout.tile(static_cast<int>(i))));
        else
            writeImage(pictures.files[i], sized);
    }
    if (job.quilt) writeImage(pictures.files.front(), quilt);
    progress.clear();
    times.end("views");
    const bool several = pictures.files.size() > 1;
    messages.say((several ? job.output : pictures.files.front()).string() + ": " +
                 counted(pictures.eyes.size(), "view") + ", " + sizeText(sized.size()) +
                 (several || job.quilt ? " each" : ""));
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("native2view", "Shows a Native as an eye sees it through the lenses "
                                           "of the display: one view, some, or all.");
    commandLine.addUsage("[options] NATIVE OUT.png");
    commandLine.addUsage("[options] --view 0,12,47|all NATIVE OUTDIR");
    commandLine.addUsage("[options] --quilt-out NATIVE OUT.png");
    commandLine.addSection("Eye");
    commandLine.add({"angle"},
                    "Angle from which the panel is seen, in degrees: 0 (default) is straight "
                    "ahead, negative angles are to the left. Under each lens the eye sees a spot "
                    "one sub-pixel wide, which holds about three views of a Portrait.",
                    "DEGREES");
    commandLine.add({"view"},
                    "Views by number, 0 = leftmost, each from exactly the sub-pixels that show it. "
                    "One view is written to a file, several to a directory; all: all views of "
                    "the quilt.",
                    "LIST");
    commandLine.add({"quilt-out"},
                    "All views in one quilt (named ..._qs<columns>x<rows>a<aspect>).");
    commandLine.addAdvanced(
        {"eye"}, "Show the picture as sharp as an eye sees it, to judge the detail and "
                 "the coloured noise of a Native: in each row a lens shows one sub-pixel "
                 "over its whole width, and the eye blurs the light by 1.6 arc minutes "
                 "(standard deviation; colour by twice as much). At 50 cm that is 3 px "
                 "of a Portrait.");
    commandLine.addAdvanced({"distance"}, "Distance of --eye from the panel, 10..1000 cm (50).",
                            "CM");
    commandLine.addSection("Output");
    commandLine.add({"y"}, "Replace outputs that exist.");
    addDisplayOptions(commandLine);
    commandLine.addNote("A view has the panel's size, or that of -r, but less detail: each of N "
                        "views owns one N-th of the sub-pixels. With another display's "
                        "calibration the views mix, as they do on the panel.");
    commandLine.addExample("native.png middle.png", "Show what an eye sees straight ahead.");
    commandLine.addExample("--angle -12 native.png left.png",
                           "Show what it sees from 12 degrees to the left.");
    commandLine.addExample("--view all native.png seen", "Write each view to the directory seen.");
    commandLine.addExample("--eye --distance 70 native.png seen.png",
                           "Show how sharp it looks at 70 cm.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return showViews(viewJob(given), messages);
    });
}
