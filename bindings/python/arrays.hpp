#pragma once

/// @file
/// Pictures of NumPy and of the library.
///
/// An argument is used where it lies if its rows are contiguous and its channels have the library's
/// order, blue first; else it is copied. A result is an array that owns the library's memory.

#include "bindings.hpp"

#include <altiro3D/depth_network.hpp>
#include <initializer_list>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D::python {

/// Order of the channels of an array: the argument `order`, "rgb" or "bgr".
using Order = ChannelOrder;

/// An array as an argument: anything that NumPy converts to one.
struct Array {
    py::object object; ///< As given.
};

/// An array that receives a result, or None: the argument `out`.
struct Out {
    py::object object; ///< As given.
};

/// A picture from an argument.
/// @param array [rows x columns x 3], or [rows x columns] if `types` has one channel
/// @param name of the argument, for errors
/// @param order of its channels
/// @param types of OpenCV that are allowed
/// @return the picture in the library's order; keeps the array alive if it shares its memory
/// @throws Error InvalidArgument that names the argument, its type and shape, and what is expected
cv::Mat pictureOf(const Array& array, const char* name, Order order,
                  std::initializer_list<int> types = {CV_8UC3});

/// A depth map from an argument. @param array [rows x columns], float32
/// @param name for errors @return as pictureOf()
cv::Mat depthOf(const Array& array, const char* name);

/// Raw depth numbers from an argument. @param array [rows x columns], uint8, uint16, float32 or
/// float64 @param name for errors @return as pictureOf()
cv::Mat rawDepthOf(const Array& array, const char* name);

/// A picture of the library as an array.
/// @param picture of 1 to 3 channels @param order that the array has; depth has none
/// @return an array that owns the memory of `picture`, unless others share it and its order differs
py::object arrayOf(cv::Mat picture, Order order = Order::Bgr);

/// A picture that the library computes, into an array of the caller or into a new one.
class Result {
  public:
    /// @param out the array, or None @param order that the result has
    explicit Result(const Out& out, Order order = Order::Bgr);
    cv::Mat mat; ///< For the library, blue first; filled without the GIL.
    /// The result. @return `out`, or a new array
    /// @throws Error Mismatch (`out` has another type or shape)
    py::object array();

  private:
    py::object out_;
    const uchar* data_ = nullptr; // data of out_
    Order order_;
};

/// Defines the class Picture, which is what arrayOf() returns. @param m the module
void bindArrays(py::module_& m);

} // namespace altiro3D::python

namespace pybind11::detail {

/// The conversion for Array and Out, which hold the Python object as it was given.
template <class T>
struct ArrayCaster {
    bool load(handle source, bool /*convert*/) {
        value.object = reinterpret_borrow<object>(source);
        return std::is_same_v<T, altiro3D::python::Out> || !source.is_none();
    }
    static handle cast(const T& array, return_value_policy /*policy*/, handle /*parent*/) {
        return array.object.inc_ref();
    }
    template <class>
    using cast_op_type = T;
    operator T() { return value; }
    T value;
};
// NOLINTBEGIN(readability-identifier-naming): the name is pybind11's
template <>
struct type_caster<altiro3D::python::Array> : ArrayCaster<altiro3D::python::Array> {
    static constexpr auto name = const_name("numpy.ndarray");
};
template <>
struct type_caster<altiro3D::python::Out> : ArrayCaster<altiro3D::python::Out> {
    static constexpr auto name = const_name("Optional[numpy.ndarray]");
};
// NOLINTEND(readability-identifier-naming)

template <>
struct type_caster<altiro3D::python::Order> {
    PYBIND11_TYPE_CASTER(altiro3D::python::Order, const_name("str"));
    bool load(handle source, bool /*convert*/);
    static handle cast(altiro3D::python::Order order, return_value_policy /*policy*/,
                       handle /*of*/) {
        return str(order == altiro3D::python::Order::Rgb ? "rgb" : "bgr").release();
    }
};

} // namespace pybind11::detail
