// quilt2native: a quilt becomes a Native.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"

#include <cmath>
#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace {

// Fits each view of a quilt to the panel's shape, tile by tile.
cv::Mat fitViews(const cv::Mat& quilt, const QuiltLayout& layout, double viewAspect,
                 double panelAspect, FitMode mode) {
    cv::Mat fitted(quilt.size(), quilt.type());
    // A tile shows viewAspect whatever its px: fit in a space where that is so.
    const int height = layout.tileSize.height;
    const cv::Size shown(std::max(1, static_cast<int>(std::lround(height * viewAspect))), height);
    const PhotoFit toShown = fitPhoto(layout.tileSize, viewAspect, shown, FitMode::Stretch);
    const PhotoFit toPanel = fitPhoto(shown, panelAspect, layout.tileSize, mode);
    cv::parallel_for_(cv::Range(0, layout.columns * layout.rows), [&](const cv::Range& tiles) {
        cv::Mat view;
        for (int i = tiles.start; i < tiles.end; ++i) {
            applyFit(quilt(layout.tile(i)), toShown, view);
            applyFit(view, toPanel, view);
            view.copyTo(fitted(layout.tile(i)));
        }
    });
    return fitted;
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) {
        throw UsageError("expected QUILT and OUT, got " +
                         std::to_string(commandLine.files().size()) +
                         " names; see quilt2native --help");
    }
    const std::filesystem::path& quiltFile = commandLine.files()[0];
    const std::filesystem::path& output = commandLine.files()[1];
    const FitMode fit = fitOption(commandLine, FitMode::Stretch);
    requirePictureName(output);
    StageTimes times;
    const Display display = findDisplay(commandLine, messages);
    Outputs outputs(commandLine.has("y"));
    outputs.addInput(quiltFile);
    for (const std::filesystem::path& file : display.files)
        outputs.addInput(file);
    outputs.addOutput(output);
    outputs.check();

    cv::Mat quilt = readPhotoFile(quiltFile, messages);
    times.end("read");
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages, quiltFile, quilt.size());
    messages.say("quilt: " + layout.text());
    const auto name = parseQuiltName(quiltFile);
    const double viewAspect =
        name && name->aspect ? *name->aspect
                             : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    std::vector<std::string> notes;
    quilt = fitQuilt(quilt, layout, &notes);
    for (const std::string& note : notes)
        messages.warn(note);
    if (fit != FitMode::Stretch) {
        quilt = fitViews(quilt, layout, viewAspect, display.panelAspect(), fit);
    } else if (name && name->aspect && std::abs(viewAspect / display.panelAspect() - 1) > 0.05) {
        messages.warn("the file name says that the views are meant for another shape than the "
                      "panel's; they are stretched to it (--fit contain or cover keep theirs)");
    }
    const Quilt2Native renderer = makeQuilt2Native(commandLine, display, layout, messages);
    times.end("look-up table");
    makeNativeFile(renderer, quilt, output, messages, times);
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("quilt2native", "Turns a quilt, the collage of all views, into the "
                                            "Native picture for a display.");
    commandLine.addUsage("[options] QUILT OUT.png");
    commandLine.addSection("Output");
    commandLine.add({"y"}, "Replace the output if it exists.");
    addDisplayOptions(commandLine);
    addFitOption(commandLine, "stretch");
    addSamplingOptions(commandLine);
    commandLine.addNote("A file name that ends in _qs<columns>x<rows>a<aspect>, such as "
                        "photo_qs8x6a0.75.png, tells the layout; otherwise it is the display's own "
                        "or that of -q. View 0 is the bottom-left tile.");
    return runTool(argc, argv, commandLine, run);
}
