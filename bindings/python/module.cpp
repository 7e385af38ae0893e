#include "arrays.hpp"

#include <altiro3D/version.hpp>
#include <opencv2/core.hpp>

namespace {

constexpr const char* kDoc =
    R"(Photos, depth, views and video as 3D pictures for light-field displays.

    visual.json -> Display ------------------------+
                                                   v
    photo -> DepthSource -> Scene (photo, depth) -> NativeMaker -> Native

Pictures are NumPy arrays: uint8 [rows x columns x 3], red first (order="bgr": blue first, as OpenCV
has it). Depth maps are float32 [rows x columns], 0..1, 1 = nearest. Sizes are (width, height).
Results are arrays that own the library's memory, or `out` if it is given.

The library works with blue first. Arguments with order="bgr" whose rows are contiguous, depth maps,
and a view pixels[..., ::-1] of a picture with blue first are used where they lie, and contiguous
quilts of either order; all others are copied. A Scene keeps its arrays; all other functions only
read them during the call.

Failures are altiro3d.Error. Other threads of Python run while the library works.
)";

} // namespace

// The package is this module alone: altiro3d/__init__.*.so.
PYBIND11_MODULE(altiro3d, m) {
    namespace python = altiro3D::python;
    m.doc() = kDoc;
    m.attr("__version__") = altiro3D::version();
    python::bindErrors(m);
    python::bindArrays(m);
    python::bindImageIo(m);
    python::bindDisplay(m);
    python::bindDepthMap(m);
    python::bindViewOptions(m);
    python::bindPlacement(m);
    python::bindDepthSource(m);
    python::bindViews(m);
    python::bindNative(m);
    python::bindQuilt2Native(m);
    python::bindSplats(m);
    python::bindLensView(m);
    python::bindPrintSheet(m);
    python::bindVideoIo(m);
    python::bindVideoDepth(m);
    python::bindVideoConversion(m);
    m.def("set_num_threads", &cv::setNumThreads, pybind11::arg("threads"),
          "Threads of the library, for each call; -1: one per processor. Results do not depend on "
          "it.");
}
