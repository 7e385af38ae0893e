#pragma once

#include <QCommandLineParser>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace altiro3D::tools {

/// Wrong usage of a tool; leads to exit status 2.
class UsageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// "1 name", "2 names"
template <typename WholeNumber>
std::string counted(WholeNumber count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// The words with a text between them, and perhaps another before the last one.
std::string joined(const std::vector<std::string>& words, const std::string& between = ", ",
                   const std::optional<std::string>& beforeLast = {});

class OptionField;

/// The options of one tool, their help and their values.
///
/// Arguments are kept byte for byte, because file names need not be UTF-8.
class CommandLine {
  public:
    /// @param name the tool's name @param summary one sentence: what it does
    CommandLine(std::string name, std::string summary);

    /// Adds a usage line, without the tool's name: "[options] PHOTO OUT.png".
    void addUsage(const std::string& usage) { usages_.push_back(usage); }
    void addSection(const std::string& title) {
        entries_.push_back({"", title, {}, {}, {}, false});
    }
    /// Adds an option; `names` without dashes, `valueName` empty if it takes no value.
    /// @param known returns names that are accepted in place of a FILE; shells complete them
    void add(const std::vector<std::string>& names, const std::string& description,
             const std::string& valueName = {},
             const std::function<std::vector<std::string>()>& known = {});
    /// As add(), for an option that few users need: if the tool has many options, --help omits it.
    /// --help-all, the manual page and the completions list it.
    void addAdvanced(const std::vector<std::string>& names, const std::string& description,
                     const std::string& valueName = {},
                     const std::function<std::vector<std::string>()>& known = {});
    /// Adds an option for the build of the package; the help does not list it.
    void addHidden(const std::string& name, const std::string& valueName = {});
    void addNote(const std::string& text) { notes_.push_back(text); }

    /// Chapters after the options, in this order; Files and Environment in the manual only.
    enum class Chapter { Keys, Examples, Files, Environment };
    /// Adds a line to a chapter: a key, a command (without the tool's name), a file or a variable.
    void addTerm(Chapter chapter, const std::string& term, const std::string& meaning) {
        chapters_[chapter].emplace_back(term, meaning);
    }
    void addExample(const std::string& arguments, const std::string& meaning) {
        addTerm(Chapter::Examples, arguments, meaning);
    }

    /// @param words with the name of the tool @throws UsageError
    void parse(const std::vector<std::string>& words);

    const std::string& name() const { return name_; }
    /// Whether --help omits options.
    bool hasMore() const;
    /// @param all include the options that few users need
    std::string help(bool all) const;
    /// The manual page for man(1): the help and the chapters that are in the manual only.
    /// @param version of the package
    std::string manPage(const std::string& version) const;
    /// Script that completes options and names in a shell. The name of an option's value decides
    /// what is completed: FILE or a name with an extension, DIR, `one|of|these`; else nothing.
    std::string bashCompletion() const;
    std::string zshCompletion() const; ///< See bashCompletion().

    /// Whether an option was given; false for an option that the tool does not have.
    bool has(const std::string& option) const;
    /// The value of an option. @throws UsageError if it is empty or an option of the tool
    std::optional<std::string> value(const std::string& option) const;
    /// All values of an option that may be repeated. @throws UsageError if one is empty
    std::vector<std::string> values(const std::string& option) const;
    /// The arguments that do not belong to an option, in order.
    const std::vector<std::filesystem::path>& files() const { return files_; }

    /// All options that were given, by their first names, with their values.
    std::vector<std::pair<std::string, std::string>> given() const;

    /// A number in a range. @throws UsageError that names option, value and range
    std::optional<double> number(const std::string& option, double low, double high) const;
    /// A whole number in a range. @throws UsageError that names option, value and range
    std::optional<int> wholeNumber(const std::string& option, int low, int high) const;
    /// The index of an option's value in a list of words. @throws UsageError that lists them
    std::optional<std::size_t> choice(const std::string& option,
                                      const std::vector<std::string>& words) const;
    /// What an option's value stands for. @throws UsageError that lists the words
    template <typename Value, std::size_t N>
    std::optional<Value> oneOf(const std::string& option,
                               const std::pair<const char*, Value> (&named)[N]) const {
        std::vector<std::string> words;
        for (const auto& [word, value] : named)
            words.emplace_back(word);
        const auto index = choice(option, words);
        return index ? std::optional<Value>(named[*index].second) : std::nullopt;
    }
    /// Reads options into fields, in this order. The field of an option that was not given stays as
    /// it is. @throws UsageError
    void take(std::initializer_list<OptionField> options) const;
    /// Reads the names that do not belong to an option. @param expected "QUILT and OUT"
    /// @throws UsageError if there are more or fewer
    void takeNames(const std::string& expected,
                   std::initializer_list<std::filesystem::path*> names) const;
    /// Throws a UsageError because the number of names is wrong.
    /// @param expected "PHOTO and OUT" @param count number of names in `expected`
    [[noreturn]] void failNames(const std::string& expected, std::size_t count) const;
    /// Throws a UsageError because of an option's value: `--size is "7", expected ...`.
    [[noreturn]] void failValue(const std::string& option, const std::string& expected) const;
    /// Refuses two options that exclude each other. @throws UsageError
    void exclude(const std::string& option, const std::string& other) const;
    void exclude(const std::string& option, std::initializer_list<const char*> others) const;
    /// Refuses options. @param why follows the option's name @throws UsageError
    void refuse(std::initializer_list<const char*> options, const std::string& why) const;
    /// Refuses options that describe another one, if that is not given. @throws UsageError
    void refuseWithout(const std::string& other, std::initializer_list<const char*> options,
                       const std::string& why) const {
        if (!has(other)) refuse(options, why);
    }

  private:
    struct HelpEntry {
        std::string left; // empty: a section title
        std::string text;
        std::vector<std::string> names;
        std::string valueName;
        std::function<std::vector<std::string>()> known;
        bool isAdvanced = false;

        std::vector<std::string> dashedNames() const;
    };
    using Terms = std::vector<std::pair<std::string, std::string>>;
    static std::string dashed(const std::string& name) {
        return (name.size() == 1 ? "-" : "--") + name;
    }
    // The entries of the help, without empty sections.
    std::vector<HelpEntry> shown(bool all) const;
    // The technical terms that these entries use, with their meanings.
    Terms words(const std::vector<HelpEntry>& entries) const;
    Terms terms(Chapter chapter) const;
    // Refuses an empty value, and an option in place of one. @throws UsageError
    void checkValue(const std::string& option, const std::string& text) const;
    // The option that an unknown one may be a misspelling of; empty if none is similar.
    std::string suggestion(const std::vector<std::string>& words) const;

    std::string name_;
    std::string summary_;
    std::vector<std::string> usages_;
    std::vector<HelpEntry> entries_;
    std::vector<std::string> notes_;
    std::map<Chapter, Terms> chapters_;
    std::set<std::string> options_;
    QCommandLineParser parser_;
    std::vector<std::filesystem::path> files_;
};

/// An option and the field that it sets, for CommandLine::take().
class OptionField {
  public:
    /// A text or the name of a file.
    template <typename Value>
    OptionField(const char* option, Value& field)
        : take_([=, &field](const CommandLine& given) {
              if (const auto text = given.value(option)) field = *text;
          }) {}
    /// An option without a value. @param meant what it stands for
    template <typename Value, typename Meant>
    OptionField(const char* option, Value& field, const Meant& meant)
        : take_([=, &field](const CommandLine& given) {
              if (given.has(option)) field = meant;
          }) {}
    OptionField(const char* option, bool& field) : OptionField(option, field, true) {}
    /// One of a few words.
    template <typename Value, typename Meant, std::size_t N>
    OptionField(const char* option, Value& field, const std::pair<const char*, Meant> (&words)[N])
        : take_([=, &field, &words](const CommandLine& given) {
              if (const auto meant = given.oneOf(option, words)) field = *meant;
          }) {}
    /// A number in a range, for an int a whole one.
    template <typename Value>
    OptionField(const char* option, Value& field, double low, double high)
        : take_([=, &field](const CommandLine& given) {
              if constexpr (std::is_same_v<Value, int> ||
                            std::is_same_v<Value, std::optional<int>>) {
                  const auto least = static_cast<int>(low);
                  if (const auto number = given.wholeNumber(option, least, static_cast<int>(high)))
                      field = *number;
              } else if (const auto number = given.number(option, low, high)) {
                  field = *number;
              }
          }) {}
    /// A text that a function reads. @param expected what it takes, for the error
    template <typename Value, typename Read>
    OptionField(const char* option, Value& field,
                std::optional<Read> (&read)(const std::string& text), const char* expected)
        : take_([=, &field, &read](const CommandLine& given) {
              const auto text = given.value(option);
              if (!text) return;
              const std::optional<Read> value = read(*text);
              if (!value) given.failValue(option, expected);
              field = *value;
          }) {}

    void take(const CommandLine& given) const { take_(given); }

  private:
    std::function<void(const CommandLine& given)> take_;
};

} // namespace altiro3D::tools
