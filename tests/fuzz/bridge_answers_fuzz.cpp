// Answers of Looking Glass Bridge, a program on another computer perhaps.

#include "cli/bridge_answers.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string answer(fuzz::textOf(data, size));
    fuzz::reads([&] { tools::requireBridgeAnswer(answer, "Bridge"); });
    fuzz::reads([&] {
        fuzz::require(!tools::bridgeToken(answer, "Bridge").empty(), "a token has characters");
    });
    fuzz::reads([&] {
        for (const tools::BridgeDevice& device : tools::bridgeDevices(answer, "Bridge")) {
            if (device.problem.empty()) validate(device.calibration);
            if (device.quilt) validate(*device.quilt);
            fuzz::require(device.index >= 0, "an index is not negative");
        }
    });
    return 0;
}
