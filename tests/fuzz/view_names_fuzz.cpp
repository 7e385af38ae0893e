// Names, one a line: directories of views and their natural order, and tags of 3D pictures.

#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "fuzz.hpp"

#include <vector>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t kMaxNames = 12;
    fuzz::Bytes bytes(data, size);
    const fuzz::Directory directory;
    std::vector<std::string> names;
    while (!bytes.rest().empty() && names.size() < kMaxNames) {
        names.push_back(bytes.line());
        std::string name = names.back();
        for (char& c : name) {
            if (c == '/' || c == '\0') c = '_';
        }
        if (!name.empty() && name.size() < 200) directory.file(name, "");
    }
    for (const std::string& name : names) {
        (void)findDepthBeside(directory.path() / name);
        fuzz::require(comparableName(name).size() <= name.size(), "letters are only joined");
        const auto scene = parseSceneName(directory.path() / name);
        fuzz::require(!scene || (!scene->tag.empty() && name.find(scene->tag) != std::string::npos),
                      "a tag is a word of the name");
    }
    // Checks the order: irreflexive, total and without cycles.
    for (const std::string& a : names) {
        fuzz::require(!naturalLess(a, a), "no name stands before itself");
        for (const std::string& b : names) {
            fuzz::require(a == b || naturalLess(a, b) != naturalLess(b, a), "one name is first");
            if (!naturalLess(a, b)) continue;
            for (const std::string& c : names)
                fuzz::require(!naturalLess(b, c) || naturalLess(a, c), "the order has no circles");
        }
    }
    fuzz::reads([&] {
        const std::vector<std::filesystem::path> files = listImages(directory.path());
        for (std::size_t i = 1; i < files.size(); ++i)
            fuzz::require(
                naturalLess(files[i - 1].filename().string(), files[i].filename().string()),
                "pictures come in order");
    });
    fuzz::reads([&] { listImages(directory.path() / "nothing"); });
    return 0;
}
