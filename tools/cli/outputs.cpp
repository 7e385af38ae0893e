#include "cli/outputs.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <initializer_list>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

using Extensions = std::initializer_list<const char*>;

constexpr Extensions kLossyFormats = {".jpg", ".jpeg", ".jpe", ".jp2"};
constexpr Extensions kEightBitFormats = {".webp", ".bmp", ".dib"};

bool hasExtension(const fs::path& file, Extensions extensions) {
    const std::string extension = lowerExtension(file);
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

// The path of a name with links resolved; it need not exist.
fs::path place(const fs::path& file) {
    std::error_code error;
    fs::path resolved = fs::weakly_canonical(fs::absolute(file, error), error);
    return error ? file : resolved;
}

// @param problem says that files exist
bool userAgrees(const std::string& problem) {
    if (!isTerminal(stdin) || !isTerminal(stderr)) return false;
    std::cerr << oneLine(problem) << ". Replace? [y/N] " << std::flush;
    std::string answer;
    std::getline(std::cin, answer);
    return answer == "y" || answer == "Y" || answer == "yes";
}

} // namespace

std::string inFileName(std::string text) {
    for (char& c : text) {
        const bool isPlain =
            (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
        if (!isPlain && !(c == '-' || c == '_' || c == '.')) c = '_';
    }
    if (text.empty()) return "_";
    if (text.front() == '-' || text.front() == '.') text.front() = '_';
    return text;
}

void writePicture(const fs::path& file, const cv::Mat& picture, ImageMark mark) {
    if (!isStandardStream(file)) return writeImage(file, picture, mark);
    const std::vector<unsigned char> bytes = encodePicture(picture, mark);
    // not reopened by its name: it may be a socket, or a file at another position
    if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() ||
        std::fflush(stdout) != 0) {
        throw Error(ErrorCode::WriteFailed, "standard output",
                    "cannot be written: " + std::generic_category().message(errno));
    }
}

void requireNoTerminal(const fs::path& file) {
    if (isStandardStream(file) && isTerminal(stdout))
        throw UsageError("standard output is a terminal, expected > FILE or | PROGRAM");
}

void Outputs::addNative(const fs::path& file) {
    const bool mayBeMarked = file.extension() == ".png" && isFile(file);
    if (mayBeMarked && !isMarkedNative(file))
        explainExisting(file, "and is not marked as a Native (inputs come first, then outputs)");
    addResult(file);
}

// "exists" or, with the reason why the name was chosen, "exists, and ..., and so do 47 others"
std::string Outputs::existText(const std::vector<fs::path>& files) const {
    std::string text = "exists";
    const auto why = why_.find(files.front());
    if (why != why_.end()) text += why->second;
    if (files.size() == 2) text += ", and so does one other";
    if (files.size() > 2) text += ", and so do " + std::to_string(files.size() - 1) + " others";
    return text;
}

void Outputs::check() const {
    std::set<fs::path> inputPlaces;
    std::set<std::string> inputIdentities; // hard links share them
    for (const fs::path& input : inputs_) {
        if (isStandardStream(input)) continue;
        inputPlaces.insert(place(input));
        inputIdentities.insert(identityOf(input));
    }
    inputIdentities.erase(""); // of what is no file
    std::set<fs::path> newDirectories;
    for (const fs::path& directory : directories_)
        newDirectories.insert(place(directory / "file").parent_path()); // whatever slash it ends in

    std::set<fs::path> places;
    std::vector<fs::path> existing;
    for (const fs::path& output : outputs_) {
        if (isStandardStream(output)) {
            throw UsageError("-: only the last name may be standard output, expected the name of "
                             "a file");
        }
        const fs::path outputPlace = place(output);
        if (inputPlaces.count(outputPlace) > 0 || inputIdentities.count(identityOf(output)) > 0) {
            throw UsageError(output.string() + ": is also an input, expected another output");
        }
        std::error_code error;
        const fs::file_status status = fs::status(output, error);
        if (fs::is_directory(status)) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "is a directory, expected the name of a file to write");
        }
        const fs::path directory = outputPlace.parent_path();
        if (newDirectories.count(directory) == 0 && !fs::is_directory(directory, error)) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "cannot be written: there is no directory " + directory.string());
        }
        const bool special = fs::exists(status) && !fs::is_regular_file(status);
        const bool isNew = newDirectories.count(directory) > 0;
        const int problem = special || isNew ? 0 : checkDirectory(directory);
        if (problem != 0) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "cannot be written: " + std::generic_category().message(problem) +
                            ", expected a directory in which you may write");
        }
        if (!special && !places.insert(outputPlace).second) {
            throw UsageError(output.string() +
                             ": is written twice, expected a name for each output");
        }
        if (fs::is_regular_file(status)) existing.push_back(output);
    }
    if (existing.empty() || replace_) return;
    const std::string problem = existText(existing);
    if (userAgrees(existing.front().string() + " " + problem)) return;
    throw Error(ErrorCode::WriteFailed, existing.front().string(),
                problem + (existing.size() == 1 ? ", expected a new name, or -y to replace it"
                                                : ", expected new names, or -y to replace them"));
}

void Outputs::makeDirectories() const {
    for (const fs::path& directory : directories_) {
        std::error_code error;
        fs::create_directories(directory, error);
        if (!fs::is_directory(directory, error)) {
            throw Error(ErrorCode::WriteFailed, directory.string(),
                        "cannot be made a directory, expected a place for the outputs");
        }
    }
}

void requirePictureName(const fs::path& file, bool colours) {
    const std::string extension = file.extension().string();
    if (colours && (extension == ".pgm" || extension == ".PGM")) {
        throw UsageError(file.string() + ": PGM holds no colours, expected .ppm or .png");
    }
    if (!canWriteImage(file)) {
        throw UsageError(file.string() + ": unknown picture extension, expected .png" +
                         (canWriteVideo(file) ? "; video2native makes videos" : ""));
    }
}

void requireVideoName(const fs::path& file) {
    if (!canWriteVideo(file)) {
        if (isDirectory(file))
            throw UsageError(file.string() + ": is a directory, expected the name of a video");
        throw UsageError(file.string() +
                         ": no video format has this extension, expected .mp4, .mov or "
                         ".mkv");
    }
}

void warnAboutNativeFormat(const fs::path& file, Messages& messages) {
    if (hasExtension(file, kLossyFormats)) {
        messages.warn(file.string() +
                      ": this format mixes neighbouring sub-pixels, which belong to different "
                      "views, and weakens the depth; use PNG");
    }
}

void warnAboutEyesFormat(const fs::path& file, Messages& messages) {
    if (hasExtension(file, kLossyFormats)) {
        messages.warn(file.string() + ": this format mixes a little of each eye's picture into the "
                                      "other one's; PNG keeps them apart");
    }
}

void warnAboutDepthFormat(const fs::path& file, Messages& messages) {
    if (hasExtension(file, kLossyFormats)) {
        messages.warn(file.string() + ": this format changes depth, most of all at its "
                                      "edges; PNG keeps all 16 bits");
    } else if (hasExtension(file, kEightBitFormats)) {
        messages.warn(file.string() +
                      ": this format keeps 8 of the depth's 16 bits; PNG keeps them all");
    }
}

void requireSplatName(const fs::path& file) {
    const std::string ending = lowerExtension(file);
    if (file.empty() || ending == ".ply" || ending == ".spz") return;
    throw UsageError(file.string() + ": is not the name of splats, expected .ply or .spz");
}

std::string viewFileName(int view, int views) {
    const std::size_t digits = std::to_string(views - 1).size();
    const std::string number = std::to_string(view);
    return "view_" + std::string(digits - number.size(), '0') + number + ".png";
}

} // namespace altiro3D::tools
