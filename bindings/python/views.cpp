#include "arrays.hpp"

#include <altiro3D/depth2quilt.hpp>
#include <altiro3D/stereo_views.hpp>

namespace altiro3D::python {

namespace {

std::pair<Array, Array> eyesOf(StereoPair pair, Order order) {
    return {Array{arrayOf(std::move(pair.left), order)},
            Array{arrayOf(std::move(pair.right), order)}};
}

void bindStereo(py::module_& m) {
    py::enum_<EyesFrom>(m, "EyesFrom", "Which of the eyes' pictures are rendered.")
        .value("Both", EyesFrom::Both, "the photo lies between them")
        .value("KeepLeft", EyesFrom::KeepLeft, "the left one is the photo");
    m.def(
        "render_eyes",
        [](const Scene& scene, const ViewOptions& views, EyesFrom from, Order order) {
            return eyesOf(unlocked([=] { return renderEyes(scene, views, from); }), order);
        },
        py::arg("scene"), py::arg("views"), py::kw_only(), py::arg("from_") = EyesFrom::Both,
        py::arg("order") = "rgb",
        "The pictures of both eyes, left and right: uint8 [rows x shown columns x 3].\n\n"
        "views: a strength_percent of 2.5 is comfortable.");
    m.def(
        "join_eyes",
        [](const Array& left, const Array& right, EyesPicture picture, const Out& out,
           Order order) {
            const cv::Mat leftEye = pictureOf(left, "left", order);
            const cv::Mat rightEye = pictureOf(right, "right", order);
            Result joined(out, order);
            unlocked([&] { joinEyes(leftEye, rightEye, picture, joined.mat); });
            return Array{joined.array()};
        },
        py::arg("left"), py::arg("right"), py::arg("picture"), py::kw_only(),
        py::arg("out") = py::none(), py::arg("order") = "rgb",
        "Joins the pictures of both eyes, uint8 [rows x columns x 3], to one picture.");
    m.def(
        "split_stereo_pair",
        [](const Array& picture, StereoLayout layout, StereoHalves halves, Order order) {
            const cv::Mat whole = pictureOf(picture, "picture", order);
            return eyesOf(unlocked([&] { return splitStereoPair(whole, layout, halves); }), order);
        },
        py::arg("picture"), py::arg("layout"), py::kw_only(),
        py::arg("halves") = StereoHalves::Automatic, py::arg("order") = "rgb",
        "Splits a picture that holds both eyes, uint8, into the left and the right one.");
}

} // namespace

void bindViews(py::module_& m) {
    py::class_<Depth2Quilt>(m, "Depth2Quilt",
                            "Makes the views of a photo with depth and lays them out as a quilt. "
                            "Immutable; threads may share it.")
        .def(py::init<const QuiltLayout&, const ViewOptions&>(), py::arg("layout"), py::kw_only(),
             py::arg_v("options", ViewOptions(), "ViewOptions()"))
        .def_property_readonly("layout", &Depth2Quilt::layout, py::return_value_policy::copy,
                               "The layout of the quilts.")
        .def_property_readonly("options", &Depth2Quilt::options, py::return_value_policy::copy,
                               "The options in use.")
        .def(
            "render",
            [](const Depth2Quilt& self, const Scene& scene, const std::optional<py::function>& goOn,
               const Out& out, Order order) -> Out {
                Result quilt(out, order);
                const QuiltProgressFunction progress = quiltProgressOf(goOn);
                const bool isWhole =
                    unlocked([&, scene] { return self.render(scene, quilt.mat, progress); });
                return {isWhole ? quilt.array() : py::none()};
            },
            py::arg("scene"), py::kw_only(), py::arg("go_on") = py::none(),
            py::arg("out") = py::none(), py::arg("order") = "rgb",
            "All views: uint8 [quilt rows x quilt columns x 3].\n\n"
            "scene: photo and depth of one size. go_on(share), 0..1, is called after each part;\n"
            "if it returns False, the work stops and the result is None.")
        .def(
            "render_view",
            [](const Depth2Quilt& self, const Scene& scene, double position, Order order) {
                cv::Mat view;
                unlocked([&, scene] { self.renderView(scene, position, view); });
                return Array{arrayOf(std::move(view), order)};
            },
            py::arg("scene"), py::arg("position"), py::kw_only(), py::arg("order") = "rgb",
            "One view: uint8 [rows x shown columns x 3].\n\n"
            "position: of the camera, -1 leftmost .. +1 rightmost.");
    bindStereo(m);
}

} // namespace altiro3D::python
