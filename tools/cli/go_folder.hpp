#pragma once

#include "cli/display_options.hpp"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// What a Looking Glass Go plays without a computer: quilts on its storage, and the lists of them.
///
///     currentlyPlaying.json                                   read by the Go before anything else
///     LKG/Content/N/playlist.m3u
///     LKG/Content/N/001_holiday_qs11x6a0.5625.jpg
///     LKG/Content/N/001_holiday_qs11x6a0.5625.jpg.json        its layout and duration
///
/// Each run adds a list of its own; what the storage holds already stays.
class GoFolder {
  public:
    /// --go --each @param things "photos"
    static void addOptions(CommandLine& commandLine, const std::string& things);
    /// Reads `--go` and `--each`. @return nothing without --go @throws UsageError, Error
    static std::optional<GoFolder> of(const CommandLine& commandLine);

    /// @param storage a Go's storage, or a folder to be copied to it; need not exist
    /// @param seconds how long each quilt is shown
    /// @throws Error BadFormat (its currentlyPlaying.json), ReadFailed, WriteFailed (not a folder)
    GoFolder(std::filesystem::path storage, double seconds);

    /// The folder for the quilts; it does not exist yet.
    const std::filesystem::path& content() const { return content_; }
    /// The file of a quilt. @param index from 0, in the order of the list @param stem of its name
    std::filesystem::path quiltFile(std::size_t index, const std::string& stem) const;
    /// Requires space for quilts. @throws Error WriteFailed
    void requireSpace(std::size_t quilts) const;
    /// Writes the list of the quilts that were made, and what belongs to them. If none was made,
    /// writes nothing and removes the empty folder.
    /// @throws Error WriteFailed
    void finish(const std::vector<std::filesystem::path>& quilts, Messages& messages) const;

  private:
    std::filesystem::path storage_;
    double seconds_;
    std::filesystem::path content_;
    std::string number_; // the name of content_
};

/// A Go with nominal lenses; quilts do not depend on them.
ChosenDisplay goDisplay();

} // namespace altiro3D::tools
