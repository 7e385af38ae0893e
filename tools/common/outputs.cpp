#include "common/outputs.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "common/command_line.hpp"

#include <cstdio>
#include <iostream>
#include <set>
#include <string>
#include <unistd.h>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// The place a name means, links followed, whether it exists or not.
fs::path place(const fs::path& file) {
    std::error_code error;
    fs::path resolved = fs::weakly_canonical(fs::absolute(file, error), error);
    return error ? file : resolved;
}

bool sameFile(const fs::path& a, const fs::path& b) {
    std::error_code error;
    return place(a) == place(b) || fs::equivalent(a, b, error); // the latter sees hard links
}

bool userAgrees(const fs::path& file) {
    if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) return false;
    std::cerr << file.string() << " exists. Replace it? [y/N] " << std::flush;
    std::string answer;
    std::getline(std::cin, answer);
    return answer == "y" || answer == "Y" || answer == "yes";
}

} // namespace

void Outputs::check() const {
    std::set<fs::path> places;
    for (const fs::path& output : outputs_) {
        for (const fs::path& input : inputs_) {
            if (sameFile(output, input)) {
                throw UsageError(output.string() +
                                 ": is an input too, expected an output of its own");
            }
        }
        std::error_code error;
        const fs::file_status status = fs::status(output, error);
        if (fs::is_directory(status)) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "is a directory, expected the name of a file to write");
        }
        const fs::path directory = place(output).parent_path();
        if (!fs::is_directory(directory, error)) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "cannot be written: there is no directory " + directory.string());
        }
        const bool special = fs::exists(status) && !fs::is_regular_file(status);
        if (!special && !places.insert(place(output)).second) {
            throw UsageError(output.string() +
                             ": is written twice, expected a name for each output");
        }
        if (fs::is_regular_file(status) && !replace_ && !userAgrees(output)) {
            throw Error(ErrorCode::WriteFailed, output.string(),
                        "exists, expected a new name, or -y to replace it");
        }
    }
}

void makeOutputDirectory(const fs::path& directory) {
    std::error_code error;
    fs::create_directories(directory, error);
    if (!fs::is_directory(directory)) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be made a directory" + (error ? " (" + error.message() + ")" : "") +
                        ", expected a place for the outputs");
    }
}

void requirePictureName(const fs::path& file) {
    if (!canWritePicture(file)) {
        throw UsageError(file.string() +
                         ": no picture format is known by this extension, expected .png");
    }
}

} // namespace altiro3D::tools
