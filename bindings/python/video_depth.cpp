#include "arrays.hpp"

#include <altiro3D/video_depth.hpp>

namespace altiro3D::python {

void bindVideoDepth(py::module_& m) {
    Value<VideoDepthOptions>(m, "VideoDepthOptions",
                             "How often the depth of a video is estimated, and how steady it is.")
        .field("every", &VideoDepthOptions::every, "Each n-th picture; 0: when it is needed.")
        .field("longest_gap", &VideoDepthOptions::longestGap, "Most pictures between estimates.")
        .field("max_changed_share", &VideoDepthOptions::maxChangedShare, "New share, 0..1.")
        .field("steadiness", &VideoDepthOptions::steadiness, "0..0.99.")
        .constructible()
        .done();
    Value<VideoDepthStep>(m, "VideoDepthStep", "What happened with one picture.")
        .field("cut", &VideoDepthStep::cut, "The first picture of a scene.")
        .field("inferred", &VideoDepthStep::inferred, "The estimator ran.")
        .field("repeated", &VideoDepthStep::repeated, "It equals the picture before.")
        .done();
    using SteadyDepth = OneByOne<VideoDepth>;
    py::class_<SteadyDepth>(m, "VideoDepth",
                            "Makes the depth of a video or camera steady, with few estimates.")
        .def(py::init([](const py::function& estimator, DepthKind kind,
                         const VideoDepthOptions& options) {
                 const auto estimate = [kept = keptOf(estimator)](const cv::Mat& picture,
                                                                  cv::Mat& raw) {
                     const Locked locked;
                     const py::object depth = (*kept)(arrayOf(picture, Order::Rgb));
                     raw = rawDepthOf({depth}, "depth of the estimator").clone();
                 };
                 return std::make_unique<SteadyDepth>("VideoDepth", true, estimate, kind, options);
             }),
             py::arg("estimator"), py::kw_only(), py::arg("kind") = DepthKind::NearWhite,
             py::arg_v("options", VideoDepthOptions(), "VideoDepthOptions()"),
             "estimator: a function of a picture, uint8 [rows x columns x 3], RGB, that returns "
             "raw\n"
             "depth [any size], for example the method `read` of a DepthSource.")
        .def(
            "next",
            [](SteadyDepth& self, const Array& picture, Order order) {
                const cv::Mat frame = pictureOf(picture, "picture", order);
                cv::Mat depth;
                const VideoDepthStep step = unlocked(self, [&] { return self.next(frame, depth); });
                return std::pair(Array{arrayOf(std::move(depth))}, step);
            },
            py::arg("picture"), py::kw_only(), py::arg("order") = "rgb",
            "The depth map of the next picture, float32 [any size], and how it was made.\n\n"
            "picture: uint8 [rows x columns x 3].");
}

} // namespace altiro3D::python
