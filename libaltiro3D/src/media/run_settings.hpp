#pragma once

#include "altiro3D/video_io.hpp"
#include "base/json_reader.hpp"

#include <filesystem>
#include <string>

/// Settings of a run in a file, compared by a later run.
namespace altiro3D {

/// Reads run.json, the list of an unfinished run.
/// @param directory unfinishedVideoDirectory()
/// @throws Error ReadFailed, BadFormat
Json readRunFile(const std::filesystem::path& directory);

/// The settings as a file holds them: bytes that are not UTF-8 are replaced.
Json settingsJson(const RunSettings& settings);

/// The first setting that differs, as a sentence; empty if none does. Settings that only one run
/// has come first, because other differences may follow from them.
std::string differenceOf(const Json& before, const Json& now);

} // namespace altiro3D
