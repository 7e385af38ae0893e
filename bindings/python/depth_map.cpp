#include "arrays.hpp"

#include <altiro3D/depth_map.hpp>

namespace altiro3D::python {

void bindDepthMap(py::module_& m) {
    py::enum_<DepthKind>(m, "DepthKind", "Meaning of the numbers in a depth image.")
        .value("NearWhite", DepthKind::NearWhite, "larger = nearer, linear in inverse depth")
        .value("FarWhite", DepthKind::FarWhite, "larger = farther, linear in inverse depth")
        .value("Metric", DepthKind::Metric, "distance; 0, negative and NaN = unknown");
    py::enum_<DepthSide>(m, "DepthSide", "Position of the depth half of an RGB-D image.")
        .value("Right", DepthSide::Right)
        .value("Left", DepthSide::Left)
        .value("Top", DepthSide::Top)
        .value("Bottom", DepthSide::Bottom);
    Value<DepthNormalization>(m, "DepthNormalization",
                              "How raw depth numbers are mapped to a depth map of 0..1.")
        .field("kind", &DepthNormalization::kind, "Meaning of the raw numbers.")
        .field("low_percentile", &DepthNormalization::lowPercentile, "Becomes 0, 0..50 %.")
        .field("high_percentile", &DepthNormalization::highPercentile, "Becomes 1, 50..100 %.")
        .field("flat_depth", &DepthNormalization::flatDepth, "Result without a range, 0..1.")
        .constructible()
        .done();
    Value<RgbdLayout>(m, "RgbdLayout", "Where the depth half is, and the shape of both halves.")
        .field("side", &RgbdLayout::side, "Position of the depth half.")
        .field("halves", &RgbdLayout::halves, "Squeezed halves are stretched.")
        .constructible()
        .done();
    Value<DepthFlaws>(m, "DepthFlaws",
                      "How a depth map as a whole differs from its photo; all zero: exact.")
        .field("softness_pixels", &DepthFlaws::softnessPixels, "Width of depth steps, px, 0..64.")
        .field("growth_pixels", &DepthFlaws::growthPixels, "Near things are too large, px, -7..7.")
        .field("shift_pixels", &DepthFlaws::shiftPixels, "x and y of depth against photo, px.")
        .field("is_uneven", &DepthFlaws::isUneven, "Steps differ in softness.")
        .field("is_blurred", &DepthFlaws::isBlurred, "Soft steps were blurred, not enlarged.")
        .field("mixed_pixels", &DepthFlaws::mixedPixels, "Width of mixed colours, px, 0..7.")
        .constructible()
        .done()
        .def("any", &DepthFlaws::any, "Whether there is any flaw.");
    Value<DepthRefineOptions>(m, "DepthRefineOptions", "Options of refine_depth().")
        .field("flaws", &DepthRefineOptions::flaws,
               "Flaws to correct; None: they are measured; DepthFlaws(): depth stays as it is.")
        .constructible()
        .done();
    m.def(
        "normalize_depth",
        [](const Array& raw, const DepthNormalization& options, const Out& out) {
            const cv::Mat numbers = rawDepthOf(raw, "raw");
            Result depth(out);
            unlocked([&, options] { normalizeDepth(numbers, depth.mat, options); });
            return Array{depth.array()};
        },
        py::arg("raw"), py::kw_only(),
        py::arg_v("options", DepthNormalization(), "DepthNormalization()"),
        py::arg("out") = py::none(),
        "Turns raw depth numbers into a depth map.\n\n"
        "raw: [rows x columns], uint8, uint16, float32 or float64. Returns float32 [rows x "
        "columns],\n"
        "0..1, 1 = nearest. Percentiles 0.5 and 99.5 of the numbers become 0 and 1.");
    m.def(
        "fit_depth",
        [](const Array& depth, const Array& guide, const Out& out, Order order) {
            const cv::Mat map = depthOf(depth, "depth");
            const cv::Mat picture = pictureOf(guide, "guide", order);
            Result fitted(out);
            unlocked(
                [&] { fitDepth(map, cv::Rect2d(0, 0, map.cols, map.rows), picture, fitted.mat); });
            return Array{fitted.array()};
        },
        py::arg("depth"), py::arg("guide"), py::kw_only(), py::arg("out") = py::none(),
        py::arg("order") = "rgb",
        "Resamples a depth map to the size of a photo and aligns its edges with the photo's.\n\n"
        "depth: float32 [any size]; guide: uint8 [rows x columns x 3]. Returns float32 of guide's "
        "size.");
    m.def(
        "refine_depth",
        [](const Array& photo, const Array& depth, const DepthRefineOptions& options,
           const Out& out, Order order) {
            const cv::Mat picture = pictureOf(photo, "photo", order);
            const cv::Mat map = depthOf(depth, "depth");
            Result refined(out);
            const DepthFlaws flaws =
                unlocked([&, options] { return refineDepth(picture, map, refined.mat, options); });
            return std::pair(Array{refined.array()}, flaws);
        },
        py::arg("photo"), py::arg("depth"), py::kw_only(),
        py::arg_v("options", DepthRefineOptions(), "DepthRefineOptions()"),
        py::arg("out") = py::none(), py::arg("order") = "rgb",
        "Moves the edges of a depth map to those of its photo, which has the same size.\n\n"
        "Returns the refined depth map, and the flaws that were corrected.");
    m.def(
        "split_rgbd",
        [](const Array& picture, const RgbdLayout& layout, std::optional<py::list> notes,
           Order order) {
            const cv::Mat whole = pictureOf(picture, "picture", order, {CV_8UC3, CV_16UC3});
            Remarks remarks(std::move(notes));
            cv::Mat photo;
            cv::Mat raw;
            unlocked([&, layout] { splitRgbd(whole, layout, photo, raw, remarks.notes()); });
            remarks.give();
            return std::pair(Array{arrayOf(std::move(photo), order)},
                             Array{arrayOf(std::move(raw))});
        },
        py::arg("picture"), py::kw_only(), py::arg_v("layout", RgbdLayout(), "RgbdLayout()"),
        py::arg("notes") = py::none(), py::arg("order") = "rgb",
        "Splits an RGB-D image into its photo and its raw depth, for normalize_depth().");
    m.def(
        "join_rgbd",
        [](const Array& photo, const Array& depth, const RgbdLayout& layout, const Out& out,
           Order order) {
            const cv::Mat picture = pictureOf(photo, "photo", order);
            const cv::Mat map = depthOf(depth, "depth");
            Result joined(out, order);
            unlocked([&, layout] { joinRgbd(picture, map, layout, joined.mat); });
            return Array{joined.array()};
        },
        py::arg("photo"), py::arg("depth"), py::kw_only(),
        py::arg_v("layout", RgbdLayout(), "RgbdLayout()"), py::arg("out") = py::none(),
        py::arg("order") = "rgb",
        "Joins a photo and a depth map of the same size to an RGB-D image, near = white.");
    m.def(
        "depth_to16_bit",
        [](const Array& depth) {
            const cv::Mat map = depthOf(depth, "depth");
            return Array{arrayOf(unlocked([&] { return depthTo16Bit(map); }))};
        },
        py::arg("depth"), "A depth map as uint16, 65535 = nearest, for write_image().");
}

} // namespace altiro3D::python
