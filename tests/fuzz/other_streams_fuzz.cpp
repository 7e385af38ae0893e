// Sound, subtitles, chapters, attachments and tags of a foreign video, copied by writers.

#include "fuzz.hpp"
#include "video_samples.hpp"

#include <algorithm>

using namespace altiro3D;

namespace {

constexpr int kMaxFrames = 4;
constexpr const char* kNames[] = {"a.mkv", "a.mp4", "a.mov", "a.m4v"};

VideoWriterOptions optionsFor(const std::string& name, unsigned without) {
    VideoWriterOptions options = fuzz::videoOptions();
    options.preset = EncoderPreset::UltraFast;
    if (name == "a.mov") options.codec = VideoCodec::ProRes;
    if (name == "a.mp4" || name == "a.m4v") options.codec = VideoCodec::H264;
    options.audio = (without & 1U) == 0;
    options.subtitles = (without & 2U) == 0;
    options.chapters = (without & 4U) == 0;
    options.metadata = (without & 8U) == 0;
    return options;
}

// At once, with the pictures of the source.
void writeAtOnce(VideoReader& reader, const std::filesystem::path& target,
                 const VideoWriterOptions& options, Notes& notes) {
    VideoWriter writer(target, options, &reader);
    VideoFrame frame;
    for (int i = 0; i < kMaxFrames && reader.read(frame); ++i)
        writer.write({fuzz::samplePicture(i), frame.pts, frame.duration});
    writer.finish();
    notes = writer.notes();
}

// In segments, joined at the end; the pictures of the source are passed by without decoding.
void writeSegments(VideoReader& reader, const std::filesystem::path& target,
                   const VideoWriterOptions& options, Notes& notes) {
    ResumableVideoWriter writer(target, options, fuzz::runOptions(false));
    const Fraction unit = options.timeBase;
    const std::int64_t step = std::max(unit.denominator / 5 / unit.numerator, 1);
    for (int i = 0; i < kMaxFrames; ++i)
        writer.write({fuzz::samplePicture(i), i * step, step});
    writer.finish(&reader);
    notes = writer.notes();
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    fuzz::Bytes bytes(data, size);
    const unsigned way = bytes.byte();
    const unsigned without = bytes.byte();
    const std::filesystem::path source = directory.file("source.video", bytes.rest());
    const std::string name = kNames[way & 3U];
    const std::filesystem::path target = directory.path() / name;
    const bool written = fuzz::reads([&] {
        VideoReaderOptions part;
        part.threads = 1;
        if ((way & 4U) != 0) part.from = 0.3;
        if ((way & 8U) != 0) part.to = 0.7;
        VideoReader reader(source, part);
        if (std::max(reader.facts().size.width, reader.facts().size.height) > 300)
            return; // time is for our code
        VideoWriterOptions options = optionsFor(name, without);
        options.timeBase = reader.facts().timeBase;
        Notes notes;
        ((way & 16U) != 0 ? writeSegments : writeAtOnce)(reader, target, options, notes);
        for (const Note& note : notes)
            fuzz::require(note.text.find('\n') == std::string::npos, "a note is one line");
    });
    if (written && std::filesystem::exists(target)) {
        VideoReaderOptions known; // sound may look like another container to FFmpeg's guess
        known.format = target.extension() == ".mkv" ? "matroska" : "mov";
        VideoFrame frame;
        fuzz::require(VideoReader(target, known).read(frame), "what was written can be read");
    }
    std::error_code none;
    std::filesystem::remove(target, none);
    discardUnfinishedVideo(target);
    return 0;
}
