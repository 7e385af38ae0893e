#include "cli/bridge_answers.hpp"

#include "altiro3D/error.hpp"
#include "cli/foreign_json.hpp"

#include <nlohmann/json.hpp>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kExpected = "an answer of Looking Glass Bridge";

// A member of an object; null if there is none.
const Json& member(const Json& object, const char* name) {
    static const Json kNone;
    if (!object.is_object()) return kNone;
    const auto found = object.find(name);
    return found == object.end() ? kNone : *found;
}

// The value of a member: {"name": {"value": ...}}
const Json& valueOf(const Json& object, const char* name) {
    return member(member(object, name), "value");
}

std::string textOf(const Json& value) {
    return value.is_string() ? value.get<std::string>() : std::string();
}

int numberOf(const Json& value) {
    return value.is_number_integer() && value >= 0 && value <= kMaxQuiltSide ? value.get<int>() : 0;
}

Json answerOf(const std::string& text, const std::string& source) {
    if (text.empty())
        throw Error(ErrorCode::BadFormat, source,
                    std::string("answers with nothing, expected ") + kExpected);
    Json answer = parseForeignJson(text, source, kExpected);
    const std::string status = textOf(valueOf(answer, "status"));
    if (status != "Completion" && status != "Pending")
        throw Error(
            ErrorCode::BadFormat, source,
            (status.empty() ? "answers without a status" : "answers " + status.substr(0, 60)) +
                ", expected Completion");
    return answer;
}

std::optional<QuiltLayout> quiltOf(const std::string& text, const std::string& source) {
    try {
        const Json json = parseForeignJson(text, source, kExpected);
        QuiltLayout layout;
        layout.columns = numberOf(member(json, "tileX"));
        layout.rows = numberOf(member(json, "tileY"));
        if (layout.columns < 1 || layout.rows < 1) return std::nullopt;
        layout.tileSize = {numberOf(member(json, "quiltX")) / layout.columns,
                           numberOf(member(json, "quiltY")) / layout.rows};
        layout.viewCount = layout.columns * layout.rows;
        validate(layout);
        return layout;
    } catch (const Error&) {
        return std::nullopt; // the model's is as good
    }
}

} // namespace

void requireBridgeAnswer(const std::string& answer, const std::string& source) {
    (void)answerOf(answer, source);
}

std::string bridgeToken(const std::string& answer, const std::string& source) {
    std::string token = textOf(valueOf(answerOf(answer, source), "payload"));
    if (token.empty())
        throw Error(ErrorCode::BadFormat, source, "gives no token, expected one for a session");
    return token;
}

std::vector<BridgeDevice> bridgeDevices(const std::string& answer, const std::string& source) {
    constexpr std::size_t kMaxCalibrationBytes = 64 * 1024;
    std::vector<BridgeDevice> devices;
    const Json document = answerOf(answer, source);
    const Json& list = valueOf(document, "payload");
    if (!list.is_object()) return devices;
    for (const auto& [key, entry] : list.items()) {
        const Json& fields = member(entry, "value");
        if (textOf(valueOf(fields, "hardwareVersion")) == "thirdparty") continue;
        BridgeDevice device;
        device.name = textOf(valueOf(fields, "hwid")).substr(0, 60);
        device.index = numberOf(valueOf(fields, "index"));
        device.calibrationText = textOf(valueOf(fields, "calibration"));
        const std::string who = source + ", display " + (device.name.empty() ? key : device.name);
        device.quilt = quiltOf(textOf(valueOf(fields, "defaultQuilt")), who);
        try {
            if (device.calibrationText.empty())
                throw Error(ErrorCode::BadFormat, who, "has no calibration, expected one");
            if (device.calibrationText.size() > kMaxCalibrationBytes)
                throw Error(ErrorCode::TooLarge, who,
                            "has a calibration of more than 64 kB, expected a visual.json");
            device.calibration = parseCalibrations(device.calibrationText, who).front();
            if (device.name.empty()) device.name = device.calibration.serial;
        } catch (const Error& error) {
            device.problem = error.what();
        }
        devices.push_back(std::move(device));
    }
    return devices;
}

} // namespace altiro3D::tools
