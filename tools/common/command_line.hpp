#pragma once

#include <QCommandLineParser>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

/// The user called the tool in a way it cannot be called: exit status 2.
class UsageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// "1 name", "2 names"
template <typename WholeNumber>
std::string counted(WholeNumber count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// The options of one tool, their help and their values.
///
/// Arguments are kept byte for byte (file names need not be UTF-8).
class CommandLine {
  public:
    /// @param name the tool's name @param summary one sentence: what it does
    CommandLine(std::string name, std::string summary);

    /// A way to call the tool, without its name: "[options] PHOTO OUT.png".
    void addUsage(const std::string& usage);
    /// Begins a group of options in the help.
    void addSection(const std::string& title);
    /// An option; `names` without dashes, `valueName` empty if it takes no value.
    /// @param known names that stand for a FILE, which shells complete as well
    void add(const std::vector<std::string>& names, const std::string& description,
             const std::string& valueName = {},
             const std::function<std::vector<std::string>()>& known = {});
    /// As add(), for an option that few people need: if the tool has many options, --help leaves it
    /// out. --help-all, the manual page and the completions have it.
    void addAdvanced(const std::vector<std::string>& names, const std::string& description,
                     const std::string& valueName = {},
                     const std::function<std::vector<std::string>()>& known = {});
    /// An option for programs that build the package; the help does not name it.
    void addHidden(const std::string& name, const std::string& valueName = {});
    /// An earlier name of an option, for scripts that use it; the help does not name it. Nothing
    /// where the tool already has an option of that name.
    void addOldName(const std::string& option, const std::string& oldName);
    /// An option of earlier versions, for scripts that use it: it has no effect, has() is false,
    /// and warnings() says so. The help does not name it.
    /// @param why it left
    void addDropped(const std::string& name, const std::string& why,
                    const std::string& valueName = {});
    /// A paragraph after the options.
    void addNote(const std::string& text);

    /// What stands after the options, in this order; Files and Environment in the manual only.
    enum class Chapter { Keys, Examples, Files, Environment };
    /// A line of a chapter: a key, a command (without the tool's name), a file or a variable.
    void addTerm(Chapter chapter, const std::string& term, const std::string& meaning);

    /// Reads the arguments. @throws UsageError
    void parse(int argc, char** argv);

    const std::string& name() const { return name_; }
    /// Whether --help leaves options out.
    bool hasMore() const;
    /// @param all also the options that few people need
    std::string help(bool all) const;
    /// Warnings about the arguments: options that have no effect any more.
    std::vector<std::string> warnings() const;
    /// The manual page for man(1): the help and the chapters that are in the manual only.
    /// @param version of the package
    std::string manPage(const std::string& version) const;
    /// Scripts with which shells complete options and names. What an option takes is told by the
    /// name of its value: FILE or a name with an extension, DIR, `one|of|these`, or anything.
    std::string bashCompletion() const;
    std::string zshCompletion() const; ///< See bashCompletion().

    /// Whether an option was given; no for one that the tool does not have.
    bool has(const std::string& option) const;
    /// What was given with an option. @throws UsageError if that is empty
    std::optional<std::string> value(const std::string& option) const;
    /// What stands without an option, in order.
    const std::vector<std::filesystem::path>& files() const { return files_; }

    /// All options that were given, by their first names, with their values.
    std::vector<std::pair<std::string, std::string>> given() const;

    /// A number in a range. @throws UsageError that names option, value and range
    std::optional<double> number(const std::string& option, double low, double high) const;
    /// A whole number in a range. @throws UsageError that names option, value and range
    std::optional<int> wholeNumber(const std::string& option, int low, int high) const;
    /// One of some words: its index. @throws UsageError that lists them
    std::optional<std::size_t> choice(const std::string& option,
                                      const std::vector<std::string>& words) const;
    /// Refuses a number of names that is not the expected one.
    /// @param expected "PHOTO and OUT" @param count how many these are
    [[noreturn]] void failNames(const std::string& expected, std::size_t count) const;
    /// Refuses options that make no sense together. @throws UsageError
    void exclude(const std::string& option, const std::string& other) const;

  private:
    struct HelpEntry {
        std::string left; // empty: a section title
        std::string text;
        std::vector<std::string> names;
        std::string valueName;
        std::function<std::vector<std::string>()> known;
        bool isAdvanced = false;
        std::vector<std::string> oldNames;
    };
    using Terms = std::vector<std::pair<std::string, std::string>>;
    static std::string dashed(const std::string& name);
    // The entries of the help, without sections that are empty.
    std::vector<HelpEntry> shown(bool all) const;
    // The words of the trade that these entries use, with their meanings.
    Terms words(const std::vector<HelpEntry>& entries) const;
    Terms terms(Chapter chapter) const;
    // What an unknown option may have been meant for; empty if nothing is near.
    std::string suggestion(int argc, char** argv) const;

    std::string name_;
    std::string summary_;
    std::vector<std::string> usages_;
    std::vector<HelpEntry> entries_;
    std::vector<std::string> notes_;
    std::map<Chapter, Terms> chapters_;
    std::set<std::string> options_;
    std::map<std::string, std::string> dropped_; // why each left
    QCommandLineParser parser_;
    std::vector<std::filesystem::path> files_;
};

} // namespace altiro3D::tools
