#include "bindings.hpp"

#include <altiro3D/video_conversion.hpp>

namespace altiro3D::python {

namespace {

// Classes of Python stay alive, so that they are found again.
py::object sourceIn(const VideoConversion& conversion) {
    return py::cast(conversion.depth);
}

void setSource(VideoConversion& conversion, const py::object& source) {
    conversion.depth = source.is_none() ? nullptr : sourceOf(source);
}

void bindParts(py::module_& m) {
    py::enum_<VideoProduct>(m, "VideoProduct", "Kind of video that a conversion makes.")
        .value("Native", VideoProduct::Native)
        .value("Quilt", VideoProduct::Quilt)
        .value("Rgbd", VideoProduct::Rgbd, "frame and depth side by side")
        .value("Stereo", VideoProduct::Stereo, "pictures of both eyes");
    py::enum_<UnfinishedRun>(m, "UnfinishedRun", "What to do with an unfinished earlier run.")
        .value("Refuse", UnfinishedRun::Refuse, "raise Error WriteFailed")
        .value("Resume", UnfinishedRun::Resume, "continue it")
        .value("Discard", UnfinishedRun::Discard, "remove it and begin anew");
    Value<StereoVideo>(m, "StereoVideo", "How the frames of a video hold both eyes' pictures.")
        .field("layout", &StereoVideo::layout, "Order of the eyes.")
        .field("halves", &StereoVideo::halves, "Shape of the halves.")
        .constructible()
        .done();
    Value<VideoEyes>(m, "VideoEyes", "How a video for two eyes is made.")
        .field("picture", &VideoEyes::picture, "How a frame shows both eyes.")
        .field("from_", &VideoEyes::from, "Which eyes are rendered.")
        .field("swapped", &VideoEyes::swapped, "The left eye sees the right one's picture.")
        .field("filmed", &VideoEyes::filmed, "Both pictures stay as they were filmed.")
        .constructible()
        .done();
    Value<DepthRange>(m, "DepthRange", "The numbers of 16-bit depth that become 0 and 1.")
        .field("low", &DepthRange::low, "Becomes 0.")
        .field("high", &DepthRange::high, "Becomes 1.")
        .constructible()
        .done();
    Value<GivenVideoDepth>(m, "GivenVideoDepth", "Existing depth of a video: source or rgbd.")
        .field("source", &GivenVideoDepth::source, "A depth video, or a folder of depth images.")
        .field("rgbd", &GivenVideoDepth::rgbd, "Each frame is an RGB-D image.")
        .field("kind", &GivenVideoDepth::kind, "Meaning of the numbers.")
        .field("range", &GivenVideoDepth::range, "Range of 16-bit depth; None: measured.")
        .constructible()
        .done();
    Value<SceneChoice>(m, "SceneChoice", "What was chosen for a scene.")
        .field("start", &SceneChoice::start, "First frame, s.")
        .field("framing", &SceneChoice::framing, "The part that is shown.")
        .field("focus", &SceneChoice::focus, "Depth on the panel's surface.")
        .field("strength_percent", &SceneChoice::strengthPercent, "See ViewOptions.")
        .done();
}

void bindResult(py::module_& m) {
    Value<VideoConversionResult>(m, "VideoConversionResult", "Result of a conversion.")
        .field("frames", &VideoConversionResult::frames, "Frames made.")
        .field("kept_frames", &VideoConversionResult::keptFrames, "Frames of an earlier run.")
        .field("end", &VideoConversionResult::end, "End of the last frame made, s.")
        .field("inferences", &VideoConversionResult::inferences, "Frames with an estimate.")
        .field("repeated", &VideoConversionResult::repeated, "Frames that equal the one before.")
        .field("cuts", &VideoConversionResult::cuts, "Scene cuts, s.")
        .field("choices", &VideoConversionResult::choices, "What was chosen per scene.")
        .field("cancelled", &VideoConversionResult::cancelled, "The run was stopped.")
        .field("keeps_work", &VideoConversionResult::keepsWork, "A later run can resume.")
        .field("finish_seconds", &VideoConversionResult::finishSeconds, "Time to close the file.")
        .field("counts", &VideoConversionResult::counts, "Counts of the reader.")
        .field("notes", &VideoConversionResult::notes, "Remarks about input and depth.")
        .done();
}

} // namespace

void bindVideoConversion(py::module_& m) {
    bindParts(m);
    bindResult(m);
    Value<VideoConversion>(m, "VideoConversion",
                           "How a video is converted. To make a Native video, set input, "
                           "output and display.")
        .field("input", &VideoConversion::input, "The video.")
        .part("part", &VideoConversion::part, "The part of it to convert.")
        .field("output", &VideoConversion::output, ".mkv, .mp4, .m4v or .mov; is replaced.")
        .field("product", &VideoConversion::product, "Kind of video to make.")
        .part("eyes", &VideoConversion::eyes, "Of the product Stereo.")
        .field("rgbd_halves", &VideoConversion::rgbdHalves, "Of the product Rgbd.")
        .field("display", &VideoConversion::display, "For Natives and quilts.")
        .field("map", &VideoConversion::map, "Look-up table for the Natives.")
        .field("layout", &VideoConversion::layout, "Layout of the quilts; None: the display's.")
        .part("recipe", &VideoConversion::recipe, "How views are rendered and fitted.")
        .field("from_quilt", &VideoConversion::fromQuilt, "The frames are quilts.")
        .field("view_aspect", &VideoConversion::viewAspect, "Width : height of a view's scene.")
        .field("stereo", &VideoConversion::stereo, "Frames hold both eyes' pictures.")
        .property("depth", &sourceIn, &setSource, "Source of the depth; None: estimated_depth().")
        .part("depth_options", &VideoConversion::depthOptions, "How often depth is estimated.")
        .field("given", &VideoConversion::given, "Existing depth, used instead of an estimate.")
        .part("encoding", &VideoConversion::encoding, "Options of the output.")
        .field("unfinished", &VideoConversion::unfinished, "What to do with an earlier run.")
        .field("settings", &VideoConversion::settings, "Further settings of the caller.")
        .constructible()
        .done();
    using Converter = OneByOne<VideoConverter>;
    py::class_<Converter>(m, "VideoConverter",
                          "Converts a video: decodes, estimates depth, renders and encodes, with a "
                          "thread each.")
        .def(py::init([](const VideoConversion& conversion) {
                 return unlocked([=] {
                     // a run takes long, and its functions of Python must not wait for it
                     return std::make_unique<Converter>("VideoConverter", false, conversion);
                 });
             }),
             py::arg("conversion"), "Checks the options and opens input and output.")
        .def("size", &VideoConverter::size, "Width and height of the pictures that are made, px.")
        .def("notes", inTurn<Converter>(&VideoConverter::notes),
             "Remarks about the output; not during run().")
        .def(
            "run",
            [](Converter& self, const std::optional<py::function>& goOn) {
                VideoConversionResult result;
                const std::lock_guard<Turn> held(self.turn);
                runStoppable(progressOf(goOn), [&](const VideoProgressFunction& progress) {
                    result = self.run(progress);
                });
                return result;
            },
            py::kw_only(), py::arg("go_on") = py::none(),
            "Converts the video.\n\n"
            "go_on(progress) is called for each frame, in threads of the run; if it returns "
            "False,\n"
            "the run stops, and the file can be played up to there. An exception in it, or "
            "Ctrl-C,\n"
            "stops the run and is raised here.");
}

} // namespace altiro3D::python
