// visual.json, and what is derived from it.

#include "altiro3D/display.hpp"
#include "fuzz.hpp"

#include <cmath>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(fuzz::textOf(data, size));
    fuzz::reads([&] {
        for (const Calibration& calibration : parseCalibrations(text, "visual.json")) {
            validate(calibration, "visual.json");
            fingerprint(calibration);
            const LensGeometry lens = lensGeometry(calibration);
            const double phase = lens.phase(calibration.screenW - 1, calibration.screenH - 1, 2);
            fuzz::require(phase >= 0 && phase < 1, "a lens phase is 0..1");
        }
    });
    return 0;
}
