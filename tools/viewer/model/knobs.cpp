#include "viewer/model/knobs.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"

#include <QFile>
#include <QStandardPaths>
#include <QString>
#include <QUrl>
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <tuple>

namespace altiro3D::viewer {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// What fills the panel without zoom, in widths and heights of the photo; above 1 where bars show.
cv::Size2d windowOf(const FramedPhoto& photo) {
    constexpr int kFine = 1 << 14; // px of the result; the bars are rounded to them
    const PhotoFit fit = fitPhoto(photo.size, photo.panelAspect, {kFine, kFine}, photo.fit);
    const auto part = [](int source, int whole, int target) {
        return static_cast<double>(source) / whole * kFine / target;
    };
    return {part(fit.source.width, photo.size.width, fit.target.width),
            part(fit.source.height, photo.size.height, fit.target.height)};
}

double centreWithin(double centre, double part) {
    return part >= 1 ? 0.5 : std::clamp(centre, part / 2, 1 - part / 2);
}

cv::Point2d within(cv::Point2d centre, cv::Size2d window, double zoom) {
    return {centreWithin(centre.x, window.width / zoom),
            centreWithin(centre.y, window.height / zoom)};
}

constexpr int kVersion = 2;
constexpr int kMaxViewsAcross = 64; // as in the panel of settings
constexpr std::size_t kMaxName = 100;

// Path, size and time of change. File names are bytes, JSON is UTF-8: others are percent-encoded.
std::string keyOf(const fs::path& photo) {
    std::error_code error;
    const fs::path whole = fs::absolute(photo, error);
    if (error || !fs::is_regular_file(whole, error)) return {};
    const auto size = fs::file_size(whole, error);
    if (error) return {};
    const auto changed = fs::last_write_time(whole, error).time_since_epoch();
    if (error) return {};
    const std::string bytes = whole.lexically_normal().string();
    return QUrl::toPercentEncoding(QString::fromLatin1(bytes.c_str(), int(bytes.size())), "/ ")
               .toStdString() +
           "|" + std::to_string(size) + "|" +
           std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(changed).count());
}

Json jsonOf(const Knobs& knobs) {
    return {{"recipe", Json::parse(recipeText(knobs))},
            {"framingChosen", knobs.isFramingChosen},
            {"depth", knobs.depth},
            {"views", {knobs.columns, knobs.rows}}};
}

// Throws exceptions of several kinds for all but what jsonOf() writes.
Knobs knobsOf(const Json& json) {
    Knobs knobs;
    static_cast<Recipe&>(knobs) = parseRecipe(json.at("recipe").dump(), "settings");
    knobs.isFramingChosen = json.at("framingChosen").get<bool>();
    knobs.depth = json.at("depth").get<std::string>();
    if (knobs.depth.size() > kMaxName) throw Error(ErrorCode::BadFormat, "depth", "is too long");
    const auto across = [&](int i) {
        const int number = json.at("views").at(i).get<int>();
        if (number < 0 || number > kMaxViewsAcross)
            throw Error(ErrorCode::BadFormat, "views", "are out of range");
        return number;
    };
    knobs.columns = across(0);
    knobs.rows = across(1);
    return knobs;
}

} // namespace

int nextGesture() {
    static int last = 0;
    return ++last;
}

bool operator==(const Knobs& a, const Knobs& b) {
    return static_cast<const Recipe&>(a) == b &&
           std::tie(a.isFramingChosen, a.depth, a.columns, a.rows) ==
               std::tie(b.isFramingChosen, b.depth, b.columns, b.rows);
}

QuiltLayout layoutOf(const Knobs& knobs, const Display& display) {
    QuiltLayout layout = display.quilt;
    if (knobs.columns <= 0 && knobs.rows <= 0) return layout;
    const cv::Size quilt = layout.size();
    if (knobs.columns > 0) layout.columns = knobs.columns;
    if (knobs.rows > 0) layout.rows = knobs.rows;
    layout.tileSize = {quilt.width / layout.columns, quilt.height / layout.rows};
    layout.viewCount = layout.columns * layout.rows;
    return layout;
}

Framing allowed(const Framing& framing, const FramedPhoto& photo) {
    if (framing.zoom <= 1) return framing;
    if (std::min(photo.size.width, photo.size.height) < kMinFramedPixels)
        return {framing.centre, 1};
    const cv::Size2d window = windowOf(photo);
    const double least =
        std::min(window.width * photo.size.width, window.height * photo.size.height);
    return {framing.centre, std::clamp(least / kMinFramedPixels, 1.0, framing.zoom)};
}

Framing moved(const Framing& framing, const FramedPhoto& photo, cv::Point2d by) {
    const cv::Size2d window = windowOf(photo);
    const auto [centre, zoom] = allowed(framing, photo);
    const cv::Point2d from = within(centre, window, zoom);
    const cv::Point2d to(from.x - by.x * window.width / zoom, from.y - by.y * window.height / zoom);
    return {within(to, window, zoom), zoom};
}

Framing zoomed(const Framing& framing, const FramedPhoto& photo, cv::Point2d at, double factor) {
    const cv::Size2d window = windowOf(photo);
    const auto [centre, zoom] = allowed(framing, photo);
    const cv::Point2d from = within(centre, window, zoom);
    Framing result;
    result.zoom = allowed({centre, std::clamp(zoom * factor, 1.0, kMaxZoom)}, photo).zoom;
    const double change = 1 / zoom - 1 / result.zoom;
    const cv::Point2d to(from.x + (at.x - 0.5) * window.width * change,
                         from.y + (at.y - 0.5) * window.height * change);
    result.centre = within(to, window, result.zoom);
    return result;
}

fs::path KnobStore::standardFile() {
    const QString folder = QStandardPaths::writableLocation(QStandardPaths::GenericDataLocation);
    return fs::path(QFile::encodeName(folder).toStdString()) / "altiro3D" /
           "settings-of-photos.json";
}

KnobStore::KnobStore(fs::path file) : file_(std::move(file)) {
    for (Entry& entry : read(file_, note_))
        knobs_[entry.key] = std::move(entry.knobs);
}

std::vector<KnobStore::Entry> KnobStore::read(const fs::path& file, std::string& note) {
    std::vector<Entry> entries;
    if (!tools::isThere(file)) return entries;
    Json json;
    try {
        json = Json::parse(readFile(file, kMaxBytes), nullptr, false);
        if (!json.is_object() || json.value("version", Json()) != kVersion ||
            !json.value("photos", Json()).is_array())
            throw Error(ErrorCode::BadFormat, file.string(),
                        "is not such a file, expected version " + std::to_string(kVersion));
    } catch (const Error& problem) {
        note = std::string(problem.what()) + "; the settings of the photos are not read from it";
        return entries;
    }
    std::size_t broken = 0;
    for (const Json& photo : json["photos"]) {
        if (entries.size() >= kMaxPhotos) break;
        try {
            entries.push_back(
                {photo.at("photo").get<std::string>(), knobsOf(photo.at("settings"))});
        } catch (const std::exception&) {
            ++broken;
        }
    }
    if (broken > 0)
        note = file.string() + ": the settings of " + std::to_string(broken) +
               (broken == 1 ? " photo" : " photos") + " are broken and not used";
    return entries;
}

std::optional<Knobs> KnobStore::find(const fs::path& photo) const {
    const auto found = knobs_.find(keyOf(photo));
    if (found == knobs_.end()) return std::nullopt;
    return found->second;
}

void KnobStore::set(const fs::path& photo, const Knobs& knobs) {
    const std::string key = keyOf(photo);
    if (key.empty()) return;
    knobs_[key] = knobs;
    changed_.erase(std::remove(changed_.begin(), changed_.end(), key), changed_.end());
    changed_.push_back(key);
}

void KnobStore::save() {
    if (changed_.empty()) return;
    std::string unused;
    std::vector<Entry> entries = read(file_, unused); // another viewer may have written
    entries.erase(std::remove_if(entries.begin(), entries.end(),
                                 [this](const Entry& entry) {
                                     return std::find(changed_.begin(), changed_.end(),
                                                      entry.key) != changed_.end();
                                 }),
                  entries.end());
    for (const std::string& key : changed_)
        entries.push_back({key, knobs_.at(key)});
    const std::size_t spare = entries.size() > kMaxPhotos ? entries.size() - kMaxPhotos : 0;
    Json photos = Json::array();
    for (std::size_t i = spare; i < entries.size(); ++i)
        photos.push_back({{"photo", entries[i].key}, {"settings", jsonOf(entries[i].knobs)}});
    const Json json = {{"version", kVersion}, {"photos", std::move(photos)}};
    std::error_code error;
    fs::create_directories(file_.parent_path(), error);
    try {
        writeFile(file_, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    } catch (const Error&) {
        note_ = file_.string() + ": cannot be written, so the settings of the photos are not kept";
        return;
    }
    changed_.clear();
}

} // namespace altiro3D::viewer
