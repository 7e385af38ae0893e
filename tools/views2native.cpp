// views2native: turns a directory of sorted views into a Native.

#include "altiro3D/altiro3D.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"
#include "cli/picture_options.hpp"
#include "cli/print_options.hpp"
#include "cli/views_folder.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// @throws Error unless a directory holds views and nothing else
void requireViews(const fs::path& directory, const std::vector<fs::path>& files, int viewCount) {
    for (const fs::path& file : files)
        refuseNative(file, "views of one scene, a file for each");
    const std::size_t fewest = std::min(kFewestViews, static_cast<std::size_t>(viewCount));
    const std::string reason = reasonAgainstViews(files, fewest);
    if (reason.empty()) return;
    throw Error(ErrorCode::BadFormat, directory.string(),
                reason + ", expected at least " + std::to_string(fewest) +
                    " views of one scene from neighbouring cameras (to use other pictures as "
                    "views, name the files; photo2native makes Natives of photos; --flip shows "
                    "unrelated ones)");
}

// The command line.
struct ViewsJob {
    fs::path directory; // of the views; empty: each is named
    std::vector<fs::path> views;
    bool isReversed = false;
    fs::path native;
    fs::path quilt; // empty: it is not saved
    bool replace = false;
    std::optional<FitMode> fit;
    DisplayOptions display;
    QuiltRequest layout;
    QuiltSampling sampling;
    std::optional<PrintOptions> print;
    std::optional<FlipKind> flip;
};

ViewsJob viewsJob(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    if (names.size() < 2) commandLine.failNames("DIR and OUT", 2);
    ViewsJob job;
    job.native = names.back();
    job.fit = fitOption(commandLine);
    job.print = printOptions(commandLine);
    requireNativeName(job.native, job.print.has_value());
    constexpr std::pair<const char*, FlipKind> kFlips[] = {{"hard", FlipKind::Hard},
                                                           {"soft", FlipKind::Soft}};
    commandLine.take({{"reverse", job.isReversed},
                      {"save-quilt", job.quilt},
                      {"y", job.replace},
                      {"flip", job.flip, kFlips}});
    if (job.flip && names.size() == 2 && !isDirectory(names.front()))
        throw UsageError("--flip shows several pictures, expected two or more, or a directory");
    if (names.size() == 2) {
        job.directory = names.front();
    } else if (isDirectory(names.front())) {
        commandLine.failNames("one DIR or the names of views, and OUT", 2);
    } else {
        job.views.assign(names.begin(), names.end() - 1);
    }
    job.display = displayOptions(commandLine);
    job.layout = quiltRequest(commandLine);
    job.sampling = pictureSampling(commandLine);
    return job;
}

int makeNative(const ViewsJob& job, Messages& messages) {
    Notes notes;
    const std::vector<fs::path> sorted =
        job.directory.empty() ? job.views : listViews(job.directory, &notes);
    messages.warn(notes);
    std::vector<fs::path> files = sorted;
    if (job.isReversed) std::reverse(files.begin(), files.end());
    Outputs outputs(job.replace);
    outputs.addInputs(files);
    outputs.addNative(job.native);
    StageTimes times;
    ChosenDisplay display = findDisplay(job.display, messages);
    const std::optional<PrintSheet> print = printSheet(job.print, display, messages);
    outputs.addInputs(display.files);
    const QuiltLayout layout = chooseQuilt(job.layout, display, messages);
    fs::path quiltOutput;
    if (!job.quilt.empty()) {
        quiltOutput = quiltFileName(job.quilt, layout, display.aspect());
        requirePictureName(quiltOutput);
        outputs.addOutputs({quiltOutput});
    }
    outputs.check();
    if (!job.directory.empty() && !job.flip) requireViews(job.directory, sorted, layout.viewCount);

    messages.say("quilt: " + quiltText(layout, display.aspect()));
    Progress progress(files.size());
    const ViewsQuilt views = quiltOfViews(
        files, layout, display.aspect(), job.fit.value_or(FitMode::Cover), messages,
        [&progress](const fs::path& file) { progress.step(file.filename().string()); }, job.flip);
    progress.clear();
    times.end("read views");
    const double aspect = static_cast<double>(views.viewSize.width) / views.viewSize.height;
    if (!job.fit && !haveSameShape(aspect, display.aspect())) {
        messages.warn("the views have another shape than the panel and are cut to it; --fit "
                      "contain keeps all of them");
    }
    const Quilt2Native renderer = makeQuilt2Native(job.sampling, display, layout);
    times.end("look-up table");
    makeNativeFile(renderer, views.quilt, job.native, print, messages, times);
    if (!quiltOutput.empty()) {
        writeImage(quiltOutput, views.quilt);
        times.end("write quilt");
        messages.say(quiltOutput.string() + ": quilt");
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
    commandLine.addUsage("[options] VIEW... OUT.png");
    commandLine.addSection("Views");
    commandLine.add({"flip"},
                    "The pictures are unrelated and follow each other as the print is turned: one "
                    "at a time (hard), or with a soft change from each to the next (soft).",
                    "hard|soft");
    commandLine.add({"reverse"}, "The files run from the rightmost camera to the leftmost.");
    addFitOption(commandLine, "cover");
    commandLine.addSection("Output");
    commandLine.add({"save-quilt"}, "Also write the quilt (named ..._qs<columns>x<rows>a<aspect>).",
                    "FILE");
    commandLine.add({"y"}, "Replace outputs that exist.");
    addPrintOptions(commandLine);
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine, "linear");
    commandLine.addNote(
        "Numbers in names are sorted by value: view9.png comes before view10.png. If "
        "there are more or fewer pictures than views, each view takes the picture "
        "nearest to it.");
    commandLine.addNote(
        "A directory must hold views of one scene and no other pictures: at least " +
        std::to_string(kFewestViews) +
        " (fewer if the quilt has fewer views), of one size, with one number in their names that "
        "counts in equal steps. Files that are named one by one are used as views in the given "
        "order, whatever they show.");
    commandLine.addNote("Views may be " + readableFormats() + ".");
    commandLine.addExample("views native.png", "Make a Native of the pictures in a directory.");
    commandLine.addExample("--reverse views reversed.png",
                           "The same for pictures that run from the right to the left.");
    commandLine.addExample("--flip hard holiday.jpg painted.png flip.png",
                           "Show one photo from one side and another from the other.");
    commandLine.addExample("--save-quilt scene.png views also.png",
                           "Also write the quilt, with its layout in the name.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return makeNative(viewsJob(given), messages);
    });
}
