#include "altiro3D/qt/display_search.hpp"

#include "altiro3D/error.hpp"

#include <QScreen>
#include <QStorageInfo>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

namespace altiro3D::qt {

namespace fs = std::filesystem;

namespace {

std::string upper(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

// The words that could be a display's name or serial number, in upper case.
std::vector<std::string> wordsOf(const ScreenFacts& screen) {
    std::istringstream text(upper(screen.model + ' ' + screen.serialNumber + ' ' + screen.name));
    return {std::istream_iterator<std::string>(text), {}};
}

// The first word that begins with LKG or CubeVi; empty if there is none.
std::string lightFieldName(const ScreenFacts& screen) {
    for (const std::string& word : wordsOf(screen)) {
        if (word.compare(0, 3, "LKG") == 0 || word.compare(0, 6, "CUBEVI") == 0) return word;
    }
    return {};
}

bool namesIt(const ScreenFacts& screen, const FoundDisplay& display) {
    const std::vector<std::string> words = wordsOf(screen);
    const auto among = [&words](const std::string& name) {
        return !name.empty() && std::find(words.begin(), words.end(), upper(name)) != words.end();
    };
    return among(display.volume) || (display.calibration && among(display.calibration->serial));
}

bool isScaled(const ScreenFacts& screen) {
    return std::abs(screen.scale - 1) > 1e-3;
}

std::string text(cv::Size size) {
    return std::to_string(size.width) + " x " + std::to_string(size.height);
}

cv::Size panelOf(const Calibration& calibration) {
    return {calibration.screenW, calibration.screenH};
}

FoundDisplay displayOfVolume(const MountedCalibration& volume) {
    FoundDisplay display;
    display.volume = volume.volume;
    display.name = volume.volume;
    display.calibrationFile = volume.file;
    try {
        display.calibration = readCalibration(volume);
    } catch (const Error& error) {
        display.problems.emplace_back(error.what());
    }
    return display;
}

// Pairs the remaining screens and volumes of equal size if the pair is unambiguous.
void pairBySize(std::vector<FoundDisplay>& displays, const std::vector<ScreenFacts>& screens,
                const std::vector<bool>& candidates) {
    const auto taken = [&displays](std::size_t screen) {
        return std::any_of(displays.begin(), displays.end(),
                           [screen](const FoundDisplay& d) { return d.screen == screen; });
    };
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t d = 0; d < displays.size(); ++d) {
        if (displays[d].screen || !displays[d].calibration) continue;
        for (std::size_t s = 0; s < screens.size(); ++s) {
            if (candidates[s] && !taken(s) &&
                hasSize(screens[s], panelOf(*displays[d].calibration)))
                pairs.emplace_back(d, s);
        }
    }
    for (const auto& [d, s] : pairs) {
        const auto sharesOne = [d = d, s = s](const auto& pair) {
            return pair.first == d || pair.second == s;
        };
        if (std::count_if(pairs.begin(), pairs.end(), sharesOne) > 1) continue;
        displays[d].screen = s;
        displays[d].pairedBy = PairedBy::Size;
    }
}

// Whether a screen has the shape of the panel, so that the desktop only enlarges or shrinks it.
bool hasShape(const ScreenFacts& screen, cv::Size panel) {
    const double scale = static_cast<double>(screen.size.width) / panel.width;
    return std::abs(screen.size.height - panel.height * scale) <= 2;
}

} // namespace

// The desktop reports sizes in whole desktop px, so a scaled screen's size is off by up to one.
bool hasSize(const ScreenFacts& screen, cv::Size size) {
    const double most = isScaled(screen) ? screen.scale : 0;
    return std::abs(screen.size.width - size.width) <= most &&
           std::abs(screen.size.height - size.height) <= most;
}

ScreenFacts factsOf(const QScreen& screen) {
    ScreenFacts facts;
    facts.name = screen.name().toStdString();
    facts.model = screen.model().toStdString();
    facts.serialNumber = screen.serialNumber().toStdString();
    facts.scale = screen.devicePixelRatio();
    const auto px = [&facts](int length) {
        return static_cast<int>(std::lround(length * facts.scale));
    };
    facts.size = {px(screen.geometry().width()), px(screen.geometry().height())};
    facts.refreshHz = screen.refreshRate();
    return facts;
}

std::vector<std::string> problemsOf(const ScreenFacts& screen, cv::Size panel) {
    std::vector<std::string> problems;
    if (isScaled(screen))
        problems.push_back("the desktop scales this screen to " +
                           std::to_string(std::lround(screen.scale * 100)) +
                           " %: set its scale to 100 %");
    if (hasSize(screen, panel)) return problems;
    if (hasSize(screen, {panel.height, panel.width})) {
        problems.push_back("the desktop turns this screen on its side: set its rotation to none");
    } else if (hasShape(screen, panel)) {
        problems.push_back("the desktop shows " + text(screen.size) + " px on this panel of " +
                           text(panel) +
                           " px: set its resolution to the panel's and its scale to 100 %; on "
                           "some desktops the scale of the main screen counts for all");
    } else {
        problems.push_back("the screen is set to " + text(screen.size) + " px, but the panel has " +
                           text(panel) +
                           " px: set its resolution to that, and extend the desktop to it "
                           "instead of mirroring another screen");
    }
    return problems;
}

std::vector<FoundDisplay> findDisplays(const std::vector<ScreenFacts>& screens,
                                       const std::vector<MountedCalibration>& volumes) {
    std::vector<FoundDisplay> displays;
    for (const MountedCalibration& volume : volumes)
        displays.push_back(displayOfVolume(volume));
    std::vector<bool> named(screens.size());
    std::vector<bool> other(screens.size());
    for (std::size_t s = 0; s < screens.size(); ++s) {
        named[s] = !lightFieldName(screens[s]).empty();
        other[s] = !named[s];
        for (FoundDisplay& display : displays) {
            if (display.screen || !namesIt(screens[s], display)) continue;
            display.screen = s;
            display.pairedBy = PairedBy::Serial;
            named[s] = other[s] = false; // paired
            break;
        }
    }
    pairBySize(displays, screens, named);
    pairBySize(displays, screens, other);

    for (std::size_t s = 0; s < screens.size(); ++s) {
        const bool paired = std::any_of(displays.begin(), displays.end(),
                                        [s](const FoundDisplay& d) { return d.screen == s; });
        if (paired || !named[s]) continue;
        FoundDisplay display;
        display.screen = s;
        display.name = lightFieldName(screens[s]);
        display.problems.emplace_back(
            "its calibration was not found: mount the display's own volume (first generation: "
            "connect its USB cable), or give its visual.json");
        displays.push_back(std::move(display));
    }
    for (FoundDisplay& display : displays) {
        if (!display.screen) {
            display.problems.emplace_back(
                display.calibration
                    ? "no screen of its own was found: connect its video cable, and extend the "
                      "desktop to it at " +
                          text(panelOf(*display.calibration)) + " px"
                    : "no screen of its own was found: connect its video cable, and extend the "
                      "desktop to it");
        } else if (display.calibration) {
            for (std::string& problem :
                 problemsOf(screens[*display.screen], panelOf(*display.calibration)))
                display.problems.push_back(std::move(problem));
        }
    }
    std::stable_sort(displays.begin(), displays.end(),
                     [](const FoundDisplay& a, const FoundDisplay& b) {
                         if (!a.screen || !b.screen)
                             return a.screen.has_value() > b.screen.has_value();
                         return *a.screen < *b.screen;
                     });
    return displays;
}

std::vector<MountedCalibration> findVolumes(const fs::path& root) {
    std::vector<MountedCalibration> found = findMountedCalibrations(root);
    if (root != "/") return found;
    for (const QStorageInfo& storage : QStorageInfo::mountedVolumes()) {
        if (!storage.isReady()) continue;
        std::string volume = storage.name().toStdString();
        const fs::path place = storage.rootPath().toStdString();
        if (volume.empty()) volume = place.filename().string();
        if (upper(volume).compare(0, 3, "LKG") != 0) continue;
        const fs::path file = place / "LKG_calibration" / "visual.json";
        std::error_code error;
        const bool known = std::any_of(found.begin(), found.end(),
                                       [&](const auto& other) { return other.file == file; });
        if (!known && fs::is_regular_file(file, error)) found.push_back({file, volume});
    }
    return found;
}

std::optional<std::size_t> chooseDisplay(const std::vector<FoundDisplay>& displays,
                                         const std::vector<ScreenFacts>& screens,
                                         const std::optional<Calibration>& calibration,
                                         cv::Size native) {
    std::vector<std::size_t> all;
    std::vector<std::size_t> ofSize;
    for (std::size_t i = 0; i < displays.size(); ++i) {
        if (!displays[i].screen) continue;
        all.push_back(i);
        if (hasSize(screens[*displays[i].screen], native)) ofSize.push_back(i);
        if (calibration && displays[i].calibration &&
            fingerprint(*calibration) == fingerprint(*displays[i].calibration)) {
            return i;
        }
    }
    if (ofSize.size() == 1) return ofSize.front();
    if (ofSize.empty() && all.size() == 1) return all.front();
    return std::nullopt;
}

} // namespace altiro3D::qt
