#pragma once

#include "bindings.hpp"

#include <altiro3D/depth_source.hpp>

namespace altiro3D::python {

/// A source for the library to keep. A class of Python stays alive as long as the library uses it.
/// @param source a DepthSource @return the source
std::shared_ptr<DepthSource> sourceOf(const py::object& source);

} // namespace altiro3D::python
