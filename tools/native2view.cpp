// native2view: the picture that an eye sees of a Native through the display's lenses.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_options.hpp"
#include "common/run_tool.hpp"

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

// The output: one picture, a directory of pictures, or a quilt of all views.
struct Job {
    std::vector<LensEye> eyes;
    std::vector<fs::path> files; // one for each eye; a quilt is one file
    bool quilt = false;
    std::optional<cv::Size> size; // of each view, else the panel's
};

Job planJob(const CommandLine& commandLine, const ChosenDisplay& display, const QuiltLayout& layout,
            Messages& messages) {
    commandLine.exclude("angle", "view");
    commandLine.exclude("angle", "quilt-out");
    commandLine.exclude("view", "quilt-out");
    const fs::path& output = commandLine.files()[1];
    const int count = layout.viewCount;
    Job job;
    job.quilt = commandLine.has("quilt-out");
    if (job.quilt || commandLine.has("r")) job.size = layout.tileSize;
    const auto list = job.quilt ? std::string("all") : commandLine.value("view");
    if (!list) {
        const double angle = commandLine.number("angle", -kWidestAngle, kWidestAngle).value_or(0);
        const double most = viewConeDegrees(display.calibration) / 2;
        if (std::abs(angle) > most) {
            messages.warn("the display's views fill " + fixed(most, 1) +
                          " degrees to each side; beyond that they repeat");
        }
        job.eyes = {eyeAtAngle(display.calibration, angle)};
        job.files = {output};
    } else {
        const std::vector<int> views = chosenViews(*list, count);
        for (const int view : views) {
            job.eyes.push_back(eyeAtView(view, count));
            if (!job.quilt) job.files.push_back(output / viewFileName(view, count));
        }
        if (job.quilt)
            job.files = {quiltFileName(output, layout, display.aspect())};
        else if (views.size() == 1)
            job.files = {output};
    }
    const auto distance = commandLine.number("distance", 10, 1000);
    if (commandLine.has("eye")) {
        for (LensEye& eye : job.eyes)
            eye.blur = eyeBlur(display.calibration, distance.value_or(50));
    } else if (distance) {
        throw UsageError("--distance is that of the eye, expected --eye with it");
    }
    const bool directory = job.files.size() > 1;
    if (directory && canWriteImage(output)) {
        throw UsageError(output.string() +
                         ": names one file, expected a directory for the pictures of several "
                         "views (--quilt-out puts all into one picture)");
    }
    if (!directory) requirePictureName(job.files.front());
    return job;
}

Outputs checkedOutputs(const CommandLine& commandLine, const ChosenDisplay& display,
                       const Job& job) {
    Outputs outputs(commandLine.has("y"));
    outputs.addInput(commandLine.files()[0]);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    if (job.files.size() > 1) outputs.addDirectory(commandLine.files()[1]);
    for (const fs::path& file : job.files)
        outputs.addOutput(file);
    outputs.check();
    return outputs;
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) commandLine.failNames("NATIVE and OUT", 2);
    const fs::path& nativeFile = commandLine.files()[0];
    const ChosenDisplay display = findDisplay(commandLine, messages, {}, DisplayUse::Simulate);
    if (display.isMapOnly) {
        throw UsageError("a map does not contain the geometry of the lenses, expected the "
                         "display's calibration with -c");
    }
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages);
    const Job job = planJob(commandLine, display, layout, messages);
    requireFile(nativeFile);
    const Outputs outputs = checkedOutputs(commandLine, display, job);
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
    Progress progress(job.eyes.size());
    cv::Mat seen;
    cv::Mat sized;
    for (std::size_t i = 0; i < job.eyes.size(); ++i) {
        progress.step("view " + std::to_string(i + 1));
        simulateView(native, display.calibration, job.eyes[i], seen, display.invert);
        sized = seen;
        if (job.size) {
            const PhotoFit fit =
                fitPhoto(seen.size(), display.aspect(), *job.size, FitMode::Stretch);
            applyFit(seen, fit, sized);
        }
        if (job.quilt)
            sized.copyTo(quilt(layout.tile(static_cast<int>(i))));
        else
            writeImage(job.files[i], sized);
    }
    if (job.quilt) writeImage(job.files.front(), quilt);
    progress.clear();
    times.end("views");
    const bool several = job.files.size() > 1;
    messages.say((several ? commandLine.files()[1] : job.files.front()).string() + ": " +
                 counted(job.eyes.size(), "view") + ", " + sizeText(sized.size()) +
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
    commandLine.addOldName("quilt-out", "quilt-of-views");
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
    commandLine.addTerm(CommandLine::Chapter::Examples, "native.png middle.png",
                        "Show what an eye sees straight ahead.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "--angle -12 native.png left.png",
                        "Show what it sees from 12 degrees to the left.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "--view all native.png seen",
                        "Write each view to the directory seen.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "--eye --distance 70 native.png seen.png",
                        "Show how sharp it looks at 70 cm.");
    return runTool(argc, argv, commandLine, run);
}
