// views2native: turns a directory of sorted views into a Native.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_options.hpp"
#include "common/run_tool.hpp"
#include "common/views_quilt.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) commandLine.failNames("DIR and OUT", 2);
    const fs::path& directory = commandLine.files()[0];
    const fs::path& output = commandLine.files()[1];
    const FitMode mode = fitOption(commandLine, FitMode::Cover);
    requirePictureName(output);
    std::vector<fs::path> files = listImages(directory);
    if (files.empty()) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "holds no pictures, expected one file for each view");
    }
    if (commandLine.has("reverse")) std::reverse(files.begin(), files.end());
    Outputs outputs(commandLine.has("y"));
    for (const fs::path& file : files)
        outputs.addInput(file);
    outputs.addNative(output);
    std::optional<fs::path> quiltOutput;
    StageTimes times;
    const ChosenDisplay display = findDisplay(commandLine, messages);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages);
    if (const auto name = commandLine.value("save-quilt")) {
        quiltOutput = quiltFileName(*name, layout, display.aspect());
        requirePictureName(*quiltOutput);
        outputs.addOutput(*quiltOutput);
    }
    outputs.check();

    messages.say("quilt: " + quiltText(layout, display.aspect()));
    Progress progress(files.size());
    const ViewsQuilt views = quiltOfViews(
        directory, files, layout, display.aspect(), mode, messages,
        [&progress](const fs::path& file) { progress.step(file.filename().string()); });
    progress.clear();
    times.end("read views");
    const double aspect = static_cast<double>(views.viewSize.width) / views.viewSize.height;
    if (!commandLine.has("fit") && !haveSameShape(aspect, display.aspect())) {
        messages.warn("the views have another shape than the panel and are cut to it; --fit "
                      "contain keeps all of them");
    }
    const Quilt2Native renderer = makeQuilt2Native(commandLine, display, layout, messages);
    times.end("look-up table");
    makeNativeFile(renderer, views.quilt, output, messages, times);
    if (quiltOutput) {
        writeImage(*quiltOutput, views.quilt);
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
    commandLine.addNote(
        "Numbers in names are sorted by value: view9.png comes before view10.png. If "
        "there are more or fewer pictures than views, each view takes the picture "
        "nearest to it.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "views native.png",
                        "Make a Native of the pictures in a directory.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "--reverse views reversed.png",
                        "The same for pictures that run from the right to the left.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "--save-quilt scene.png views also.png",
                        "Also write the quilt, with its layout in the name.");
    return runTool(argc, argv, commandLine, run);
}
