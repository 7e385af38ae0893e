#pragma once

#include "altiro3D/display.hpp"

#include <optional>
#include <string>
#include <vector>

/// The answers of Looking Glass Bridge. All functions are safe for any bytes.
namespace altiro3D::tools {

/// A display that Bridge knows.
struct BridgeDevice {
    std::string name;            ///< The hardware's ("LKG-P00655"); may be empty.
    int index = 0;               ///< Its window's.
    std::string calibrationText; ///< Contents of its visual.json.
    Calibration calibration;
    std::optional<QuiltLayout> quilt; ///< The quilt that Bridge recommends.
    std::string problem;              ///< Why it has no calibration; empty: it has one.
};

/// The token of a session: the answer to enter_orchestration.
/// @param source for errors: who answered @throws Error BadFormat
std::string bridgeToken(const std::string& answer, const std::string& source);

/// The light-field displays in the answer to available_output_devices; ordinary monitors are left
/// out. @param source for errors @throws Error BadFormat
std::vector<BridgeDevice> bridgeDevices(const std::string& answer, const std::string& source);

/// Requires an answer that says that the call was understood: Bridge answers wrong ones with
/// nothing, and still with success. @throws Error BadFormat
void requireBridgeAnswer(const std::string& answer, const std::string& source);

} // namespace altiro3D::tools
