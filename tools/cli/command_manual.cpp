// Manual page and shell completions, generated from the help.

#include "cli/command_line.hpp"
#include "cli/run_tool.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

namespace altiro3D::tools {

namespace {

// The kind of an option's value, derived from its name in the help.
enum class ValueKind { None, File, Directory, Words, Free };

// The tools, for SEE ALSO.
constexpr const char* kTools[] = {"altiro3Dcluster", "altiro3Dnative", "altiro3Dtradeoff",
                                  "altiro3Dview",    "native2view",    "photo2native",
                                  "quilt2native",    "quilt2video",    "slide2native",
                                  "splat2native",    "video2native",   "views2native"};

ValueKind kindOf(const std::string& valueName) {
    if (valueName.empty()) return ValueKind::None;
    if (valueName == "DIR") return ValueKind::Directory;
    const bool file = valueName.find('.') != std::string::npos ||
                      valueName.find("FILE") != std::string::npos || valueName == "NETWORK";
    if (file) return ValueKind::File;
    return valueName.find('|') != std::string::npos ? ValueKind::Words : ValueKind::Free;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
    return text;
}

// Escapes a text for groff: no character has a special meaning, and hyphens stay ASCII.
std::string roff(std::string text) {
    text = replaced(std::move(text), "\\", "\\e");
    text = replaced(std::move(text), "-", "\\-");
    text = replaced(std::move(text), "~", "\\(ti");
    if (!text.empty() && (text.front() == '.' || text.front() == '\'')) text.insert(0, "\\&");
    return text;
}

// The beginning of a text, up to the first of some punctuation marks.
std::string beginning(const std::string& text, const std::string& ends) {
    const auto isInside = [&](std::size_t at) { // of a number or a name, or between two words
        return at > 0 && at + 1 < text.size() && text[at] != '(' &&
               (text[at + 1] != ' ' || text[at - 1] == ' ');
    };
    std::size_t at = text.find_first_of(ends);
    while (at != std::string::npos && isInside(at))
        at = text.find_first_of(ends, at + 1);
    std::string first = text.substr(0, at);
    while (!first.empty() && first.back() == ' ')
        first.pop_back();
    return first;
}

} // namespace

std::string CommandLine::manPage(const std::string& version) const {
    std::string summary = beginning(summary_, ":;.");
    if (!summary.empty())
        summary[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(summary[0])));
    std::string upper = name_;
    std::transform(upper.begin(), upper.end(), upper.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    std::string page = ".TH " + roff(upper) + " 1 \"\" \"altiro3D " + version + "\" altiro3D\n";
    page += ".SH NAME\n" + roff(name_) + " \\- " + roff(summary) + "\n.SH SYNOPSIS\n";
    for (std::size_t i = 0; i < usages_.size(); ++i) {
        page += (i == 0 ? ".B " : ".br\n.B ") + roff(name_) + "\n" + roff(usages_[i]) + "\n";
    }
    page += ".SH DESCRIPTION\n" + roff(summary_) + "\n";
    for (const std::string& note : notes_)
        page += ".PP\n" + roff(note) + "\n";
    page += ".SH OPTIONS\n";
    for (const HelpEntry& entry : entries_) {
        if (entry.left.empty()) {
            page += ".SS " + roff(entry.text) + "\n";
            continue;
        }
        page += ".TP\n";
        std::string names;
        for (const std::string& name : entry.names)
            names += (names.empty() ? "\\fB" : ", \\fB") + roff(dashed(name)) + "\\fR";
        if (!entry.valueName.empty()) names += " \\fI" + roff(entry.valueName) + "\\fR";
        page += names + "\n" + roff(entry.text) + "\n";
    }
    const auto addTerms = [&](const std::string& title, const Terms& terms) {
        if (!terms.empty()) page += ".SH " + title + "\n";
        for (const auto& [term, meaning] : terms)
            page += ".TP\n\\fB" + roff(term) + "\\fR\n" + roff(meaning) + "\n";
    };
    addTerms("KEYS", terms(Chapter::Keys));
    addTerms("WORDS", words(entries_));
    Terms examples = terms(Chapter::Examples);
    for (auto& example : examples)
        example.first.insert(0, name_ + " ");
    addTerms("EXAMPLES", examples);
    addTerms("FILES", terms(Chapter::Files));
    addTerms("ENVIRONMENT", terms(Chapter::Environment));
    addTerms("EXIT STATUS", {std::begin(kExitStatuses), std::end(kExitStatuses)});
    page += ".SH SEE ALSO\n";
    std::string others;
    for (const std::string tool : kTools) {
        if (tool != name_) others += (others.empty() ? ".BR " : ",\n.BR ") + tool + " (1)";
    }
    return page + others + "\n";
}

std::string CommandLine::bashCompletion() const {
    std::vector<std::string> all;
    std::vector<std::string> files;
    std::vector<std::string> directories;
    std::vector<std::string> free;
    std::string words;
    for (const HelpEntry& entry : entries_) {
        const std::vector<std::string> options = entry.dashedNames();
        all.insert(all.end(), options.begin(), options.end());
        switch (kindOf(entry.valueName)) {
        case ValueKind::None:
            break;
        case ValueKind::File:
            if (!entry.known) {
                files.insert(files.end(), options.begin(), options.end());
            } else {
                words += "    " + joined(options, " | ") +
                         ")\n        compopt -o filenames\n"
                         "        mapfile -t COMPREPLY < <(compgen -W '" +
                         joined(entry.known(), " ") +
                         "' -- \"$current\"\n            compgen -f -- \"$current\")\n"
                         "        return ;;\n";
            }
            break;
        case ValueKind::Directory:
            directories.insert(directories.end(), options.begin(), options.end());
            break;
        case ValueKind::Words:
            words += "    " + joined(options, " | ") +
                     ")\n        compopt +o default\n"
                     "        mapfile -t COMPREPLY < <(compgen -W '" +
                     replaced(entry.valueName, "|", " ") +
                     "' -- \"$current\")\n        return ;;\n";
            break;
        case ValueKind::Free:
            free.insert(free.end(), options.begin(), options.end());
            break;
        }
    }
    const std::string function = "_" + name_;
    std::string script = "# bash completion of " + name_ + "\n" + function +
                         "() {\n"
                         "    local current=${COMP_WORDS[COMP_CWORD]}\n"
                         "    local previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
                         "    COMPREPLY=()\n"
                         "    case $previous in\n";
    if (!files.empty())
        script += "    " + joined(files, " | ") + ") return ;; # names of files, as bash does it\n";
    if (!directories.empty()) {
        script += "    " + joined(directories, " | ") +
                  ")\n        compopt +o default -o dirnames\n        return ;;\n";
    }
    script += words;
    if (!free.empty()) {
        script +=
            "    " + joined(free, " | ") + ")\n        compopt +o default\n        return ;;\n";
    }
    script += "    esac\n"
              "    [[ $current == -* ]] || return\n"
              "    mapfile -t COMPREPLY < <(compgen -W '" +
              joined(all, " ") + "' -- \"$current\")\n}\ncomplete -o default -F " + function + " " +
              name_ + "\n";
    return script;
}

std::string CommandLine::zshCompletion() const {
    const auto quoted = [](std::string text) {
        for (const char* special : {"\\", "[", "]", ":"})
            text = replaced(std::move(text), special, std::string("\\") + special);
        return replaced(std::move(text), "'", "'\\''");
    };
    std::string script = "#compdef " + name_ + "\n\n_arguments -s";
    for (const HelpEntry& entry : entries_) {
        if (entry.left.empty()) continue;
        const std::vector<std::string> options = entry.dashedNames();
        script += " \\\n    ";
        if (options.size() == 1) {
            script += "'" + options.front();
        } else {
            script += "'(" + joined(options, " ") + ")'{" + joined(options, ",") + "}'";
        }
        script += "[" + quoted(beginning(entry.text, ".;:(")) + "]";
        const std::string value = ":" + quoted(entry.valueName) + ":";
        switch (kindOf(entry.valueName)) {
        case ValueKind::None:
            break;
        case ValueKind::File:
            script += value + (!entry.known ? "_files"
                                            : "{_alternative \"names\\:name\\:(" +
                                                  joined(entry.known(), " ") +
                                                  ")\" \"files\\:file\\:_files\"}");
            break;
        case ValueKind::Directory:
            script += value + "_files -/";
            break;
        case ValueKind::Words:
            script += ":value:(" + replaced(entry.valueName, "|", " ") + ")";
            break;
        case ValueKind::Free:
            script += value;
            break;
        }
        script += "'";
    }
    return script + " \\\n    '*:file:_files'\n";
}

} // namespace altiro3D::tools
