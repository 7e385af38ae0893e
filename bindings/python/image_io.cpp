#include "arrays.hpp"

#include <altiro3D/file_io.hpp>
#include <altiro3D/image_io.hpp>

namespace altiro3D::python {

namespace {

constexpr std::initializer_list<int> kWritable = {CV_8UC3, CV_8UC1, CV_16UC3, CV_16UC1};

// Binds a function that reads a picture from a file and adds remarks.
template <class Read>
void defRead(py::module_& m, const char* name, Read read, const char* doc) {
    m.def(
        name,
        [read](const PhotoFile& file, std::optional<py::list> notes, Order order) {
            Remarks remarks(std::move(notes));
            cv::Mat picture = unlocked([&] { return read(file, remarks.notes()); });
            remarks.give();
            return Array{arrayOf(std::move(picture), order)};
        },
        py::arg("file"), py::kw_only(), py::arg("notes") = py::none(), py::arg("order") = "rgb",
        doc);
}

std::vector<PathResult> pathsOf(const std::vector<std::filesystem::path>& paths) {
    return {paths.begin(), paths.end()};
}

} // namespace

void bindImageIo(py::module_& m) {
    py::class_<PhotoFile>(m, "PhotoFile",
                          "A picture file that is read once, or a picture in memory. Functions "
                          "that read pictures take one; a path converts to it.")
        .def(py::init([](const std::filesystem::path& path) { return PhotoFile(path); }),
             py::arg("path"), "Nothing is read before it is needed.")
        .def(py::init([](const py::bytes& bytes, const std::filesystem::path& name) {
                 return PhotoFile(std::string(bytes), name);
             }),
             py::arg("bytes"), py::arg("name"),
             "A picture in memory; its name stands in messages, and its tags count.")
        .def_property_readonly(
            "path", [](const PhotoFile& file) { return PathResult{file.path()}; },
            "The name, as given.")
        .def("__repr__", [](const PhotoFile& file) {
            return "PhotoFile(" + py::repr(py::cast(file.path().string())).cast<std::string>() +
                   ")";
        });
    py::implicitly_convertible<std::filesystem::path, PhotoFile>();
    py::enum_<ImageMark>(m, "ImageMark", "Mark in a picture file.")
        .value("None_", ImageMark::None, "no mark")
        .value("Native", ImageMark::Native, "a Native, which must not be scaled; PNG only");
    defRead(
        m, "read_image", &readImage,
        "Reads a picture upright, in sRGB, with its full bit depth.\n\n"
        "PNG, JPEG, HEIC, AVIF, TIFF, WebP, BMP, PNM, PFM, EXR, HDR and JPEG 2000. Remarks are\n"
        "appended to `notes`. Returns [rows x columns x 3], uint8, uint16 or float32.");
    defRead(m, "read_photo", &readPhoto,
            "Reads a photo as read_image() does, converted to uint8 [rows x columns x 3].");
    defRead(m, "read_depth_image", &readDepthImage,
            "Reads the raw numbers of a depth image: float32 [rows x columns]; normalize_depth()\n"
            "makes a depth map of them. `order` has no effect.");
    m.def(
        "write_image",
        [](const std::filesystem::path& path, const Array& picture, ImageMark mark, Order order) {
            const cv::Mat image = pictureOf(picture, "picture", order, kWritable);
            unlocked([&] { writeImage(path, image, mark); });
        },
        py::arg("path"), py::arg("picture"), py::kw_only(), py::arg("mark") = ImageMark::None,
        py::arg("order") = "rgb",
        "Writes a picture in the format of the extension; the file appears complete or not at "
        "all.\n\n"
        "picture: [rows x columns x 3] or [rows x columns], uint8 or uint16.");
    m.def(
        "encode_picture",
        [](const Array& picture, ImageMark mark, const std::filesystem::path& name, Order order) {
            const cv::Mat image = pictureOf(picture, "picture", order, kWritable);
            const auto bytes = unlocked([&] { return encodePicture(image, name, mark); });
            return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        },
        py::arg("picture"), py::kw_only(), py::arg("mark") = ImageMark::None,
        py::arg("name") = "picture.png", py::arg("order") = "rgb",
        "The bytes that write_image() writes to a file of that name.");
    m.def("is_marked_native", &isMarkedNative, py::arg("file"),
          "Whether a PNG file is marked as a Native.");
    m.def(
        "list_images",
        [](const std::filesystem::path& directory) { return pathsOf(listImages(directory)); },
        py::arg("directory"), "The pictures in a directory: view9.png before view10.png.");
    m.def(
        "read_embedded_depth",
        [](const PhotoFile& photo, std::optional<py::list> notes) -> Out {
            Remarks remarks(std::move(notes));
            auto found = unlocked([&] { return readEmbeddedDepth(photo, remarks.notes()); });
            remarks.give();
            return {found ? arrayOf(std::move(found->depth)) : py::none()};
        },
        py::arg("photo"), py::kw_only(), py::arg("notes") = py::none(),
        "The depth that phones store in photos: a depth map [any size], float32, 0..1, or None.");
    m.def(
        "write_photo_with_depth",
        [](const std::filesystem::path& path, const Array& photo, const Array& depth, Order order) {
            const cv::Mat picture = pictureOf(photo, "photo", order);
            const cv::Mat map = depthOf(depth, "depth");
            unlocked([&] { writePhotoWithDepth(path, picture, map); });
        },
        py::arg("path"), py::arg("photo"), py::arg("depth"), py::kw_only(),
        py::arg("order") = "rgb",
        "Writes a photo with its depth as one JPEG (Dynamic Depth), as phones do.\n\n"
        "photo: uint8 [rows x columns x 3]; depth: float32 [any size of that shape], 1 = nearest.");
    m.def(
        "data_directories", [] { return pathsOf(dataDirectories()); },
        "Folders of the library's own files: calibration/, models/.");
    py::enum_<StereoLayout>(m, "StereoLayout", "How one picture holds the pictures of both eyes.")
        .value("LeftRight", StereoLayout::LeftRight, "the left eye's picture is the left half")
        .value("RightLeft", StereoLayout::RightLeft, "the left eye's picture is the right half")
        .value("TopBottom", StereoLayout::TopBottom, "the left eye's picture is the upper half")
        .value("BottomTop", StereoLayout::BottomTop, "the left eye's picture is the lower half");
    py::enum_<StereoHalves>(m, "StereoHalves", "Shape of the halves of a picture.")
        .value("Automatic", StereoHalves::Automatic, "squeezed if the whole is about 16:9")
        .value("Full", StereoHalves::Full, "the shape of the scene")
        .value("Squeezed", StereoHalves::Squeezed, "half the width or height, as for 3D TV");
    py::enum_<EyesPicture>(m, "EyesPicture", "How one picture shows the pictures of both eyes.")
        .value("SideBySide", EyesPicture::SideBySide)
        .value("SideBySideHalf", EyesPicture::SideBySideHalf)
        .value("Crossed", EyesPicture::Crossed)
        .value("TopBottom", EyesPicture::TopBottom)
        .value("TopBottomHalf", EyesPicture::TopBottomHalf)
        .value("Anaglyph", EyesPicture::Anaglyph, "for red-cyan glasses, colours by Dubois")
        .value("AnaglyphHalf", EyesPicture::AnaglyphHalf, "left eye in grey, right one in colour")
        .value("AnaglyphGrey", EyesPicture::AnaglyphGrey, "both eyes in grey")
        .value("Rows", EyesPicture::Rows, "alternating rows")
        .value("Columns", EyesPicture::Columns, "alternating columns")
        .value("Checkerboard", EyesPicture::Checkerboard, "alternating px");
}

} // namespace altiro3D::python
