#include "common/quilt_options.hpp"

#include "altiro3D/error.hpp"
#include "common/cache.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr double kSameAspect = 0.0025; // of a panel and its name

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
    commandLine.addOldName("layout", "quilt");
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

QuiltSampling samplingOption(const CommandLine& commandLine) {
    const auto views = commandLine.choice("view-filter", {"nearest", "linear"});
    const auto inTile = commandLine.choice("sampling", {"nearest", "linear"});
    QuiltSampling sampling;
    if (views.value_or(0) == 1) sampling.views = ViewFilter::Linear;
    if (inTile.value_or(0) == 1) sampling.inTile = TileSampling::Linear;
    return sampling;
}

bool blends(const QuiltSampling& sampling) {
    return sampling.views != ViewFilter::Nearest || sampling.inTile != TileSampling::Nearest;
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

std::optional<QuiltGrid> gridOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("q");
    if (!text) return std::nullopt;
    try {
        return parseQuiltGrid(*text);
    } catch (const Error& error) {
        throw UsageError(inOptions(error).what());
    }
}

bool isLayoutStated(const CommandLine& commandLine, const fs::path& quiltFile) {
    return commandLine.has("q") || commandLine.has("r") || parseQuiltName(quiltFile).has_value();
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

QuiltLayout chooseQuilt(const CommandLine& commandLine, const ChosenDisplay& display,
                        Messages& messages, const std::optional<fs::path>& quiltFile,
                        std::optional<cv::Size> quiltSize, const std::optional<FoundQuilt>& found) {
    QuiltRequest request;
    request.grid = gridOption(commandLine);
    try {
        if (const auto tile = commandLine.value("r")) request.tileSize = parseTileSize(*tile);
    } catch (const Error& error) {
        throw UsageError(inOptions(error).what());
    }
    if (quiltFile) request.name = parseQuiltName(*quiltFile);
    request.quiltSize = quiltSize;
    const bool stated = display.map && found && found->verdict != QuiltVerdict::Quilt; // by the map
    if (found && !stated)
        request.found = certainLayout(*found, *quiltFile, *quiltSize, display.quilt);
    const ResolvedQuilt resolved = resolveLayout(request, display.quilt, display.aspect());
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
    // of a nameless quilt the map states what it is
    if (!display.map || request.grid || request.tileSize || request.name)
        messages.warn(resolved.notes);
    return layout;
}

NativeLut lookUpTable(const ChosenDisplay& display, const QuiltLayout& layout, Messages& messages) {
    return display.map ? *display.map
                       : cachedLut(display.calibration, layout, display.invert, messages);
}

Quilt2Native makeQuilt2Native(const CommandLine& commandLine, const ChosenDisplay& display,
                              const QuiltLayout& layout, Messages& messages) {
    QuiltSampling sampling = samplingOption(commandLine);
    // px of a view are larger than those of the panel; repeated ones become coloured noise
    if (!commandLine.has("sampling") && !display.map) sampling.inTile = TileSampling::Linear;
    if (blends(sampling)) return {display.calibration, layout, sampling, display.invert};
    return Quilt2Native(lookUpTable(display, layout, messages));
}

} // namespace altiro3D::tools
