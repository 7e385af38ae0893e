// Videos, read through FFmpeg's demuxers and decoders.

#include "altiro3D/video_io.hpp"
#include "fuzz.hpp"

#include <algorithm>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr int kMaxFrames = 6;
    static const fuzz::Directory directory;
    fuzz::Bytes bytes(data, size);
    const unsigned flags = bytes.byte();
    const std::filesystem::path file = directory.file("a.video", bytes.rest());
    fuzz::reads([&] {
        VideoReaderOptions options;
        options.threads = 1;
        if ((flags & 1U) != 0) options.from = 0.05;
        if ((flags & 2U) != 0) options.to = 0.2;
        VideoReader reader(file, options);
        if (std::max(reader.facts().size.width, reader.facts().size.height) > 300)
            return; // time is for our code
        if ((flags & 8U) != 0)
            fuzz::require(reader.framesBefore() >= 0, "no fewer frames than none come before");
        if ((flags & 4U) != 0) reader.skipTo(2);
        std::int64_t last = -1;
        VideoFrame frame;
        for (int i = 0; i < kMaxFrames && reader.read(frame); ++i) {
            fuzz::require(frame.picture.type() == CV_8UC3, "frames are 8-bit BGR");
            fuzz::require(frame.pts > last, "times rise");
            fuzz::require(frame.duration >= 0, "frames last");
            last = frame.pts;
        }
        static_cast<void>(reader.notes());
    });
    return 0;
}
