#include "bindings.hpp"

#include <altiro3D/view_options.hpp>

namespace altiro3D::python {

void bindViewOptions(py::module_& m) {
    py::enum_<ViewMethod>(m, "ViewMethod", "How views are rendered from a photo and its depth.")
        .value("Fast", ViewMethod::Fast, "backward mapping: no holes, soft edges")
        .value("Real", ViewMethod::Real, "a real camera with focal length and baseline; slow")
        .value("Layered", ViewMethod::Layered, "surfaces over a background painted once");
    py::enum_<Inpainting>(m, "Inpainting", "How method Real fills holes.")
        .value("Telea", Inpainting::Telea)
        .value("NavierStokes", Inpainting::NavierStokes);
    py::enum_<LayeredFill>(m, "LayeredFill", "What the hidden background shows.")
        .value("Continue", LayeredFill::Continue, "the border pixel, repeated")
        .value("BackgroundLayer", LayeredFill::BackgroundLayer, "a background painted once");
    Value<RealOptions>(m, "RealOptions", "Options of method Real.")
        .field("inpainting", &RealOptions::inpainting, "How holes are filled.")
        .field("inpainting_radius", &RealOptions::inpaintingRadius, "Neighbourhood, px, 1..20.")
        .field("background_only", &RealOptions::backgroundOnly, "Fill from the background only.")
        .constructible()
        .done();
    Value<LayeredOptions>(m, "LayeredOptions", "Options of method Layered.")
        .field("tear_pixels", &LayeredOptions::tearPixels, "Steps above this are torn, px.")
        .field("edge_dilation_pixels", &LayeredOptions::edgeDilationPixels,
               "Background px that move with the foreground, 0..8.")
        .field("soft_borders", &LayeredOptions::softBorders, "Split the colours at borders.")
        .field("fill", &LayeredOptions::fill, "What disocclusions show.")
        .constructible()
        .done();
    Value<ViewOptions>(m, "ViewOptions", "Options of the views.")
        .field("method", &ViewOptions::method, "How views are rendered.")
        .field("strength_percent", &ViewOptions::strengthPercent,
               "Parallax between the outermost views for a depth of 1, % of the width.")
        .field("focus", &ViewOptions::focus, "Depth on the panel's surface, 0 (far) .. 1 (near).")
        .field("refinement", &ViewOptions::refinement, "Fast: iterations, 0..16.")
        .part("real", &ViewOptions::real, "Options of method Real.")
        .part("layered", &ViewOptions::layered, "Options of method Layered.")
        .constructible()
        .done()
        .def(
            "validate", [](const ViewOptions& options) { validate(options); },
            "Raises Error InvalidArgument that names the field, its value and the range.");
}

} // namespace altiro3D::python
