#include "altiro3D/file_io.hpp"

#include "altiro3D/error.hpp"
#include "media/video_container.hpp"
#include "support/child.hpp"
#include "support/files.hpp"

#include <fcntl.h>
#include <functional>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMuch = 1u << 24;

std::string someBytes(std::size_t size) {
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<char>(i * 7919 >> 3);
    return bytes;
}

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

TEST_F(FileIo, ANewFileFollowsTheUmask) {
    const mode_t before = umask(027);
    writeFile(directory / "file", "x");
    umask(before);
    EXPECT_EQ(static_cast<int>(fs::status(directory / "file").permissions()), 0640);
}

TEST_F(FileIo, AReplacedFileKeepsItsPermissionBits) {
    spill(directory / "file", "old");
    fs::permissions(directory / "file", static_cast<fs::perms>(0604));
    writeFile(directory / "file", "new");
    EXPECT_EQ(slurp(directory / "file"), "new");
    EXPECT_EQ(static_cast<int>(fs::status(directory / "file").permissions()), 0604);
}

TEST_F(FileIo, SymbolicLinksAreFollowed) {
    fs::create_directory(directory / "sub");
    spill(directory / "sub" / "target", "old");
    fs::create_symlink("sub/target", directory / "link");
    fs::create_symlink(directory / "link", directory / "chain");
    fs::create_symlink("sub/made", directory / "dangling");
    writeFile(directory / "chain", "new");
    writeFile(directory / "dangling", "made");
    EXPECT_TRUE(fs::is_symlink(directory / "link"));
    EXPECT_TRUE(fs::is_symlink(directory / "chain"));
    EXPECT_EQ(slurp(directory / "sub" / "target"), "new");
    EXPECT_EQ(slurp(directory / "sub" / "made"), "made");
}

TEST_F(FileIo, LinksInACircleAreRefused) {
    fs::create_symlink("b", directory / "a");
    fs::create_symlink("a", directory / "b");
    EXPECT_EQ(errorOf([&] { writeFile(directory / "a", "x"); }),
              (directory / "a").string() +
                  ": cannot be written: Too many levels of symbolic links");
}

TEST_F(FileIo, DevicesAreWrittenInPlace) {
    writeFile("/dev/null", "x");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(FileIo, AFullDiskIsNamed) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
    EXPECT_EQ(errorOf([] { writeFile("/dev/full", "x"); }),
              "/dev/full: cannot be written: No space left on device");
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(FileIo, PipesAreWrittenAndReadInPlace) {
    const fs::path fifo = directory / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    const std::string bytes = someBytes(300001); // more than a pipe holds at a time
    std::thread writer([&] { writeFile(fifo, bytes); });
    const std::string got = readFile(fifo, kMuch);
    writer.join();
    EXPECT_EQ(got, bytes);
    EXPECT_TRUE(fs::is_fifo(fifo));
}

TEST_F(FileIo, APipeLongerThanTheLimitIsRefused) {
    const fs::path fifo = directory / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    // Both ends are open, so the reader cannot leave the writer without one.
    const int both = open(fifo.c_str(), O_RDWR);
    ASSERT_EQ(write(both, "0123456789", 10), 10);
    EXPECT_EQ(errorOf([&] { readFile(fifo, 9); }),
              fifo.string() + ": holds more bytes, expected at most 9");
    close(both);
}

TEST_F(FileIo, StandardOutputIsContinuedNotReplaced) {
    spill(directory / "out", "first ");
    const std::string said = inChild([&] {
        const int file = open((directory / "out").c_str(), O_WRONLY | O_APPEND);
        dup2(file, STDOUT_FILENO);
        return errorOf([] { writeFile("/dev/stdout", "second"); });
    });
    EXPECT_EQ(said, "(no error)");
    EXPECT_EQ(slurp(directory / "out"), "first second");
}

TEST_F(FileIo, AFailedWriteLeavesTheOldFileAndNothingElse) {
    spill(directory / "file", "old");
    const std::string said = withFileLimit(
        1000, [&] { return errorOf([&] { writeFile(directory / "file", someBytes(5000)); }); });
    EXPECT_EQ(said, (directory / "file").string() + ": cannot be written: File too large");
    EXPECT_EQ(slurp(directory / "file"), "old");
    EXPECT_EQ(filesIn(directory.path()), 1u);
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

TEST_F(FileIo, WithoutPermissionNothingIsReadOrWritten) {
    if (getuid() != 0) GTEST_SKIP() << "needs root, to become another user";
    fs::permissions(directory.path(), fs::perms::all);
    spill(directory / "secret", "old");
    fs::permissions(directory / "secret", static_cast<fs::perms>(0400));
    fs::create_directory(directory / "closed");
    fs::permissions(directory / "closed", static_cast<fs::perms>(0555));
    const auto asNobody = [](const std::function<void()>& call) {
        return inChild([&] {
            if (setgid(65534) != 0 || setuid(65534) != 0) return std::string("still root");
            return errorOf(call);
        });
    };
    EXPECT_EQ(asNobody([&] { readFile(directory / "secret", kMuch); }),
              (directory / "secret").string() + ": cannot be read: Permission denied");
    EXPECT_EQ(asNobody([&] { writeFile(directory / "closed" / "file", "x"); }),
              (directory / "closed" / "file").string() + ": cannot be written: Permission denied");
    // The directory is open to all, so a rename alone would replace the protected file.
    EXPECT_EQ(asNobody([&] { writeFile(directory / "secret", "x"); }),
              (directory / "secret").string() + ": cannot be written: Permission denied");
    EXPECT_EQ(slurp(directory / "secret"), "old");
    EXPECT_EQ(asNobody([&] { writeFile(directory / "fresh", "x"); }), "(no error)");
}

// A replaced file keeps its owner. Only root can replace another user's file.
TEST_F(FileIo, AReplacedFileKeepsItsOwnerAndPermissions) {
    if (getuid() != 0) GTEST_SKIP() << "needs root, to write another user's file";
    const auto others = [&](const char* name) {
        spill(directory / name, "old");
        EXPECT_EQ(chown((directory / name).c_str(), 65534, 65533), 0);
        EXPECT_EQ(chmod((directory / name).c_str(), 0640), 0);
        return directory / name;
    };
    const fs::path whole = others("whole");
    writeFile(whole, "new");
    const fs::path part = others("part");
    fs::create_symlink("part", directory / "link");
    PartFile video(directory / "link");
    avio_write(video.io(), reinterpret_cast<const unsigned char*>("new"), 3);
    video.finish();
    for (const fs::path& file : {whole, part}) {
        struct stat state {};
        ASSERT_EQ(stat(file.c_str(), &state), 0);
        EXPECT_EQ(state.st_uid, 65534U) << file;
        EXPECT_EQ(state.st_gid, 65533U) << file;
        EXPECT_EQ(state.st_mode & 07777U, 0640U) << file;
        EXPECT_EQ(slurp(file), "new");
    }
    EXPECT_EQ(filesIn(directory.path()), 3u);
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
    fs::resize_file(file, std::uintmax_t{1} << 40); // a terabyte of holes
    EXPECT_EQ(errorOf([&] { readFile(file, kMuch); }),
              file.string() + ": holds 1099511627776 bytes, expected at most 16777216");
    spill(directory / "ten", "0123456789");
    EXPECT_EQ(readFile(directory / "ten", 10).size(), 10u);
    EXPECT_NE(errorOf([&] { readFile(directory / "ten", 9); }), "(no error)");
}

TEST_F(FileIo, FilesWithoutASizeAreReadToTheirEnd) {
    if (!fs::exists("/proc/self/status")) GTEST_SKIP() << "needs /proc";
    EXPECT_GT(readFile("/proc/self/status", kMuch).size(), 100u);
}

} // namespace
} // namespace altiro3D::test
