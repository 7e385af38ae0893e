#include "arrays.hpp"

#include <altiro3D/quilt2native.hpp>
#include <altiro3D/splats.hpp>

namespace altiro3D::python {

namespace {

using Splats = std::shared_ptr<const SplatScene>;

// The quilt of a scene, and its depth.
py::dict render(const Splats& splats, const Display& display, const SplatCameraOptions& camera,
                std::optional<double> focus, std::optional<double> strength, Order order) {
    cv::Mat quilt;
    cv::Mat depth;
    SplatPlacement placed;
    unlocked([&, splats, display, camera] {
        const QuiltLayout& layout = display.quilt;
        const SplatCamera chosen =
            chooseSplatCamera(*splats, layout.tileSize, display.aspect(), camera).camera;
        const SplatRenderer renderer(*splats, chosen);
        const SplatView middle = renderer.render();
        placed = placeSplats(middle, chosen, layout, focus, strength);
        depth = depthOf(middle, placed);
        renderQuilt(renderer, placed, layout, quilt);
    });
    py::dict result;
    result["quilt"] = arrayOf(quilt, order);
    result["depth"] = arrayOf(depth);
    result["focus"] = placed.focus;
    result["strength_percent"] = placed.strengthPercent;
    return result;
}

} // namespace

void bindSplats(py::module_& m) {
    py::enum_<SplatAxes>(m, "SplatAxes", "How the axes of a file of splats lie.")
        .value("Auto", SplatAxes::Auto, "as its format says: RUB in .spz, RDF in all others")
        .value("Rdf", SplatAxes::Rdf, "x right, y down, z forward")
        .value("Rub", SplatAxes::Rub, "x right, y up, z back");
    py::class_<SplatScene, std::shared_ptr<SplatScene>>(
        m, "SplatScene", "A scene of Gaussian splats. Immutable; threads may share it.")
        .def("__len__", [](const SplatScene& self) { return self.splats.size(); })
        .def_property_readonly(
            "degree", [](const SplatScene& self) { return self.degree; },
            "Degree of its spherical harmonics, 0..3.")
        .def_property_readonly(
            "has_camera", [](const SplatScene& self) { return self.camera.has_value(); },
            "Whether its file has a camera.");
    m.def(
        "read_splats",
        [](const std::filesystem::path& file, SplatAxes axes, std::optional<py::list> notes) {
            Remarks remarks(std::move(notes));
            auto scene = unlocked([&] {
                return std::make_shared<SplatScene>(readSplats(file, axes, remarks.notes()));
            });
            remarks.give();
            return scene;
        },
        py::arg("file"), py::kw_only(), py::arg("axes") = SplatAxes::Auto,
        py::arg("notes") = py::none(),
        "Reads a scene of splats: .ply, .splat or .spz. Remarks are appended to `notes`.");
    m.def(
        "write_splats",
        [](const std::filesystem::path& file, const std::shared_ptr<SplatScene>& splats) {
            unlocked([&] { writeSplats(file, *splats); });
        },
        py::arg("file"), py::arg("splats"), "Writes a scene of splats as .ply or .spz.");
    m.def(
        "splats_of",
        [](const Scene& scene, double focus) {
            PhotoSplatOptions options;
            options.focus = focus;
            return unlocked(
                [&, scene] { return std::make_shared<SplatScene>(splatsOf(scene, options)); });
        },
        py::arg("scene"), py::kw_only(), py::arg("focus") = 0.5,
        "The splats of a photo and its depth of the same size, with its camera.");
    m.def(
        "render_splats",
        [](const std::shared_ptr<SplatScene>& splats, const Display& display, double yaw,
           double tilt, std::optional<double> viewAngle, std::optional<double> focus,
           std::optional<double> strength, Order order) {
            SplatCameraOptions camera;
            camera.yaw = yaw;
            camera.tilt = tilt;
            camera.viewDegrees = viewAngle;
            return render(splats, display, camera, focus, strength, order);
        },
        py::arg("splats"), py::arg("display"), py::kw_only(), py::arg("yaw") = 0.0,
        py::arg("tilt") = 0.0, py::arg("view_angle") = py::none(), py::arg("focus") = py::none(),
        py::arg("strength_percent") = py::none(), py::arg("order") = "rgb",
        "Renders a scene of splats for a display. Returns a dict: quilt, uint8, of display.quilt; "
        "depth of the middle view, float32; focus and strength_percent as they were given or "
        "chosen. Angles are in degrees. filter_for_lens() prepares the quilt for Quilt2Native.");
    m.def(
        "filter_for_lens",
        [](const Array& quilt, const QuiltLayout& layout, const Calibration& calibration,
           Order order) {
            const cv::Mat picture = pictureOf(quilt, "quilt", order);
            return Array{arrayOf(
                unlocked([=] { return filterForLens(picture, layout, calibration); }), order)};
        },
        py::arg("quilt"), py::arg("layout"), py::arg("calibration"), py::kw_only(),
        py::arg("order") = "rgb",
        "Removes detail of a quilt, uint8, that the lenses cannot show in one direction.");
}

} // namespace altiro3D::python
