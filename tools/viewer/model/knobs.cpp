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

auto parts(const Knobs& k) {
    return std::tuple_cat(std::tie(k.views, k.fit, k.framing, k.isFramingChosen, k.depthCurve,
                                   k.depth, k.columns, k.rows),
                          AutoChoices::fields(k.automatic));
}

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

constexpr int kVersion = 1;
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
    const ViewOptions& v = knobs.views;
    return {{"method", int(v.method)},
            {"strength", v.strengthPercent},
            {"focus", v.focus},
            {"refinement", v.refinement},
            {"fill", int(v.layered.fill)},
            {"fit", int(knobs.fit)},
            {"center", {knobs.framing.centre.x, knobs.framing.centre.y}},
            {"zoom", knobs.framing.zoom},
            {"framingChosen", knobs.isFramingChosen},
            {"auto",
             {knobs.automatic.framing, knobs.automatic.focus, knobs.automatic.strength,
              knobs.automatic.limit}},
            {"depthCurve", knobs.depthCurve},
            {"depth", knobs.depth},
            {"views", {knobs.columns, knobs.rows}}};
}

template <class Word>
Word wordOf(const Json& json, std::initializer_list<Word> known) {
    const int number = json.get<int>();
    for (const Word word : known)
        if (int(word) == number) return word;
    throw Error(ErrorCode::BadFormat, "number", "is unknown");
}

double numberOf(const Json& json, double low, double high) {
    const double number = json.get<double>();
    if (!(number >= low && number <= high))
        throw Error(ErrorCode::BadFormat, "number", "is out of range");
    return number;
}

// Throws exceptions of several kinds for all but what jsonOf() writes.
Knobs knobsOf(const Json& json) {
    Knobs knobs;
    ViewOptions& v = knobs.views;
    v.method = wordOf(json.at("method"), {ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered});
    v.strengthPercent = json.at("strength").get<double>();
    v.focus = json.at("focus").get<double>();
    v.refinement = static_cast<int>(numberOf(json.at("refinement"), 0, 16));
    v.layered.fill = wordOf(json.at("fill"), {LayeredFill::BackgroundLayer, LayeredFill::Continue});
    knobs.fit = wordOf(json.at("fit"), {FitMode::Cover, FitMode::Contain, FitMode::Stretch});
    knobs.framing.centre.x = numberOf(json.at("center").at(0), 0, 1);
    knobs.framing.centre.y = numberOf(json.at("center").at(1), 0, 1);
    knobs.framing.zoom = numberOf(json.at("zoom"), 1, 100);
    knobs.isFramingChosen = json.value("framingChosen", false); // later than the others
    const Json& automatic = json.at("auto");
    knobs.automatic = {automatic.at(0).get<bool>(), automatic.at(1).get<bool>(),
                       automatic.at(2).get<bool>(),
                       automatic.size() > 3 && automatic.at(3).get<bool>()}; // since 4 numbers
    if (knobs.fit != FitMode::Cover) knobs.automatic.framing = false;
    if (json.contains("depthCurve")) // later than the others
        knobs.depthCurve = numberOf(json["depthCurve"], kMinDepthCurve, kMaxDepthCurve);
    knobs.depth = json.at("depth").get<std::string>();
    if (knobs.depth.size() > kMaxName) throw Error(ErrorCode::BadFormat, "depth", "is too long");
    knobs.columns = static_cast<int>(numberOf(json.at("views").at(0), 0, kMaxViewsAcross));
    knobs.rows = static_cast<int>(numberOf(json.at("views").at(1), 0, kMaxViewsAcross));
    validate(v);
    return knobs;
}

} // namespace

int nextGesture() {
    static int last = 0;
    return ++last;
}

bool operator==(const Knobs& a, const Knobs& b) {
    return parts(a) == parts(b);
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
