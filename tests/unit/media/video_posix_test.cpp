#include "altiro3D/video_io.hpp"

#include "media/resumable_video.hpp"
#include "support/child.hpp"
#include "support/files.hpp"
#include "support/video.hpp"

#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

// Links, devices and pipes of POSIX where videos are read and written.
class VideosOnPosix : public FileTest {};
class PipesOnPosix : public FfmpegTest {};

// Whether drivers of devices are asked if they are cameras: the emulator QEMU does not pass it on.
bool asksDevices() {
    const int device = open("/dev/null", O_RDWR);
    v4l2_capability answer{};
    const bool asks = ioctl(device, VIDIOC_QUERYCAP, &answer) == 0 || errno != ENOSYS;
    close(device);
    return asks;
}

TEST_F(VideosOnPosix, CharacterDevicesAreCamerasWhateverTheirNames) {
    EXPECT_EQ(openError("/dev/null", "matroska"), "is not a video that FFmpeg can read");
    if (!asksDevices()) GTEST_SKIP() << "devices cannot be asked whether they are cameras";
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_GE(terminal, 0);
    ASSERT_EQ(grantpt(terminal), 0);
    ASSERT_EQ(unlockpt(terminal), 0);
    const int other = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    int number = 0;
    for (const std::string& device :
         std::vector<std::string>{"/dev/null", "/dev/urandom", ptsname(terminal)}) {
        const fs::path link = directory / ("usb-camera-" + std::to_string(++number));
        const fs::path linkToLink = directory / ("camera" + std::to_string(number) + ".mp4");
        fs::create_symlink(device, link);
        fs::create_symlink(link, linkToLink);
        for (const fs::path& path : {fs::path(device), link, linkToLink})
            EXPECT_EQ(openError(path), "is a device but not a camera, expected a video file, a "
                                       "camera, or the name of the device's format");
    }
    close(other);
    close(terminal);
}

TEST_F(VideosOnPosix, FilesAreFilesWhateverTheirNamesAndHoweverTheyAreReached) {
    fs::create_directories(directory / "dev");
    const fs::path file = directory / "dev/video0";
    spill(file, std::string(5000, '\x5a'));
    fs::create_symlink(file, directory / "camera-of-a-file");
    for (const fs::path& path : {file, directory / "camera-of-a-file"})
        EXPECT_EQ(openError(path), "is not a video that FFmpeg can read");
    EXPECT_EQ(openError(directory / "dev"), "is a directory, expected a video file");
    fs::create_symlink("nowhere", directory / "video1");
    EXPECT_EQ(openError(directory / "video1"), "does not exist, expected a video file");
}

TEST_F(PipesOnPosix, FilesComeThroughPipesAsTheyAre) {
    const fs::path pipe = directory / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const std::pair<const char*, const char*> clips[] = {
        {"end.mp4", ""}, // its index
        {"start.mp4", "-movflags faststart"},
        {"parts.mp4", "-movflags frag_keyframe+empty_moov"},
        {"a.mov", ""},
        {"a.mkv", ""},
        {"a.ts", ""}};
    for (const auto& [name, options] : clips) {
        const fs::path file = makeClip(name, options);
        std::thread feeder([&] { std::ofstream(pipe, std::ios::binary) << slurp(file); });
        EXPECT_TRUE(sameFrames(allFrames(pipe), allFrames(file))) << name;
        feeder.join();
    }
    // also one that is already open, as of a shell's <(...)
    const std::string bytes = slurp(directory / "end.mp4");
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    std::thread feeder([&, to = ends[1]] {
        for (std::size_t at = 0; at < bytes.size();)
            at += static_cast<std::size_t>(::write(to, bytes.data() + at, bytes.size() - at));
        ::close(to);
    });
    EXPECT_TRUE(sameFrames(allFrames("/dev/fd/" + std::to_string(ends[0])),
                           allFrames(directory / "end.mp4")));
    feeder.join();
    ::close(ends[0]);
}

TEST_F(PipesOnPosix, FramesBeforeAPartOfAPipeAreCounted) {
    VideoReaderOptions options;
    options.from = 1.2;
    const std::string bytes = slurp(makeClip("clip.mkv"));
    ASSERT_EQ(mkfifo((directory / "pipe").c_str(), 0600), 0);
    std::thread feeder([&] { std::ofstream(directory / "pipe", std::ios::binary) << bytes; });
    VideoReader piped(directory / "pipe", options);
    EXPECT_EQ(piped.framesBefore(), 30);
    EXPECT_EQ(allFrames(piped).size(), 20u);
    feeder.join();
}

TEST_F(VideosOnPosix, LinksAreFollowedAndDevicesRefused) {
    fs::create_directory(directory / "sub");
    fs::create_symlink("sub/clip.mkv", directory / "link.mkv");
    writeClip(directory / "link.mkv", smallOptions(), 2);
    EXPECT_TRUE(fs::is_symlink(directory / "link.mkv"));
    EXPECT_TRUE(fs::is_regular_file(directory / "sub" / "clip.mkv"));
    fs::permissions(directory / "sub" / "clip.mkv", static_cast<fs::perms>(0604));
    writeClip(directory / "link.mkv", smallOptions(), 3);
    EXPECT_EQ(static_cast<int>(fs::status(directory / "sub" / "clip.mkv").permissions()), 0604);
    fs::create_symlink("/dev/null", directory / "null.mkv");
    fs::create_directory(directory / "folder.mkv");
    const auto problem = [&](const char* name) {
        return problemOf(directory / name, [&] { VideoWriter(directory / name, smallOptions()); });
    };
    EXPECT_TRUE(holds(problem("null.mkv"), "is a device or pipe"));
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_TRUE(holds(problem("folder.mkv"), "is a directory"));
    EXPECT_EQ(problem("no/clip.mkv"),
              "cannot be written: No such file or directory; its directory must exist");
}

// A file at its size limit fails in the same way as one on a full disk.
TEST_F(VideosOnPosix, AFileThatCannotGrowIsNamedAndRemoved) {
    const struct {
        rlim_t limit;
        const char* name;
        VideoCodec codec;
        int frames;
    } cases[] = {{4, "clip.mkv", VideoCodec::H264, 0}, // before the first frame
                 {4, "clip.mp4", VideoCodec::H264, 0},
                 {200000, "clip.mkv", VideoCodec::Ffv1, 200},
                 {200000, "clip.mov", VideoCodec::ProRes, 200}};
    for (const auto& one : cases) {
        VideoWriterOptions options = smallOptions();
        options.codec = one.codec;
        const fs::path file = directory / one.name;
        EXPECT_EQ(withFileLimit(one.limit,
                                [&] {
                                    return problemOf(file, [&] {
                                        if (one.frames == 0) VideoWriter(file, options);
                                        if (one.frames > 0) writeClip(file, options, one.frames);
                                    });
                                }),
                  "cannot be written: File too large");
        EXPECT_EQ(filesIn(directory.path()), 0u) << one.name;
    }
}

TEST_F(VideosOnPosix, ARunThatCannotBeginLeavesNothing) {
    const fs::path out = directory / "out.mkv";
    ResumableVideoOptions resumable;
    resumable.settings["long"] = std::string(20000, 'x');
    const std::string text = withFileLimit(10000, [&] {
        return errorOf([&] { ResumableVideoWriter(out, smallOptions(), resumable); });
    });
    EXPECT_EQ(text, (unfinishedVideoDirectory(out) / "run.json").string() +
                        ": cannot be written: File too large");
    EXPECT_TRUE(fs::is_empty(directory.path()));
}

} // namespace
} // namespace altiro3D::test
