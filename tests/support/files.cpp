#include "support/files.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <unistd.h>

namespace altiro3D::test {

namespace fs = std::filesystem;

fs::path dataPath(const std::string& relative) {
    const char* variable = std::getenv("ALTIRO3D_TEST_DATA");
    const fs::path root = variable != nullptr
                              ? fs::path(variable)
                              : fs::path(ALTIRO3D_TEST_SOURCE_DIR) / ".." / "shared" / "data";
    std::error_code error;
    const fs::path path = root / relative;
    return fs::exists(path, error) ? fs::canonical(path) : fs::path();
}

std::vector<fs::path> realCalibrations() {
    constexpr std::size_t kCount = 15;
    std::vector<fs::path> files;
    const fs::path folder = dataPath("calibrations");
    if (folder.empty()) return files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (entry.path().extension() == ".json" && name.find("samples") == std::string::npos &&
            name.find("templates") == std::string::npos) {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    EXPECT_EQ(files.size(), kCount) << folder;
    return files;
}

fs::path sourcePath(const std::string& relative) {
    return fs::path(ALTIRO3D_TEST_SOURCE_DIR) / relative;
}

TemporaryDirectory::TemporaryDirectory() {
    std::random_device random;
    do
        path_ = fs::temp_directory_path() / ("altiro3D-test-" + std::to_string(random()));
    while (!fs::create_directory(path_));
}

TemporaryDirectory::~TemporaryDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

StandardInput::StandardInput(const fs::path& file) : before_(dup(0)) {
    std::FILE* const opened = std::fopen(file.string().c_str(), "rb");
    EXPECT_GE(dup2(fileno(opened), 0), 0);
    std::fclose(opened);
}

StandardInput::~StandardInput() {
    dup2(before_, 0);
    close(before_);
}

std::string errorOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    } catch (const std::exception& other) {
        ADD_FAILURE() << "no altiro3D::Error but: " << other.what();
        return other.what();
    }
    return "(no error)";
}

std::string problemOf(const fs::path& file, const std::function<void()>& call) {
    const std::string error = errorOf(call);
    const std::string start = file.string() + ": ";
    return error.rfind(start, 0) == 0 ? error.substr(start.size()) : error;
}

ErrorCode codeOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.code();
    }
    ADD_FAILURE() << "no altiro3D::Error";
    return {};
}

::testing::AssertionResult holds(const std::string& text, const std::string& part) {
    return ::testing::AssertionResult(text.find(part) != std::string::npos)
           << '"' << text << "\", and the part is \"" << part << '"';
}

::testing::AssertionResult startsWith(const std::string& text, const std::string& part) {
    return ::testing::AssertionResult(text.rfind(part, 0) == 0)
           << '"' << text << "\", and the beginning is \"" << part << '"';
}

std::string textOf(const Notes& notes) {
    std::string text;
    for (const Note& note : notes)
        text += note.text + "\n";
    return text;
}

Note only(const Notes& notes) {
    if (notes.size() == 1) return notes[0];
    return {NoteCode(), std::to_string(notes.size()) + " notes: " + textOf(notes)};
}

std::size_t filesIn(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string someBytes(std::size_t size) {
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<char>(i * 7919 >> 3);
    return bytes;
}

std::string slurp(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream || fs::is_directory(file)) throw std::runtime_error("cannot read " + file.string());
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void spill(const fs::path& file, const std::string& contents) {
    std::ofstream stream(file, std::ios::binary);
    stream << contents;
    if (!stream.flush()) throw std::runtime_error("cannot write " + file.string());
}

} // namespace altiro3D::test
