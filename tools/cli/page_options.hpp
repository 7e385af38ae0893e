#pragma once

#include "altiro3D/page.hpp"
#include "cli/command_line.hpp"
#include "cli/messages.hpp"

#include <filesystem>
#include <string>

/// The options of pages that any browser opens: `--save-page`, `--page-side`, `--title`.
namespace altiro3D::tools {

struct PageOptions {
    int side = kPageSide; ///< Longer side of the picture, at most; px.
    std::string title;    ///< Empty: the name of the picture's file.

    PageOptions() = default;
    /// @throws UsageError
    explicit PageOptions(const CommandLine& commandLine);
    /// Declares the options. @param shows "the photo in depth", what the page shows
    /// @param more further sentences, with a space before them
    static void add(CommandLine& commandLine, const std::string& shows,
                    const std::string& more = {});

    /// What a page says of a picture: the name of its file, its author and licence.
    PageText text(const std::filesystem::path& picture) const;
};

/// Refuses names that are not those of a page; empty ones are fine. @throws UsageError
void requirePageName(const std::filesystem::path& file);
/// Writes a page, and says so.
void writePage(const std::filesystem::path& file, const std::string& page, Messages& messages);

} // namespace altiro3D::tools
