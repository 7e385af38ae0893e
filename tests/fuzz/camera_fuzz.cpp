// The camera of a photo.

#include "altiro3D/view_options.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(fuzz::textOf(data, size));
    fuzz::reads([&] {
        const Camera camera = parseCamera(text, "camera.json");
        validate(camera);
        parallaxOf(camera);
    });
    return 0;
}
