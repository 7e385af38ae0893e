#include "image/opencv_codecs.hpp"

namespace altiro3D {

const OpenCvCodecs& openCvCodecs() {
    return kAltiro3dOpenCvCodecs;
}

} // namespace altiro3D
