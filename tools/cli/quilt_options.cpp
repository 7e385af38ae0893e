#include "cli/quilt_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr double kSameAspect = 0.0025; // largest relative error of a short name

// An error of the library about a quilt, with the option's name as its subject.
Error inOptions(const Error& error) {
    const std::string text = error.what();
    for (const auto& [subject, option] : {std::pair("quilt grid", "-q"), {"view size", "-r"}}) {
        const std::string beginning = std::string(subject) + ": ";
        if (text.rfind(beginning, 0) == 0)
            return {error.code(), option, text.substr(beginning.size())};
    }
    return error;
}

// "16:9", or "1.85:1" for what has no short name
std::string aspectText(double aspect) {
    constexpr int kMax = 21;
    for (int height = 1; height <= kMax; ++height) {
        const int width = static_cast<int>(std::lround(aspect * height));
        if (width < 1 || width > kMax || std::min(width, height) > 10) continue;
        if (std::abs(static_cast<double>(width) / height / aspect - 1) < kSameAspect)
            return std::to_string(width) + ":" + std::to_string(height);
    }
    return fixed(aspect, 2) + ":1";
}

} // namespace

void addQuiltOptions(CommandLine& commandLine) {
    commandLine.add({"q", "layout"},
                    "Views in the quilt, rows x columns (default: the display model's; 6x8 on a "
                    "Portrait: 6 rows of 8 columns).",
                    "RxC");
    commandLine.addAdvanced(
        {"r", "resolution"},
        "Size of one view, height x width in px (default: the display model's; 560x420 "
        "on a Portrait).",
        "HxW");
}

void addSamplingOptions(CommandLine& commandLine, const std::string& standard) {
    commandLine.addAdvanced(
        {"view-filter"},
        "Views that a sub-pixel shows: nearest (default) or linear, a blend of two; "
        "not with -m.",
        "nearest|linear");
    commandLine.addAdvanced(
        {"sampling"},
        "Pixels inside a view: nearest, or linear, a blend of four (default " + standard +
            (standard == "linear" ? ", but nearest in videos and with -m)." : "; not with -m)."),
        "nearest|linear");
}

QuiltSampling samplingOption(const CommandLine& commandLine, TileSampling standard) {
    constexpr std::pair<const char*, TileSampling> kWords[] = {{"nearest", TileSampling::Nearest},
                                                               {"linear", TileSampling::Linear}};
    QuiltSampling sampling{viewFilterOption(commandLine), standard};
    commandLine.take({{"sampling", sampling.inTile, kWords}});
    return sampling;
}

QuiltSampling pictureSampling(const CommandLine& commandLine) {
    TileSampling standard = TileSampling::Linear;
    commandLine.take({{"m", standard, TileSampling::Nearest}});
    return samplingOption(commandLine, standard);
}

ViewFilter viewFilterOption(const CommandLine& commandLine) {
    constexpr std::pair<const char*, ViewFilter> kWords[] = {{"nearest", ViewFilter::Nearest},
                                                             {"linear", ViewFilter::Linear}};
    ViewFilter filter = ViewFilter::Nearest;
    commandLine.take({{"view-filter", filter, kWords}});
    return filter;
}

void tellShape(const QuiltShape& shape, Messages& messages) {
    if (shape.stretchesUnasked())
        messages.warnOfSubject(stretchText(shape) + "; --fit contain keeps the shape of the px");
    if (!shape.fitsUnasked()) return;
    messages.say("fit: by the file name the shape of the views differs from the panel's; black "
                 "bars keep it (--fit cover or stretch fills the panel)");
}

std::string stretchText(const QuiltShape& shape) {
    return "the views have the shape " + aspectText(shape.aspect()) +
           " by their px and are stretched to the panel's, " + aspectText(shape.shownAspect()) +
           ", as the file name does not state their shape";
}

std::string quiltText(const QuiltLayout& layout, double aspect) {
    std::string text = layout.text();
    const double ofTile = static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    if (!haveSameShape(ofTile, aspect)) text += ", shown " + aspectText(aspect);
    return text;
}

ResolvedQuilt resolveLayout(const QuiltRequest& request, const QuiltLayout& standard,
                            double panelAspect) {
    try {
        ResolvedQuilt resolved = resolveQuilt(request, standard, panelAspect);
        for (Note& note : resolved.notes)
            note.text += request.tileSize ? " (-q takes rows x columns, -r height x width)"
                                          : " (-q takes rows x columns)";
        return resolved;
    } catch (const Error& error) {
        throw inOptions(error);
    }
}

QuiltRequest quiltRequest(const CommandLine& commandLine) {
    QuiltRequest request;
    std::string grid;
    std::string tile;
    commandLine.take({{"q", grid}, {"r", tile}});
    try {
        if (!grid.empty()) request.grid = parseQuiltGrid(grid);
        if (!tile.empty()) request.tileSize = parseTileSize(tile);
    } catch (const Error& error) {
        throw UsageError(inOptions(error).what());
    }
    return request;
}

bool isLayoutStated(const QuiltRequest& request, const fs::path& quiltFile) {
    return request.grid || request.tileSize || parseQuiltName(quiltFile);
}

std::optional<QuiltGrid> certainLayout(const FoundQuilt& found, const fs::path& file, cv::Size size,
                                       const QuiltLayout& usual) {
    const QuiltGrid grid{found.layout.columns, found.layout.rows};
    switch (found.verdict) {
    case QuiltVerdict::Quilt:
        return grid;
    case QuiltVerdict::NoQuilt:
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is a photo or another picture of one view, expected a quilt (photo2native "
                    "makes a Native of a photo; -q ROWSxCOLUMNS reads any picture as a quilt)");
    case QuiltVerdict::Unsure:
        break;
    }
    if (found.isFromTop) {
        throw UsageError(
            file.string() + ": its rows of views seem to run from the top to the bottom (" +
            std::to_string(grid.columns) + " columns x " + std::to_string(grid.rows) +
            " rows), expected the first view at the bottom left; -q ROWSxCOLUMNS reads "
            "it as it is");
    }
    // a few px more or less, where views have a fractional size
    if (usual.tileSize == cv::Size(size.width / usual.columns, size.height / usual.rows))
        return std::nullopt;
    std::string problem = "its name does not state the layout, and the picture shows none clearly";
    if (found.confidence > 0) {
        problem += " (perhaps " + std::to_string(grid.columns) + " columns x " +
                   std::to_string(grid.rows) + " rows)";
    }
    throw UsageError(file.string() + ": " + problem +
                     ", expected -q ROWSxCOLUMNS, or a name that ends in "
                     "_qs<columns>x<rows>a<aspect>");
}

bool isQuiltPicture(const FoundQuilt& found, cv::Size picture, const QuiltLayout& usual) {
    if (found.verdict != QuiltVerdict::Unsure) return found.verdict == QuiltVerdict::Quilt;
    return cv::Size(picture.width / usual.columns, picture.height / usual.rows) == usual.tileSize;
}

std::string foundText(const FoundQuilt& found) {
    if (found.verdict != QuiltVerdict::Quilt) return "";
    return "; found in the picture, " + fixed(100 * found.confidence, 0) + " % sure";
}

QuiltLayout chooseQuilt(QuiltRequest request, const ChosenDisplay& display, Messages& messages,
                        const std::optional<fs::path>& quiltFile, std::optional<cv::Size> quiltSize,
                        const std::optional<FoundQuilt>& found) {
    if (quiltFile) request.name = parseQuiltName(*quiltFile);
    request.quiltSize = quiltSize;
    const QuiltLayout usual = display.map ? display.quilt : usualQuilt(display, request);
    const bool stated = display.map && found && found->verdict != QuiltVerdict::Quilt; // by the map
    if (found && !stated) request.found = certainLayout(*found, *quiltFile, *quiltSize, usual);
    const ResolvedQuilt resolved = resolveLayout(request, usual, display.aspect());
    QuiltLayout layout = resolved.layout;
    if (display.map) {
        const QuiltLayout& mapped = display.map->quilt();
        layout.viewCount = mapped.viewCount;
        if (layout != mapped) {
            throw Error(ErrorCode::Mismatch, display.source,
                        "is made for a quilt of " + sizeText(mapped.size()) + " with " +
                            mapped.text() + ", but this one has " + sizeText(layout.size()) +
                            " with " + layout.text() + "; expected the map's");
        }
    }
    // without these, only the map states the layout, which is then certain
    if (!display.map || request.grid || request.tileSize || request.name)
        messages.warn(resolved.notes);
    return layout;
}

Quilt2Native makeQuilt2Native(const QuiltSampling& sampling, const ChosenDisplay& display,
                              const QuiltLayout& layout) {
    if (display.map && !sampling.blends() && !display.calibration.sheet)
        return Quilt2Native(*display.map);
    return {display.calibration, layout, sampling, display.invert};
}

void makeNativeFile(const Quilt2Native& renderer, const cv::Mat& quilt,
                    const std::filesystem::path& output, const std::optional<PrintSheet>& print,
                    Messages& messages, StageTimes& times) {
    if (print) {
        print->write(output, [&](const RowSink& rows) { renderer.render(quilt, rows); });
        times.end("render and write");
        messages.say(output.string() + ": print, " + sizeText(print->size()));
        return;
    }
    cv::Mat native;
    renderer.render(quilt, native);
    times.end("render");
    warnAboutNativeFormat(output, messages);
    writePicture(output, native, ImageMark::Native);
    times.end("write");
    messages.say(nameOf(output, "standard output") + ": Native, " + sizeText(native.size()));
}

} // namespace altiro3D::tools
