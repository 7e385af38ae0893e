#include "bindings.hpp"

#include <altiro3D/display.hpp>

namespace altiro3D::python {

namespace {

void bindCalibration(py::module_& m) {
    py::enum_<InvertViews>(m, "InvertViews", "Whether the order of views under a lens is reversed.")
        .value("Auto", InvertViews::Auto, "as the calibration states it")
        .value("On", InvertViews::On, "reversed")
        .value("Off", InvertViews::Off, "not reversed");
    Value<SubpixelCell>(m, "SubpixelCell",
                        "Positions of the colours of one pixel relative to its centre, px.")
        .field("x", &SubpixelCell::x, "Offsets to the right of red, green, blue.")
        .field("y", &SubpixelCell::y, "Offsets upward of red, green, blue.")
        .constructible()
        .done();
    Value<LensSheet>(m, "LensSheet", "A sheet of lenses on a print or a screen; 0: unknown.")
        .field("is_print", &LensSheet::isPrint, "On paper, and not on a screen.")
        .field("dpi_down", &LensSheet::dpiDown, "Px per inch down.")
        .field("views", &LensSheet::views, "Number of views; 0: by the lens.")
        .field("thickness", &LensSheet::thickness, "mm.")
        .field("index", &LensSheet::index, "Refractive index.")
        .field("distance", &LensSheet::distance, "Of the eye, mm.")
        .constructible()
        .done();
    Value<SubpixelLens>(m, "SubpixelLens", "Lenses whose place is known in sub-pixels.")
        .field("period", &SubpixelLens::period, "Sub-pixels across one lens.")
        .field("slope", &SubpixelLens::slope, "Change of the place per row.")
        .field("offset", &SubpixelLens::offset, "Place of the first sub-pixel.")
        .field("slope_in_subpixels", &SubpixelLens::slopeInSubpixels, "Else in px.")
        .constructible()
        .done();
    Value<Calibration>(m, "Calibration",
                       "A display's calibration with the names and values of its visual.json.")
        .field("config_version", &Calibration::configVersion, "Format tag of the file.")
        .field("serial", &Calibration::serial, "Serial number; may be empty.")
        .field("pitch", &Calibration::pitch, "Lenses per inch, > 0.")
        .field("slope", &Calibration::slope, "Rise over run of a lens in panel px, != 0.")
        .field("center", &Calibration::center, "Phase offset of the lens array, lens periods.")
        .field("fringe", &Calibration::fringe, "Colour fringe correction; not used.")
        .field("view_cone", &Calibration::viewCone, "Full view cone, degrees; 0 = not given.")
        .field("inv_view", &Calibration::invView, "View order is reversed if >= 0.5.")
        .field("vertical_angle", &Calibration::verticalAngle, "Tilt of the viewing axis, degrees.")
        .field("dpi", &Calibration::DPI, "Panel px per inch, > 0.")
        .field("screen_w", &Calibration::screenW, "Panel width, px.")
        .field("screen_h", &Calibration::screenH, "Panel height, px.")
        .field("flip_image_x", &Calibration::flipImageX, "Mirrored left-right if >= 0.5.")
        .field("flip_image_y", &Calibration::flipImageY, "Mirrored upside down if >= 0.5.")
        .field("flip_subp", &Calibration::flipSubp, "The panel is BGR if >= 0.5.")
        .field("cell_pattern_mode", &Calibration::CellPatternMode, "How cells repeat, 0..4.")
        .field("subpixel_cells", &Calibration::subpixelCells, "Empty on stripe panels.")
        .field("sheet", &Calibration::sheet, "Of prints and of screens with a lens film; or None.")
        .field("lens", &Calibration::lens, "In sub-pixels, in place of pitch, slope and center.")
        .field("view_order", &Calibration::viewOrder, "Views under a lens, left to right; or [].")
        .constructible()
        .done()
        .def(
            "validate", [](const Calibration& calibration) { validate(calibration); },
            "Raises Error BadFormat that names the field, its value and what is expected.");
    m.def("read_calibrations", &readCalibrations, py::arg("file"), "All calibrations in a file.");
    m.def("parse_calibrations", &parseCalibrations, py::arg("text"), py::arg("source"),
          "As read_calibrations(), from text; `source` names it in errors.");
    m.def("fingerprint", &fingerprint, py::arg("calibration"),
          "Hash of all fields that enter the mapping of sub-pixels.");
}

void bindQuilt(py::module_& m) {
    auto layouts =
        Value<QuiltLayout>(m, "QuiltLayout",
                           "Arrangement of views in a quilt: view 0 is the bottom-left tile; the "
                           "next ones follow to the right, then up.")
            .field("columns", &QuiltLayout::columns, "Tiles side by side.")
            .field("rows", &QuiltLayout::rows, "Tiles above each other.")
            .field("tile_size", &QuiltLayout::tileSize, "Width and height of one view, px.")
            .field("view_count", &QuiltLayout::viewCount, "Views in use.")
            .constructible()
            .done();
    layouts.def("size", &QuiltLayout::size, "Width and height of the quilt, px.")
        .def(
            "tile",
            [](const QuiltLayout& self, int view) {
                validate(self);
                if (view < 0 || view >= self.columns * self.rows) {
                    throw Error(ErrorCode::InvalidArgument, "view",
                                "is " + std::to_string(view) + ", expected 0.." +
                                    std::to_string(self.columns * self.rows - 1));
                }
                return self.tile(view);
            },
            py::arg("view"),
            "(x, y, width, height) of a view's tile in px of the quilt, y from the top:\n\n"
            "    x, y, width, height = layout.tile(view)\n"
            "    quilt[y:y + height, x:x + width] = picture")
        .def(
            "validate", [](const QuiltLayout& self) { validate(self); },
            "Raises Error InvalidArgument or TooLarge that names the field and its limits.");
    m.def("view_position", &viewPosition, py::arg("view"), py::arg("view_count"),
          "Camera position of a view, -1 (leftmost) to +1 (rightmost).");
    m.def(
        "quilt_file_name",
        [](const std::filesystem::path& file, const QuiltLayout& layout, double aspect) {
            return PathResult{quiltFileName(file, layout, aspect)};
        },
        py::arg("file"), py::arg("layout"), py::arg("aspect"),
        "The file name for a quilt: photo.png becomes photo_qs8x6a0.75.png.");
    Value<QuiltGrid>(m, "QuiltGrid", "Columns and rows of a quilt.")
        .field("columns", &QuiltGrid::columns, "Tiles side by side.")
        .field("rows", &QuiltGrid::rows, "Tiles above each other.")
        .constructible()
        .done();
    Value<QuiltName>(m, "QuiltName", "What a quilt's file name states: `_qs8x6a0.75`.")
        .part("grid", &QuiltName::grid, "Columns and rows.")
        .field("aspect", &QuiltName::aspect, "Width : height of the scene; None if not stated.")
        .constructible()
        .done();
    m.def("parse_quilt_name", &parseQuiltName, py::arg("file"),
          "The last `_qs<columns>x<rows>a<aspect>` of a file name; None without one.");
}

} // namespace

void bindDisplay(py::module_& m) {
    bindCalibration(m);
    bindQuilt(m);
    Value<DisplayModel>(m, "DisplayModel", "A display model and its maker's recommendations.")
        .field("name", &DisplayModel::name, "Looking Glass Portrait, for example.")
        .field("serial_prefix", &DisplayModel::serialPrefix, "Prefix of its serial numbers.")
        .field("panel_size", &DisplayModel::panelSize, "Width and height, px.")
        .field("dpi", &DisplayModel::dpi, "Panel px per inch.")
        .field("view_cone_degrees", &DisplayModel::viewConeDegrees, "Full view cone, degrees.")
        .part("quilt", &DisplayModel::quilt, "Default quilt.")
        .done();
    Value<Display>(m, "Display", "A display that Natives are made for.")
        .part("calibration", &Display::calibration, "Contents of its visual.json.")
        .part("quilt", &Display::quilt, "Default layout of its quilts.")
        .field("invert", &Display::invert, "Whether the order of views is reversed.")
        .field("source", &Display::source, "Where the calibration comes from, for people.")
        .constructible()
        .done()
        .def("panel_size", &Display::panelSize, "Width and height of the panel, px.")
        .def("aspect", &Display::aspect, "Width : height of the panel.");
    m.def("read_display", &readDisplay, py::arg("calibration_file"), py::kw_only(),
          py::arg("serial") = "",
          "Reads a display from its visual.json; `serial` chooses one of several in the file.");
    m.def("display_of", &displayOf, py::arg("calibration"), py::kw_only(), py::arg("source") = "",
          "Makes a display from a calibration, with default_quilt().");
    m.def("find_display_model", &findDisplayModel, py::return_value_policy::copy,
          py::arg("calibration"), "The model by serial number, else by panel; None if unknown.");
    m.def("default_quilt", &defaultQuilt, py::arg("calibration"),
          "The default quilt for a display: its model's.");
    m.def("calibration_warnings", &calibrationWarnings, py::arg("calibration"),
          "Remarks about a calibration that is valid but unusual.");
    Value<MountedCalibration>(m, "MountedCalibration", "A calibration on a display's own volume.")
        .field("file", &MountedCalibration::file, "Its visual.json.")
        .field("volume", &MountedCalibration::volume, "Name of the volume.")
        .done();
    m.def("find_mounted_calibrations", &findMountedCalibrations,
          py::arg("file_system_root") = std::filesystem::path("/"),
          "The calibrations on mounted volumes of displays.");
}

} // namespace altiro3D::python
