#include "arrays.hpp"

#include <altiro3D/lens_sheet.hpp>
#include <altiro3D/native_maker.hpp>
#include <altiro3D/print_sheet.hpp>

namespace altiro3D::python {

namespace {

void bindLenses(py::module_& m) {
    py::enum_<SubpixelOrder>(m, "SubpixelOrder", "How the colours of a px lie under a lens.")
        .value("None_", SubpixelOrder::None, "at one place: a print")
        .value("Rgb", SubpixelOrder::Rgb, "side by side, red at the left: most screens")
        .value("Bgr", SubpixelOrder::Bgr, "side by side, blue at the left")
        .value("VerticalRgb", SubpixelOrder::VerticalRgb, "above each other, red at the top");
    Value<LensNumbers>(m, "LensNumbers", "A sheet of lenses on a print or a screen; 0: unknown.")
        .field("lpi", &LensNumbers::lpi, "Lenses per inch, perpendicular to them.")
        .field("dpi", &LensNumbers::dpi, "Px per inch across.")
        .field("dpi_down", &LensNumbers::dpiDown, "Px per inch down; 0: as across.")
        .field("width", &LensNumbers::width, "Of the picture, mm.")
        .field("height", &LensNumbers::height, "Of the picture, mm.")
        .field("is_horizontal", &LensNumbers::isHorizontal, "The lenses lie.")
        .field("angle", &LensNumbers::angle, "Of the lenses, -45..45 degrees.")
        .field("views", &LensNumbers::views, "Number of views; 0: as many as are useful.")
        .field("subpixels", &LensNumbers::subpixels, "None_: a print; else a screen.")
        .field("thickness", &LensNumbers::thickness, "Of the sheet, mm.")
        .field("index", &LensNumbers::index, "Refractive index of the sheet.")
        .field("distance", &LensNumbers::distance, "Of the eye, mm.")
        .constructible()
        .done();
    Value<LensFacts>(m, "LensFacts", "What follows from the numbers of a lens; 0: unknown.")
        .field("useful_views", &LensFacts::usefulViews, "More views blend.")
        .field("view_cone", &LensFacts::viewCone, "Full angle, degrees.")
        .field("visual_lpi", &LensFacts::visualLpi, "As the lenses appear at the distance.")
        .field("sharp_depth", &LensFacts::sharpDepth, "Depth without blur, mm.")
        .field("sharp_strength", &LensFacts::sharpStrength, "ViewOptions.strength_percent of it.")
        .done();
    Value<BarrierNumbers>(m, "BarrierNumbers", "A screen with lenses or a barrier, by sub-pixels.")
        .field("panel", &BarrierNumbers::panel, "Width and height, px.")
        .field("dpi", &BarrierNumbers::dpi, "Px per inch, for sizes in mm only.")
        .field("pitch", &BarrierNumbers::pitch, "Sub-pixels across one lens, 2..1000.")
        .field("slope", &BarrierNumbers::slope, "Sub-pixels to the right per row, -3..3.")
        .field("offset", &BarrierNumbers::offset, "Left edge of a lens in the top row, sub-pixels.")
        .field("is_bgr", &BarrierNumbers::isBgr, "Blue is the leftmost colour.")
        .field("views", &BarrierNumbers::views, "Number of views; 0: those of order, else 48.")
        .field("order", &BarrierNumbers::order, "Views under a lens from left to right.")
        .constructible()
        .done();
    m.def("calibration_of", py::overload_cast<const LensNumbers&>(&calibrationOf),
          py::arg("numbers"), "The calibration of a print or of a screen with a lens film.");
    m.def("calibration_of", py::overload_cast<const BarrierNumbers&>(&calibrationOf),
          py::arg("numbers"), "The calibration of a screen with lenses or a barrier.");
    m.def("calibration_text", &calibrationText, py::arg("calibration"),
          "The text of a visual.json, which read_display() reads.");
    m.def("lens_facts", &lensFacts, py::arg("calibration"), "What follows from a calibration.");
}

} // namespace

void bindPrintSheet(py::module_& m) {
    bindLenses(m);
    Value<PrintOptions>(m, "PrintOptions", "What a print has around its picture.")
        .field("bleed", &PrintOptions::bleed, "More of the picture at each side, 0..50 mm.")
        .field("has_marks", &PrintOptions::hasMarks, "Strips, crop marks and a line of text.")
        .field("text", &PrintOptions::text, "Added to that line.")
        .constructible()
        .done();
    py::class_<PrintSheet>(
        m, "PrintSheet",
        "A print of exact size: a Native with bleed, strips to align the lenses, "
        "crop marks and a line of text. Immutable; threads may share it.")
        .def(py::init<const Display&, PrintOptions>(), py::arg("display"), py::kw_only(),
             py::arg_v("options", PrintOptions(), "PrintOptions()"))
        .def_property_readonly("display", &PrintSheet::display, py::return_value_policy::copy,
                               "The print with its bleed.")
        .def("size", &PrintSheet::size, "Width and height of the sheet, px.")
        .def("picture", &PrintSheet::picture, "(x, y, width, height) that remain when it is cut.")
        .def(
            "write",
            [](const PrintSheet& self, const std::filesystem::path& file, const Scene& scene,
               const NativeOptions& options) {
                unlocked([&, scene, options] {
                    const NativeMaker maker(self.display(), options);
                    const bool isDirect = maker.path() == NativePath::Direct;
                    const Placement placed =
                        placeScene(scene, self.display().aspect(),
                                   isDirect ? maker.workSize() : maker.quiltSize(), options);
                    cv::Mat quilt;
                    if (!isDirect) maker.makeQuilt(placed.scene, quilt);
                    self.write(file, [&](const RowSink& sink) {
                        maker.makeNative(placed.scene, quilt, [&](const cv::Mat& rows) {
                            sink(rows);
                            const Locked locked;
                            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                        });
                    });
                });
            },
            py::arg("file"), py::arg("scene"), py::kw_only(),
            py::arg_v("options", NativeOptions(), "NativeOptions()"),
            "Fits a scene of any size and writes its print, a .png, .tif or .pdf, in bands of "
            "rows.");
    m.def(
        "write_pitch_sheet",
        [](const std::filesystem::path& file, const Calibration& print, double around,
           double step) { unlocked([=] {
                              writePitchSheet(file, print, {around, step});
                          }); },
        py::arg("file"), py::arg("calibration"), py::kw_only(), py::arg("around") = 0.0,
        py::arg("step") = 0.0, "Writes bands of lines that find the pitch, LPI; 0: by itself.");
}

} // namespace altiro3D::python
