#include "arrays.hpp"

#include <altiro3D/native_lut.hpp>
#include <altiro3D/native_maker.hpp>

namespace altiro3D::python {

namespace {

void bindLut(py::module_& m) {
    py::class_<NativeLut>(
        m, "NativeLut",
        "The look-up table of a display and a quilt layout: for every sub-pixel of "
        "the panel, the quilt pixel that it shows. Immutable; threads may share it.")
        .def(py::init(
                 [](const Calibration& calibration, const QuiltLayout& quilt, InvertViews invert) {
                     return unlocked([=] { return NativeLut(calibration, quilt, invert); });
                 }),
             py::arg("calibration"), py::arg("quilt"), py::kw_only(),
             py::arg("invert") = InvertViews::Auto)
        .def_static("load", &NativeLut::load, py::arg("file"), py::call_guard<Released>(),
                    "Reads and checks a .map file.")
        .def("save", &NativeLut::save, py::arg("file"), py::call_guard<Released>(),
             "Writes a .map file; it appears complete or not at all.")
        .def("panel_size", &NativeLut::panelSize, "Width and height of the panel, px.")
        .def_property_readonly("quilt", &NativeLut::quilt, py::return_value_policy::copy,
                               "The layout of the quilts.")
        .def("calibration_fingerprint", &NativeLut::calibrationFingerprint,
             "The fingerprint() of the calibration that it was built from.")
        .def(
            "channel",
            [](const NativeLut& self, int channel) {
                return Array{arrayOf(self.channel(channel))};
            },
            py::arg("channel"), py::keep_alive<0, 1>(),
            "The table of red (0), green (1) or blue (2): uint16 [panel rows x panel columns x "
            "2],\n"
            "x and y in px of the quilt, y from the top. Do not change it.");
}

} // namespace

void bindNative(py::module_& m) {
    bindLut(m);
    py::enum_<NativePath>(m, "NativePath", "The path from a photo to its Native.")
        .value("Direct", NativePath::Direct, "reads each sub-pixel from the photo")
        .value("OverQuilt", NativePath::OverQuilt, "makes all views first");
    py::class_<NativeMaker>(
        m, "NativeMaker",
        "Makes Natives of photos with depth for one display. Immutable; threads "
        "may share it.")
        .def(py::init([](const Display& display, const NativeOptions& options) {
                 return unlocked([=] { return NativeMaker(display, options); });
             }),
             py::arg("display"), py::kw_only(),
             py::arg_v("options", NativeOptions(), "NativeOptions()"))
        .def(py::init([](const Display& display, const QuiltLayout& layout,
                         const NativeOptions& options) {
                 return unlocked([=] { return NativeMaker(display, layout, options); });
             }),
             py::arg("display"), py::arg("layout"), py::kw_only(),
             py::arg_v("options", NativeOptions(), "NativeOptions()"),
             "With another number and size of views than the display's own.")
        .def(py::init([](const NativeLut& map, const NativeOptions& options) {
                 return unlocked([=] { return NativeMaker(map, options); });
             }),
             py::arg("map"), py::kw_only(),
             py::arg_v("options", NativeOptions(), "NativeOptions()"),
             "With an existing look-up table: over a quilt, which takes longer.")
        .def("with_views", &NativeMaker::withViews, py::arg("views"),
             "A maker with other view options, which shares what this one has computed.")
        .def_static("obstacle", &NativeMaker::obstacle, py::arg("layout"), py::arg("options"),
                    "Why the direct path is not possible; empty if it is.")
        .def("path", &NativeMaker::path, "The path in use.")
        .def_property_readonly("options", &NativeMaker::options, py::return_value_policy::copy,
                               "The options in use.")
        .def_property_readonly("layout", &NativeMaker::layout, py::return_value_policy::copy,
                               "Layout of the quilts.")
        .def("panel_size", &NativeMaker::panelSize, "Width and height of the Native, px.")
        .def("work_size", &NativeMaker::workSize, "Size to which photos are fitted for a Native.")
        .def("quilt_size", &NativeMaker::quiltSize, "Size to which photos are fitted for a quilt.")
        .def(
            "make_quilt",
            [](const NativeMaker& self, const Scene& fitted,
               const std::optional<py::function>& goOn, const Out& out, Order order) -> Out {
                Result quilt(out, order);
                const QuiltProgressFunction progress = quiltProgressOf(goOn);
                const bool isWhole =
                    unlocked([&, fitted] { return self.makeQuilt(fitted, quilt.mat, progress); });
                return {isWhole ? quilt.array() : py::none()};
            },
            py::arg("fitted"), py::kw_only(), py::arg("go_on") = py::none(),
            py::arg("out") = py::none(), py::arg("order") = "rgb",
            "The quilt of a fitted scene: uint8 [quilt rows x quilt columns x 3].\n\n"
            "fitted: from place_scene() for quilt_size(). go_on: as for Depth2Quilt.render().")
        .def(
            "make_native",
            [](const NativeMaker& self, const Scene& scene, const Out& out, Order order) {
                Result native(out); // the maker writes `order`
                unlocked([&, scene] { self.makeNative(scene, native.mat, order); });
                return Array{native.array()};
            },
            py::arg("scene"), py::kw_only(), py::arg("out") = py::none(), py::arg("order") = "rgb",
            "Fits a scene of any size and makes its Native: uint8 [panel rows x panel columns x "
            "3].")
        .def(
            "make_native",
            [](const NativeMaker& self, const Placement& placed, const Out& out, Order order) {
                Result native(out); // the maker writes `order`
                unlocked([&, placed] { self.makeNative(placed, native.mat, order); });
                return Array{native.array()};
            },
            py::arg("placed"), py::kw_only(), py::arg("out") = py::none(), py::arg("order") = "rgb",
            "The Native of a placed scene, from place_scene().");
}

} // namespace altiro3D::python
