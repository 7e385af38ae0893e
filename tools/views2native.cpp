// views2native: a directory of sorted views becomes a Native.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// The picture nearest to a view's camera position among `pictures` evenly spaced ones.
std::size_t pictureOfView(int view, int views, std::size_t pictures) {
    const double place = (viewPosition(view, views) + 1) / 2 * static_cast<double>(pictures - 1);
    return static_cast<std::size_t>(std::lround(place));
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) {
        throw UsageError("expected DIR and OUT, got " + std::to_string(commandLine.files().size()) +
                         " names; see views2native --help");
    }
    const fs::path& directory = commandLine.files()[0];
    const fs::path& output = commandLine.files()[1];
    const FitMode mode = fitOption(commandLine, FitMode::Cover);
    requirePictureName(output);
    std::vector<fs::path> files = listPictures(directory);
    if (files.empty()) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "holds no pictures, expected one file for each view");
    }
    if (commandLine.has("reverse")) std::reverse(files.begin(), files.end());
    Outputs outputs(commandLine.has("y"));
    for (const fs::path& file : files)
        outputs.addInput(file);
    outputs.addOutput(output);
    std::optional<fs::path> quiltOutput;
    StageTimes times;
    const Display display = findDisplay(commandLine, messages);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages);
    if (const auto name = commandLine.value("save-quilt")) {
        quiltOutput = quiltFileName(*name, layout, display.panelAspect());
        requirePictureName(*quiltOutput);
        outputs.addOutput(*quiltOutput);
    }
    outputs.check();

    messages.say("quilt: " + layout.text());
    if (files.size() != static_cast<std::size_t>(layout.viewCount)) {
        messages.warn(directory.string() + " holds " + std::to_string(files.size()) +
                      " pictures for " + std::to_string(layout.viewCount) +
                      " views: each view takes the picture nearest to it");
    }
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    cv::Size viewSize;
    Progress progress(files.size());
    for (std::size_t picture = 0; picture < files.size(); ++picture) {
        cv::Mat view; // read when the first of its tiles comes, not at all if it has none
        cv::Mat fitted;
        progress.step(files[picture].filename().string());
        for (int i = 0; i < layout.viewCount; ++i) {
            if (pictureOfView(i, layout.viewCount, files.size()) != picture) continue;
            if (view.empty()) {
                view = readPhotoFile(files[picture], messages);
                if (viewSize.area() == 0) viewSize = view.size();
                if (view.size() != viewSize) {
                    throw Error(
                        ErrorCode::Mismatch, files[picture].string(),
                        "has " + std::to_string(view.cols) + " x " + std::to_string(view.rows) +
                            " px, expected " + std::to_string(viewSize.width) + " x " +
                            std::to_string(viewSize.height) + " px like the views before it");
                }
                applyFit(view, fitPhoto(viewSize, display.panelAspect(), layout.tileSize, mode),
                         fitted);
            }
            fitted.copyTo(quilt(layout.tile(i)));
        }
    }
    progress.clear();
    times.end("read views");
    const double aspect = static_cast<double>(viewSize.width) / viewSize.height;
    if (std::abs(aspect / display.panelAspect() - 1) > 0.05) {
        messages.warn("the views have another shape than the panel: --fit " + fitName(mode) +
                      " is applied");
    }
    const Quilt2Native renderer = makeQuilt2Native(commandLine, display, layout, messages);
    times.end("look-up table");
    makeNativeFile(renderer, quilt, output, messages, times);
    if (quiltOutput) {
        writePicture(*quiltOutput, quilt);
        times.end("write quilt");
        messages.say(quiltOutput->string() + ": quilt");
    }
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine(
        "views2native", "Turns a directory of views, sorted by name from the leftmost camera to "
                        "the rightmost, into the Native picture for a display.");
    commandLine.addUsage("[options] DIR OUT.png");
    commandLine.addSection("Views");
    commandLine.add({"reverse"}, "The files run from the rightmost camera to the leftmost.");
    addFitOption(commandLine, "cover");
    commandLine.addSection("Output");
    commandLine.add({"save-quilt"}, "Also write the quilt (named ..._qs<columns>x<rows>a<aspect>).",
                    "FILE");
    commandLine.add({"y"}, "Replace outputs that exist.");
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine);
    commandLine.addNote("Names are sorted as people count: view9.png comes before view10.png. If "
                        "there are more or fewer pictures than views, each view takes the picture "
                        "nearest to it.");
    return runTool(argc, argv, commandLine, run);
}
