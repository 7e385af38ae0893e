#include "arrays.hpp"

#include <altiro3D/lens_view.hpp>

namespace altiro3D::python {

void bindLensView(py::module_& m) {
    Value<LensEye>(m, "LensEye", "An eye in front of a display.")
        .field("phase", &LensEye::phase, "Position under the lenses: 0 start of view 0, 1 end.")
        .field("spot", &LensEye::spot, "Width seen under each lens, lens periods; 0: a sub-pixel.")
        .field("blur", &LensEye::blur, "Standard deviation of its blur, px, 0..64.")
        .constructible()
        .done();
    m.def("view_cone_degrees", &viewConeDegrees, py::arg("calibration"),
          "The full horizontal view cone of a display, degrees.");
    m.def("eye_at_angle", &eyeAtAngle, py::arg("calibration"), py::arg("angle_degrees"),
          "The eye at an angle from the panel's normal; negative = left, where view 0 is seen.");
    m.def("eye_at_view", &eyeAtView, py::arg("view"), py::arg("view_count"),
          "The eye that sees exactly the sub-pixels of one view.");
    m.def("eye_blur", &eyeBlur, py::arg("calibration"), py::kw_only(),
          py::arg("distance_centimetres") = 50.0, "The blur of an eye, px, for LensEye.blur.");
    m.def(
        "simulate_view",
        [](const Array& native, const Calibration& calibration, const LensEye& eye,
           InvertViews invert, const Out& out, Order order) {
            const cv::Mat picture = pictureOf(native, "native", order);
            Result seen(out, order);
            unlocked([&, calibration, eye] {
                simulateView(picture, calibration, eye, seen.mat, invert);
            });
            return Array{seen.array()};
        },
        py::arg("native"), py::arg("calibration"), py::arg("eye"), py::kw_only(),
        py::arg("invert") = InvertViews::Auto, py::arg("out") = py::none(),
        py::arg("order") = "rgb",
        "What an eye sees of a Native through the display's lenses.\n\n"
        "native: uint8 [panel rows x panel columns x 3]. Returns a picture of the same size.");
}

} // namespace altiro3D::python
