#include "arrays.hpp"

#include <altiro3D/quilt2native.hpp>

namespace altiro3D::python {

namespace {

// Binds a function that cuts or resamples a quilt.
template <class Work>
void defQuilt(py::module_& m, const char* name, const Work& work, const char* doc) {
    m.def(
        name,
        [work](const Array& quilt, const QuiltLayout& layout, Order order) {
            const cv::Mat picture = pictureOf(quilt, "quilt", order);
            return Array{arrayOf(unlocked([=] { return work(picture, layout); }), order)};
        },
        py::arg("quilt"), py::arg("layout"), py::kw_only(), py::arg("order") = "rgb", doc);
}

void bindSearch(py::module_& m) {
    py::enum_<QuiltVerdict>(m, "QuiltVerdict", "What find_quilt_layout() has found out.")
        .value("Quilt", QuiltVerdict::Quilt, "its layout is certain enough to be used")
        .value("Unsure", QuiltVerdict::Unsure, "parts resemble each other, but it is not certain")
        .value("NoQuilt", QuiltVerdict::NoQuilt, "a photo, for example");
    Value<FoundQuilt>(m, "FoundQuilt", "The layout that a picture seems to have.")
        .field("verdict", &FoundQuilt::verdict, "How far the layout can be trusted.")
        .part("layout", &FoundQuilt::layout, "The most likely layout.")
        .field("confidence", &FoundQuilt::confidence, "How alike neighbouring views are, 0..1.")
        .field("is_from_top", &FoundQuilt::isFromTop, "Its rows follow each other downwards.")
        .done();
    m.def(
        "find_quilt_layout",
        [](const Array& picture, Order order) {
            const cv::Mat quilt = pictureOf(picture, "picture", order);
            return unlocked([&] { return findQuiltLayout(quilt); });
        },
        py::arg("picture"), py::kw_only(), py::arg("order") = "rgb",
        "Finds the columns and rows of a quilt by comparing parts of the picture, uint8.");
    m.def(
        "check_quilt_layout",
        [](const Array& picture, const QuiltLayout& layout, Order order) {
            const cv::Mat quilt = pictureOf(picture, "picture", order);
            return unlocked([=] { return checkQuiltLayout(quilt, layout); });
        },
        py::arg("picture"), py::arg("layout"), py::kw_only(), py::arg("order") = "rgb",
        "Compares a quilt, uint8, with its layout. Returns remarks, usually none: views of one "
        "colour, rows from the top, another layout.");
}

} // namespace

void bindQuilt2Native(py::module_& m) {
    defQuilt(
        m, "fit_quilt", [](const cv::Mat& q, const QuiltLayout& l) { return fitQuilt(q, l); },
        "Resamples a quilt, uint8, so that its views have whole px.");
    defQuilt(
        m, "crop_quilt", [](const cv::Mat& q, const QuiltLayout& l) { return cropQuilt(q, l); },
        "Crops a quilt, uint8, to views of whole px.");
    py::class_<Quilt2Native>(m, "Quilt2Native",
                             "Renders Natives from quilts. Immutable; threads may share it.")
        .def(py::init<NativeLut>(), py::arg("lut"), "Nearest view, nearest px.")
        .def(py::init([](const Calibration& calibration, const QuiltLayout& quilt,
                         QuiltSampling sampling, InvertViews invert) {
                 return unlocked(
                     [=] { return Quilt2Native(calibration, quilt, sampling, invert); });
             }),
             py::arg("calibration"), py::arg("quilt"), py::kw_only(),
             py::arg_v("sampling", QuiltSampling(), "QuiltSampling()"),
             py::arg("invert") = InvertViews::Auto, "With any sampling.")
        .def(
            "render",
            [](const Quilt2Native& self, const Array& quilt, const Out& out, Order order) {
                const cv::Mat picture = pictureOf(quilt, "quilt", Order::Bgr); // as it is
                Result native(out);
                unlocked([&] { self.render(picture, native.mat, order); });
                return Array{native.array()};
            },
            py::arg("quilt"), py::kw_only(), py::arg("out") = py::none(), py::arg("order") = "rgb",
            "The Native of a quilt: uint8 [panel rows x panel columns x 3].\n\n"
            "quilt: uint8 [layout's rows x columns x 3], or of another size that fit_quilt() "
            "takes.");
    py::class_<QuiltShape>(m, "QuiltShape",
                           "How the views of a quilt file are fitted to the panel if their shapes "
                           "differ: by the aspect in the file's name, else that of their px.")
        .def(py::init<const std::filesystem::path&, const QuiltLayout&, const Display&,
                      std::optional<FitMode>>(),
             py::arg("file"), py::arg("layout"), py::arg("display"), py::kw_only(),
             py::arg("fit") = py::none())
        .def(
            "apply",
            [](const QuiltShape& self, const Array& picture, Order order) {
                const cv::Mat quilt = pictureOf(picture, "picture", order);
                return Array{arrayOf(unlocked([&] { return self.apply(quilt); }), order)};
            },
            py::arg("picture"), py::kw_only(), py::arg("order") = "rgb",
            "The quilt for Quilt2Native: uint8 of the layout's size.")
        .def("shown_aspect", &QuiltShape::shownAspect, "Width : height of a view on the panel.")
        .def("aspect", &QuiltShape::aspect, "Width : height for which the views were made.")
        .def("fit", &QuiltShape::fit, "How the views are fitted.");
    bindSearch(m);
}

} // namespace altiro3D::python
