#pragma once

#include "altiro3D/video_io.hpp"
#include "support/files.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

/// Skips the test with a clear message where the program `ffmpeg` is not installed.
#define ALTIRO3D_REQUIRE_FFMPEG()                                                                  \
    if (!::altiro3D::test::haveFfmpeg()) GTEST_SKIP() << "needs the programs ffmpeg and ffprobe"

namespace altiro3D::test {

/// Whether the programs ffmpeg and ffprobe are there.
bool haveFfmpeg();

/// A suite whose tests write files and need those programs.
class FfmpegTest : public FileTest {
  protected:
    void SetUp() override { ALTIRO3D_REQUIRE_FFMPEG(); }

    /// Makes a file in the test's directory. @param arguments of `ffmpeg`, but for its name
    std::filesystem::path make(const std::string& name, const std::string& arguments) const;

    /// Makes a short clip with B-frames, a key frame every 10 frames, and no sound.
    std::filesystem::path
    makeClip(const std::string& name, const std::string& options = "",
             const std::string& source = "testsrc2=size=96x64:rate=25:duration=2") const;
};

/// A file's name as one word of a shell's command line.
std::string arg(const std::filesystem::path& path);

/// Runs `ffmpeg` quietly with these arguments of a shell; a failure throws with the command line,
/// its messages go to standard error.
/// @return what it wrote to its standard output
std::string ffmpeg(const std::string& arguments);

/// Runs `ffprobe` with a list of entries.
///
/// @param entries as for -show_entries
/// @param more further arguments ("-select_streams v:0")
/// @return the values, one line per record, separated by '|'
std::string ffprobe(const std::filesystem::path& file, const std::string& entries,
                    const std::string& more = "");

/// Text split at line ends, empty lines left out.
std::vector<std::string> lines(const std::string& text);

/// The frames that the program ffmpeg decodes, as BGR.
///
/// @param filter video filters before the conversion, or empty
/// @param most how many frames at most
std::vector<cv::Mat> ffmpegFrames(const std::filesystem::path& file, cv::Size size,
                                  const std::string& filter = "", int most = 1000000);

/// Options of a video of 64 x 48 px with 25 pictures a second.
VideoWriterOptions smallOptions();
/// Writes a clip of so many of movingPicture().
void writeClip(const std::filesystem::path& file, const VideoWriterOptions& options, int count);
/// Writes a lossless clip (FFV1). @param rate frames per second, a divisor of 1000
void writeClip(const std::filesystem::path& file, const std::vector<cv::Mat>& pictures,
               int rate = 2);

/// All frames of a reader, or of a file.
std::vector<VideoFrame> allFrames(VideoReader& reader);
std::vector<VideoFrame> allFrames(const std::filesystem::path& file,
                                  const VideoReaderOptions& options = {});

/// What is said of a file that cannot be opened.
std::string openError(const std::filesystem::path& file, const std::string& format = "");

/// Success if frames have the bits of others, from the one with the number `first` on, and their
/// times, which are `earlier` by so many units.
::testing::AssertionResult sameFrames(const std::vector<VideoFrame>& frames,
                                      const std::vector<VideoFrame>& others, std::size_t first = 0,
                                      std::int64_t earlier = 0);

/// Times of all packets of a stream ("v:0", "a"), in seconds, in the order they are shown.
std::vector<double> packetTimes(const std::filesystem::path& file, const std::string& stream);

/// An MP4 file of one video track whose header states a rotation by a multiple of 90 degrees.
/// Versions of ffmpeg need different options for that.
///
/// @param bytes the file's contents
/// @param degrees 0, 90, 180 or 270, clockwise
std::string turnedClockwise(std::string bytes, int degrees);

/// A picture with a gradient, moving shapes and noise-free colours, different for each number.
cv::Mat movingPicture(cv::Size size, int number);

} // namespace altiro3D::test
