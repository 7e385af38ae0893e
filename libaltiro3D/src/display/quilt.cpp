#include "altiro3D/quilt.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <charconv>
#include <cmath>

namespace altiro3D {

namespace {

constexpr int kMaxTilesPerSide = 1024;
constexpr double kAspectTolerance = 0.05;
// Subjects of errors.
constexpr const char* kGrid = "quilt grid";
constexpr const char* kTile = "view size";

// What is left of a text that is read from its beginning.
struct Reading {
    std::string_view left;

    bool take(char lowerCaseLetter) {
        if (left.empty() || lowerCase(left.front()) != lowerCaseLetter) return false;
        left.remove_prefix(1);
        return true;
    }
    // All digits that follow, and no more than `most`.
    std::optional<int> whole(std::size_t most) {
        std::size_t digits = 0;
        while (digits < left.size() && isDigit(left[digits]))
            ++digits;
        if (digits == 0 || digits > most) return std::nullopt;
        int number = 0;
        std::from_chars(left.data(), left.data() + digits, number);
        left.remove_prefix(digits);
        return number;
    }
    // "0.75", not ".75" nor "1e3".
    std::optional<double> number() {
        double number = 0;
        if (left.empty() || !isDigit(left.front())) return std::nullopt;
        const std::size_t read = readNumber(left, number);
        if (read == 0) return std::nullopt;
        left.remove_prefix(read);
        return number;
    }
};

// Parses "AxB", whole numbers of at most five digits; the error explains the order.
std::pair<int, int> parsePair(const std::string& text, const char* subject, const char* expected) {
    constexpr std::size_t kMaxDigits = 5;
    Reading reading{text};
    const std::optional<int> first = reading.whole(kMaxDigits);
    const std::optional<int> second =
        first && reading.take('x') ? reading.whole(kMaxDigits) : std::nullopt;
    if (!second || !reading.left.empty() || *first < 1 || *second < 1) {
        throw Error(ErrorCode::InvalidArgument, subject,
                    "\"" + text + "\" is not understood, expected " + expected);
    }
    return {*first, *second};
}

// `_qs8x6`, `_qs8x6a0.75` at the beginning of a text, not followed by a letter or a digit.
struct QuiltSuffix {
    QuiltName name;
    std::string text;
};

std::optional<QuiltSuffix> parseSuffix(std::string_view text) {
    constexpr std::size_t kMaxDigits = 4;
    Reading reading{text};
    QuiltSuffix suffix;
    if (!reading.take('_') || !reading.take('q') || !reading.take('s')) return std::nullopt;
    const std::optional<int> columns = reading.whole(kMaxDigits);
    if (!columns || !reading.take('x')) return std::nullopt;
    const std::optional<int> rows = reading.whole(kMaxDigits);
    if (!rows) return std::nullopt;
    suffix.name.grid = {*columns, *rows};
    if (reading.take('a')) {
        suffix.name.aspect = reading.number();
        if (!suffix.name.aspect) return std::nullopt;
    }
    const char next = reading.left.empty() ? '\0' : lowerCase(reading.left.front());
    if (isDigit(next) || (next >= 'a' && next <= 'z')) return std::nullopt;
    suffix.text = text.substr(0, text.size() - reading.left.size());
    return suffix;
}

double aspectOf(cv::Size size) {
    return static_cast<double>(size.width) / size.height;
}

bool fits(double aspect, double panelAspect) {
    return std::abs(aspect / panelAspect - 1) <= kAspectTolerance;
}

bool holdsTiles(QuiltGrid grid) {
    return grid.columns >= 1 && grid.columns <= kMaxTilesPerSide && grid.rows >= 1 &&
           grid.rows <= kMaxTilesPerSide;
}

std::string textOf(QuiltGrid grid) {
    return std::to_string(grid.columns) + " columns x " + std::to_string(grid.rows) + " rows";
}

QuiltGrid gridOf(const QuiltLayout& layout) {
    return {layout.columns, layout.rows};
}

bool areSame(QuiltGrid a, QuiltGrid b) {
    return a.columns == b.columns && a.rows == b.rows;
}

void checkGrid(QuiltGrid grid) {
    if (holdsTiles(grid)) return;
    throw Error(ErrorCode::InvalidArgument, "quilt layout",
                textOf(grid) + ", expected 1..1024 of each");
}

// Whether file names of quilts can hold this aspect.
bool isNamed(double aspect) {
    return aspect >= 0.1 && aspect <= 10;
}

cv::Size tileOf(cv::Size quilt, QuiltGrid grid) {
    return {quilt.width / grid.columns, quilt.height / grid.rows};
}

} // namespace

std::string QuiltLayout::text() const {
    std::string text = textOf(gridOf(*this)) + ", each view " + sizeText(tileSize);
    if (viewCount != columns * rows) text += ", " + std::to_string(viewCount) + " views";
    return text;
}

void validate(const QuiltLayout& layout) {
    const auto fail = [](ErrorCode code, const std::string& problem) {
        throw Error(code, "quilt layout", problem);
    };
    checkGrid(gridOf(layout));
    if (layout.tileSize.width < 1 || layout.tileSize.height < 1) {
        fail(ErrorCode::InvalidArgument, "views of " + sizeText(layout.tileSize) +
                                             " (width x height), expected at least 1 x 1");
    }
    const std::int64_t width = std::int64_t{layout.columns} * layout.tileSize.width;
    const std::int64_t height = std::int64_t{layout.rows} * layout.tileSize.height;
    if (width > kMaxQuiltSide || height > kMaxQuiltSide) {
        fail(ErrorCode::TooLarge,
             pairText(width, height) + " px (width x height), expected at most 65535 a side");
    }
    if (layout.viewCount < 1 || layout.viewCount > layout.columns * layout.rows) {
        fail(ErrorCode::InvalidArgument, std::to_string(layout.viewCount) + " views, expected 1.." +
                                             std::to_string(layout.columns * layout.rows) +
                                             ", the number of tiles");
    }
}

double viewPosition(int view, int viewCount) {
    return viewCount > 1 ? 2.0 * view / (viewCount - 1) - 1 : 0;
}

QuiltGrid parseQuiltGrid(const std::string& text) {
    const auto [rows, columns] =
        parsePair(text, kGrid, "ROWSxCOLUMNS, for instance 6x8 for 6 rows of 8 columns");
    if (rows > kMaxTilesPerSide || columns > kMaxTilesPerSide) {
        throw Error(ErrorCode::InvalidArgument, kGrid,
                    "\"" + text + "\" is too many, expected ROWSxCOLUMNS of 1..1024 each");
    }
    return {columns, rows};
}

cv::Size parseTileSize(const std::string& text) {
    const auto [height, width] =
        parsePair(text, kTile, "HEIGHTxWIDTH of one view in px, for instance 560x420");
    return {width, height};
}

std::optional<QuiltName> parseQuiltName(const std::filesystem::path& file) {
    // `photo_qs8x6a0.75` without an extension: ".75" is the end of the aspect, not an extension
    const std::string extension = file.extension().string();
    const bool number = extension.size() > 1 && isDigit(extension[1]);
    const std::string stem = number ? file.filename().string() : file.stem().string();
    std::optional<QuiltSuffix> last;
    if (stem.size() > 3 && lowerCase(stem.substr(stem.size() - 3)) == "_cv")
        return QuiltName{{8, 5}, 0.5625};
    for (std::size_t at = stem.rfind('_'); at != std::string::npos && !last;
         at = at > 0 ? stem.rfind('_', at - 1) : std::string::npos) {
        last = parseSuffix(std::string_view(stem).substr(at));
    }
    if (!last) return std::nullopt;
    const QuiltName& name = last->name;
    if (!holdsTiles(name.grid) || !isNamed(name.aspect.value_or(1))) {
        throw Error(ErrorCode::InvalidArgument, file.string(),
                    "its name says \"" + shortened(last->text) +
                        "\", expected _qs<columns>x<rows>a<aspect> with 1..1024 columns and rows "
                        "and an aspect of 0.1..10");
    }
    return name;
}

std::filesystem::path quiltFileName(const std::filesystem::path& file, const QuiltLayout& layout,
                                    double aspect) {
    checkGrid(gridOf(layout));
    std::string suffix = "_qs" + std::to_string(layout.columns) + "x" + std::to_string(layout.rows);
    if (isNamed(aspect)) suffix += "a" + numberText(aspect);
    if (const std::optional<QuiltName> name = parseQuiltName(file)) {
        const bool same =
            areSame(name->grid, gridOf(layout)) && (!name->aspect || fits(*name->aspect, aspect));
        if (same) return file;
        throw Error(ErrorCode::Mismatch, file.string(),
                    "its name says " + textOf(name->grid) + ", but the quilt has " + layout.text() +
                        "; expected a name that ends in " + suffix);
    }
    std::filesystem::path named = file;
    named.replace_filename(file.stem().string() + suffix + file.extension().string());
    return named;
}

ResolvedQuilt resolveQuilt(const QuiltRequest& request, const QuiltLayout& standard,
                           double panelAspect) {
    validate(standard);
    ResolvedQuilt resolved;
    QuiltLayout& layout = resolved.layout;
    QuiltGrid grid = gridOf(standard);
    if (request.found) grid = *request.found;
    if (request.grid) grid = *request.grid;
    if (request.name) {
        const QuiltGrid named = request.name->grid;
        if (request.grid && !areSame(named, grid)) {
            throw Error(ErrorCode::Mismatch, kGrid,
                        "says " + textOf(grid) + ", but the file name says " + textOf(named) +
                            "; expected the same in both");
        }
        grid = named;
    }
    checkGrid(grid);
    const cv::Size canvas = request.quiltSize.value_or(standard.size());
    const bool fixedTile = request.tileSize && !request.quiltSize;
    layout.columns = grid.columns;
    layout.rows = grid.rows;
    layout.viewCount = grid.columns * grid.rows;
    if (!request.grid && !request.name && !request.found) layout.viewCount = standard.viewCount;
    layout.tileSize = fixedTile ? *request.tileSize : tileOf(canvas, grid);
    if (request.quiltSize && request.tileSize && layout.tileSize != *request.tileSize) {
        throw Error(ErrorCode::Mismatch, kTile,
                    "says views of " + sizeText(*request.tileSize) +
                        " (width x height), but a quilt of " + sizeText(canvas) + " with " +
                        textOf(grid) + " has views of " + sizeText(layout.tileSize));
    }
    if (layout.tileSize.width < 1 || layout.tileSize.height < 1) {
        throw Error(ErrorCode::InvalidArgument, "quilt layout",
                    textOf(grid) + " do not fit into a quilt of " + sizeText(canvas) +
                        ", expected fewer");
    }
    validate(layout);
    if (!request.grid && !request.name && !request.found && !request.tileSize &&
        request.quiltSize.value_or(standard.size()) != standard.size()) {
        resolved.notes.push_back(
            {NoteCode::Doubtful,
             "the file's name does not state the layout, and its size, " + sizeText(canvas) +
                 ", is not that of the display's quilts; it is read as " + layout.text()});
    }

    // People use both orders. The warning points out that the other one fits better.
    const bool asked = request.grid || request.tileSize;
    if (asked && !request.name && !fits(aspectOf(layout.tileSize), panelAspect)) {
        const QuiltGrid swappedGrid = request.grid ? QuiltGrid{grid.rows, grid.columns} : grid;
        const cv::Size swappedTile =
            fixedTile ? cv::Size(request.tileSize->height, request.tileSize->width)
                      : tileOf(canvas, swappedGrid);
        if (!swappedTile.empty() && fits(aspectOf(swappedTile), panelAspect)) {
            QuiltLayout swapped = layout;
            swapped.columns = swappedGrid.columns;
            swapped.rows = swappedGrid.rows;
            swapped.tileSize = swappedTile;
            resolved.notes.push_back(
                {NoteCode::Doubtful,
                 "the layout is read as " + layout.text() +
                     ", whose views do not have the panel's shape; the swapped reading, " +
                     swapped.text() + ", would have it"});
        }
    }
    return resolved;
}

} // namespace altiro3D
