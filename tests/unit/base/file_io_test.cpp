#include "altiro3D/file_io.hpp"

#include "altiro3D/error.hpp"
#include "support/files.hpp"

#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMuch = 1u << 24;

class FileIo : public FileTest {};

TEST_F(FileIo, ReadsBackWhatItWrote) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{2},
                                   std::size_t{8191}, (std::size_t{1} << 20) + 7}) {
        const std::string bytes = someBytes(size);
        writeFile(directory / "file", bytes);
        EXPECT_EQ(slurp(directory / "file"), bytes);
        EXPECT_EQ(readFile(directory / "file", kMuch), bytes);
    }
    EXPECT_EQ(filesIn(directory.path()), 1u);
}

TEST_F(FileIo, PartsAreJoinedInOrder) {
    writeFile(directory / "file", {{"abc", 3}, {nullptr, 0}, {"de", 2}});
    EXPECT_EQ(slurp(directory / "file"), "abcde");
}

TEST_F(FileIo, WritesToABareNameInTheWorkingDirectory) {
    const fs::path before = fs::current_path();
    fs::current_path(directory.path());
    writeFile("bare", "x");
    fs::current_path(before);
    EXPECT_EQ(slurp(directory / "bare"), "x");
}

TEST_F(FileIo, AMissingDirectoryIsNamed) {
    EXPECT_EQ(errorOf([&] { writeFile(directory / "no" / "file", "x"); }),
              (directory / "no" / "file").string() +
                  ": cannot be written: No such file or directory; its directory must exist");
}

TEST_F(FileIo, ADirectoryIsNoTarget) {
    const std::string name = directory.path().string();
    EXPECT_EQ(errorOf([&] { writeFile(name, "x"); }),
              name + ": is a directory, expected a file name");
    EXPECT_EQ(errorOf([&] { writeFile(name + "/", "x"); }),
              name + "/: is a directory, expected a file name");
    EXPECT_TRUE(startsWith(errorOf([&] { writeFile("", "x"); }), "(no name): "));
}

TEST_F(FileIo, ANameIsNotCutAndBytesAreReplacedWhereTheyAre) {
    const std::string name = (directory / "a").string();
    EXPECT_EQ(codeOf([&] { writeFile(name + std::string("\0.png", 5), "x"); }),
              ErrorCode::WriteFailed);
    EXPECT_FALSE(std::filesystem::exists(name));
    FileWriter file(name);
    file.append({{"abc", 3}});
    file.replace(1, {"x", 1});
    EXPECT_EQ(codeOf([&] { file.replace(2, {"yz", 2}); }), ErrorCode::InvalidArgument);
    EXPECT_EQ(codeOf([&] { file.replace(100, {"y", 1}); }), ErrorCode::InvalidArgument);
    file.finish();
    EXPECT_EQ(readFile(name, 10), "axc");
}

TEST_F(FileIo, MissingFilesAndDirectoriesAreNotRead) {
    const std::string name = directory.path().string();
    EXPECT_EQ(errorOf([&] { readFile(name + "/none", kMuch); }),
              name + "/none: does not exist, expected a file");
    EXPECT_EQ(errorOf([&] { readFile(name, kMuch); }), name + ": is a directory, expected a file");
    EXPECT_EQ(errorOf([&] { readFile({}, kMuch); }), "path: is empty, expected a file");
    EXPECT_EQ(codeOf([&] { readFile(name + "/none", kMuch); }), ErrorCode::NotFound);
}

TEST_F(FileIo, TheSizeIsCheckedBeforeMemoryIsTaken) {
    const fs::path file = directory / "sparse";
    spill(file, "");
    std::error_code error;
    fs::resize_file(file, std::uintmax_t{1} << 40, error); // a terabyte of holes
    if (error) fs::resize_file(file, kMuch + 1);           // where files have none, as on Windows
    EXPECT_EQ(errorOf([&] { readFile(file, kMuch); }), file.string() + ": holds " +
                                                           std::to_string(fs::file_size(file)) +
                                                           " bytes, expected at most 16777216");
    spill(directory / "ten", "0123456789");
    EXPECT_EQ(readFile(directory / "ten", 10).size(), 10u);
    EXPECT_NE(errorOf([&] { readFile(directory / "ten", 9); }), "(no error)");
}

} // namespace
} // namespace altiro3D::test
