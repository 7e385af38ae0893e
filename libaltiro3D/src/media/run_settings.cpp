#include "media/run_settings.hpp"

#include "altiro3D/file_io.hpp"

#include <cstdint>
#include <set>

namespace altiro3D {

namespace {

// Settings whose values identify the state of a file.
const std::set<std::string> kFiles = {"video", "depth video", "network"};

constexpr std::uintmax_t kMaxRunBytes = std::uintmax_t{64} << 20;
constexpr JsonLimits kRunLimits{8, 1000, false}; // ours has 3 levels

} // namespace

Json readRunFile(const std::filesystem::path& directory) {
    const std::filesystem::path file = directory / "run.json";
    return parseJson(readFile(file, kMaxRunBytes), file.string(), "an unfinished run", kRunLimits);
}

Json settingsJson(const RunSettings& settings) {
    return Json::parse(Json(settings).dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string differenceOf(const Json& before, const Json& now) {
    const auto text = [](const Json& all, const std::string& name) {
        if (!all.contains(name)) return std::string("not set");
        if (!all[name].is_string()) return all[name].dump();
        const auto given = all[name].get<std::string>();
        return given.empty() ? std::string("set") : given;
    };
    for (const bool inBoth : {false, true}) {
        for (const Json* all : {&before, &now}) {
            for (const auto& item : all->items()) {
                const std::string& name = item.key();
                if ((before.contains(name) && now.contains(name)) != inBoth) continue;
                if (text(before, name) == text(now, name)) continue;
                if (inBoth && kFiles.count(name) > 0)
                    return "the file of the " + name + " has changed";
                return name + " was " + text(before, name) + " and is " + text(now, name);
            }
        }
    }
    return {};
}

} // namespace altiro3D
