// visual.json, and what is derived from it.

#include "altiro3D/lens_sheet.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(fuzz::textOf(data, size));
    fuzz::reads([&] {
        for (const Calibration& calibration : parseCalibrations(text, "visual.json")) {
            validate(calibration, "visual.json");
            fingerprint(calibration);
            const LensGeometry lens = lensGeometry(calibration);
            const double phase = lens.phase(calibration.screenW - 1, calibration.screenH - 1, 2);
            fuzz::require(phase >= 0 && phase <= 1, "a lens phase is 0..1");
            const std::string written = calibrationText(calibration);
            const Calibration again = parseCalibrations(written, "again").front();
            fuzz::require(fingerprint(again) == fingerprint(calibration), "it is written as read");
            const LensFacts facts = lensFacts(calibration);
            fuzz::require(facts.usefulViews > 0 && facts.sharpStrength <= 100, "facts are numbers");
        }
    });
    return 0;
}
