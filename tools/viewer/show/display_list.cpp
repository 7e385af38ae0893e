#include "viewer/show/display_list.hpp"

#include <QGuiApplication>
#include <QScreen>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

namespace altiro3D::viewer {

namespace {

using Json = nlohmann::ordered_json;

std::string pairedByText(qt::PairedBy by) {
    if (by == qt::PairedBy::Serial) return "serial";
    return by == qt::PairedBy::Size ? "size" : "nothing";
}

Json jsonOf(const std::vector<qt::FoundDisplay>& displays,
            const std::vector<qt::ScreenFacts>& screens) {
    Json json = {{"displays", Json::array()}, {"screens", Json::array()}};
    for (const qt::FoundDisplay& display : displays) {
        Json entry = {{"name", display.name},
                      {"screen", nullptr},
                      {"volume", display.volume},
                      {"calibrationFile", display.calibrationFile.string()},
                      {"pairedBy", pairedByText(display.pairedBy)},
                      {"problems", display.problems}};
        if (display.screen) entry["screen"] = *display.screen;
        if (display.calibration) {
            entry["serial"] = display.calibration->serial;
            entry["panelWidth"] = display.calibration->screenW;
            entry["panelHeight"] = display.calibration->screenH;
        }
        json["displays"].push_back(std::move(entry));
    }
    for (const qt::ScreenFacts& screen : screens) {
        json["screens"].push_back({{"name", screen.name},
                                   {"model", screen.model},
                                   {"serialNumber", screen.serialNumber},
                                   {"width", screen.size.width},
                                   {"height", screen.size.height},
                                   {"scale", screen.scale},
                                   {"refreshHz", screen.refreshHz}});
    }
    return json;
}

} // namespace

bool hasDesktop() {
    for (const char* name : {"QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY"}) {
        const char* value = std::getenv(name);
        if (value != nullptr && *value != '\0') return true;
    }
    return false;
}

std::vector<qt::ScreenFacts> screenFacts() {
    std::vector<qt::ScreenFacts> facts;
    for (const QScreen* screen : QGuiApplication::screens())
        facts.push_back(qt::factsOf(*screen));
    return facts;
}

std::string textOf(const qt::ScreenFacts& screen) {
    std::string text;
    if (!screen.name.empty()) text += screen.name + ", ";
    if (!screen.model.empty() && screen.model != screen.name) text += screen.model + ", ";
    text += tools::sizeText(screen.size);
    if (std::abs(screen.scale - 1) > 1e-3)
        text += ", scaled to " + std::to_string(std::lround(screen.scale * 100)) + " %";
    return text;
}

int listDisplays(int& argc, char** argv, bool json, tools::Messages& messages) {
    std::unique_ptr<QGuiApplication> application;
    if (hasDesktop())
        application = std::make_unique<QGuiApplication>(argc, argv);
    else
        messages.warn("no desktop was found: screens are not known");
    const std::vector<qt::ScreenFacts> screens =
        application ? screenFacts() : std::vector<qt::ScreenFacts>();
    const std::vector<qt::FoundDisplay> displays = qt::findDisplays(screens, qt::findVolumes());
    if (json) {
        messages.print(
            jsonOf(displays, screens).dump(2, ' ', false, Json::error_handler_t::replace));
        return tools::kExitDone;
    }
    for (const qt::FoundDisplay& display : displays) {
        std::string line = "display " + display.name;
        if (display.screen) line += ", screen " + std::to_string(*display.screen);
        if (display.calibration) {
            line += ", panel " +
                    tools::sizeText({display.calibration->screenW, display.calibration->screenH});
        }
        if (!display.calibrationFile.empty()) line += ", " + display.calibrationFile.string();
        messages.say(line);
        for (const std::string& problem : display.problems)
            messages.say("  " + problem);
    }
    if (displays.empty()) messages.say("no light-field display was found");
    for (std::size_t i = 0; i < screens.size(); ++i)
        messages.say("screen " + std::to_string(i) + ": " + textOf(screens[i]));
    return tools::kExitDone;
}

} // namespace altiro3D::viewer
