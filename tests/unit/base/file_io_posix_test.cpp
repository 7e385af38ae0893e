#include "altiro3D/file_io.hpp"

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "media/video_container.hpp"
#include "support/child.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/memory_limit.hpp"
#include "support/random_pictures.hpp"

#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMuch = 1u << 24;

// Links, permissions, devices, pipes with names, and limits of a process: what Windows has not, or
// has otherwise.
class FilesOnPosix : public FileTest {};

TEST_F(FilesOnPosix, ANewFileFollowsTheUmask) {
    const mode_t before = umask(027);
    writeFile(directory / "file", "x");
    umask(before);
    EXPECT_EQ(static_cast<int>(fs::status(directory / "file").permissions()), 0640);
}

TEST_F(FilesOnPosix, AReplacedFileKeepsItsPermissionBits) {
    spill(directory / "file", "old");
    fs::permissions(directory / "file", static_cast<fs::perms>(0604));
    writeFile(directory / "file", "new");
    EXPECT_EQ(slurp(directory / "file"), "new");
    EXPECT_EQ(static_cast<int>(fs::status(directory / "file").permissions()), 0604);
}

TEST_F(FilesOnPosix, SymbolicLinksAreFollowed) {
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

TEST_F(FilesOnPosix, LinksInACircleAreRefused) {
    fs::create_symlink("b", directory / "a");
    fs::create_symlink("a", directory / "b");
    EXPECT_EQ(errorOf([&] { writeFile(directory / "a", "x"); }),
              (directory / "a").string() +
                  ": cannot be written: Too many levels of symbolic links");
}

TEST_F(FilesOnPosix, DevicesAreWrittenInPlace) {
    writeFile("/dev/null", "x");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(FilesOnPosix, AFullDiskIsNamed) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
    EXPECT_EQ(errorOf([] { writeFile("/dev/full", "x"); }),
              "/dev/full: cannot be written: No space left on device");
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(FilesOnPosix, PipesAreWrittenAndReadInPlace) {
    const fs::path fifo = directory / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    const std::string bytes = someBytes(300001); // more than a pipe holds at a time
    std::thread writer([&] { writeFile(fifo, bytes); });
    const std::string got = readFile(fifo, kMuch);
    writer.join();
    EXPECT_EQ(got, bytes);
    EXPECT_TRUE(fs::is_fifo(fifo));
}

TEST_F(FilesOnPosix, APipeLongerThanTheLimitIsRefused) {
    const fs::path fifo = directory / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    // Both ends are open, so the reader cannot leave the writer without one.
    const int both = open(fifo.c_str(), O_RDWR);
    ASSERT_EQ(write(both, "0123456789", 10), 10);
    EXPECT_EQ(errorOf([&] { readFile(fifo, 9); }),
              fifo.string() + ": holds more bytes, expected at most 9");
    close(both);
}

TEST_F(FilesOnPosix, StandardOutputIsContinuedNotReplaced) {
    spill(directory / "out", "first ");
    const std::string said = inChild([&] {
        const int file = open((directory / "out").c_str(), O_WRONLY | O_APPEND);
        dup2(file, STDOUT_FILENO);
        return errorOf([] { writeFile("/dev/stdout", "second"); });
    });
    EXPECT_EQ(said, "(no error)");
    EXPECT_EQ(slurp(directory / "out"), "first second");
}

TEST_F(FilesOnPosix, AFailedWriteLeavesTheOldFileAndNothingElse) {
    spill(directory / "file", "old");
    const std::string said = withFileLimit(
        1000, [&] { return errorOf([&] { writeFile(directory / "file", someBytes(5000)); }); });
    EXPECT_EQ(said, (directory / "file").string() + ": cannot be written: File too large");
    EXPECT_EQ(slurp(directory / "file"), "old");
    EXPECT_EQ(filesIn(directory.path()), 1u);
}

TEST_F(FilesOnPosix, WithoutPermissionNothingIsReadOrWritten) {
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
TEST_F(FilesOnPosix, AReplacedFileKeepsItsOwnerAndPermissions) {
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

TEST_F(FilesOnPosix, FilesWithoutASizeAreReadToTheirEnd) {
    if (!fs::exists("/proc/self/status")) GTEST_SKIP() << "needs /proc";
    EXPECT_GT(readFile("/proc/self/status", kMuch).size(), 100u);
}

TEST_F(FilesOnPosix, APipeIsLeftAloneUntilItIsRead) {
    const cv::Mat picture = randomPhoto({9, 7});
    writeImage(directory / "a.png", picture, ImageMark::Native);
    const std::string bytes = PhotoFile(directory / "a.png").bytes();
    const fs::path path = directory / "pipe.png";
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    const PhotoFile pipe(path);
    EXPECT_EQ(pipe.look(), ""); // would wait for ever
    EXPECT_EQ(pipe.start(8), "");
    EXPECT_FALSE(isMarkedNative(pipe));
    std::thread writer([&] { std::ofstream(path, std::ios::binary) << bytes; });
    EXPECT_TRUE(samePicture(readPhoto(pipe), picture));
    writer.join();
    EXPECT_TRUE(isMarkedNative(pipe));
    EXPECT_EQ(pipe.look(), bytes);
}

TEST_F(FilesOnPosix, MemoryThatRunsOutBehindTheDecoderIsAnErrorOfTheFile) {
    ALTIRO3D_REQUIRE_MEMORY_LIMITS();
    std::string file = "P5 4000 4000 255\n";
    file.resize(file.size() + 16000000, 'g');
    spill(directory / "grey.pgm", file);
    const auto codeWith = [&](std::size_t megabytes, const std::function<void()>& work) {
        return inChild([&] {
            cv::setNumThreads(1); // threads would take memory for their stacks
            long pages = 0;
            std::ifstream("/proc/self/statm") >> pages;
            const rlim_t now =
                static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
            // Nothing below may allocate: the loop leaves no block that is sure to be large enough.
            const auto limitMemory = [now](std::size_t megabytesMore) {
                const rlimit limit{now + (static_cast<rlim_t>(megabytesMore) << 20), RLIM_INFINITY};
                setrlimit(RLIMIT_AS, &limit);
            };
            limitMemory(0);
            void* volatile free = nullptr; // what earlier tests have given back is taken
            do
                free = std::malloc(1 << 16);
            while (free != nullptr);
            limitMemory(megabytes);
            try {
                work();
            } catch (const Error& error) {
                return std::string(error.code() == ErrorCode::OutOfMemory ? "memory" : "other");
            }
            return std::string("done");
        });
    };
    // File and picture have room, three channels (48 MB) or floats (64 MB) have not.
    EXPECT_EQ(codeWith(50, [&] { readImage(directory / "grey.pgm"); }), "memory");
    EXPECT_EQ(codeWith(50, [&] { readDepthImage(directory / "grey.pgm"); }), "memory");
    EXPECT_EQ(codeWith(50, [&] { readDepthSamples(directory / "grey.pgm"); }), "done");
    const cv::Mat picture = randomPicture({4000, 4000}, CV_8UC3, 1);
    EXPECT_EQ(codeWith(16, [&] { writeImage(directory / "out.png", picture); }), "memory");
    EXPECT_FALSE(fs::exists(directory / "out.png"));
}

TEST_F(FilesOnPosix, TablesComeThroughPipes) {
    NativeLut(stripePanel(31, 23), {8, 6, {42, 56}, 47}).save(directory / "a.map");
    const std::string bytes = slurp(directory / "a.map");
    const fs::path pipe = directory / "pipe.map";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    std::thread feeder([&] { std::ofstream(pipe, std::ios::binary) << bytes; });
    NativeLut::load(pipe).save(directory / "again.map");
    feeder.join();
    EXPECT_EQ(slurp(directory / "again.map"), bytes);
}

TEST_F(FilesOnPosix, ReadErrorsOfTablesNameTheirCause) {
    fs::create_symlink("loop.map", directory / "loop.map");
    EXPECT_EQ(errorOf([&] { NativeLut::load(directory / "loop.map"); }),
              (directory / "loop.map").string() +
                  ": cannot be read: Too many levels of symbolic links, expected a .map file");
    const std::string longName = (directory / std::string(300, 'a')).string();
    EXPECT_EQ(errorOf([&] { NativeLut::load(longName); }),
              longName + ": cannot be read: File name too long, expected a .map file");
}

TEST_F(FilesOnPosix, ALinkInACircleIsNoDirectoryWithPictures) {
    fs::create_directory_symlink("loop", directory / "loop");
    EXPECT_EQ(problemOf(directory / "loop", [&] { listImages(directory / "loop"); }),
              "cannot be listed: Too many levels of symbolic links, expected a directory");
}

TEST_F(FilesOnPosix, AProbeOfANetworkEndsInTime) {
    // reading a pipe without a writer never ends
    const fs::path file = directory / "pipe.onnx";
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
    NetworkProfile profile;
    profile.name = "test";
    profile.inputWidth = profile.inputHeight = 8;
    profile.multipleOf = 1;
    const std::string error = errorOf([&] { probeNetwork(file, profile, {}, 0.2); });
    EXPECT_TRUE(holds(error, "does not finish within 0.2 s"));
}

} // namespace
} // namespace altiro3D::test
