#include "image/opencv_codecs.hpp"

namespace altiro3D {

const OpenCvCodecs& openCvCodecs() {
    return altiro3d_opencv_codecs;
}

} // namespace altiro3D
