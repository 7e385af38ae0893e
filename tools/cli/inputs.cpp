#include "cli/inputs.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/quilt.hpp"
#include "cli/run_tool.hpp"

#include <cstdio>
#include <optional>
#include <system_error>
#include <utility>

namespace altiro3D::tools {

namespace fs = std::filesystem;

PhotoFile pictureToRead(const fs::path& file) {
    constexpr std::size_t kMost = std::size_t{1} << 31;
    if (!isStandardStream(file)) {
        std::error_code error;
        if (!fs::is_fifo(file, error)) return file;
        try {
            return {readFile(file, kMost), file};
        } catch (const Error&) {
            endIfStopWanted(); // while it waited for the writer
            throw;
        }
    }
    constexpr std::size_t kStep = std::size_t{1} << 20;
    const char* const name = "standard input";
    std::string bytes;
    for (std::size_t count = kStep; count == kStep && bytes.size() < kMost;) {
        const std::size_t begin = bytes.size();
        bytes.resize(begin + kStep);
        count = std::fread(bytes.data() + begin, 1, kStep, stdin);
        bytes.resize(begin + count);
    }
    endIfStopWanted();
    if (std::ferror(stdin) != 0)
        throw Error(ErrorCode::ReadFailed, name, "cannot be read, expected a picture");
    if (bytes.size() >= kMost)
        throw Error(ErrorCode::TooLarge, name, "holds 2 GiB or more, expected a picture");
    return {std::move(bytes), name};
}

void requireFile(const fs::path& file) {
    std::error_code error;
    if (fs::status(file, error).type() == fs::file_type::not_found)
        throw Error(ErrorCode::NotFound, file.string(), "does not exist, expected a file");
}

bool isQuiltName(const fs::path& file) {
    try {
        const std::optional<QuiltName> name = parseQuiltName(file);
        return name && name->grid.columns * name->grid.rows > 1;
    } catch (const Error&) {
        return false; // it looks like a quilt's, but its numbers are out of range
    }
}

void warnIfQuilt(const fs::path& file, const std::string& instead, Messages& messages) {
    if (!isQuiltName(file)) return;
    messages.warn(file.string() +
                  ": its name says that it is a quilt, but it is read as one "
                  "picture of a scene; for a quilt use " +
                  instead);
}

void refuseNative(const PhotoFile& file, const std::string& expected) {
    if (!isMarkedNative(file)) return;
    throw Error(ErrorCode::BadFormat, file.path().string(),
                "is a Native already, expected " + expected +
                    " (inputs come first, then outputs; "
                    "native2view shows the views of a Native)");
}

cv::Mat readPhotoFile(const PhotoFile& file, Messages& messages) {
    Notes notes;
    cv::Mat photo;
    {
        const QuietStandardError quiet;
        photo = readPhoto(file, &notes);
    }
    for (const Note& note : notes)
        messages.warn(file.path().string() + ": " + note.text);
    return photo;
}

} // namespace altiro3D::tools
