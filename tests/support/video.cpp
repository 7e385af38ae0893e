#include "support/video.hpp"
#include "support/pixels.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

// libx265 keeps a little memory for good; only the leak check of a sanitized build calls this.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" const char* __lsan_default_suppressions();
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libx265.so\n";
}

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

std::string run(const std::string& command) {
    // NOLINTNEXTLINE(bugprone-unused-return-value): closed by the pointer or below
    FILE* const pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
    std::string text;
    std::array<char, 65536> part{};
    while (const std::size_t count = fread(part.data(), 1, part.size(), pipe))
        text.append(part.data(), count);
    if (pclose(pipe) != 0) throw std::runtime_error("failed: " + command);
    return text;
}

} // namespace

std::string arg(const fs::path& path) {
    return "'" + path.string() + "'";
}

bool haveFfmpeg() {
    static const bool have =
        // NOLINTNEXTLINE(cert-env33-c): a fixed command
        std::system("ffmpeg -version >/dev/null 2>&1 && ffprobe -version >/dev/null 2>&1") == 0;
    return have;
}

std::string ffmpeg(const std::string& arguments) {
    return run("ffmpeg -nostdin -v error -y " + arguments);
}

fs::path FfmpegTest::make(const std::string& name, const std::string& arguments) const {
    ffmpeg(arguments + " " + arg(directory / name));
    return directory / name;
}

fs::path FfmpegTest::makeClip(const std::string& name, const std::string& options,
                              const std::string& source) const {
    return make(name, "-f lavfi -i " + source +
                          " -c:v libx264 -preset veryfast -g 10 -bf 2 -pix_fmt yuv420p " + options);
}

std::string ffprobe(const fs::path& file, const std::string& entries, const std::string& more) {
    return run("ffprobe -v error " + more + " -show_entries " + entries +
               " -of compact=p=0:nk=1:s=\\| " + arg(file));
}

std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> result;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        if (!line.empty()) result.push_back(line);
    return result;
}

std::vector<cv::Mat> ffmpegFrames(const fs::path& file, cv::Size size, const std::string& filter,
                                  int most) {
    // Colour samples of MPEG video lie at the left; ffmpeg must be told so.
    const std::string scale =
        "scale=in_h_chr_pos=0:flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp";
    const std::string bytes =
        ffmpeg("-i " + arg(file) + " -map 0:v:0 -vsync passthrough -frames:v " +
               std::to_string(most) + " -vf '" + (filter.empty() ? scale : filter) +
               "' -sws_flags bicubic+accurate_rnd+full_chroma_int+full_chroma_inp" +
               " -f rawvideo -pix_fmt bgr24 -");
    const auto frameBytes = static_cast<std::size_t>(size.area()) * 3;
    std::vector<cv::Mat> frames;
    for (std::size_t at = 0; at + frameBytes <= bytes.size(); at += frameBytes) {
        cv::Mat frame(size, CV_8UC3);
        std::memcpy(frame.data, bytes.data() + at, frameBytes);
        frames.push_back(frame);
    }
    return frames;
}

VideoWriterOptions smallOptions() {
    VideoWriterOptions options;
    options.size = {64, 48};
    options.preset = EncoderPreset::UltraFast;
    options.timeBase = {1, 25};
    options.frameRate = {25, 1};
    options.constantRate = true;
    options.threads = 1;
    return options;
}

void writeClip(const fs::path& file, const VideoWriterOptions& options, int count) {
    VideoWriter writer(file, options);
    for (int i = 0; i < count; ++i)
        writer.write({movingPicture(options.size, i), i, 1});
    writer.finish();
}

void writeClip(const fs::path& file, const std::vector<cv::Mat>& pictures, int rate) {
    VideoWriterOptions options;
    options.size = pictures.front().size();
    options.codec = VideoCodec::Ffv1;
    options.frameRate = {rate, 1};
    options.constantRate = true;
    VideoWriter writer(file, options);
    std::int64_t number = 0;
    for (const cv::Mat& picture : pictures) {
        writer.write({picture, 1000 / rate * number, 1000 / rate});
        ++number;
    }
    writer.finish();
}

std::vector<VideoFrame> allFrames(VideoReader& reader) {
    std::vector<VideoFrame> frames;
    while (std::optional<VideoFrame> frame = reader.next())
        frames.push_back(std::move(*frame));
    return frames;
}

std::vector<VideoFrame> allFrames(const fs::path& file, const VideoReaderOptions& options) {
    VideoReader reader(file, options);
    return allFrames(reader);
}

std::string openError(const fs::path& file, const std::string& format) {
    VideoReaderOptions options;
    options.format = format;
    return problemOf(file, [&] { const VideoReader reader(file, options); });
}

::testing::AssertionResult sameFrames(const std::vector<VideoFrame>& frames,
                                      const std::vector<VideoFrame>& others, std::size_t first,
                                      std::int64_t earlier) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const VideoFrame& other = others.at(first + i);
        if (frames[i].pts == other.pts - earlier && frames[i].duration == other.duration &&
            cv::norm(frames[i].picture, other.picture, cv::NORM_INF) == 0)
            continue;
        return ::testing::AssertionFailure()
               << "frame " << i << " at " << frames[i].pts << " differs from the one at "
               << other.pts << " - " << earlier;
    }
    return ::testing::AssertionResult(!frames.empty()) << "there are no frames";
}

std::vector<double> packetTimes(const fs::path& file, const std::string& stream) {
    std::vector<double> times;
    for (const std::string& line :
         lines(ffprobe(file, "packet=pts_time", "-select_streams " + stream)))
        times.push_back(std::stod(line));
    std::sort(times.begin(), times.end());
    return times;
}

std::string turnedClockwise(std::string bytes, int degrees) {
    constexpr std::uint32_t kOne = 0x10000;
    constexpr int kSines[] = {0, 1, 0, -1};
    const auto sine = static_cast<std::uint32_t>(kSines[degrees / 90]) * kOne;
    const auto cosine = static_cast<std::uint32_t>(kSines[(degrees / 90 + 1) % 4]) * kOne;
    const std::uint32_t matrix[] = {cosine, sine, 0, 0U - sine, cosine};
    std::size_t at = bytes.find("tkhd") + 44;
    for (const std::uint32_t number : matrix)
        for (int shift = 24; shift >= 0; shift -= 8)
            bytes.at(at++) = static_cast<char>(number >> shift & 0xFF);
    return bytes;
}

cv::Mat movingPicture(cv::Size size, int number) {
    cv::Mat picture = pictureOf<cv::Vec3b>(size, [&](int x, int y) {
        return cv::Vec3b{static_cast<uchar>(x * 200 / size.width + 20),
                         static_cast<uchar>(y * 200 / size.height + 20),
                         static_cast<uchar>((x + y + 3 * number) % 200 + 20)};
    });
    const int side = std::max(2, size.height / 4);
    const int at = (number * 5) % std::max(1, size.width - side);
    cv::rectangle(picture, cv::Rect(at, size.height / 3, side, side) & cv::Rect({0, 0}, size),
                  cv::Scalar(40, 220, 60), cv::FILLED);
    return picture;
}

} // namespace altiro3D::test
