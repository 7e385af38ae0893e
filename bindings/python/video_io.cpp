#include "arrays.hpp"

namespace altiro3D::python {

namespace {

// A frame whose picture is an array already.
struct Frame {
    py::object picture;
    double seconds = 0;
    std::int64_t pts = 0;
    std::int64_t duration = 0;
    Fraction sampleAspect{1, 1};
};

// Frames of a reader in one order of channels.
struct Reader : OneByOne<VideoReader> {
    Reader(const std::filesystem::path& path, const VideoReaderOptions& options, Order given)
        : OneByOne("VideoReader", true, path, options), order(given) {}
    Order order;
};
using Writer = OneByOne<VideoWriter>;

void bindFacts(py::module_& m) {
    Value<VideoFacts>(m, "VideoFacts", "Properties of a video file.")
        .field("format", &VideoFacts::format, "FFmpeg's name of the container.")
        .field("codec", &VideoFacts::codec, "FFmpeg's name of the codec.")
        .field("pixel_format", &VideoFacts::pixelFormat, "FFmpeg's name of the pixel format.")
        .field("size", &VideoFacts::size, "Width and height of the first frame, upright, px.")
        .field("sample_aspect", &VideoFacts::sampleAspect, "Width : height of a px.")
        .field("average_rate", &VideoFacts::averageRate, "Frames per second; 0: unknown.")
        .field("constant_rate", &VideoFacts::constantRate, "Whether the rate is constant.")
        .field("time_base", &VideoFacts::timeBase, "Unit of the frames' times, s.")
        .field("duration", &VideoFacts::duration, "s; None if unknown.")
        .field("frame_count", &VideoFacts::frameCount, "Frames; may be estimated; None: unknown.")
        .field("eyes", &VideoFacts::eyes, "How a frame shows both eyes; empty: not stated.")
        .field("tags", &VideoFacts::tags, "Tags of the file.")
        .done();
    Value<VideoReadCounts>(m, "VideoReadCounts", "Counts of what was read so far.")
        .field("frames", &VideoReadCounts::frames, "Frames delivered.")
        .field("corrupt", &VideoReadCounts::corrupt, "Frames skipped because they are damaged.")
        .field("repaired_times", &VideoReadCounts::repairedTimes, "Frames without a valid time.")
        .field("truncated", &VideoReadCounts::truncated, "The file ends too early.")
        .done();
    Value<VideoProgress>(m, "VideoProgress", "Progress of a conversion.")
        .field("frames", &VideoProgress::frames, "Frames made so far.")
        .field("kept_frames", &VideoProgress::keptFrames, "Frames of an earlier run.")
        .field("end", &VideoProgress::end, "End of the last frame made, s.")
        .field("frames_in_all", &VideoProgress::framesInAll, "Expected frames; None: unknown.")
        .field("length", &VideoProgress::length, "Expected final value of end, s; None: unknown.")
        .field("finishing", &VideoProgress::finishing, "The file is being closed.")
        .done();
}

void bindWriterOptions(py::module_& m) {
    py::enum_<VideoCodec>(m, "VideoCodec", "Encoding of the frames.")
        .value("H264", VideoCodec::H264, "H.264 4:4:4")
        .value("H264Rgb", VideoCodec::H264Rgb, "H.264 of red, green and blue")
        .value("Hevc", VideoCodec::Hevc, "H.265 4:4:4")
        .value("Ffv1", VideoCodec::Ffv1, "lossless, .mkv")
        .value("ProRes", VideoCodec::ProRes, "ProRes 4444");
    py::enum_<EncoderPreset>(m, "EncoderPreset", "Effort of the encoder.")
        .value("UltraFast", EncoderPreset::UltraFast)
        .value("SuperFast", EncoderPreset::SuperFast)
        .value("VeryFast", EncoderPreset::VeryFast)
        .value("Faster", EncoderPreset::Faster)
        .value("Fast", EncoderPreset::Fast)
        .value("Medium", EncoderPreset::Medium)
        .value("Slow", EncoderPreset::Slow)
        .value("Slower", EncoderPreset::Slower)
        .value("VerySlow", EncoderPreset::VerySlow);
    Value<VideoWriterOptions>(m, "VideoWriterOptions", "Options to write a video.")
        .field("size", &VideoWriterOptions::size, "Width and height of all frames, px.")
        .field("codec", &VideoWriterOptions::codec, "Encoding of the frames.")
        .field("compatible", &VideoWriterOptions::compatible, "4:2:0; blends views of a Native.")
        .field("crf", &VideoWriterOptions::crf, "Constant rate factor, 0..51; lower is better.")
        .field("preset", &VideoWriterOptions::preset, "Effort of the encoder.")
        .field("native", &VideoWriterOptions::native, "The frames are Natives.")
        .field("max_rate", &VideoWriterOptions::maxRate, "Most Mbit/s; 0: any.")
        .field("time_base", &VideoWriterOptions::timeBase, "Unit of the frames' times, s.")
        .field("frame_rate", &VideoWriterOptions::frameRate, "Frames per second; 0: unknown.")
        .field("constant_rate", &VideoWriterOptions::constantRate, "The rate holds exactly.")
        .field("sample_aspect", &VideoWriterOptions::sampleAspect, "Width : height of a px.")
        .field("eyes", &VideoWriterOptions::eyes, "Each frame shows both eyes.")
        .field("threads", &VideoWriterOptions::threads, "Encoder threads; 0: one per processor.")
        .field("audio", &VideoWriterOptions::audio, "Copy the source's sound.")
        .field("subtitles", &VideoWriterOptions::subtitles, "Copy the source's subtitles.")
        .field("chapters", &VideoWriterOptions::chapters, "Copy the source's chapters.")
        .field("metadata", &VideoWriterOptions::metadata, "Copy the source's tags.")
        .field("tags", &VideoWriterOptions::tags, "Further tags: [(name, value), ...].")
        .constructible()
        .done();
}

void bindReader(py::module_& m) {
    Value<VideoReaderOptions>(m, "VideoReaderOptions", "Options to open a video.")
        .field("from_", &VideoReaderOptions::from, "Start of the part to read, s.")
        .field("to", &VideoReaderOptions::to, "End of the part to read, s.")
        .field("threads", &VideoReaderOptions::threads, "Decoder threads; 0: one per processor.")
        .field("format", &VideoReaderOptions::format, "FFmpeg's name of the format or device.")
        .field("format_options", &VideoReaderOptions::formatOptions, "[(name, value), ...].")
        .field("deinterlace", &VideoReaderOptions::deinterlace, "Fill in interlaced lines.")
        .field("is_depth", &VideoReaderOptions::isDepth, "The pictures are depth.")
        .constructible()
        .done();
    py::class_<Frame>(m, "VideoFrame", "One picture of a video and its time.")
        .def_readonly("picture", &Frame::picture, "uint8 [rows x columns x 3].")
        .def_readonly("seconds", &Frame::seconds, "Time of display, s.")
        .def_readonly("pts", &Frame::pts, "Time of display, units of the time base.")
        .def_readonly("duration", &Frame::duration, "Units of the time base; 0: unknown.")
        .def_readonly("sample_aspect", &Frame::sampleAspect, "Width : height of a px.");
    py::class_<Reader>(
        m, "VideoReader",
        "Reads the frames of a video file or a camera: for frame in VideoReader(...).")
        .def(py::init([](const std::filesystem::path& path, const VideoReaderOptions& options,
                         Order order) {
                 return unlocked([=] { return std::make_unique<Reader>(path, options, order); });
             }),
             py::arg("path"), py::kw_only(),
             py::arg_v("options", VideoReaderOptions(), "VideoReaderOptions()"),
             py::arg("order") = "rgb")
        .def(
            "facts", [](const Reader& self) { return self.facts(); }, "Properties of the file.")
        .def("counts", inTurn<Reader>(&VideoReader::counts), "Counts of what was read so far.")
        .def("notes", inTurn<Reader>(&VideoReader::notes),
             "Remarks about the file and what happened so far.")
        .def("__iter__", [](py::object self) { return self; })
        .def("__next__", [](Reader& self) {
            std::optional<VideoFrame> frame = unlocked(self, [&] { return self.next(); });
            if (!frame) throw py::stop_iteration();
            const double unit = self.facts().timeBase.value();
            return Frame{arrayOf(std::move(frame->picture), self.order),
                         static_cast<double>(frame->pts) * unit, frame->pts, frame->duration,
                         frame->sampleAspect};
        });
}

} // namespace

void bindVideoIo(py::module_& m) {
    bindFacts(m);
    bindReader(m);
    bindWriterOptions(m);
    py::class_<Writer>(m, "VideoWriter",
                       "Writes frames as a video, with the sound and the other streams of its "
                       "source. The file appears in finish(); a `with` block calls it.")
        .def(py::init([](const std::filesystem::path& path, const VideoWriterOptions& options,
                         Reader* source) {
                 const auto open = [=] {
                     return std::make_unique<Writer>("VideoWriter", true, path, options, source);
                 };
                 return source == nullptr ? unlocked(open) : unlocked(*source, open);
             }),
             py::arg("path"), py::arg("options"), py::kw_only(), py::arg("source") = py::none(),
             "path: .mkv, .mp4, .m4v or .mov; source: a reader that has not delivered a frame.")
        .def(
            "write",
            [](Writer& self, const Array& picture, std::int64_t pts, std::int64_t duration,
               Order order) {
                VideoFrame frame;
                frame.picture = pictureOf(picture, "picture", order);
                frame.pts = pts;
                frame.duration = duration;
                unlocked(self, [&] { self.write(frame); });
            },
            py::arg("picture"), py::arg("pts"), py::kw_only(), py::arg("duration") = 0,
            py::arg("order") = "rgb",
            "Encodes a frame, uint8 [rows x columns x 3]; times in VideoWriterOptions.time_base.")
        .def("finish", inTurn<Writer>(&VideoWriter::finish),
             "Writes the remaining data and gives the file its name.")
        .def("notes", inTurn<Writer>(&VideoWriter::notes),
             "Remarks on what was left out or converted.")
        .def("__enter__", [](py::object self) { return self; })
        .def("__exit__", [](Writer& self, const py::object& type, const py::object& /*value*/,
                            const py::object& /*traceback*/) {
            if (type.is_none()) unlocked(self, [&] { self.finish(); });
        });
}

} // namespace altiro3D::python
