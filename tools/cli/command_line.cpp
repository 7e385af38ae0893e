#include "cli/command_line.hpp"

#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numeric>
#include <sstream>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxTypos = 2;
constexpr std::size_t kHelpColumn = 30;
constexpr std::size_t kHelpWidth = 96;
constexpr std::ptrdiff_t kFewOptions = 20; // up to this number, --help shows all options

// The terms that the help of a tool explains if it uses them.
const std::pair<const char*, const char*> kWords[] = {
    {"Native",
     "the picture for the panel: each sub-pixel shows the view that its lens sends to one "
     "direction; it must not be scaled"},
    {"view", "the scene from one camera position; view 0 is the leftmost"},
    {"quilt", "a collage of all views, view 0 at the bottom left"},
    {"depth", "a grey picture that shows how near each pixel is; near is white"},
    {"RGB-D", "a photo and its depth side by side in one image"},
    {"parallax", "how far a thing moves between two views"},
    {"calibration",
     "the file visual.json: the geometry of the lenses of one display; its USB volume holds "
     "the file in LKG_calibration/"},
    {"map", "a look-up table made of a calibration and the layout of a quilt"},
    {"cover", "fill the frame, cut off the rest"},
    {"contain", "show everything, with black bars"},
    {"stretch", "fill the frame, distort the shape"},
};

// Whether a text has a word, or its plural, with no letter or digit beside it.
bool hasWord(const std::string& text, const std::string& word) {
    const auto isLetter = [&](std::size_t at) {
        return at < text.size() &&
               (std::isalnum(static_cast<unsigned char>(text[at])) != 0 || text[at] == '_');
    };
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        if (at > 0 && isLetter(at - 1)) continue;
        if (!isLetter(end) || (text[end] == 's' && !isLetter(end + 1))) return true;
    }
    return false;
}

// Each byte becomes one character and back, so that any file name is preserved.
QString fromBytes(const std::string& bytes) {
    return QString::fromLatin1(bytes.data(), static_cast<int>(bytes.size()));
}

std::string toBytes(const QString& text) {
    return text.toLatin1().toStdString();
}

// The number of letters to change, add or remove to turn one word into the other (Levenshtein).
std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = corner + (a[i] == b[j] ? 0 : 1);
            corner = row[j + 1];
            row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

// Appends words, broken into lines that begin at `indent`; `column` is where the first one begins.
void wrap(std::string& out, const std::string& text, std::size_t indent, std::size_t column) {
    std::istringstream words(text);
    std::string word;
    bool first = true;
    while (words >> word) {
        if (!first && column + 1 + word.size() > kHelpWidth) {
            out += "\n" + std::string(indent, ' ');
            column = indent;
            first = true;
        }
        if (!first) out += ' ';
        column += word.size() + (first ? 0 : 1);
        out += word;
        first = false;
    }
    out += "\n";
}

} // namespace

std::string joined(const std::vector<std::string>& words, const std::string& between,
                   const std::optional<std::string>& beforeLast) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (i > 0) text += i + 1 == words.size() ? beforeLast.value_or(between) : between;
        text += words[i];
    }
    return text;
}

CommandLine::CommandLine(std::string name, std::string summary)
    : name_(std::move(name)), summary_(std::move(summary)) {
    parser_.setOptionsAfterPositionalArgumentsMode(QCommandLineParser::ParseAsOptions);
}

std::vector<std::string> CommandLine::HelpEntry::dashedNames() const {
    std::vector<std::string> all;
    for (const std::string& name : names)
        all.push_back(dashed(name));
    return all;
}

void CommandLine::add(const std::vector<std::string>& names, const std::string& description,
                      const std::string& valueName,
                      const std::function<std::vector<std::string>()>& known) {
    options_.insert(names.begin(), names.end());
    HelpEntry entry{{}, description, names, valueName, known, false};
    entry.left = joined(entry.dashedNames()) + (valueName.empty() ? "" : " " + valueName);
    entries_.push_back(entry);
}

void CommandLine::addAdvanced(const std::vector<std::string>& names, const std::string& description,
                              const std::string& valueName,
                              const std::function<std::vector<std::string>()>& known) {
    add(names, description, valueName, known);
    entries_.back().isAdvanced = true;
}

void CommandLine::addHidden(const std::string& name, const std::string& valueName) {
    options_.insert(name);
    parser_.addOption(QCommandLineOption(fromBytes(name), QString(), fromBytes(valueName)));
}

CommandLine::Terms CommandLine::terms(Chapter chapter) const {
    const auto found = chapters_.find(chapter);
    return found == chapters_.end() ? Terms() : found->second;
}

bool CommandLine::hasMore() const {
    const auto options = [&](bool basicToo) {
        return std::count_if(entries_.begin(), entries_.end(), [&](const HelpEntry& entry) {
            return !entry.names.empty() && (basicToo || entry.isAdvanced);
        });
    };
    return options(true) > kFewOptions && options(false) > 0;
}

std::vector<CommandLine::HelpEntry> CommandLine::shown(bool all) const {
    std::vector<HelpEntry> entries;
    const auto endSection = [&] { // one without options
        if (!entries.empty() && entries.back().names.empty()) entries.pop_back();
    };
    for (const HelpEntry& entry : entries_) {
        if (entry.names.empty()) endSection();
        if (all || !entry.isAdvanced) entries.push_back(entry);
    }
    endSection();
    return entries;
}

CommandLine::Terms CommandLine::words(const std::vector<HelpEntry>& entries) const {
    std::string text = summary_;
    for (const HelpEntry& entry : entries)
        text += "\n" + entry.left + "\n" + entry.text;
    for (const std::string& note : notes_)
        text += "\n" + note;
    Terms used;
    for (const auto& [word, meaning] : kWords) {
        std::string first = word; // of a sentence
        first[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(first[0])));
        if (hasWord(text, word) || hasWord(text, first)) used.emplace_back(word, meaning);
    }
    return used;
}

void CommandLine::parse(const std::vector<std::string>& words) {
    for (const HelpEntry& entry : entries_) {
        QStringList names;
        for (const std::string& name : entry.names)
            names << fromBytes(name);
        if (!names.empty())
            parser_.addOption(QCommandLineOption(names, QString(), fromBytes(entry.valueName)));
    }
    QStringList arguments;
    for (const std::string& word : words)
        arguments << fromBytes(word);
    if (!parser_.parse(arguments)) {
        std::string problem = toBytes(parser_.errorText());
        if (!problem.empty() && problem.back() == '.') problem.pop_back();
        problem += suggestion(words);
        throw UsageError(problem + "; see " + name_ + " --help");
    }
    for (const QString& file : parser_.positionalArguments()) {
        if (file.isEmpty()) throw UsageError("a name is empty; see " + name_ + " --help");
        files_.emplace_back(toBytes(file));
    }
}

std::string CommandLine::suggestion(const std::vector<std::string>& words) const {
    for (auto at = words.begin() + 1; at < words.end(); ++at) {
        const std::string& word = *at;
        if (word == "--") break;
        const std::size_t dashes = std::min(word.find_first_not_of('-'), word.size());
        const std::string name = word.substr(dashes, word.find('=') - dashes);
        if (dashes == 1 && name.size() > 1 && options_.count(name) > 0)
            return "; long options have two dashes: --" + name;
        if (dashes != 2 || options_.count(name) > 0) continue;
        std::string nearest;
        std::size_t typos = std::min(kMaxTypos, name.size() / 3) + 1;
        for (const HelpEntry& entry : entries_) { // not the hidden ones
            for (const std::string& known : entry.names) {
                if (known.size() < 2 || editDistance(name, known) >= typos) continue;
                typos = editDistance(name, known);
                nearest = known;
            }
        }
        if (!nearest.empty()) return ", did you mean --" + nearest + "?";
    }
    return {};
}

std::string CommandLine::help(bool all) const {
    const bool leavesOut = !all && hasMore();
    const std::vector<HelpEntry> entries = shown(!leavesOut);
    std::string out;
    for (std::size_t i = 0; i < usages_.size(); ++i) {
        out += (i == 0 ? "Usage: " : "       ") + name_ + " " + usages_[i] + "\n";
    }
    out += "\n";
    wrap(out, summary_, 0, 0);
    const auto addLine = [&](const std::string& term, const std::string& text) {
        std::string left = "  " + term;
        if (left.size() + 2 > kHelpColumn) {
            out += left + "\n" + std::string(kHelpColumn, ' ');
        } else {
            left.resize(kHelpColumn, ' ');
            out += left;
        }
        wrap(out, text, kHelpColumn, kHelpColumn);
    };
    const auto addTerms = [&](const std::string& title, const Terms& terms) {
        if (!terms.empty()) out += "\n" + title + ":\n";
        for (const auto& [term, meaning] : terms)
            addLine(term, meaning);
    };
    for (const HelpEntry& entry : entries) {
        if (entry.left.empty()) {
            out += "\n" + entry.text + ":\n";
        } else {
            addLine(entry.left, entry.text);
        }
    }
    if (leavesOut) {
        const auto left = std::count_if(entries_.begin(), entries_.end(),
                                        [](const HelpEntry& entry) { return entry.isAdvanced; });
        out += "\n" + counted(left, "more option") + ": " + name_ + " --help-all\n";
    }
    addTerms("Keys", terms(Chapter::Keys));
    addTerms("Words", words(entries));
    for (const std::string& note : notes_) {
        out += "\n";
        wrap(out, note, 0, 0);
    }
    const Terms examples = terms(Chapter::Examples);
    if (!examples.empty()) out += "\nExamples:\n";
    for (const auto& [arguments, meaning] : examples) {
        constexpr std::size_t kIndent = 6;
        out += "  " + name_ + " " + arguments + "\n" + std::string(kIndent, ' ');
        wrap(out, meaning, kIndent, kIndent);
    }
    return out;
}

bool CommandLine::has(const std::string& option) const {
    return options_.count(option) > 0 && parser_.isSet(fromBytes(option));
}

void CommandLine::checkValue(const std::string& option, const std::string& text) const {
    if (text.empty()) throw UsageError(dashed(option) + " is empty; see " + name_ + " --help");
    const std::size_t dashes = std::min(text.find_first_not_of('-'), text.size());
    const std::string name = text.substr(dashes, text.find('=') - dashes);
    if (dashes == (name.size() == 1 ? 1 : 2) && options_.count(name) > 0) {
        throw UsageError(dashed(option) + " takes a value, but " + text +
                         " follows, which is an option; see " + name_ + " --help");
    }
}

std::optional<std::string> CommandLine::value(const std::string& option) const {
    if (!has(option)) return std::nullopt;
    const std::string text = toBytes(parser_.value(fromBytes(option)));
    checkValue(option, text);
    return text;
}

std::vector<std::string> CommandLine::values(const std::string& option) const {
    std::vector<std::string> all;
    if (!has(option)) return all;
    for (const QString& text : parser_.values(fromBytes(option))) {
        all.push_back(toBytes(text));
        if (all.back().empty())
            throw UsageError(dashed(option) + " is empty; see " + name_ + " --help");
    }
    return all;
}

std::vector<std::pair<std::string, std::string>> CommandLine::given() const {
    std::vector<std::pair<std::string, std::string>> all;
    for (const HelpEntry& entry : entries_) {
        if (entry.names.empty() || !has(entry.names.front())) continue;
        all.emplace_back(entry.names.front(),
                         toBytes(parser_.value(fromBytes(entry.names.front()))));
    }
    return all;
}

std::optional<double> CommandLine::number(const std::string& option, double low,
                                          double high) const {
    const std::optional<std::string> text = value(option);
    if (!text) return std::nullopt;
    double result = 0;
    const char* end = text->data() + text->size();
    const auto parsed = std::from_chars(text->data(), end, result);
    if (parsed.ec != std::errc() || parsed.ptr != end || !(result >= low && result <= high))
        failValue(option, "a number " + numberText(low) + ".." + numberText(high));
    return result;
}

std::optional<int> CommandLine::wholeNumber(const std::string& option, int low, int high) const {
    const std::optional<double> value = number(option, low, high);
    if (!value) return std::nullopt;
    if (*value != static_cast<int>(*value))
        failValue(option, "a whole number " + std::to_string(low) + ".." + std::to_string(high));
    return static_cast<int>(*value);
}

std::optional<std::size_t> CommandLine::choice(const std::string& option,
                                               const std::vector<std::string>& words) const {
    const std::optional<std::string> text = value(option);
    if (!text) return std::nullopt;
    const auto found = std::find(words.begin(), words.end(), *text);
    if (found == words.end()) failValue(option, joined(words, ", ", " or "));
    return static_cast<std::size_t>(found - words.begin());
}

void CommandLine::take(std::initializer_list<OptionField> options) const {
    for (const OptionField& option : options)
        option.take(*this);
}

void CommandLine::takeNames(const std::string& expected,
                            std::initializer_list<fs::path*> names) const {
    if (files_.size() != names.size()) failNames(expected, names.size());
    auto file = files_.begin();
    for (fs::path* name : names)
        *name = *file++;
}

void CommandLine::failValue(const std::string& option, const std::string& expected) const {
    throw UsageError(dashed(option) + " is \"" + *value(option) + "\", expected " + expected);
}

void CommandLine::failNames(const std::string& expected, std::size_t count) const {
    std::string got = counted(files_.size(), "name");
    for (const auto& [option, taken] : given()) { // an option may have taken a name for its value
        const bool isPicture = canWriteImage(taken) || canWriteVideo(taken);
        if (files_.size() < count && isPicture)
            got += " (" + dashed(option) + " took " + taken + ")";
    }
    throw UsageError("expected " + expected + ", got " + got + "; see " + name_ + " --help");
}

void CommandLine::exclude(const std::string& option, const std::string& other) const {
    if (has(option) && has(other)) {
        throw UsageError(dashed(option) + " and " + dashed(other) + " exclude each other; see " +
                         name_ + " --help");
    }
}

void CommandLine::exclude(const std::string& option,
                          std::initializer_list<const char*> others) const {
    for (const char* other : others)
        exclude(option, other);
}

void CommandLine::refuse(std::initializer_list<const char*> options, const std::string& why) const {
    for (const std::string option : options)
        if (has(option)) throw UsageError(dashed(option) + why);
}

} // namespace altiro3D::tools
