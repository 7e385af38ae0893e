#include "arrays.hpp"

#include <algorithm>
#include <altiro3D/depth_map.hpp>
#include <altiro3D/image_io.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <pybind11/numpy.h>

namespace altiro3D::python {

namespace {

// Keeps a NumPy array alive as long as a cv::Mat uses its memory.
class ArrayMemory : public cv::MatAllocator {
  public:
    static cv::Mat wrap(const py::array& array, int type, const uchar* begin) {
        static const ArrayMemory memory;
        cv::Mat mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
                    const_cast<uchar*>(begin), static_cast<std::size_t>(array.strides(0)));
        mat.u = new cv::UMatData(&memory);
        mat.u->data = mat.u->origdata = mat.data;
        mat.u->userdata = py::object(array).release().ptr();
        mat.u->refcount = 1;
        return mat;
    }
    void deallocate(cv::UMatData* data) const override {
        const Locked locked;
        py::handle(static_cast<PyObject*>(data->userdata)).dec_ref();
        delete data;
    }
    // Only wrap() makes such memory.
    cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, std::size_t* step,
                           cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
        return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
    }
    bool allocate(cv::UMatData* /*data*/, cv::AccessFlag /*flags*/,
                  cv::UMatUsageFlags /*usage*/) const override {
        return false;
    }
};

struct Number {
    int depth; // OpenCV's depth
    char kind; // NumPy's kind
    int bytes;
    const char* name;
};
constexpr Number kNumbers[] = {{CV_8U, 'u', 1, "uint8"},
                               {CV_16U, 'u', 2, "uint16"},
                               {CV_32F, 'f', 4, "float32"},
                               {CV_64F, 'f', 8, "float64"}};

const Number& numberOf(int type) {
    return *std::find_if(std::begin(kNumbers), std::end(kNumbers),
                         [&](const Number& number) { return number.depth == CV_MAT_DEPTH(type); });
}

std::string expectedText(std::initializer_list<int> types) {
    std::string text;
    for (const int type : types) {
        if (!text.empty()) text += " or ";
        text += std::string(numberOf(type).name) + " of shape (rows, columns" +
                (CV_MAT_CN(type) == 1 ? ")" : ", 3)");
    }
    return text;
}

std::string shapeText(const py::array& array) {
    return py::str(array.dtype()).cast<std::string>() + " of shape " +
           py::str(array.attr("shape")).cast<std::string>();
}

bool hasType(const py::array& array, int type) {
    const Number& number = numberOf(type);
    const bool isPicture =
        CV_MAT_CN(type) == 1 ? array.ndim() == 2 : array.ndim() == 3 && array.shape(2) == 3;
    return isPicture && array.dtype().kind() == number.kind && array.itemsize() == number.bytes;
}

cv::Mat matOf(const Array& argument, const char* name, std::initializer_list<int> types,
              bool isReversed) {
    py::array array = py::array::ensure(argument.object);
    if (!array) PyErr_Clear();
    const auto* const type =
        !array ? types.end()
               : std::find_if(types.begin(), types.end(), [&](int t) { return hasType(array, t); });
    if (type == types.end() || array.size() == 0) {
        throw Error(ErrorCode::InvalidArgument, name,
                    "is " +
                        (array ? shapeText(array)
                               : py::repr(argument.object.get_type()).cast<std::string>()) +
                        ", expected " + expectedText(types));
    }
    const py::ssize_t number = array.itemsize();
    const py::ssize_t px = number * CV_MAT_CN(*type);
    const auto isInRows = [&](py::ssize_t step) {
        return (array.ndim() == 2 || array.strides(2) == step) && array.strides(1) == px &&
               array.strides(0) >= px * array.shape(1) && array.strides(0) % number == 0 &&
               (array.dtype().byteorder() == '=' || array.dtype().byteorder() == '|');
    };
    if (CV_MAT_CN(*type) == 3 && isReversed && isInRows(-number)) // array[..., ::-1]
        return ArrayMemory::wrap(array, *type,
                                 static_cast<const uchar*>(array.data()) - 2 * number);
    if (!isInRows(number)) {
        array = py::module_::import("numpy").attr("ascontiguousarray")(
            array, py::arg("dtype") = array.dtype().attr("newbyteorder")("="));
    }
    cv::Mat mat = ArrayMemory::wrap(array, *type, static_cast<const uchar*>(array.data()));
    if (CV_MAT_CN(*type) == 1 || !isReversed) return mat;
    return unlocked([&] {
        cv::Mat swapped;
        cv::cvtColor(mat, swapped, cv::COLOR_RGB2BGR);
        return swapped;
    });
}

py::handle pictureType; // Picture, as long as the module lives

// The PNG of a result, for notebooks; None if it is not a picture.
py::object pngOf(const py::array& array) {
    if (array.size() == 0) return py::none();
    const auto is = [&](int type) { return hasType(array, type); };
    cv::Mat picture;
    if (is(CV_32FC1)) {
        picture = depthTo16Bit(depthOf({array}, "picture"));
    } else if (is(CV_8UC3) || is(CV_16UC3) || is(CV_8UC1) || is(CV_16UC1)) {
        picture = pictureOf({array}, "picture", Order::Rgb, {CV_8UC3, CV_16UC3, CV_8UC1, CV_16UC1});
    } else {
        return py::none();
    }
    const auto png = unlocked([&] { return encodePicture(picture); });
    return py::bytes(reinterpret_cast<const char*>(png.data()), png.size());
}

} // namespace

cv::Mat pictureOf(const Array& array, const char* name, Order order,
                  std::initializer_list<int> types) {
    return matOf(array, name, types, order == Order::Rgb);
}

cv::Mat depthOf(const Array& array, const char* name) {
    return matOf(array, name, {CV_32FC1}, false);
}

cv::Mat rawDepthOf(const Array& array, const char* name) {
    return matOf(array, name, {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}, false);
}

py::object arrayOf(cv::Mat picture, Order order) {
    if (picture.empty()) return py::none();
    if (picture.channels() == 3 && order == Order::Rgb) {
        unlocked([&] {
            const bool isOurs = picture.u != nullptr && picture.u->refcount == 1 &&
                                !picture.isSubmatrix() && picture.u->userdata == nullptr;
            cv::Mat swapped;
            if (isOurs)
                swapped = cv::Mat(picture.size(), picture.type(), picture.data, picture.step);
            cv::cvtColor(picture, swapped, cv::COLOR_BGR2RGB); // in place if it is ours
            if (!isOurs) picture = swapped;
        });
    }
    const auto number = static_cast<py::ssize_t>(picture.elemSize1());
    std::vector<py::ssize_t> shape = {picture.rows, picture.cols};
    std::vector<py::ssize_t> strides = {static_cast<py::ssize_t>(picture.step[0]),
                                        static_cast<py::ssize_t>(picture.elemSize())};
    if (picture.channels() > 1) {
        shape.push_back(picture.channels());
        strides.push_back(number);
    }
    const py::dtype type(numberOf(picture.type()).name);
    void* const data = picture.data;
    const py::capsule owner(new cv::Mat(std::move(picture)),
                            [](void* mat) { delete static_cast<cv::Mat*>(mat); });
    const py::array array(type, shape, strides, data, owner);
    return array.attr("view")(pictureType);
}

Result::Result(const Out& out, Order order) : out_(out.object), order_(order) {
    if (out_.is_none()) return;
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::InvalidArgument, "out", problem);
    };
    if (!py::isinstance<py::array>(out_)) fail("is not a NumPy array, expected one or None");
    const auto array = py::reinterpret_borrow<py::array>(out_);
    const int type = hasType(array, CV_8UC3) ? CV_8UC3 : CV_32FC1;
    if (!hasType(array, type))
        fail("is " + shapeText(array) + ", expected " + expectedText({CV_8UC3}));
    if (!array.writeable() || (array.flags() & py::array::c_style) == 0)
        fail("is read-only or not C-contiguous, expected an array like that of numpy.empty()");
    mat = cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
                  const_cast<void*>(array.data()));
    data_ = mat.data;
}

py::object Result::array() {
    if (out_.is_none()) return arrayOf(std::move(mat), order_);
    if (mat.data != data_) {
        throw Error(ErrorCode::Mismatch, "out",
                    "is " + shapeText(py::reinterpret_borrow<py::array>(out_)) + ", expected " +
                        shapeText(py::reinterpret_borrow<py::array>(arrayOf(mat))));
    }
    if (mat.channels() == 3 && order_ == Order::Rgb) {
        unlocked([&] {
            cv::Mat swapped(mat.size(), mat.type(), mat.data, mat.step);
            cv::cvtColor(mat, swapped, cv::COLOR_BGR2RGB);
        });
    }
    return out_;
}

void bindArrays(py::module_& m) {
    py::object numpy;
    try {
        numpy = py::module_::import("numpy");
    } catch (const py::error_already_set& missing) {
        if (!missing.matches(PyExc_ModuleNotFoundError)) throw;
        const auto python = py::module_::import("sys").attr("executable").cast<std::string>();
        throw py::import_error("altiro3d: NumPy is not installed for " + python +
                               ", expected it: " + python +
                               " -m pip install numpy, or for Debian's Python apt install "
                               "python3-numpy");
    }
    py::dict members;
    members["__doc__"] = "An array of the library: a picture [rows x columns x 3] or a depth map "
                         "[rows x columns]. Notebooks show it.";
    members["__module__"] = m.attr("__name__");
    const py::object metaclass = py::type::of(numpy.attr("ndarray"));
    const py::object type = metaclass("Picture", py::make_tuple(numpy.attr("ndarray")), members);
    py::setattr(type, "_repr_png_",
                py::cpp_function([](const py::array& self) { return pngOf(self); },
                                 py::name("_repr_png_"), py::is_method(type),
                                 "The picture as PNG, for notebooks; None if it is not one."));
    py::setattr(type, "__array_wrap__",
                py::cpp_function(
                    [](const py::object& /*self*/, const py::array& computed,
                       const py::args& /*context*/) -> py::object {
                        if (computed.ndim() == 0) return computed[py::tuple()];
                        return computed.attr("view")(py::module_::import("numpy").attr("ndarray"));
                    },
                    py::name("__array_wrap__"), py::is_method(type),
                    "What is computed of a picture is a plain array."));
    m.attr("Picture") = type;
    pictureType = type;
}

} // namespace altiro3D::python

bool pybind11::detail::type_caster<altiro3D::python::Order>::load(handle source, bool /*convert*/) {
    if (!isinstance<str>(source)) return false;
    const auto text = source.cast<std::string>();
    if (text != "rgb" && text != "bgr") {
        throw altiro3D::Error(altiro3D::ErrorCode::InvalidArgument, "order",
                              "is " + text + ", expected rgb or bgr");
    }
    value = text == "rgb" ? altiro3D::python::Order::Rgb : altiro3D::python::Order::Bgr;
    return true;
}
