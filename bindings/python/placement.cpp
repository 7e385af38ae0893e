#include "arrays.hpp"

#include <altiro3D/depth_map.hpp>
#include <altiro3D/photo_fit.hpp>
#include <altiro3D/placement.hpp>
#include <altiro3D/recipe.hpp>
#include <altiro3D/scene.hpp>

namespace altiro3D::python {

namespace {

// A picture of a scene as a property: an array that shares the scene's memory, or a copy in RGB.
template <class Picture>
auto arrayIn(Picture picture) {
    return [picture](const Scene& scene) { return Out{arrayOf(picture(scene), Order::Rgb)}; };
}

void bindScene(py::module_& m) {
    py::enum_<DepthEdges>(m, "DepthEdges", "What is known of the edges of a depth map.")
        .value("Unknown", DepthEdges::Unknown, "refinement measures and corrects them")
        .value("Matched", DepthEdges::Matched, "found by matching two pictures: not moved")
        .value("Aligned", DepthEdges::Aligned, "aligned with the photo when depth was estimated");
    py::class_<Scene>(m, "Scene",
                      "A photo and its depth map. It shares the arrays' memory: do not "
                      "change them while it is in use.")
        .def(py::init([](const Array& photo, const Array& depth, const Out& hiddenPhoto,
                         const Out& hiddenDepth, DepthEdges edges, Order order) {
                 Scene scene;
                 scene.photo = pictureOf(photo, "photo", order);
                 scene.depth = depthOf(depth, "depth");
                 checkDepthRange(scene.depth);
                 if (!hiddenPhoto.object.is_none()) {
                     scene.hidden = {pictureOf({hiddenPhoto.object}, "hidden_photo", order),
                                     depthOf({hiddenDepth.object}, "hidden_depth")};
                 }
                 scene.edges = edges;
                 return scene;
             }),
             py::arg("photo"), py::arg("depth"), py::kw_only(),
             py::arg("hidden_photo") = py::none(), py::arg("hidden_depth") = py::none(),
             py::arg("edges") = DepthEdges::Unknown, py::arg("order") = "rgb",
             "photo: uint8 [rows x columns x 3]; depth: float32 [any size], 0..1, 1 = nearest.\n"
             "hidden_photo, hidden_depth: what nearer things hide, for method Layered; its depth "
             "is\n"
             "NaN where it is unknown.")
        .def_property_readonly("photo", arrayIn([](const Scene& scene) { return scene.photo; }),
                               "uint8 [rows x columns x 3], RGB; a copy.")
        .def_property_readonly("depth", arrayIn([](const Scene& scene) { return scene.depth; }),
                               "float32 [any size], 0..1, 1 = nearest; not copied.")
        .def_property_readonly("hidden_photo",
                               arrayIn([](const Scene& scene) { return scene.hidden.photo; }),
                               "As photo, or None; a copy.")
        .def_property_readonly("hidden_depth",
                               arrayIn([](const Scene& scene) { return scene.hidden.depth; }),
                               "As depth, or None; not copied.")
        .def_readwrite("edges", &Scene::edges, "What is known of the edges of the depth.")
        .def_property_readonly("shown", &shownColumns,
                               "First and last + 1 of the columns that the "
                               "panel shows; the others are margins.")
        .def("__repr__", [](const Scene& scene) {
            const auto text = [](const cv::Mat& mat) {
                return std::to_string(mat.rows) + " rows x " + std::to_string(mat.cols) +
                       " columns";
            };
            return "<Scene: photo " + text(scene.photo) + ", depth " + text(scene.depth) + ">";
        });
}

void bindFit(py::module_& m) {
    py::enum_<FitMode>(m, "FitMode", "How a picture is fitted to another shape.")
        .value("Cover", FitMode::Cover, "fills the panel; the excess is cropped")
        .value("Contain", FitMode::Contain, "shows all of the picture, with black bars")
        .value("Stretch", FitMode::Stretch, "shows all of the picture, distorted");
    Value<Framing>(m, "Framing", "The part of a picture that is shown.")
        .field("centre", &Framing::centre, "x and y of its centre, each 0..1.")
        .field("zoom", &Framing::zoom, "Enlargement, 1..1000.")
        .constructible()
        .done();
    Value<PhotoFit>(m, "PhotoFit", "The source and target rectangles of a fit, and its margins.")
        .field("source", &PhotoFit::source, "x, y, width, height of the part that is shown, px.")
        .field("target", &PhotoFit::target, "Its place on the panel, px; the rest is black.")
        .field("size", &PhotoFit::size, "Width and height of the picture on the panel, px.")
        .field("left_margin", &PhotoFit::leftMargin, "Columns left of it.")
        .field("right_margin", &PhotoFit::rightMargin, "Columns right of it.")
        .done();
}

template <class Options>
Options& addPlacement(Options& options) {
    return options.part("views", &PlacementOptions::views, "Method, strength, focus.")
        .field("fit", &PlacementOptions::fit, "Fit to the panel if the shapes differ.")
        .part("framing", &PlacementOptions::framing, "The part of a photo that is shown.")
        .part("refine", &PlacementOptions::refine, "How the depth is refined.")
        .field("depth_curve", &PlacementOptions::depthCurve, "Exponent of depth, 0.5..2.");
}

template <class Options>
Options& addNative(Options& options) {
    return addPlacement(options)
        .field("detail", &NativeOptions::detail, "Size to which photos are fitted.")
        .field("lens_filter", &NativeOptions::lensFilter, "Remove what lenses cannot show.")
        .field("positions", &NativeOptions::positions, "Camera position of a sub-pixel.")
        .part("sampling", &NativeOptions::sampling, "How a quilt is sampled.");
}

void bindOptions(py::module_& m) {
    Value<PlacementOptions> placement(m, "PlacementOptions", "How a scene is placed on a display.");
    addPlacement(placement).constructible().done();
    Value<AutoChoices>(m, "AutoChoices", "The settings that choose_from_scene() chooses.")
        .field("framing", &AutoChoices::framing, "Centre and size of the part that is shown.")
        .field("focus", &AutoChoices::focus, "The depth of the subject.")
        .field("strength", &AutoChoices::strength, "As much parallax as stays sharp.")
        .field("limit", &AutoChoices::limit, "The given strength, but at most what depth bears.")
        .field("is_video", &AutoChoices::isVideo, "The scene is the first frame of a video.")
        .constructible()
        .done();
    py::enum_<ViewPositions>(m, "ViewPositions", "Camera position of a sub-pixel.")
        .value("Discrete", ViewPositions::Discrete, "that of one of the views, as in a quilt")
        .value("Continuous", ViewPositions::Continuous, "exactly in its own direction");
    py::enum_<Detail>(m, "Detail", "The size to which a photo is fitted.")
        .value("View", Detail::View, "px of a view of the quilt")
        .value("Lens", Detail::Lens, "all that the lenses show in one direction")
        .value("Panel", Detail::Panel, "px of the panel");
    py::enum_<ViewFilter>(m, "ViewFilter", "How a sub-pixel samples the views.")
        .value("Nearest", ViewFilter::Nearest, "one view")
        .value("Linear", ViewFilter::Linear, "two views, blended");
    py::enum_<TileSampling>(m, "TileSampling", "How a sub-pixel samples the px of a view.")
        .value("Nearest", TileSampling::Nearest, "one px")
        .value("Linear", TileSampling::Linear, "four px, blended");
    Value<QuiltSampling>(m, "QuiltSampling", "How a quilt is sampled.")
        .field("views", &QuiltSampling::views, "Between views.")
        .field("in_tile", &QuiltSampling::inTile, "Inside a view.")
        .constructible()
        .done();
    Value<NativeOptions, PlacementOptions> native(
        m, "NativeOptions",
        "How a photo with depth becomes a Native. The defaults make the published picture; "
        "show_as(Detail.Lens) is recommended for photos, show_live() for cameras.");
    addNative(native)
        .constructible()
        .done()
        .def("show_as", &NativeOptions::showAs, py::arg("most"),
             "Sets detail, filter and positions for the most accurate picture through the lenses.\n"
             "Detail.Panel takes 3 times the time of Detail.Lens and is no more accurate.")
        .def(
            "show_live", &NativeOptions::showLive,
            "Sets what is quick enough for every frame of a camera: method Fast at the size of\n"
            "the views. Off are the hidden background (columns at edges are doubled), the lens\n"
            "filter (fine detail becomes coloured noise), continuous positions and the refinement\n"
            "of depth. An eye sees photos with 2 dB less PSNR than with show_as(Detail.Lens).");
    Value<Recipe, NativeOptions> recipe(m, "Recipe",
                                        "All settings of a picture: NativeOptions, and what is "
                                        "chosen for each scene instead.");
    addNative(recipe)
        .part("choices", &Recipe::choices, "What is chosen; it replaces the values of its fields.")
        .constructible()
        .done();
    m.def("recipe_text", &recipeText, py::arg("recipe"),
          "The settings as JSON, with the names and words of the command line.");
    m.def("parse_recipe", &parseRecipe, py::arg("json"), py::arg("source") = "recipe",
          "Reads what recipe_text() has written. Missing members keep their defaults.");
}

} // namespace

void bindPlacement(py::module_& m) {
    bindScene(m);
    bindFit(m);
    bindOptions(m);
    py::class_<Placement>(m, "Placement", "A scene on a display.")
        .def_readonly("scene", &Placement::scene, "Photo and refined depth, fitted.")
        .def_readonly("fit", &Placement::fit, "How it was fitted.")
        .def_readonly("flaws", &Placement::flaws, "Flaws of the depth that were corrected.");
    m.def(
        "place_scene",
        [](const Scene& scene, double aspect, cv::Size size, const PlacementOptions& options) {
            return unlocked([=] { return placeScene(scene, aspect, size, options); });
        },
        py::arg("scene"), py::arg("aspect"), py::arg("size"), py::arg("options"),
        "Fits a scene to a panel and refines its depth.\n\n"
        "aspect: Display.aspect(); size: NativeMaker.work_size() or quilt_size(); options: those\n"
        "of the maker, or of choose_from_scene().");
    m.def(
        "choose_from_scene",
        [](const Scene& scene, double aspect, const QuiltLayout& quilt,
           const PlacementOptions& options, const AutoChoices& choices) {
            return unlocked(
                [=] { return chooseFromScene(scene, aspect, quilt, options, choices).options; });
        },
        py::arg("scene"), py::arg("aspect"), py::arg("quilt"), py::arg("options"),
        py::arg("choices"),
        "Chooses framing, focus and strength of a scene, as far as `choices` asks for them.\n\n"
        "scene: before the fit. Returns options for place_scene().");
}

} // namespace altiro3D::python
