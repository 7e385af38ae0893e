#include "altiro3D/version.hpp"

namespace altiro3D {

const char* version() noexcept {
    return ALTIRO3D_VERSION;
}

} // namespace altiro3D
